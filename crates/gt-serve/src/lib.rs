//! The monitoring service: readings of machines in, samples, verdicts and alarms out.
//!
//! ```text
//! source (lines, broker, embedded turbine, played record) -> queue -> worker
//!     worker: readings -> hygiene -> samples -> bank or isolator -> alarms
//!     -> outbox -> journal, then page and API, broker, recorder; snapshots beside them
//! ```
//!
//! [`pipeline`] is all that decides, without input, output or a clock. Around it [`serve()`] puts
//! sources, the journal of alarms, snapshots, logs, a broker and the page. [`ServeConfig`] is the whole
//! configuration, with a type a section; [`ServeConfig::default`] runs the embedded turbine on loopback.
//!
//! ```
//! use gt_serve::ServeConfig;
//!
//! let config = ServeConfig::default();
//! config.check()?;
//! assert!(config.embedded().is_some() && config.machines.is_empty());
//! # Ok::<(), gt_serve::ServeError>(())
//! ```
//!
//! What an operator has to know stands in `docs/service.md`.

mod clock;
mod config;
mod error;
#[cfg(fuzzing)]
pub mod fuzzing;
mod history;
mod http;
mod hub;
mod journal;
mod logging;
mod metrics;
mod outbox;
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
