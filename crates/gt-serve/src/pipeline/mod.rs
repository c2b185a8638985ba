//! From readings to alarms, without input, output or a clock.

mod alarm;
mod alarm_list;
mod hygiene;
mod machine;
mod quality;
mod reading;
mod trend;
mod watch;

pub use alarm::{Acknowledgement, Alarm, AlarmAction, AlarmEvent, AlarmState, Candidate, Shelf};
pub use alarm_list::{AlarmError, AlarmList, AlarmListState, AlarmOptions, Condition};
pub use hygiene::{Hygiene, HygieneCounts, HygieneError, HygieneOptions, Sample};
pub use machine::{
    Machine, MachineError, MachineOptions, MachineSnapshot, MachineState, SNAPSHOT_SCHEMA_VERSION,
};
pub use quality::Quality;
pub use reading::Reading;
pub use trend::{Band, Trend};
pub use watch::{Watch, WatchEvent, WatchState};
