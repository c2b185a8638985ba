//! A run: the plant from its equilibrium through a scenario, sampled.

use gt_core::{Dataset, Signal};
use nalgebra::DMatrix;

use crate::channels::{INPUTS, OUTPUTS, input_signals, output_signals};
use crate::dynamics::{Inputs, derivative, sample};
use crate::excitation::Excitation;
use crate::faults::{Fault, FaultCase, FaultSizes};
use crate::scenario::Scenario;
use crate::sensors::{Deviations, NoiseLevel, add_drift, add_noise};
use crate::state::State;
use crate::trim::steady_state;
use crate::warning::{LimitCounter, Warning};
use crate::{PlantError, PlantParameters, SAMPLE_TIME_S, rk4};

/// The record of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// What the plant did: no noise, and t3 as it is, not as a drifting thermocouple reads it.
    pub truth: Dataset,
    /// What the sensors say: drift and noise included.
    pub measured: Dataset,
    /// Name and unit of each fault of the scenario (nf).
    pub fault_signals: Vec<Signal>,
    /// Magnitude of each fault at each sample (nf x N).
    pub fault_magnitudes: DMatrix<f64>,
    /// What a reader of the record should know.
    pub warnings: Vec<Warning>,
}

/// Runs a scenario with the parameters of its map set.
///
/// # Errors
/// See [`simulate_with`].
pub fn simulate(scenario: &Scenario) -> Result<Run, PlantError> {
    simulate_with(&PlantParameters::for_maps(scenario.map_set), scenario)
}

/// Runs a scenario with given parameters, which replace those of its map set.
///
/// The run starts from the healthy equilibrium. At `t = k Ts`, `k = 0 .. N-1`, the outputs and the
/// governor's demand are read; then valve, speed reference and dither move and are held until the
/// next sample, while the governor acts continuously. `a_v` and `w_ref` are recorded as they are
/// held from `t` on, so that a model needs no direct term for them; `M_f` is the demand that the
/// outputs saw, and every output needs a direct term for it (`nk = 0`). Recording `a_v` before it
/// moves would call for a direct term there too: without one, free runs of ARX models of order 8
/// diverged.
///
/// Where there is noise and a fault that acts on the plant, the healthy record is simulated too,
/// because noise is scaled by it.
///
/// # Errors
/// [`PlantError`] when parameters or scenario are refused, when there is no equilibrium, or when
/// the plant leaves the range in which the model means something.
pub fn simulate_with(parameters: &PlantParameters, scenario: &Scenario) -> Result<Run, PlantError> {
    scenario.validate()?;
    let path = integrate(parameters, scenario, &scenario.faults)?;
    let n = path.y.ncols();
    let mut warnings = path.limits.warnings();
    let (mut u, mut y) = (path.u.clone(), path.y.clone());
    add_drift(&mut y, &scenario.faults, time_s);
    if scenario.noise != NoiseLevel::None && !scenario.profile.excites() {
        warnings.push(Warning::NoNoise);
    } else if scenario.noise != NoiseLevel::None {
        let reaches_plant = |fault: &Fault| {
            fault.case() != FaultCase::ThermocoupleDrift && fault.magnitude(time_s(n - 1)) != 0.0
        };
        let deviations = if scenario.faults.iter().any(reaches_plant) {
            let healthy = integrate(parameters, scenario, &[])?;
            Deviations::of(&healthy.u, &healthy.y)
        } else {
            Deviations::of(&path.u, &path.y)
        };
        let key = [scenario.seed, scenario.run_index];
        add_noise(&mut u, &mut y, scenario.noise, &deviations, key);
    }
    let dataset = |u, y| Dataset::new(input_signals(), output_signals(), u, y, SAMPLE_TIME_S);
    Ok(Run {
        truth: dataset(path.u, path.y)?,
        measured: dataset(u, y)?,
        fault_signals: scenario.faults.iter().map(Fault::signal).collect(),
        fault_magnitudes: DMatrix::from_fn(scenario.faults.len(), n, |row, k| {
            scenario.faults[row].magnitude(time_s(k))
        }),
        warnings,
    })
}

/// Time of sample `k`, s.
fn time_s(k: usize) -> f64 {
    k as f64 * SAMPLE_TIME_S
}

/// The true inputs (5 x N) and outputs (28 x N) of a run.
struct Path {
    u: DMatrix<f64>,
    y: DMatrix<f64>,
    limits: LimitCounter,
}

fn integrate(
    parameters: &PlantParameters,
    scenario: &Scenario,
    faults: &[Fault],
) -> Result<Path, PlantError> {
    let n = scenario.samples()?;
    let step_s = scenario.step_s();
    let design = Inputs::design(parameters);
    let mut inputs = design;
    let mut excitation = Excitation::new(&scenario.profile, scenario.seed, scenario.run_index);
    let mut x = steady_state(parameters)?.state.to_array();
    let mut path = Path {
        u: DMatrix::zeros(INPUTS, n),
        y: DMatrix::zeros(OUTPUTS, n),
        limits: LimitCounter::default(),
    };
    for k in 0..n {
        let t = time_s(k);
        let sizes = FaultSizes::at(faults, t);
        let sampled = sample(parameters, &inputs, &sizes, &State::from_array(&x), t)?;
        path.limits.see(sampled.demand.limit, t);
        path.y.column_mut(k).copy_from_slice(&sampled.outputs);
        let deviation = excitation.step();
        inputs.valve_deg = design.valve_deg + deviation.valve_deg;
        inputs.speed_reference_rad_s =
            design.speed_reference_rad_s * (1.0 + deviation.speed_fraction);
        inputs.fuel_dither_kg_s = parameters.governor.design_fuel_kg_s * deviation.dither_fraction;
        path.u.column_mut(k).copy_from_slice(&[
            inputs.valve_deg,
            sampled.demand.fuel_kg_s,
            inputs.speed_reference_rad_s,
            inputs.ambient_pa,
            inputs.ambient_k,
        ]);
        if k + 1 == n {
            break;
        }
        for substep in 0..scenario.substeps {
            let start_s = t + substep as f64 * step_s;
            let rates = |t: f64, x: &[f64; _]| {
                derivative(parameters, &inputs, &FaultSizes::at(faults, t), x)
            };
            x = rk4::step(rates, start_s, &x, step_s);
            State::from_array(&x).check(start_s + step_s)?;
        }
    }
    Ok(path)
}
