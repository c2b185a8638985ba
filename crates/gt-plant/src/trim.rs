//! Equilibria by Newton's method, and the steady state in terms of the measured variables.

use gt_core::Signal;
use nalgebra::SVector;

use crate::channels::{self, ALL_OUTPUTS, HIDDEN_CHANNELS, signals};
use crate::components::actuator::between;
use crate::components::valve::VALVE_STOPS_DEG;
use crate::dynamics::Instant;
use crate::faults::FaultSizes;
use crate::gas_path::{Actuation, Point};
use crate::inputs::Inputs;
use crate::linearise::jacobian_exact;
use crate::real::Real;
use crate::state::{GAS_PATH_STATES, STATES, State};
use crate::variant::Variant;
use crate::{PlantError, PlantParameters};

/// Newton iterations before the search is given up.
const ITERATIONS: usize = 50;
/// Rate of each state over its size that counts as an equilibrium, 1/s. Rounding leaves 1e-12;
/// over an hour this is a change of 4e-7 even without a governor.
const TOLERANCE_PER_S: f64 = 1e-10;
/// The same for the plant with its controllers: above what rounding leaves, far below what a limit
/// that holds the fuel back makes of it.
const HELD_PER_S: f64 = 1e-8;
/// Largest change of an unknown in one iteration, relative: keeps the first steps in the maps.
const LARGEST_CHANGE: f64 = 0.2;
/// Unknowns: one that [`Hold`] chooses, ten of the gas path, the guide vanes.
const UNKNOWNS: usize = GAS_PATH_STATES + 1;
/// Load torque from which the search starts in cogeneration, N m.
const START_LOAD_N_M: f64 = 800.0;
/// Guide vane angle from which the search starts in cogeneration, degrees.
const START_VANES_DEG: f64 = 10.0;

/// What is held while the equilibrium is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hold {
    /// The controllers of the variant: the governor holds the speed reference and the fuel is
    /// found; or the mains hold the speed, the fuel is given, and the guide vanes hold the exhaust
    /// temperature as far as their stops let them.
    Control,
    /// This fuel flow, kg/s, without governor or generator; the speed is found.
    Fuel {
        /// Fuel flow, kg/s.
        kg_s: f64,
    },
}

/// An equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyState {
    /// Which machine.
    pub variant: Variant,
    /// The state, with the controllers' integrals that hold it.
    pub state: State,
    /// The algebraic quantities of the gas path.
    pub point: Point,
    /// All outputs, in the order of [`channels::outputs`].
    pub outputs: [f64; ALL_OUTPUTS],
}

impl SteadyState {
    /// The measured outputs of the variant, then the efficiencies `e_c` and `e_t`.
    pub fn variables(&self) -> Vec<(Signal, f64)> {
        let measured = self.variant.output_channels();
        let hidden = &self.outputs[ALL_OUTPUTS - HIDDEN_CHANNELS.len()..];
        signals(measured)
            .into_iter()
            .zip(self.outputs)
            .chain(
                signals(&HIDDEN_CHANNELS)
                    .into_iter()
                    .zip(hidden.iter().copied()),
            )
            .filter(|(signal, _)| signal.name != "M_fc")
            .collect()
    }

    /// The value of one of [`SteadyState::variables`], by name.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.variables()
            .into_iter()
            .find(|(signal, _)| signal.name == name)
            .map(|(_, value)| value)
    }
}

/// The healthy equilibrium at the design inputs.
///
/// # Errors
/// [`PlantError::Parameter`] for impossible parameters, [`PlantError::Trim`] when there is no
/// equilibrium nearby.
pub fn steady_state(parameters: &PlantParameters) -> Result<SteadyState, PlantError> {
    trim(
        parameters,
        &Inputs::design(parameters),
        &FaultSizes::HEALTHY,
        Hold::Control,
    )
}

/// The equilibrium for given inputs and constant fault sizes.
///
/// Unknowns are the states of the gas path, where the fuel flow (governor) or the load (mains) may
/// take the place of the speed, and the guide vanes; Newton's method starts from the design point
/// of Table 3.
///
/// # Errors
/// [`PlantError::Parameter`] for impossible parameters, [`PlantError::Trim`] when Newton's method
/// does not converge, [`PlantError::OutOfRange`] when it ends outside the model's validity,
/// [`PlantError::NotHeld`] when a limit or a stuck actuator keeps the controllers from holding it.
pub fn trim(
    parameters: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    hold: Hold,
) -> Result<SteadyState, PlantError> {
    parameters.validate()?;
    let search = |vanes| {
        Search {
            plant: parameters,
            inputs,
            faults,
            hold,
            vanes,
        }
        .solve()
    };
    let state = match (parameters.variant, hold) {
        (Variant::Cogeneration, Hold::Control) => at_rest(parameters, faults, search)?,
        _ => search(Vanes::At(0.0))?,
    };
    state.check(0.0)?;
    let instant = Instant::at(parameters, inputs, faults, &state);
    check_held(parameters, hold, &instant)?;
    Ok(SteadyState {
        variant: parameters.variant,
        state,
        point: instant.point,
        outputs: channels::outputs(parameters, inputs, &state, &instant),
    })
}

