//! A single-shaft gas turbine, non-linear, with faults: the machine of Simani and Fantuzzi (2006),
//! *Dynamic system identification and model-based fault diagnosis of an industrial gas turbine
//! prototype*, in its two [`Variant`]s.
//!
//! | variant | who holds the speed | states | inputs | outputs |
//! |---|---|---|---|---|
//! | prototype (section 5.1) | a governor, by the fuel; a pressurising valve moves | 14 | 6 | 28 |
//! | cogeneration (section 3.1) | the mains; the fuel sets the load, guide vanes hold the exhaust temperature | 17 | 7 | 31 |
//!
//! [`simulate`] takes a [`Scenario`], which determines everything, and gives a [`Run`]: what the
//! plant did, what its sensors said, what no sensor measures, and the size of each fault. The same
//! scenario gives the same bits. [`simulate_batch`] runs many on one core.
//!
//! ```
//! use gt_plant::{Fault, FaultCase, Scenario, Variant, simulate};
//!
//! let scenario = Scenario {
//!     duration_s: 8.0,
//!     faults: vec![Fault::nominal(FaultCase::TurbineDamage, 4.0)],
//!     ..Scenario::default()
//! };
//! let run = simulate(&scenario)?;
//! assert_eq!((run.measured.nu(), run.measured.ny(), run.measured.len()), (6, 28, 100));
//!
//! // A scenario is a file too, see `Scenario`, `Fault`, `Noise`, `Boundary` and `maps`.
//! let scenario: Scenario = toml::from_str("variant = 'cogeneration'\nduration_s = 8.0")?;
//! let run = simulate(&scenario)?;
//! assert_eq!((run.measured.nu(), run.measured.ny(), run.measured.len()), (7, 31, 100));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Where things are
//!
//! - **What is simulated**: [`Scenario`] and its parts: [`Profile`] (excitation), [`Boundary`]
//!   (ambient conditions, heating value), [`Disturbance`], [`Noise`], [`Fault`], [`maps::Tables`].
//! - **The physics**: [`components`] has a law a file, [`maps`] those of compressor and turbine,
//!   [`gas`] the properties; [`gas_path`] puts them together at one state, and
//!   [`dynamics::derivative`] adds actuators and controllers: a pure function, which [`rk4::step`]
//!   integrates. All of it is written once over the numbers of [`real`]: plain, with exact
//!   derivatives ([`dual`]) or many plants at once ([`lanes`]).
//! - **The numbers**: [`PlantParameters`] has every one with its unit and source, [`calibration`]
//!   derives them from the paper's Table 3.
//! - **Analysis**: [`steady_state`] and [`trim::trim`] (equilibria), [`local_model()`] (the linear
//!   plant), [`stability`] (which steps are stable), [`effects`] (what the paper's faults do to
//!   each output).
//!
//! # What is known, and what is not
//!
//! The paper prints one operating point, Table 3, and no map, volume, inertia or gain. What it does
//! not settle is assumed, and every parameter says so. In particular:
//!
//! - **Table 3 contradicts itself**: its flows do not balance, its powers are no equilibrium, its
//!   temperatures and efficiencies disagree. [`calibration`] lists each case and what is done about
//!   it. The pressures, t1 to t6, m1, the speed and the fuel are met to five digits, everything
//!   else within 0.8 percent but m5, m9 (1.2) and `e_t` (1.7).
//! - **`e_c`** is reported from ambient conditions, because the printed t2, below ambient, is not
//!   physical: 0.878, the paper has 0.877.
//! - **The default compressor map was chosen because it shows the paper's fault signature**, with
//!   exponents that are too flat for an axial machine; [`MapSet::Axial`] has usual ones and does not
//!   show all of it. Dynamics rest on assumed volumes and inertias.
//! - Far from the design point the laws are no more than plausible. A run that leaves a map says so
//!   in [`Run::warnings`]; one that leaves the range in which the model means something ends there,
//!   see [`Run::ended`].

mod batch;
pub mod boundary;
pub mod calibration;
mod channel;
pub mod channels;
pub mod components;
mod disturbance;
pub mod drive;
pub mod dual;
pub mod dynamics;
pub mod effects;
mod error;
pub mod excitation;
mod faults;
pub mod gas;
pub mod gas_path;
pub mod inputs;
mod interval;
pub mod lanes;
pub mod linearise;
mod live;
mod local_model;
pub mod maps;
mod open_loop;
mod operation;
mod params;
mod random;
pub mod real;
mod recorder;
pub mod rk4;
mod scenario;
mod scenario_text;
mod sensors;
mod simulate;
pub mod stability;
pub mod state;
pub mod trim;
mod validate;
mod variant;
mod warning;

pub use batch::{lanes_at_once, simulate_batch};
pub use boundary::{Boundary, Course, Fluctuation, Sine};
pub use channel::{CHANNELS, Channel, ChannelRow};
pub use disturbance::Disturbance;
pub use effects::{EffectSettings, FaultEffects, LagLimit, lag_limit};
pub use error::PlantError;
pub use excitation::Profile;
pub use faults::{
    ActuatorFault, ActuatorId, Exponential, Fault, FaultCase, FaultSizes, Intermittent, Mode, Ramp,
    Shape, Step, Target,
};
pub use inputs::Inputs;
pub use live::{LivePlant, LiveSample};
pub use local_model::{local_model, longest_step_s};
pub use open_loop::open_loop_model;
pub use params::{DesignPoint, MapSet, PlantParameters};
pub use scenario::Scenario;
pub use sensors::{ChannelNoise, Deviations, Noise, NoiseLevel, NoiseScale};
pub use simulate::{Run, simulate, simulate_until, simulate_with};
pub use trim::{SteadyState, steady_state};
pub use variant::Variant;
pub use warning::{Seen, Warning};

/// Sample time of every record, s (paper, section 5.1).
pub const SAMPLE_TIME_S: f64 = 0.08;
