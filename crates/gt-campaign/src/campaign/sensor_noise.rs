//! Sensors that are as noisy in every record as in any other.

use gtfdi::plant::{
    Channel, ChannelNoise, Deviations, Noise, NoiseLevel, NoiseScale, PlantParameters, Scenario,
    Variant, simulate_batch,
};

use super::spec::Spec;
use crate::error::{CampaignError, During as _};

/// Run index of the record that the model is identified from, and the noise measured by: beyond
/// those of all runs.
pub(super) const MODEL_INDEX: u64 = 1 << 62;
/// Run index of the first of the records that the limits are set on.
pub(super) const HEALTHY_INDEX: u64 = MODEL_INDEX + 1;
/// Run index of the records that show what faults do, beyond all healthy ones.
pub(super) const TEACHING_INDEX: u64 = MODEL_INDEX + (1 << 32);

impl Spec {
    /// The noise of all records of the campaign. A level that is a share of what signals do is one of
    /// what they do in one healthy record of `plant.noise_record_s` seconds: a share of what they do
    /// in each record by itself would make the sensors of short records noisier or quieter, and
    /// limits that were set on others would not hold.
    ///
    /// # Errors
    /// [`CampaignError::Plant`] where the plant does not bear that record.
    pub fn noise(&self) -> Result<Noise, CampaignError> {
        let what = "record of the noise";
        let mut noise = Noise::from(self.plant.noise);
        let reference = Scenario {
            duration_s: self.plant.noise_record_s,
            ..self
                .scenario(MODEL_INDEX, &NoiseLevel::None.into())
                .during(what)?
        };
        if !noise.is_share_of_signals() || !reference.excites() {
            return Ok(noise);
        }
        let plant = PlantParameters::for_maps(self.plant.map_set);
        for run in simulate_batch(&plant, &[reference]) {
            let run = run.during(what)?;
            if let Some(reason) = run.ended {
                return Err(reason).during(what);
            }
            let signals = Deviations::of(run.truth.u(), run.truth.y());
            let level = noise.clone();
            let own = Channel::all().filter(|channel| channel.is_in(Variant::Prototype));
            for channel in own {
                if let NoiseScale::SignalShare(share) = level.scale(channel) {
                    let fixed = ChannelNoise {
                        deviation: Some(share * signals.channel(channel)),
                        ..ChannelNoise::default()
                    };
                    noise.channels.insert(channel, fixed);
                }
            }
            // What is left of the level are the channels that this plant does not have.
            noise.level = NoiseLevel::None;
        }
        Ok(noise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gtfdi::plant::simulate;

    fn spec(noise: &str) -> Spec {
        let text = format!(
            "seed = 2\nruns = 1\n[plant]\nnoise = \"{noise}\"\n\
             [record]\nduration_s = 40.0\nonset_s = [20.0, 20.0]\n\
             [[faults]]\ncase = 1\nsize = {{ uniform = [1.0, 1.0] }}"
        );
        toml::from_str(&text).expect("a campaign")
    }

    /// Table 8: t3 has 0.0941 of its deviation over one record of 600 s, in every record.
    #[test]
    fn shares_become_deviations_of_one_record() {
        let spec = spec("table8");
        let noise = spec.noise().expect("noise");
        let level = Scenario {
            duration_s: 600.0,
            ..spec
                .scenario(MODEL_INDEX, &NoiseLevel::None.into())
                .expect("a scenario")
        };
        let run = simulate(&level).expect("a record");
        let t3 = Channel::named("t3").expect("a channel");
        let expected = 0.0941 * Deviations::of(run.truth.u(), run.truth.y()).channel(t3);
        let NoiseScale::Unit(found) = noise.scale(t3) else {
            panic!("{:?}", noise.scale(t3));
        };
        // The lanes' own exponentials and logarithms.
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{found} for {expected}"
        );
        assert!(!noise.is_share_of_signals());
    }

    #[test]
    fn levels_in_units_stay_as_they_are() {
        for name in ["none", "tables4_5"] {
            let spec = spec(name);
            assert_eq!(
                spec.noise().expect("noise"),
                Noise::from(spec.plant.noise),
                "{name}"
            );
        }
    }
}
