//! A run: the plant from its equilibrium through a scenario, sampled.

use gt_core::{Dataset, Never, Signal, Stop};
use nalgebra::DMatrix;

use crate::channels::{HIDDEN_CHANNELS, OUTPUTS, recorded_inputs, signals};
use crate::dynamics::derivative;
use crate::faults::Fault;
use crate::inputs::Inputs;
use crate::recorder::{Path, Recorder};
use crate::scenario::Scenario;
use crate::sensors::{Deviations, NoiseBasis, measure};
use crate::state::STATES;
use crate::trim::steady_state;
use crate::warning::Warning;
use crate::{PlantError, PlantParameters, SAMPLE_TIME_S, rk4};

/// The record of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// What the plant did: no noise and no sensor fault; of actuators the demand.
    pub truth: Dataset,
    /// What the sensors say: noise and faults included.
    pub measured: Dataset,
    /// Names and units of [`HIDDEN_CHANNELS`]: the two efficiencies and the fuel flow that reached
    /// the combustor.
    pub hidden_signals: Vec<Signal>,
    /// What no sensor measures, at each sample (3 x N).
    pub hidden: DMatrix<f64>,
    /// Name and unit of each fault of the scenario (nf).
    pub fault_signals: Vec<Signal>,
    /// Magnitude of each fault at each sample (nf x N).
    pub fault_magnitudes: DMatrix<f64>,
    /// What a reader of the record should know.
    pub warnings: Vec<Warning>,
    /// Why the record is shorter than the scenario asks for, if it is: when the plant left the
    /// range in which the model means something, and which quantity did.
    pub ended: Option<PlantError>,
}

/// Runs a scenario with the parameters of its variant and maps.
///
/// # Errors
/// See [`simulate_with`].
pub fn simulate(scenario: &Scenario) -> Result<Run, PlantError> {
    simulate_with(&scenario.parameters(), scenario)
}

/// Runs a scenario with given parameters, which replace those of its variant and maps.
///
/// The run starts from the healthy equilibrium at the first boundary conditions. At `t = k Ts`,
/// `k = 0 .. N-1`, the outputs and the controller's demand are read; then valve, references, dither
/// and boundary conditions move and are held until the next sample, while the controllers act
/// continuously. `a_v`, `w_ref`, `p_a`, `T_a` and `LHV` are recorded as they are held from `t` on,
/// so that a model needs no direct term for them; `M_f` is the demand that the outputs saw, and
/// every output needs a direct term for it (`nk = 0`); so it is with `IGV`, the position of the
/// guide vanes. Recording `a_v` before it moves would call for a direct term there too: without
/// one, free runs of ARX models of order 8 diverged.
///
/// Where noise is a share of what signals do and a fault acts on the plant, the healthy record is
/// simulated too, because noise is scaled by it.
///
/// # Errors
/// [`PlantError`] when parameters or scenario are refused, or when there is no equilibrium. A plant
/// that leaves the range in which the model means something ends the record: [`Run::ended`].
pub fn simulate_with(parameters: &PlantParameters, scenario: &Scenario) -> Result<Run, PlantError> {
    simulate_until(parameters, scenario, &Never)
}

/// As [`simulate_with`], until `stop` wants it to end; it is asked at every sample.
///
/// # Errors
/// As [`simulate_with`]; [`PlantError::Stopped`].
pub fn simulate_until(
    parameters: &PlantParameters,
    scenario: &Scenario,
    stop: &dyn Stop,
) -> Result<Run, PlantError> {
    let path = Job::faulty(scenario).integrate(parameters, stop)?;
    let healthy = if scenario.needs_healthy_record() {
        Some(Job::healthy(scenario).integrate(parameters, stop)?)
    } else {
        None
    };
    stop.check()?;
    finish(parameters, scenario, path, healthy.as_ref())
}

/// A scenario to be integrated: as it is, or without its faults.
pub(crate) struct Job<'a> {
    pub scenario: &'a Scenario,
    faults: &'a [Fault],
}

impl<'a> Job<'a> {
    /// The scenario as it is.
    pub fn faulty(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            faults: &scenario.faults,
        }
    }

    /// The scenario without its faults.
    pub fn healthy(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            faults: &[],
        }
    }

    /// Its recorder and the state in which it starts.
    pub fn start<'p>(
        &self,
        parameters: &'p PlantParameters,
    ) -> Result<(Recorder<'p>, [f64; STATES]), PlantError> {
        self.scenario.validate_with(parameters)?;
        Recorder::start(parameters, self.scenario, self.faults)
    }

    fn integrate(&self, parameters: &PlantParameters, stop: &dyn Stop) -> Result<Path, PlantError> {
        let step_s = self.scenario.step_s();
        let (mut recorder, mut x) = self.start(parameters)?;
        let mut sample = 0;
        while recorder.sample(&x) {
            stop.check()?;
            let start_s = time_s(sample);
            sample += 1;
            let inputs = recorder.inputs();
            for substep in 0..self.scenario.substeps {
                let rates = |t: f64, x: &[f64; STATES]| {
                    derivative(parameters, inputs, &recorder.sizes(t), x)
                };
                x = rk4::step(rates, start_s + substep as f64 * step_s, &x, step_s);
            }
        }
        Ok(recorder.finish())
    }
}

