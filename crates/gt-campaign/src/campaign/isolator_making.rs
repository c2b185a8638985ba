//! The isolator of a campaign: from a model and healthy records of its own.

use gtfdi::fdi::Isolator;
use gtfdi::plant::{Fault, Noise, NoiseLevel, Scenario};

use super::bank_choice::IsolatorFamily;
use super::sensor_noise::TEACHING_INDEX;
use super::spec::Spec;
use crate::error::{CampaignError, During as _};
use crate::isolation::{IsolatorRecipe, TEACHING_S};
use crate::progress::Progress;

impl Spec {
    /// Identifies a model, and makes an isolator of the plant's four faults with limits on healthy
    /// records with the noise of [`Spec::noise`]. What each fault does is learned from noise-free
    /// runs of the same profile.
    ///
    /// # Errors
    /// [`CampaignError`] says which step failed; [`CampaignError::Stopped`] when progress says so.
    pub fn make_isolator(
        &self,
        family: IsolatorFamily,
        noise: &Noise,
        progress: &dyn Progress,
    ) -> Result<Isolator, CampaignError> {
        let plan = self.model();
        let method = plan.method_for(self.plant.noise);
        let (model, found) = self.identify(&plan, method, noise, progress)?;
        let healthy = self.healthy_records(&plan, family.calibration_h, noise, progress)?;
        let what = "isolator";
        progress.report(what, 0, 1);
        let recipe = IsolatorRecipe {
            name: "campaign",
            model: &model,
            noise: found.as_ref(),
            arl0_hours: family.arl0_h,
        };
        let quiet: Noise = NoiseLevel::None.into();
        let teach = |runs: &[Vec<Fault>]| {
            let scenarios = runs.iter().map(|faults| {
                Ok(Scenario {
                    duration_s: TEACHING_S,
                    faults: faults.clone(),
                    ..self.scenario(TEACHING_INDEX, &quiet).during(what)?
                })
            });
            let scenarios = scenarios.collect::<Result<Vec<_>, CampaignError>>()?;
            self.simulated(&scenarios, &plan, what)
        };
        let isolator = recipe.make(&healthy, teach)?;
        progress.report(what, 1, 1);
        Ok(isolator)
    }
}
