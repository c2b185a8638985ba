//! Models of several operating points, handed over smoothly by a measured load.
//!
//! A linear model holds near its operating point. Here each point of a scheduling channel (a load,
//! a speed demand) has its own ARX model, and between two points both take part with a weight that
//! rises from 0 to 1: their equations are blended, not their runs, so that one past serves both.

mod fit;
mod membership;
mod model;
mod predict;
mod stacked;

pub use fit::{Estimation, ScheduledArx};
pub use model::{SchedulePoint, ScheduledModel};