impl Scenario {
    /// Whether noise is scaled by the healthy record, and a fault makes this one another.
    pub(crate) fn needs_healthy_record(&self) -> bool {
        let reaches_plant =
            |fault: &Fault| fault.target.reaches_plant() && fault.onset_s <= self.duration_s;
        self.noise.is_share_of_signals() && self.excites() && self.faults.iter().any(reaches_plant)
    }
}

/// The record of an integrated path: sensors, noise, ground truth. `healthy` is the path without
/// faults, where [`Scenario::needs_healthy_record`].
pub(crate) fn finish(
    parameters: &PlantParameters,
    scenario: &Scenario,
    path: Path,
    healthy: Option<&Path>,
) -> Result<Run, PlantError> {
    let variant = parameters.variant;
    let mut warnings = path.warnings;
    if scenario.noise.is_share_of_signals() && !scenario.excites() {
        warnings.push(Warning::NoNoise);
    }
    let n = path.y.ncols();
    let truth_y = path.y.rows(0, variant.output_channels().len()).into_owned();
    let hidden = path.y.rows(OUTPUTS, HIDDEN_CHANNELS.len()).into_owned();
    let (mut u, mut y) = (path.u.clone(), truth_y.clone());
    let (reference_u, reference_y) = healthy.map_or((&u, &y), |path| (&path.u, &path.y));
    let basis = noise_basis(parameters, scenario, || {
        Deviations::of(reference_u, reference_y)
    })?;
    measure(
        [&mut u, &mut y],
        &scenario.faults,
        &scenario.noise,
        &basis,
        [scenario.seed, scenario.run_index],
        time_s,
    );
    let inputs = signals(variant.input_channels());
    let outputs = signals(variant.output_channels());
    Ok(Run {
        truth: Dataset::new(
            inputs.clone(),
            outputs.clone(),
            path.u,
            truth_y,
            SAMPLE_TIME_S,
        )?,
        measured: Dataset::new(inputs, outputs, u, y, SAMPLE_TIME_S)?,
        hidden_signals: signals(&HIDDEN_CHANNELS),
        hidden,
        fault_signals: Fault::signals(&scenario.faults),
        fault_magnitudes: DMatrix::from_fn(scenario.faults.len(), n, |row, k| {
            scenario.faults[row].magnitude(time_s(k))
        }),
        warnings,
        ended: path.ended,
    })
}

/// What the noise of a scenario is measured by; `signals` gives the deviations of its healthy
/// record, where they are asked for.
pub(crate) fn noise_basis(
    parameters: &PlantParameters,
    scenario: &Scenario,
    signals: impl FnOnce() -> Deviations,
) -> Result<NoiseBasis, PlantError> {
    Ok(NoiseBasis {
        // What moves in a plant at rest is rounding.
        signals: if scenario.noise.is_share_of_signals() && scenario.excites() {
            signals()
        } else {
            Deviations::zero()
        },
        design: if scenario.noise.is_share_of_design() {
            design_values(parameters)?
        } else {
            Vec::new()
        },
    })
}

/// The values of all channels, inputs first, at the healthy equilibrium of the design point.
fn design_values(parameters: &PlantParameters) -> Result<Vec<f64>, PlantError> {
    let steady = steady_state(parameters)?;
    let inputs = Inputs::design(parameters);
    let recorded = recorded_inputs(&inputs, steady.point.fuel_kg_s, &steady.state);
    Ok([recorded.as_slice(), &steady.outputs[..OUTPUTS]].concat())
}

/// Time of sample `k`, s.
pub(crate) fn time_s(k: usize) -> f64 {
    k as f64 * SAMPLE_TIME_S
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Stops at the look with this number.
    struct At(usize, AtomicUsize);

    impl Stop for At {
        fn is_stopped(&self) -> bool {
            self.1.fetch_add(1, Ordering::Relaxed) + 1 >= self.0
        }
    }

    /// The integration looks once a sample, so a run of 375 that is to end at the 100th look ends
    /// there; one that ends by itself is that of [`simulate`].
    #[test]
    fn a_run_ends_at_the_sample_at_which_it_is_stopped() {
        let scenario = Scenario {
            duration_s: 30.0,
            ..Scenario::default()
        };
        let run = |last: usize| {
            let stop = At(last, AtomicUsize::new(0));
            let run = simulate_until(&scenario.parameters(), &scenario, &stop);
            (run, stop.1.into_inner())
        };
        let (stopped, looks) = run(100);
        assert_eq!((stopped.err(), looks), (Some(gt_core::Stopped.into()), 100));
        assert_eq!(run(usize::MAX).0, simulate(&scenario));
    }
}
