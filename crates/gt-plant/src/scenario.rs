//! A scenario: everything that determines a run.

use serde::{Deserialize, Serialize};

use crate::excitation::Profile;
use crate::faults::Fault;
use crate::params::MapSet;
use crate::sensors::NoiseLevel;
use crate::{PlantError, SAMPLE_TIME_S};

/// Longest step at which RK4 is stable on the prototype, s: a prototype measured 3.48 ms as
/// finite and 3.64 ms as diverging; the fastest mode, -309 +- 696j 1/s, says 3.5 ms.
pub const LONGEST_STEP_S: f64 = 3.4e-3;
/// Most substeps that are accepted.
const MOST_SUBSTEPS: usize = 10_000;
/// Most samples of a record: 44 hours, about 1 GB while it is made. Longer running is several runs
/// under one seed.
const MOST_SAMPLES: usize = 2_000_000;

/// Everything that determines a run. Fields that a file leaves out keep their defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// Which compressor map.
    pub map_set: MapSet,
    /// Length of the record, s; rounded to samples.
    pub duration_s: f64,
    /// Integration steps a sample.
    pub substeps: usize,
    /// Excitation.
    pub profile: Profile,
    /// Sensor noise.
    pub noise: NoiseLevel,
    /// Faults, each case at most once.
    pub faults: Vec<Fault>,
    /// Seed of excitation and noise.
    pub seed: u64,
    /// Index of the run; runs with one seed and different indices are independent.
    pub run_index: u64,
}

impl Default for Scenario {
    /// A healthy, noise-free record of 600 s with the `standard` profile and steps of 2 ms.
    fn default() -> Self {
        Self {
            map_set: MapSet::default(),
            duration_s: 600.0,
            substeps: 40,
            profile: Profile::default(),
            noise: NoiseLevel::default(),
            faults: Vec::new(),
            seed: 0,
            run_index: 0,
        }
    }
}

impl Scenario {
    /// Number of samples: the duration over the sample time, rounded.
    ///
    /// # Errors
    /// [`PlantError::Duration`] when that is not between one and two million.
    pub fn samples(&self) -> Result<usize, PlantError> {
        let samples = (self.duration_s / SAMPLE_TIME_S).round();
        if samples >= 1.0 && samples <= MOST_SAMPLES as f64 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            return Ok(samples as usize);
        }
        Err(PlantError::Duration {
            shortest_s: SAMPLE_TIME_S,
            longest_s: MOST_SAMPLES as f64 * SAMPLE_TIME_S,
            found_s: self.duration_s,
        })
    }

    /// Length of an integration step, s.
    pub fn step_s(&self) -> f64 {
        SAMPLE_TIME_S / self.substeps as f64
    }

    /// Refuses what cannot be run.
    ///
    /// # Errors
    /// [`PlantError`] with the first offending option.
    pub fn validate(&self) -> Result<(), PlantError> {
        self.samples()?;
        if self.step_s() > LONGEST_STEP_S || self.substeps > MOST_SUBSTEPS {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let least = (SAMPLE_TIME_S / LONGEST_STEP_S).ceil() as usize;
            return Err(PlantError::Substeps {
                least,
                most: MOST_SUBSTEPS,
                limit_s: LONGEST_STEP_S,
                found: self.substeps,
            });
        }
        self.profile.validate()?;
        for (index, fault) in self.faults.iter().enumerate() {
            fault.validate()?;
            fault.validate_by(self.duration_s)?;
            if self.faults[..index]
                .iter()
                .any(|other| other.case() == fault.case())
            {
                return Err(PlantError::RepeatedFault { case: fault.case() });
            }
        }
        Ok(())
    }
}