/// The equilibrium in which the guide vanes' controller rests too: it holds the exhaust
/// temperature, or asks for a stop because the exhaust is too hot with open vanes or too cold with
/// closed ones.
fn at_rest(
    plant: &PlantParameters,
    faults: &FaultSizes,
    search: impl Fn(Vanes) -> Result<State, PlantError>,
) -> Result<State, PlantError> {
    let (vanes, fault) = (&plant.guide_vanes, &faults.guide_vanes);
    let demanding = |mut state: State, demand_deg: f64| {
        let reading_k = state.exhaust_reading_k;
        state.exhaust_error_integral_k_s = vanes.integral_for(demand_deg, reading_k);
        state
    };
    if fault.stuck == 0.0
        && let Ok(state) = search(Vanes::HoldExhaust)
    {
        let angle_deg = state.guide_vane_deg;
        let demand_deg = (angle_deg - fault.offset) / (1.0 + fault.gain_error);
        // Both have the same limits, and a fault lies between them: a demand within the limits may
        // ask for an angle beyond them.
        let within = 0.0..=vanes.closed_deg;
        if within.contains(&demand_deg) && within.contains(&angle_deg) {
            return Ok(demanding(state, demand_deg));
        }
    }
    // Far beyond a stop the vanes' law means nothing and the search may fail: the exhaust with open
    // vanes says which stop it is.
    let open = search(Vanes::At(between(vanes.stops_deg(), fault.position(0.0))))?;
    if open.exhaust_reading_k >= vanes.set_point_k {
        let demand_deg = vanes.resting_demand_deg(0.0, open.exhaust_reading_k);
        return Ok(demanding(open, demand_deg));
    }
    let closed = search(Vanes::At(between(
        vanes.stops_deg(),
        fault.position(vanes.closed_deg),
    )))?;
    let demand_deg = vanes.resting_demand_deg(vanes.closed_deg, closed.exhaust_reading_k);
    Ok(demanding(closed, demand_deg))
}

/// Refuses a state that the controllers do not hold, because a limit, a stop or a stuck actuator
/// keeps them from what the gas path needs.
fn check_held(plant: &PlantParameters, hold: Hold, instant: &Instant) -> Result<(), PlantError> {
    let gas_path = plant.design.gas_path();
    let rates = instant.rates.iter().zip(gas_path);
    let mut relative: Vec<f64> = rates.map(|(rate, size)| rate / size).collect();
    if let (Hold::Control, Variant::Cogeneration) = (hold, plant.variant) {
        relative.push(instant.rates[16] / plant.guide_vanes.set_point_k);
        relative.push(instant.rates[17] / plant.guide_vanes.closed_deg);
    }
    let found_per_s = largest(&relative);
    if found_per_s < HELD_PER_S {
        return Ok(());
    }
    Err(PlantError::NotHeld {
        tolerance_per_s: HELD_PER_S,
        found_per_s,
    })
}

/// What fixes the guide vanes.
#[derive(Clone, Copy)]
enum Vanes {
    At(f64),
    HoldExhaust,
}

struct Search<'a> {
    plant: &'a PlantParameters,
    inputs: &'a Inputs,
    faults: &'a FaultSizes,
    hold: Hold,
    vanes: Vanes,
}

/// A guess of the equilibrium.
struct Guess<R> {
    state: State<R>,
    point: Point<R>,
    load_n_m: R,
}

