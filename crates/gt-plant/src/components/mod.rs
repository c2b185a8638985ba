//! The parts of the turbine: each a set of parameters with its small, pure laws.

pub mod actuator;
pub mod bleed;
pub mod combustor;
pub mod compressor;
pub mod duct;
pub mod exhaust;
pub mod generator;
pub mod governor;
pub mod guide_vanes;
pub mod intake;
pub mod shaft;
pub mod turbine;
pub mod valve;
pub mod volume;
