//! From a model, faults in words and healthy records to an isolator: what the verb `design` and the
//! Python function of the same name share.

use std::collections::BTreeMap;
use std::path::PathBuf;

use gtfdi::core::Dataset;
use gtfdi::fdi::{
    EffectPair, FaultEffect, FaultHypothesis, FdiError, IsolationDesign, Isolator, JointWhitening,
    NoiseCovariance, ResidualGenerator,
};
use gtfdi::ident::eiv::{ChannelNoise, EivModel};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::error::{CampaignError, During as _};

/// Samples on either side for the rate of an actuator's demand, of noisy inputs and of others.
const NOISY_HALF_WIDTH: usize = 6;
const QUIET_HALF_WIDTH: usize = 1;
/// Robust deviations at which bursts are cut where nobody says: noise has none.
const LIMITER: f64 = 4.0;
/// Samples of the lag round which an actuator's effect is linear where nobody says.
const NOMINAL_SAMPLES: f64 = 5.0;

/// Two records of the same run, one with the fault, and how that grew.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairDescription {
    /// The record without the fault.
    pub healthy: PathBuf,
    /// The record with it.
    pub faulty: PathBuf,
    /// Times in seconds, ascending, and the fault's size at each, in its unit: even growth in
    /// between, no change before the first and after the last.
    pub course: Vec<[f64; 2]>,
}

/// A fault that is to be told from others: changes of outputs, a slow actuator, or pairs of records
/// that show what it does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FaultDescription {
    /// Its name.
    pub name: String,
    /// Unit of its size; seconds for an actuator.
    #[serde(default)]
    pub unit: String,
    /// Whether its size may be negative.
    #[serde(default)]
    pub both_signs: bool,
    /// What each output changes by for one unit of the fault, at held inputs; an output that is not
    /// named does not change. One entry of 1 is a sensor that is off.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub changes: BTreeMap<String, f64>,
    /// The input whose actuator follows its demand with a lag, which is the fault's size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actuator: Option<String>,
    /// About the smallest lag to be found, in seconds; five samples where it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal_s: Option<f64>,
    /// Records that show what the fault does.
    #[serde(default, rename = "pair", skip_serializing_if = "Vec::is_empty")]
    pub pairs: Vec<PairDescription>,
}

/// A file of faults: `[[fault]]` tables.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FaultDescriptions {
    /// In order.
    #[serde(default, rename = "fault")]
    pub faults: Vec<FaultDescription>,
}

/// What is wrong with a fault's description.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DescriptionError {
    /// Neither or both of what it changes and which actuator it is.
    #[error("fault `{name}`: expected `changes`, `actuator` or a `pair` of records, found {found}")]
    Kind {
        /// The fault.
        name: String,
        /// What there is.
        found: &'static str,
    },
    /// A course that is empty, not ascending or not finite.
    #[error("fault `{name}`, course of a pair: expected {expected}, found {found}")]
    Course {
        /// The fault.
        name: String,
        /// What was expected.
        expected: &'static str,
        /// What was found.
        found: String,
    },
    /// No faults at all.
    #[error("expected at least one `[[fault]]`, found none")]
    Empty,
}

impl FaultDescriptions {
    /// Refuses descriptions that say nothing or two things.
    ///
    /// # Errors
    /// [`DescriptionError`] with the fault's name.
    pub fn check(&self) -> Result<(), DescriptionError> {
        if self.faults.is_empty() {
            return Err(DescriptionError::Empty);
        }
        let mut faults = self.faults.iter();
        faults.try_for_each(|fault| fault.check(!fault.pairs.is_empty()))
    }
}

impl FaultDescription {
    /// Refuses a description that says nothing or two things; `has_pairs`: records show the fault.
    ///
    /// # Errors
    /// [`DescriptionError`] with its name.
    pub fn check(&self, has_pairs: bool) -> Result<(), DescriptionError> {
        let kind = |found: &'static str| {
            Err(DescriptionError::Kind {
                name: self.name.clone(),
                found,
            })
        };
        match (self.changes.is_empty(), self.actuator.is_some(), !has_pairs) {
            (true, false, true) => return kind("none of them"),
            (false, true, _) => return kind("both changes and an actuator"),
            (false, _, false) => return kind("changes and a pair that would show them"),
            _ => {}
        }
        if self.nominal_s.is_some() && self.actuator.is_none() {
            return kind("nominal_s without an actuator");
        }
        for pair in &self.pairs {
            let refuse = |expected: &'static str, found: String| {
                Err(DescriptionError::Course {
                    name: self.name.clone(),
                    expected,
                    found,
                })
            };
            if pair.course.is_empty() {
                return refuse("pairs of a time and a size", "none".to_owned());
            }
            if let Some(bad) = pair
                .course
                .iter()
                .find(|own| !own.iter().all(|v| v.is_finite()))
            {
                return refuse("finite numbers", format!("{bad:?}"));
            }
            if let Some(bad) = pair.course.windows(2).find(|own| own[1][0] <= own[0][0]) {
                return refuse(
                    "ascending times",
                    format!("{} after {}", bad[1][0], bad[0][0]),
                );
            }
        }
        Ok(())
    }
}