impl Search<'_> {
    fn guess<R: Real>(&self, z: &[R; UNKNOWNS]) -> Guess<R> {
        let zero = z[0].like(0.0);
        let inputs = self.inputs.like(zero);
        let faults = self.faults.like(zero);
        let reference = inputs.speed_reference_rad_s;
        let governor = &self.plant.governor;
        let (speed, fuel, load_n_m) = match (self.hold, self.plant.variant) {
            (Hold::Fuel { kg_s }, _) => (z[0], zero.like(kg_s), zero),
            (Hold::Control, Variant::Prototype) => (reference, z[0], zero),
            (Hold::Control, Variant::Cogeneration) => {
                let demand = governor.limited(inputs.fuel_offset_kg_s + governor.design_fuel_kg_s);
                (
                    reference,
                    between(self.plant.fuel_stops(), faults.fuel.position(demand)),
                    z[0],
                )
            }
        };
        let valve_deg = between(VALVE_STOPS_DEG, faults.valve.position(inputs.valve_deg));
        let mut x = [zero; STATES];
        x[0] = speed;
        x[1..GAS_PATH_STATES].copy_from_slice(&z[1..GAS_PATH_STATES]);
        let mut state = State::from_array(&x);
        let actuation = Actuation {
            fuel_kg_s: fuel,
            valve_deg,
            guide_vane_deg: z[UNKNOWNS - 1],
        };
        let point = Point::at(self.plant, &inputs, &faults, &state, &actuation);
        let demand = (fuel - faults.fuel.offset) / (faults.fuel.gain_error + 1.0);
        state.fuel_actuator_kg_s = fuel;
        state.valve_actuator_deg = valve_deg;
        state.guide_vane_deg = actuation.guide_vane_deg;
        state.exhaust_reading_k = point.t7_k;
        if self.plant.variant == Variant::Prototype {
            // The integral that demands this fuel, also where the speed is not at its reference.
            let proportional = (reference - speed) * governor.proportional_gain;
            state.speed_error_integral_rad =
                governor.integral_for(demand - inputs.fuel_offset_kg_s - proportional);
            state.exhaust_reading_k = zero.like(self.plant.guide_vanes.set_point_k);
        }
        Guess {
            state,
            point,
            load_n_m,
        }
    }

    /// Rates of the gas path over the size of its states, and what fixes the guide vanes.
    fn residual<R: Real>(&self, z: &[R; UNKNOWNS], scale: &[f64; UNKNOWNS]) -> [R; UNKNOWNS] {
        let guess = self.guess(z);
        let inputs = self.inputs.like(z[0]);
        let rates = guess
            .point
            .rates(self.plant, &inputs, &guess.state, guess.load_n_m);
        let set_k = self.plant.guide_vanes.set_point_k;
        std::array::from_fn(|i| {
            if i < GAS_PATH_STATES {
                rates[i] / scale[i]
            } else {
                match self.vanes {
                    Vanes::At(angle_deg) => (z[i] - angle_deg) / scale[i],
                    Vanes::HoldExhaust => (guess.point.t7_k - set_k) / set_k,
                }
            }
        })
    }

    fn solve(&self) -> Result<State, PlantError> {
        let gas_path = self.plant.design.gas_path();
        let mut state_scale = [self.plant.guide_vanes.closed_deg; UNKNOWNS];
        state_scale[..GAS_PATH_STATES].copy_from_slice(&gas_path);
        let mut z = state_scale;
        z[0] = match (self.hold, self.plant.variant) {
            (Hold::Fuel { .. }, _) => z[0],
            (Hold::Control, Variant::Prototype) => self.plant.governor.design_fuel_kg_s,
            (Hold::Control, Variant::Cogeneration) => START_LOAD_N_M,
        };
        let mut unknown_scale = z;
        unknown_scale[UNKNOWNS - 1] = self.plant.guide_vanes.closed_deg;
        z[UNKNOWNS - 1] = match self.vanes {
            Vanes::At(angle_deg) => angle_deg,
            Vanes::HoldExhaust => START_VANES_DEG,
        };
        let mut found_per_s = f64::NAN;
        for _ in 0..ITERATIONS {
            let residual = self.residual(&z, &state_scale);
            found_per_s = largest(&residual);
            // One more step after the tolerance is met reaches the rounding level.
            let last = found_per_s < TOLERANCE_PER_S;
            let matrix = jacobian_exact(|z| self.residual(z, &state_scale), &z);
            let Some(change) = matrix.lu().solve(&-SVector::from(residual)) else {
                break;
            };
            let relative: [f64; UNKNOWNS] = std::array::from_fn(|i| change[i] / unknown_scale[i]);
            let step = largest(&relative);
            let damping = if step > LARGEST_CHANGE {
                LARGEST_CHANGE / step
            } else {
                1.0
            };
            for i in 0..UNKNOWNS {
                z[i] += damping * change[i];
            }
            if last {
                return Ok(self.finished(&z));
            }
        }
        let (iterations, tolerance_per_s) = (ITERATIONS, TOLERANCE_PER_S);
        Err(PlantError::Trim {
            iterations,
            tolerance_per_s,
            found_per_s,
        })
    }

    /// The state of a solution, with the load angle that carries its load.
    fn finished(&self, z: &[f64; UNKNOWNS]) -> State {
        let mut guess = self.guess(z);
        let power_w = guess.load_n_m * self.inputs.speed_reference_rad_s;
        guess.state.load_angle_rad = (power_w / self.plant.generator.pull_out_power_w).asin();
        guess.state
    }
}

/// The largest absolute value; a NaN wins, which `f64::max` would drop.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |worst: f64, value| {
        if value.is_nan() || value.abs() > worst {
            value.abs()
        } else {
            worst
        }
    })
}
