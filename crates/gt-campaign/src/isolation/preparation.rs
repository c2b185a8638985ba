//! From records of a setting to an isolator.

use gtfdi::core::Dataset;
use gtfdi::fdi::{
    EffectPair, FaultEffect, FaultHypothesis, FdiError, IsolationDesign, IsolationDetector,
    Isolator, JointWhitening, ResidualGenerator,
};
use gtfdi::ident::eiv::EivIdentification;
use gtfdi::ident::{Arx, OrderChoice, OrderKind};
use gtfdi::plant::{Fault, FaultCase, NoiseLevel, SAMPLE_TIME_S};
use nalgebra::Complex;

use super::limit::Watcher;
use super::paper_scheme::PaperScheme;
use super::setting::Setting;
use crate::error::{CampaignError, During as _};
use crate::isolator_design::joint_kalman_generator;
use crate::paper;

/// Length of the identification record, in seconds.
const IDENTIFICATION_S: f64 = 3600.0;
/// Healthy records of equal length in an hour.
const RECORDS_AN_HOUR: u64 = 1;
/// Run indices: identification, faults of known course, healthy records.
const IDENTIFICATION_INDEX: u64 = 0;
const TEACHING_INDEX: u64 = 50;
const HEALTHY_INDEX: u64 = 100;
/// Order of the models with noise: two by the likelihood's BIC.
const NOISY_ORDER: usize = 2;
/// Course of the faults that teach the effects: a ramp from 60 s to 120 s, then held to 300 s.
const TEACHING_ONSET_S: f64 = 60.0;
const TEACHING_RISE_S: f64 = 60.0;
const TEACHING_S: f64 = 300.0;
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

/// How an isolator is made from records of a setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preparation {
    /// Hours of healthy running behind the limits.
    pub healthy_hours: u64,
    /// Hours between false alarms of all statistics together.
    pub arl0_hours: f64,
}

/// An isolator with where it came from.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The setting.
    pub setting: Setting,
    /// The isolator of the four cases, in their order.
    pub isolator: Isolator,
    /// The paper's own scheme, from the same records.
    pub scheme: PaperScheme,
    /// What the identification remarked.
    pub remarks: Vec<String>,
}

impl Watcher for Isolator {
    fn ratios(&self, record: &Dataset) -> Result<Vec<f64>, CampaignError> {
        let ratios = || -> Result<Vec<f64>, FdiError> {
            let mut detector = IsolationDetector::new(self)?;
            (0..record.len())
                .map(|sample| {
                    // The records have the isolator's channels in its order.
                    let (u, y) = (record.u().column(sample), record.y().column(sample));
                    let time_s = record.time_s(sample);
                    let verdict = detector.step(time_s, u.as_slice(), y.as_slice())?;
                    Ok(verdict.worst_ratio(self.limits()))
                })
                .collect()
        };
        ratios().during("isolator")
    }
}

impl Preparation {
    /// How the isolator comes about, for whoever reads the numbers.
    pub fn definition(&self) -> String {
        format!(
            "Models from one record of {IDENTIFICATION_S} s of the same sensors (without noise: ARX \
             of order {}, residuals output minus free run; with noise: errors in variables of order \
             {NOISY_ORDER}, one Kalman filter for all outputs). Effects of the faults from pairs of \
             noise-free runs of {TEACHING_S} s of the same plant. \
             Limits from {} healthy hours, one false alarm in {} h of all five statistics together.",
            paper::ORDER,
            self.healthy_hours,
            self.arl0_hours
        )
    }

    /// Makes the isolator.
    ///
    /// # Errors
    /// [`CampaignError`] when a run, the identification or the design fails.
    pub fn prepare(&self, setting: &Setting) -> Result<Prepared, CampaignError> {
        let healthy_run = |index: u64| (index, Vec::new());
        let noisy = setting.level != NoiseLevel::None;
        let models = || {
            let training = setting
                .records(&[healthy_run(IDENTIFICATION_INDEX)], IDENTIFICATION_S)?
                .remove(0);
            let models = if noisy {
                noisy_generators(setting, &training)?
            } else {
                let generators = quiet_generators(setting, &training)?;
                (generators, Vec::new(), Vec::new())
            };
            Ok::<_, CampaignError>((training, models))
        };
        let healthy = || {
            let runs: Vec<_> = (0..RECORDS_AN_HOUR * self.healthy_hours)
                .map(|record| healthy_run(HEALTHY_INDEX + record))
                .collect();
            setting.records(&runs, 3600.0 / RECORDS_AN_HOUR as f64)
        };
        let (models, healthy) = rayon::join(models, healthy);
        let (training, (generators, input_deviations, remarks)) = models?;
        let healthy = healthy?;
        let whitening = IsolationDesign::whitening(&generators, &healthy).during("whitening")?;
        let faults = hypotheses(setting, &generators, &whitening, noisy)?;
        let mut design = IsolationDesign::new(faults)
            .arl0_hours(self.arl0_hours)
            .half_width(if noisy {
                NOISY_HALF_WIDTH
            } else {
                QUIET_HALF_WIDTH
            })
            .limiter(if noisy { NOISY_LIMITER } else { QUIET_LIMITER });
        for (tag, deviation) in input_deviations {
            design = design.input_deviation(tag, deviation);
        }
        let name = setting.map_set.to_string();
        let (isolator, scheme) = rayon::join(
            || design.calibrate(name, generators, &healthy),
            || PaperScheme::new(setting, &training, &healthy),
        );
        Ok(Prepared {
            setting: setting.clone(),
            isolator: isolator.during("isolator")?,
            scheme: scheme?,
            remarks,
        })
    }
}

