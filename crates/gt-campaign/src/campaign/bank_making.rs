//! The bank of a campaign: identified and calibrated on healthy records of its own.

use gtfdi::core::Dataset;
use gtfdi::fdi::{Bank, ResidualGenerator};
use gtfdi::ident::eiv::{EivIdentification, EivModel};
use gtfdi::ident::{Arx, ArxModel, OrderChoice, OrderKind};
use gtfdi::plant::{Noise, PlantParameters, Scenario, lanes_at_once};

use super::bank_choice::TestFamily;
use super::sensor_noise::{HEALTHY_INDEX, MODEL_INDEX};
use super::spec::{ModelMethod, ModelPlan, Spec};
use crate::bank_design::kalman_generator;
use crate::error::{CampaignError, During as _};
use crate::parallel;
use crate::progress::{Progress, Watched};

/// Seconds of an hour; healthy records are no longer.
const HOUR_S: f64 = 3600.0;

/// A model, with the noise of its channels where that was identified too.
pub(super) type Identified = (ArxModel, Option<EivModel>);

impl Spec {
    /// Identifies a model, designs its generators and calibrates their tests, on records with the
    /// noise of [`Spec::noise`].
    ///
    /// # Errors
    /// [`CampaignError`] says which step failed; [`CampaignError::Stopped`] when progress says so.
    pub fn make_bank(
        &self,
        family: &TestFamily,
        noise: &Noise,
        progress: &dyn Progress,
    ) -> Result<Bank, CampaignError> {
        let plan = self.model();
        let method = plan.method_for(self.plant.noise);
        let (model, found) = self.identify(&plan, method, noise, progress)?;
        let generators = (0..model.outputs().len())
            .map(|output| {
                let what = format!("generator of {}", model.outputs()[output].name);
                let part = model.output_model(output).during(&what)?;
                kalman_generator(&model, found.as_ref(), output, part).during(&what)
            })
            .collect::<Result<Vec<ResidualGenerator>, _>>()?;
        let healthy = self.healthy_records(&plan, family.calibration_h, noise, progress)?;
        let plans = family.plans(plan.outputs.len());
        let plans = plans.map_err(CampaignError::Value)?;
        let in_sample = vec![false; healthy.len()];
        let mut tests = Vec::new();
        for (done, tested) in plans.iter().enumerate() {
            progress.report("limits", done, plans.len());
            let found = tested.tests(&model, &generators, &healthy, &in_sample);
            let found = found.map_err(|(test, source)| CampaignError::Fdi {
                what: format!("limit of {test}"),
                source,
            })?;
            tests.extend(found.into_iter().map(|mut test| {
                if plans.len() > 1 {
                    test.name = format!("{}_{}", test.name, done + 1);
                }
                test
            }));
        }
        progress.report("limits", plans.len(), plans.len());
        Bank::new("campaign", generators, tests).during("bank")
    }

    /// The model, with its noise where the method tells it.
    pub(super) fn identify(
        &self,
        plan: &ModelPlan,
        method: ModelMethod,
        noise: &Noise,
        progress: &dyn Progress,
    ) -> Result<Identified, CampaignError> {
        let what = "model";
        progress.report(what, 0, 1);
        let mut records = self.records(&[(MODEL_INDEX, plan.record_s)], plan, noise, what)?;
        let record = records.pop().ok_or_else(stopped)?;
        let (order, nk) = (plan.order_for(method), plan.nk_for(method));
        let identified = match method {
            ModelMethod::Eiv => {
                let identification = EivIdentification::new(OrderChoice::Given(order)).nk(nk);
                let found = identification.identify_until(&record, &Watched(progress));
                let model = found.during(what)?.model;
                (model.relation().clone(), Some(model))
            }
            ModelMethod::Arx => {
                let structure = OrderKind::Diagonal { nk };
                let structure = structure
                    .structure(order, plan.outputs.len())
                    .during(what)?;
                (Arx::new(structure).fit(&record).during(what)?, None)
            }
        };
        progress.report(what, 1, 1);
        Ok(identified)
    }

    /// Healthy running of as many hours as asked for, in records of an hour at most.
    pub(super) fn healthy_records(
        &self,
        plan: &ModelPlan,
        hours: f64,
        noise: &Noise,
        progress: &dyn Progress,
    ) -> Result<Vec<Dataset>, CampaignError> {
        let what = "healthy records";
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked"
        )]
        let count = hours.ceil().max(1.0) as u64;
        let duration_s = hours / count as f64 * HOUR_S;
        let wanted: Vec<(u64, f64)> = (0..count)
            .map(|place| (HEALTHY_INDEX + place, duration_s))
            .collect();
        let mut records = Vec::with_capacity(wanted.len());
        // As many at once as keep the cores busy, so that there is something to tell between.
        for part in wanted.chunks(lanes_at_once() * rayon::current_num_threads()) {
            progress.report(what, records.len(), wanted.len());
            if progress.is_stopped() {
                return Err(stopped());
            }
            records.extend(self.records(part, plan, noise, what)?);
        }
        progress.report(what, records.len(), wanted.len());
        Ok(records)
    }

    /// Healthy records by run index and length in seconds.
    fn records(
        &self,
        wanted: &[(u64, f64)],
        plan: &ModelPlan,
        noise: &Noise,
        what: &str,
    ) -> Result<Vec<Dataset>, CampaignError> {
        let scenarios = wanted
            .iter()
            .map(|&(index, duration_s)| {
                let scenario = self.scenario(index, noise).during(what)?;
                Ok(Scenario {
                    duration_s,
                    ..scenario
                })
            })
            .collect::<Result<Vec<Scenario>, CampaignError>>()?;
        self.simulated(&scenarios, plan, what)
    }

    /// The model's channels of what the sensors read in scenarios, on all cores.
    pub(super) fn simulated(
        &self,
        scenarios: &[Scenario],
        plan: &ModelPlan,
        what: &str,
    ) -> Result<Vec<Dataset>, CampaignError> {
        let plant = PlantParameters::for_maps(self.plant.map_set);
        parallel::simulate(
            &plant,
            scenarios,
            |_| what.to_owned(),
            |_, run| {
                let measured = run.measured.select(&plan.inputs, &plan.outputs);
                measured.during(what)
            },
        )
    }
}

fn stopped() -> CampaignError {
    CampaignError::Stopped { done: 0, total: 0 }
}
