//! From readings to alarms, without input, output or a clock.

mod alarm;
mod alarm_error;
mod alarm_list;
mod alarm_options;
mod hygiene;
mod machine;
mod reading;
mod trend;
mod watch;

pub use alarm::{Acknowledgement, Alarm, AlarmAction, AlarmEvent, AlarmState, Candidate, Shelf};
pub use alarm_error::AlarmError;
pub use alarm_list::{AlarmList, AlarmListState, Condition};
pub use alarm_options::AlarmOptions;
pub use gt_log::Quality;
pub use hygiene::{Hygiene, HygieneCounts, HygieneError, HygieneOptions, Sample};
pub use machine::{
    Machine, MachineError, MachineOptions, MachineSnapshot, MachineState, SNAPSHOT_SCHEMA_VERSION,
};
pub use reading::Reading;
pub use trend::{Band, Trend};
pub use watch::{Watch, WatchEvent, WatchState};
