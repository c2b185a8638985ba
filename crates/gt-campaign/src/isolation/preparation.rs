//! From records of a setting to an isolator.

use gtfdi::core::Dataset;
use gtfdi::fdi::{FdiError, IsolationDetector, Isolator};
use gtfdi::ident::eiv::{EivIdentification, IdentifiedEiv};
use gtfdi::ident::{Arx, ArxModel, OrderChoice, OrderKind};
use gtfdi::plant::{Fault, NoiseLevel};

use super::limit::Watcher;
use super::paper_scheme::PaperScheme;
use super::recipe::{IsolatorRecipe, TEACHING_S};
use super::setting::Setting;
use crate::error::{CampaignError, During as _};
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
                let identified = noisy_model(setting, &training)?;
                let remarks = identified.remarks.iter().map(ToString::to_string).collect();
                let model = identified.model.relation().clone();
                (model, Some(identified.model), remarks)
            } else {
                (quiet_model(setting, &training)?, None, Vec::new())
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
        let (training, (model, noise, remarks)) = models?;
        let healthy = healthy?;
        let name = setting.map_set.to_string();
        let recipe = IsolatorRecipe {
            name: &name,
            model: &model,
            noise: noise.as_ref(),
            arl0_hours: self.arl0_hours,
        };
        let quiet = setting.without_noise();
        let teach = |faults: &[Vec<Fault>]| {
            let runs: Vec<_> = faults
                .iter()
                .map(|faults| (TEACHING_INDEX, faults.clone()))
                .collect();
            quiet.records(&runs, TEACHING_S)
        };
        let (isolator, scheme) = rayon::join(
            || recipe.make(&healthy, teach),
            || PaperScheme::new(setting, &training, &healthy),
        );
        Ok(Prepared {
            setting: setting.clone(),
            isolator: isolator?,
            scheme: scheme?,
            remarks,
        })
    }
}

/// The model of the paper, with the inputs of the same sample.
fn quiet_model(setting: &Setting, training: &Dataset) -> Result<ArxModel, CampaignError> {
    let what = "models without noise";
    let nk = vec![0; setting.inputs().len()];
    let structure = OrderKind::Diagonal { nk }
        .structure(paper::ORDER, setting.outputs().len())
        .during(what)?;
    Arx::new(structure).fit(training).during(what)
}

/// Errors in variables, with the noise of all channels.
fn noisy_model(setting: &Setting, training: &Dataset) -> Result<IdentifiedEiv, CampaignError> {
    EivIdentification::new(OrderChoice::Given(NOISY_ORDER))
        .nk(vec![0; setting.inputs().len()])
        .identify(training)
        .during("models with noise")
}