/// Output minus the free run of an ARX model, of each output.
fn quiet_generators(
    setting: &Setting,
    training: &Dataset,
) -> Result<Vec<ResidualGenerator>, CampaignError> {
    let what = "models without noise";
    let outputs = setting.outputs().len();
    let nk = vec![0; setting.inputs().len()];
    let structure = OrderKind::Diagonal { nk }
        .structure(paper::ORDER, outputs)
        .during(what)?;
    let model = Arx::new(structure).fit(training).during(what)?;
    (0..outputs)
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

type Noisy = (Vec<ResidualGenerator>, Vec<(String, f64)>, Vec<String>);

/// One Kalman filter for all outputs and the identified noise, with that of the inputs.
fn noisy_generators(setting: &Setting, training: &Dataset) -> Result<Noisy, CampaignError> {
    let what = "models with noise";
    let identified = EivIdentification::new(OrderChoice::Given(NOISY_ORDER))
        .nk(vec![0; setting.inputs().len()])
        .identify(training)
        .during(what)?;
    let filter = joint_kalman_generator(&identified.model)?;
    let tags = setting.inputs().into_iter().map(str::to_owned);
    let noise = identified.model.input_noise().iter();
    let deviations = tags
        .zip(noise.map(|channel| channel.variance.sqrt()))
        .collect();
    let remarks = identified.remarks.iter().map(ToString::to_string).collect();
    Ok((vec![filter], deviations, remarks))
}

/// The four cases as hypotheses.
fn hypotheses(
    setting: &Setting,
    generators: &[ResidualGenerator],
    whitening: &JointWhitening,
    noisy: bool,
) -> Result<Vec<FaultHypothesis>, CampaignError> {
    let sizes = if noisy { NOISY_SIZES } else { QUIET_SIZES };
    let quiet = setting.without_noise();
    let mut hypotheses = Vec::new();
    for (case, size) in FaultCase::ALL.into_iter().zip(sizes) {
        let fault = ramp(case, TEACHING_ONSET_S, TEACHING_RISE_S, size);
        let runs = [
            (TEACHING_INDEX, vec![]),
            (TEACHING_INDEX, vec![fault.clone()]),
        ];
        let pair = quiet.records(&runs, TEACHING_S)?;
        let course: Vec<f64> = (0..pair[1].len())
            .map(|sample| fault.magnitude(sample as f64 * SAMPLE_TIME_S))
            .collect();
        let pairs = [EffectPair {
            faulty: &pair[1],
            healthy: &pair[0],
            sizes: &course,
        }];
        let effect = if case == FaultCase::FuelActuatorLag {
            let actuator = (paper::INPUTS[1], if noisy { NOMINAL_LAG_S } else { 0.0 });
            FaultEffect::learn_lag(generators, whitening, actuator, &pairs)
        } else {
            FaultEffect::learn(generators, whitening, &pairs)
        };
        hypotheses.push(FaultHypothesis {
            name: case.name().to_owned(),
            unit: case.unit().to_owned(),
            // A compressor fouls, a turbine wears and an actuator slows; a sensor drifts either way.
            both_signs: case == FaultCase::ThermocoupleDrift,
            effect: effect.during(case.name())?,
        });
    }
    Ok(hypotheses)
}

/// A fault that grows evenly from its onset to its size, with its sign, and stays there.
pub(crate) fn ramp(case: FaultCase, onset_s: f64, rise_s: f64, size: f64) -> Fault {
    Fault::growing(case, onset_s, size / rise_s * 3600.0, Some(size.abs()))
}
