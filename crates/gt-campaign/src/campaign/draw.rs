//! What a run is: drawn from the seed and its index alone.

use gtfdi::plant::{Noise, PlantError, Profile, Scenario, Variant};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha12Rng;

use super::fault_plan::{FaultPlan, Sign};
use super::spec::Spec;

/// Keeps the stream of a run apart from those of its excitation and noise, whose keys end in zeros.
const DOMAIN: &[u8; 8] = b"campaign";
/// Bits of a double's fraction.
const FRACTION_BITS: u32 = 53;

/// The fault of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawnFault<'a> {
    /// The plan that it was drawn from.
    pub plan: &'a FaultPlan,
    /// Its size, above 0, in the case's unit.
    pub size: f64,
    /// 1 or -1.
    pub sign: f64,
    /// Its onset in seconds.
    pub onset_s: f64,
}

/// A share between 0 and 1, 1 excluded.
fn share(random: &mut ChaCha12Rng) -> f64 {
    let bits = random.next_u64() >> (u64::BITS - FRACTION_BITS);
    bits as f64 / (1_u64 << FRACTION_BITS) as f64
}

impl Spec {
    /// The fault of a run; `None` for a healthy one. Every run takes the same numbers from its
    /// stream, so that a share or a range that changes leaves the other draws as they are.
    pub fn draw(&self, index: u64) -> Option<DrawnFault<'_>> {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        key[8..16].copy_from_slice(&index.to_le_bytes());
        key[24..].copy_from_slice(DOMAIN);
        let mut random = ChaCha12Rng::from_seed(key);
        let [healthy, case, size, sign, onset] = [(); 5].map(|()| share(&mut random));
        if healthy < self.healthy_share {
            return None;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a place"
        )]
        let place = (case * self.faults.len() as f64) as usize;
        let plan = self.faults.get(place)?;
        let [first, last] = self.record.onset_s;
        Some(DrawnFault {
            plan,
            size: plan.size.at(size),
            sign: match plan.sign {
                Sign::Positive => 1.0,
                Sign::Both if sign < 0.5 => 1.0,
                Sign::Negative | Sign::Both => -1.0,
            },
            onset_s: (first + onset * (last - first)).clamp(first, last),
        })
    }

    /// The healthy scenario of a run, with the noise of all of them.
    ///
    /// # Errors
    /// As [`Profile::named`].
    pub(super) fn scenario(&self, index: u64, noise: &Noise) -> Result<Scenario, PlantError> {
        let mut profile = Profile::named(Variant::Prototype, &self.plant.profile)?;
        if let Some(amplitude_deg) = self.plant.valve_amplitude_deg {
            profile.valve_amplitude_deg = amplitude_deg;
        }
        Ok(Scenario {
            map_set: self.plant.map_set,
            duration_s: self.record.duration_s,
            substeps: self.plant.substeps,
            profile,
            noise: noise.clone(),
            seed: self.seed,
            run_index: index,
            ..Scenario::default()
        })
    }

    /// The scenario of a run with what was drawn for it; the noise is that of [`Spec::noise`].
    ///
    /// # Errors
    /// As [`Profile::named`].
    pub fn scenario_of(
        &self,
        index: u64,
        fault: Option<&DrawnFault>,
        noise: &Noise,
    ) -> Result<Scenario, PlantError> {
        let faults = fault.map(|drawn| drawn.plan.fault(drawn.onset_s, drawn.sign * drawn.size));
        Ok(Scenario {
            faults: faults.into_iter().collect(),
            ..self.scenario(index, noise)?
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> Spec {
        toml::from_str(
            "seed = 3\nruns = 8000\nhealthy_share = 0.25\n\
             [record]\nduration_s = 60.0\nonset_s = [20.0, 30.0]\n\
             [[faults]]\ncase = 1\nsize = { log_uniform = [0.01, 1.0] }\n\
             [[faults]]\ncase = 'thermocouple_drift'\nsize = { uniform = [1.0, 2.0] }\nsign = 'both'",
        )
        .expect("a campaign")
    }

    /// Counts and means of 8000 runs within four standard deviations of what they are drawn with.
    #[test]
    fn shares_sizes_signs_and_onsets_are_those_of_the_plan() {
        let spec = spec();
        let drawn: Vec<DrawnFault> = (0..spec.runs).filter_map(|k| spec.draw(k)).collect();
        let faulty = drawn.len() as f64;
        assert!(
            (faulty - 6000.0).abs() < 4.0 * (8000.0_f64 * 0.25 * 0.75).sqrt(),
            "{faulty}"
        );
        let of = |number: usize| drawn.iter().filter(move |d| d.plan.case.number() == number);
        let first = of(1).count() as f64;
        assert!(
            (first - 0.5 * faulty).abs() < 4.0 * (0.25 * faulty).sqrt(),
            "{first}"
        );
        // Logarithms to base 10 are uniform on -2 .. 0, of deviation 2 / sqrt(12).
        let mean = of(1).map(|d| d.size.log10()).sum::<f64>() / first;
        assert!(
            (mean + 1.0).abs() < 4.0 * 2.0 / (12.0 * first).sqrt(),
            "{mean}"
        );
        assert!(of(1).all(|d| d.sign > 0.0));
        let up = of(2).filter(|d| d.sign > 0.0).count() as f64;
        let second = faulty - first;
        assert!(
            (up - 0.5 * second).abs() < 4.0 * (0.25 * second).sqrt(),
            "{up}"
        );
        let mean = drawn.iter().map(|d| d.onset_s).sum::<f64>() / faulty;
        assert!(
            (mean - 25.0).abs() < 4.0 * 10.0 / (12.0 * faulty).sqrt(),
            "{mean}"
        );
    }

    #[test]
    fn a_run_is_its_seed_and_index() {
        let (one, mut other) = (spec(), spec());
        assert_eq!(one.draw(17), one.draw(17));
        assert!((0..50).any(|k| one.draw(k) != one.draw(k + 1)));
        other.seed = 4;
        assert!((0..50).any(|k| one.draw(k) != other.draw(k)));
        // A larger share of healthy runs leaves the others as they were.
        other = spec();
        other.healthy_share = 0.5;
        assert!((0..200).all(|k| other.draw(k).is_none() || other.draw(k) == one.draw(k)));
    }
}
