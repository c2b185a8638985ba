//! From an identified model and healthy records to an isolator of the plant's four faults.

use gtfdi::core::Dataset;
use gtfdi::fdi::{
    EffectPair, FaultEffect, FaultHypothesis, IsolationDesign, Isolator, JointWhitening,
    ResidualGenerator,
};
use gtfdi::ident::ArxModel;
use gtfdi::ident::eiv::EivModel;
use gtfdi::plant::{Fault, FaultCase, SAMPLE_TIME_S};
use nalgebra::Complex;

use crate::error::{CampaignError, During as _};
use crate::isolator_design::joint_kalman_generator;
use crate::paper;

/// Course of the faults that teach the effects: a ramp from 60 s to 120 s, then held to 300 s.
const TEACHING_ONSET_S: f64 = 60.0;
const TEACHING_RISE_S: f64 = 60.0;
pub(crate) const TEACHING_S: f64 = 300.0;
/// Sizes of those faults in the cases' units, without noise and with it.
const QUIET_SIZES: [f64; 4] = [0.5, 0.5, 0.5, 0.02];
const NOISY_SIZES: [f64; 4] = [2.0, 2.0, 2.0, 0.6];
/// Lag round which the effect of a lagging actuator is linear where there is noise, and samples on
/// either side of its rate.
const NOMINAL_LAG_S: f64 = 0.4;
const NOISY_HALF_WIDTH: usize = 6;
const QUIET_HALF_WIDTH: usize = 1;
/// Where bursts are cut, in robust deviations: normal noise has none, but model errors are mostly
/// bursts, at each movement of the valve.
const NOISY_LIMITER: f64 = 4.0;
const QUIET_LIMITER: f64 = 2.5;

/// What an isolator is made from, records apart.
#[derive(Debug, Clone, Copy)]
pub(crate) struct IsolatorRecipe<'a> {
    /// The isolator's name.
    pub name: &'a str,
    /// Identified without its noise, or the relation of `noise`.
    pub model: &'a ArxModel,
    /// With the noise of all channels, where that was identified.
    pub noise: Option<&'a EivModel>,
    /// Hours between false alarms of all statistics together.
    pub arl0_hours: f64,
}

impl IsolatorRecipe<'_> {
    /// Makes the isolator. `quiet` simulates noise-free records of one excitation, of
    /// [`TEACHING_S`] each, with the faults that it is given.
    ///
    /// # Errors
    /// [`CampaignError`] when a run or the design fails.
    pub(crate) fn make(
        &self,
        healthy: &[Dataset],
        quiet: impl Fn(&[Vec<Fault>]) -> Result<Vec<Dataset>, CampaignError>,
    ) -> Result<Isolator, CampaignError> {
        let noisy = self.noise.is_some();
        let (generators, input_deviations) = match self.noise {
            Some(noise) => (vec![joint_kalman_generator(noise)?], deviations(noise)),
            None => (free_run_generators(self.model)?, Vec::new()),
        };
        let whitening = IsolationDesign::whitening(&generators, healthy).during("whitening")?;
        let faults = hypotheses(&generators, &whitening, noisy, quiet)?;
        let (half_width, limiter) = if noisy {
            (NOISY_HALF_WIDTH, NOISY_LIMITER)
        } else {
            (QUIET_HALF_WIDTH, QUIET_LIMITER)
        };
        let mut design = IsolationDesign::new(faults)
            .arl0_hours(self.arl0_hours)
            .half_width(half_width)
            .limiter(limiter);
        for (tag, deviation) in input_deviations {
            design = design.input_deviation(tag, deviation);
        }
        let isolator = design.calibrate(self.name, generators, healthy);
        isolator.during("isolator")
    }
}

/// Output minus the free run of an ARX model, of each output.
fn free_run_generators(model: &ArxModel) -> Result<Vec<ResidualGenerator>, CampaignError> {
    let what = "free run of the model";
    (0..model.outputs().len())
        .map(|output| {
            let part = model.output_model(output).during(what)?;
            let poles: Vec<Complex<f64>> = part
                .model
                .a()
                .complex_eigenvalues()
                .iter()
                .copied()
                .collect();
            // An observer whose poles are the model's does not correct: its residual is that of
            // the free run.
            ResidualGenerator::observer_complex(part.model, part.point, &poles).during(what)
        })
        .collect()
}

/// Standard deviations of the inputs' noise, by their tags.
fn deviations(noise: &EivModel) -> Vec<(String, f64)> {
    let tags = noise.relation().inputs().iter();
    let channels = noise.input_noise().iter();
    tags.zip(channels)
        .map(|(signal, channel)| (signal.name.clone(), channel.variance.sqrt()))
        .collect()
}

/// The four cases as hypotheses.
fn hypotheses(
    generators: &[ResidualGenerator],
    whitening: &JointWhitening,
    noisy: bool,
    quiet: impl Fn(&[Vec<Fault>]) -> Result<Vec<Dataset>, CampaignError>,
) -> Result<Vec<FaultHypothesis>, CampaignError> {
    let sizes = if noisy { NOISY_SIZES } else { QUIET_SIZES };
    let faults: Vec<Fault> = FaultCase::ALL
        .into_iter()
        .zip(sizes)
        .map(|(case, size)| ramp(case, TEACHING_ONSET_S, TEACHING_RISE_S, size))
        .collect();
    let with_each = faults.iter().map(|fault| vec![fault.clone()]);
    let runs: Vec<Vec<Fault>> = std::iter::once(Vec::new()).chain(with_each).collect();
    let records = quiet(&runs)?;
    let Some((healthy, faulty)) = records.split_first() else {
        return Ok(Vec::new());
    };
    let taught = FaultCase::ALL.into_iter().zip(&faults).zip(faulty);
    taught
        .map(|((case, fault), faulty)| {
            let course: Vec<f64> = (0..faulty.len())
                .map(|sample| fault.magnitude(sample as f64 * SAMPLE_TIME_S))
                .collect();
            let pairs = [EffectPair {
                faulty,
                healthy,
                sizes: &course,
            }];
            let effect = if case == FaultCase::FuelActuatorLag {
                let actuator = (paper::INPUTS[1], if noisy { NOMINAL_LAG_S } else { 0.0 });
                FaultEffect::learn_lag(generators, whitening, actuator, &pairs)
            } else {
                FaultEffect::learn(generators, whitening, &pairs)
            };
            Ok(FaultHypothesis {
                name: case.name().to_owned(),
                unit: case.unit().to_owned(),
                // A compressor fouls, a turbine wears and an actuator slows; a sensor drifts either
                // way.
                both_signs: case == FaultCase::ThermocoupleDrift,
                effect: effect.during(case.name())?,
            })
        })
        .collect()
}

/// A fault that grows evenly from its onset to its size, with its sign, and stays there.
pub(crate) fn ramp(case: FaultCase, onset_s: f64, rise_s: f64, size: f64) -> Fault {
    Fault::growing(case, onset_s, size / rise_s * 3600.0, Some(size.abs()))
}