impl PairDescription {
    /// The fault's size at each sample of a record.
    pub fn sizes(&self, record: &Dataset) -> Vec<f64> {
        (0..record.len())
            .map(|sample| {
                let time_s = record.time_s(sample);
                let after = self.course.partition_point(|[own, _]| *own <= time_s);
                let at = |place: usize| self.course.get(place).copied();
                match (after.checked_sub(1).and_then(at), at(after)) {
                    (Some([t0, s0]), Some([t1, s1])) => s0 + (s1 - s0) * (time_s - t0) / (t1 - t0),
                    (Some([_, size]), None) | (None, Some([_, size])) => size,
                    (None, None) => 0.0,
                }
            })
            .collect()
    }
}

/// How an isolator is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IsolatorPlan {
    /// Hours between false alarms of all statistics together.
    pub arl0_hours: f64,
    /// The probability from which on a fault is named.
    pub confidence: f64,
    /// How far back onsets are looked for, in seconds.
    pub longest_s: f64,
    /// Robust deviations beyond which a burst is cut; 4 where it is `None`.
    pub limiter: Option<f64>,
    /// Samples on either side for the rate of an actuator's demand; where it is `None` 6 with the
    /// noise of an errors-in-variables model, else 1.
    pub half_width: Option<usize>,
}

impl Default for IsolatorPlan {
    fn default() -> Self {
        Self {
            arl0_hours: 24.0,
            confidence: 0.99,
            longest_s: 600.0,
            limiter: None,
            half_width: None,
        }
    }
}

/// The records of a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct PairRecords {
    /// Without the fault.
    pub healthy: Dataset,
    /// With it.
    pub faulty: Dataset,
    /// The fault's size at each sample.
    pub sizes: Vec<f64>,
}

impl IsolatorPlan {
    /// The isolator of generators for `faults`, each with the records of its pairs. `noise` is that
    /// of the model behind the generators.
    ///
    /// # Errors
    /// As [`FaultEffect::learn`] with the fault's name, and as [`IsolationDesign::calibrate`].
    pub fn design(
        &self,
        name: &str,
        generators: Vec<ResidualGenerator>,
        noise: Option<&EivModel>,
        faults: &[(FaultDescription, Vec<PairRecords>)],
        healthy: &[Dataset],
    ) -> Result<Isolator, (Option<String>, FdiError)> {
        let whitening =
            IsolationDesign::whitening(&generators, healthy).map_err(|error| (None, error))?;
        let hypotheses = faults
            .iter()
            .map(|(fault, records)| {
                hypothesis(fault, records, &generators, &whitening)
                    .map_err(|error| (Some(fault.name.clone()), error))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let default = if noise.is_some() {
            NOISY_HALF_WIDTH
        } else {
            QUIET_HALF_WIDTH
        };
        let mut design = IsolationDesign::new(hypotheses)
            .arl0_hours(self.arl0_hours)
            .confidence(self.confidence)
            .longest_s(self.longest_s)
            .limiter(self.limiter.unwrap_or(LIMITER))
            .half_width(self.half_width.unwrap_or(default));
        if let Some(noise) = noise {
            let signals = noise.relation().inputs().iter();
            for (signal, channel) in signals.zip(noise.input_noise()) {
                design = design.input_deviation(signal.name.clone(), channel.variance.sqrt());
            }
        }
        design
            .calibrate(name, generators, healthy)
            .map_err(|error| (None, error))
    }
}

fn hypothesis(
    fault: &FaultDescription,
    records: &[PairRecords],
    generators: &[ResidualGenerator],
    whitening: &JointWhitening,
) -> Result<FaultHypothesis, FdiError> {
    let pairs: Vec<EffectPair> = records
        .iter()
        .map(|pair| EffectPair {
            faulty: &pair.faulty,
            healthy: &pair.healthy,
            sizes: &pair.sizes,
        })
        .collect();
    let sample_time_s = generators
        .first()
        .map_or(1.0, ResidualGenerator::sample_time_s);
    let nominal_s = fault.nominal_s.unwrap_or(NOMINAL_SAMPLES * sample_time_s);
    let effect = match &fault.actuator {
        Some(input) if pairs.is_empty() => FaultEffect::ActuatorLag {
            input: input.clone(),
            nominal_s,
            gain: 1.0,
        },
        Some(input) => FaultEffect::learn_lag(generators, whitening, (input, nominal_s), &pairs)?,
        None if pairs.is_empty() => FaultEffect::Outputs {
            changes: fault.changes.clone(),
            delay_s: 0.0,
        },
        None => FaultEffect::learn(generators, whitening, &pairs)?,
    };
    let unit = if fault.actuator.is_some() && fault.unit.is_empty() {
        "s".to_owned()
    } else {
        fault.unit.clone()
    };
    Ok(FaultHypothesis {
        name: fault.name.clone(),
        unit,
        both_signs: fault.both_signs,
        effect,
    })
}

/// One Kalman filter for all outputs of an errors-in-variables model and its noise.
///
/// # Errors
/// [`CampaignError`] when the model has no state space or no filter.
pub fn joint_kalman_generator(noise: &EivModel) -> Result<ResidualGenerator, CampaignError> {
    let what = "Kalman filter of all outputs";
    let relation = noise.relation();
    let model = relation.state_space().during(what)?;
    let variances = |channels: &[ChannelNoise]| -> Vec<f64> {
        channels.iter().map(|channel| channel.variance).collect()
    };
    let (inputs, outputs) = (
        variances(noise.input_noise()),
        variances(noise.output_noise()),
    );
    let covariance =
        NoiseCovariance::errors_in_variables(&model, &inputs, &outputs).during(what)?;
    let point = relation.operating_point().clone();
    ResidualGenerator::kalman(model, point, covariance).during(what)
}
