//! The lag of the fuel actuator at which the speed loop loses its stability.

use nalgebra::Complex;
use serde::Serialize;

use super::prototype_only;
use crate::faults::{ActuatorFault, FaultSizes};
use crate::inputs::Inputs;
use crate::local_model::local_model;
use crate::state::State;
use crate::trim::steady_state;
use crate::{PlantError, PlantParameters};

/// The longest lag that is tried, s.
const LONGEST_LAG_S: f64 = 1e3;
/// Width of the bracket over the limit at which the search ends.
const TOLERANCE: f64 = 1e-12;

/// Where the speed loop loses its stability as the fuel actuator's lag (case 4) grows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LagLimit {
    /// The lag, s: above it the speed swings by itself between the limits of the fuel. Zero where
    /// the healthy loop is unstable already.
    pub lag_s: f64,
    /// Angular frequency of the mode that neither decays nor grows there, rad/s.
    pub frequency_rad_s: f64,
}

/// The smallest lag of the fuel actuator, up to 1000 s, at which a mode of a prototype, linearised
/// about its design equilibrium, no longer decays; none where all decay throughout.
///
/// The lag is doubled until a mode grows, then bisected.
///
/// # Errors
/// [`PlantError::NotInVariant`] for another machine, otherwise as [`local_model`] and
/// [`steady_state`].
pub fn lag_limit(plant: &PlantParameters) -> Result<Option<LagLimit>, PlantError> {
    prototype_only(plant, "lag limit of the speed loop")?;
    // A lag moves no equilibrium.
    let state = steady_state(plant)?.state;
    let pole = |lag_s| slowest_pole(plant, &state, lag_s);
    let (mut stable_s, mut unstable_s) = (0.0, plant.actuator.shortest_lag_s);
    if pole(stable_s)?.re >= 0.0 {
        unstable_s = 0.0;
    }
    while unstable_s > stable_s && pole(unstable_s)?.re < 0.0 {
        if unstable_s >= LONGEST_LAG_S {
            return Ok(None);
        }
        (stable_s, unstable_s) = (unstable_s, 2.0 * unstable_s);
    }
    while unstable_s - stable_s > TOLERANCE * unstable_s {
        let middle_s = 0.5 * (stable_s + unstable_s);
        if pole(middle_s)?.re < 0.0 {
            stable_s = middle_s;
        } else {
            unstable_s = middle_s;
        }
    }
    Ok(Some(LagLimit {
        lag_s: unstable_s,
        frequency_rad_s: pole(unstable_s)?.im.abs(),
    }))
}

/// The slowest pole of the closed loop at a lag, 1/s.
fn slowest_pole(
    plant: &PlantParameters,
    state: &State,
    lag_s: f64,
) -> Result<Complex<f64>, PlantError> {
    let faults = FaultSizes {
        fuel: ActuatorFault {
            lag_s,
            ..ActuatorFault::HEALTHY
        },
        ..FaultSizes::HEALTHY
    };
    let model = local_model(plant, &Inputs::design(plant), &faults, state)?;
    let none = Complex::new(f64::NEG_INFINITY, 0.0);
    Ok(model.poles_per_s().first().copied().unwrap_or(none))
}
