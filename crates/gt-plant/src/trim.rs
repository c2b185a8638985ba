//! Equilibria by Newton's method, and the steady state in terms of the measured variables.

use gt_core::Signal;
use nalgebra::SVector;

use crate::channels::{self, OUTPUTS, output_signals};
use crate::dynamics::{Inputs, Point, gas_path_rates, operating_point};
use crate::faults::FaultSizes;
use crate::linearise::jacobian;
use crate::state::{GAS_PATH_STATES, State};
use crate::{PlantError, PlantParameters};

/// Newton iterations before the search is given up.
const ITERATIONS: usize = 50;
/// Rate of each state over its size that counts as an equilibrium, 1/s. Rounding leaves 1e-12;
/// over an hour this is a change of 4e-7 even without a governor.
const TOLERANCE_PER_S: f64 = 1e-10;
/// Largest change of an unknown in one iteration, relative: keeps the first steps in the maps.
const LARGEST_CHANGE: f64 = 0.2;

/// What is held while the equilibrium is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hold {
    /// The governor holds the speed reference; the fuel is found.
    Speed,
    /// This fuel flow, kg/s, without a governor; the speed is found.
    Fuel {
        /// Fuel flow, kg/s.
        kg_s: f64,
    },
}

/// An equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyState {
    /// The state, with the governor's integral that holds it.
    pub state: State,
    /// The algebraic quantities of the gas path.
    pub point: Point,
    /// True outputs, in the order of [`channels::OUTPUT_CHANNELS`].
    pub outputs: [f64; OUTPUTS],
}

impl SteadyState {
    /// The 28 outputs, then the efficiencies `e_c` and `e_t`.
    pub fn variables(&self) -> Vec<(Signal, f64)> {
        let mut variables: Vec<_> = output_signals().into_iter().zip(self.outputs).collect();
        variables.push((Signal::new("e_c", ""), self.point.compression.efficiency));
        variables.push((Signal::new("e_t", ""), self.point.expansion.efficiency));
        variables
    }

    /// The value of one of [`SteadyState::variables`], by name.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.variables()
            .into_iter()
            .find(|(signal, _)| signal.name == name)
            .map(|(_, value)| value)
    }
}

/// The healthy equilibrium at the design speed, valve angle and ambient conditions.
///
/// # Errors
/// [`PlantError::Parameter`] for impossible parameters, [`PlantError::Trim`] when there is no
/// equilibrium nearby.
pub fn steady_state(parameters: &PlantParameters) -> Result<SteadyState, PlantError> {
    trim(
        parameters,
        &Inputs::design(parameters),
        &FaultSizes::HEALTHY,
        Hold::Speed,
    )
}

/// The equilibrium for given inputs and constant fault sizes.
///
/// Unknowns are the 11 states of gas path and rotor, where [`Hold::Speed`] puts the fuel flow in
/// the place of the speed; Newton's method with a Jacobian by central differences starts from the
/// design point of Table 3.
///
/// # Errors
/// [`PlantError::Parameter`] for impossible parameters, [`PlantError::Trim`] when Newton's method
/// does not converge, [`PlantError::OutOfRange`] when it ends outside the model's validity.
pub fn trim(
    parameters: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    hold: Hold,
) -> Result<SteadyState, PlantError> {
    parameters.validate()?;
    let start = parameters
        .design
        .state(parameters.governor.design_fuel_kg_s);
    let unpack = |z: &[f64; GAS_PATH_STATES]| unpacked(z, inputs, parameters, hold);
    let rates = |z: &[f64; GAS_PATH_STATES]| {
        let (x, fuel_kg_s) = unpack(z);
        let point = operating_point(parameters, inputs, faults, &x, fuel_kg_s);
        gas_path_rates(parameters, inputs, &x, &point)
    };
    let full = start.to_array();
    let mut z: [f64; GAS_PATH_STATES] = std::array::from_fn(|i| full[i]);
    let state_scale = z;
    if hold == Hold::Speed {
        z[0] = parameters.governor.design_fuel_kg_s;
    }
    let unknown_scale = z;
    let size = |rates: &[f64; GAS_PATH_STATES]| {
        // `f64::max` would drop a NaN.
        rates
            .iter()
            .zip(&state_scale)
            .map(|(rate, scale)| (rate / scale).abs())
            .fold(0.0, |worst: f64, rate| {
                if rate.is_nan() || rate > worst {
                    rate
                } else {
                    worst
                }
            })
    };
    let mut found_per_s = f64::NAN;
    let mut converged = false;
    for _ in 0..ITERATIONS {
        let residual = rates(&z);
        found_per_s = size(&residual);
        // One more step after the tolerance is met reaches the rounding level.
        let last = found_per_s < TOLERANCE_PER_S;
        let matrix = jacobian(rates, &z, &unknown_scale);
        let Some(change) = matrix.lu().solve(&-SVector::from(residual)) else {
            break;
        };
        let largest = change
            .iter()
            .zip(&unknown_scale)
            .map(|(change, scale)| (change / scale).abs())
            .fold(0.0, f64::max);
        let damping = if largest > LARGEST_CHANGE {
            LARGEST_CHANGE / largest
        } else {
            1.0
        };
        for i in 0..GAS_PATH_STATES {
            z[i] += damping * change[i];
        }
        if last {
            converged = true;
            break;
        }
    }
    if !converged {
        let (iterations, tolerance_per_s) = (ITERATIONS, TOLERANCE_PER_S);
        return Err(PlantError::Trim {
            iterations,
            tolerance_per_s,
            found_per_s,
        });
    }
    let (state, fuel_kg_s) = unpack(&z);
    state.check(0.0)?;
    let point = operating_point(parameters, inputs, faults, &state, fuel_kg_s);
    let outputs = channels::outputs(&state, &point);
    Ok(SteadyState {
        state,
        point,
        outputs,
    })
}

/// State and fuel flow from the unknowns.
fn unpacked(
    z: &[f64; GAS_PATH_STATES],
    inputs: &Inputs,
    parameters: &PlantParameters,
    hold: Hold,
) -> (State, f64) {
    let [first, mi, p1, p3, m4, p4, m5, p5, p7, p8, mex] = *z;
    let (speed_rad_s, fuel_kg_s) = match hold {
        Hold::Speed => (inputs.speed_reference_rad_s, first),
        Hold::Fuel { kg_s } => (first, kg_s),
    };
    let integral = parameters.governor.integral_for(fuel_kg_s);
    let x = [
        speed_rad_s,
        mi,
        p1,
        p3,
        m4,
        p4,
        m5,
        p5,
        p7,
        p8,
        mex,
        integral,
        fuel_kg_s,
    ];
    (State::from_array(&x), fuel_kg_s)
}
