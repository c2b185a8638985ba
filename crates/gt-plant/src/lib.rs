//! A single-shaft gas turbine with speed governor and pressurising valve: 13 states, 28 measured
//! outputs and four faults, calibrated to the steady state in Table 3 of Simani and Fantuzzi
//! (2006), *Dynamic system identification and model-based fault diagnosis of an industrial gas
//! turbine prototype*.
//!
//! The paper prints one operating point and no map, volume, inertia or gain. What it does not
//! settle is assumed, and every parameter says so in its documentation. In particular:
//!
//! - m1 is read as one of two equal intake legs; otherwise it would be wrong by a factor of 2.
//! - t1, t2, p1 and p8 of Table 3 need a fan, a draught and heat flows that the paper does not
//!   mention; they are constants here.
//! - The printed powers and torques are no exact equilibrium and the printed `e_c` (0.877) disagrees
//!   with t2, t3 and the pressure ratio (0.839 with real heat capacities); the model keeps the
//!   energy balance instead.
//! - The default compressor map was chosen because it shows the paper's fault signature; see
//!   [`MapSet`].
//!
//! [`simulate`] runs a [`Scenario`]; [`steady_state`] and [`trim::trim`] find equilibria; below
//! them [`dynamics::derivative`] is a pure function that [`rk4::step`] integrates.
//!
//! ```
//! use gt_plant::{Fault, FaultCase, Scenario, simulate};
//!
//! let scenario = Scenario {
//!     duration_s: 8.0,
//!     faults: vec![Fault::nominal(FaultCase::TurbineDamage, 4.0)],
//!     ..Scenario::default()
//! };
//! let run = simulate(&scenario)?;
//! assert_eq!((run.measured.nu(), run.measured.ny(), run.measured.len()), (5, 28, 100));
//! # Ok::<(), gt_plant::PlantError>(())
//! ```

pub mod channels;
pub mod components;
pub mod dynamics;
mod error;
pub mod excitation;
mod faults;
pub mod gas;
pub mod linearise;
mod params;
mod random;
pub mod rk4;
mod scenario;
mod sensors;
mod simulate;
pub mod state;
pub mod trim;
mod validate;
mod warning;

pub use error::PlantError;
pub use excitation::Profile;
pub use faults::{Fault, FaultCase, FaultSizes};
pub use params::{DesignPoint, MapSet, PlantParameters};
pub use scenario::{LONGEST_STEP_S, Scenario};
pub use sensors::{Deviations, NoiseLevel};
pub use simulate::{Run, simulate, simulate_with};
pub use trim::{SteadyState, steady_state};
pub use warning::Warning;

/// Sample time of every record, s (paper, section 5.1).
pub const SAMPLE_TIME_S: f64 = 0.08;
