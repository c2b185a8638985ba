//! The monitoring service: readings of machines in, samples, verdicts and alarms out.
//!
//! [`pipeline`] is all that decides, without input, output or a clock. Around it [`serve()`] puts
//! sources, the journal of alarms, snapshots, logs, a broker and the page.

mod clock;
mod config;
mod error;
#[cfg(fuzzing)]
pub mod fuzzing;
mod http;
mod hub;
mod journal;
mod logging;
mod metrics;
pub mod pipeline;
mod queue;
mod recorder;
mod service;
mod snapshots;
mod source;
mod worker;

pub use config::{
    DEFAULT_LISTEN, HttpConfig, LinesConfig, MachineConfig, MqttConfig, PlantConfig, QueueConfig,
    RecorderConfig, ReplayConfig, ServeConfig,
};
pub use error::ServeError;
pub use logging::{LogFormat, LogLevel, init_logging};
pub use queue::QueuePolicy;
pub use service::serve;
