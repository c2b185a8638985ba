//! Hypotheses about faults.

use std::collections::BTreeMap;

use gt_core::{Dataset, DimensionError};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::drive_noise::SHARP;
use super::linear::Tags;
use crate::FdiError;
use crate::design::calibration::check_finite;
use crate::design::channels::Channels;
use crate::design::generator::ResidualGenerator;
use crate::design::joint_whitening::JointWhitening;
use crate::runtime::{Drive, DriveParts};

/// What a fault does to what is measured, for each unit of its size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FaultEffect {
    /// The outputs change, at held inputs.
    Outputs {
        /// Lasting change of each output in its unit, by its tag; an output that is not named does
        /// not change. One entry is a sensor that is off.
        changes: BTreeMap<String, f64>,
        /// Seconds by which the outputs follow the fault.
        #[serde(default)]
        delay_s: f64,
    },
    /// The actuator behind an input, whose demand is measured, follows it with a first-order lag;
    /// the fault's size is the lag's time constant in seconds.
    ActuatorLag {
        /// Tag of the input.
        input: String,
        /// The lag in seconds round which the effect is linear: about the smallest to be found.
        nominal_s: f64,
        /// What a lag does over what the model says it would, by way of the input: 1 unless it was
        /// learned ([`FaultEffect::learn_lag`]).
        #[serde(default = "one")]
        gain: f64,
    },
}

fn one() -> f64 {
    1.0
}

/// A fault that is to be told from others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultHypothesis {
    /// Its name.
    pub name: String,
    /// Unit of its size.
    pub unit: String,
    /// Whether its size may be negative.
    #[serde(default)]
    pub both_signs: bool,
    /// What it does.
    pub effect: FaultEffect,
}

/// Two records of the same operation, and noise if any, one with a fault of known course.
#[derive(Debug, Clone, Copy)]
pub struct EffectPair<'a> {
    /// With the fault.
    pub faulty: &'a Dataset,
    /// Without it.
    pub healthy: &'a Dataset,
    /// Size of the fault at each sample.
    pub sizes: &'a [f64],
}

impl FaultHypothesis {
    /// Refuses numbers that make no sense, and tags that the generators have not.
    ///
    /// # Errors
    /// [`FdiError::Hypothesis`] with the name, [`FdiError::MissingTags`].
    pub(super) fn check(&self, tags: &Tags) -> Result<(), FdiError> {
        let refuse = |option: &'static str, expected: &'static str, found: f64| {
            Err(FdiError::Hypothesis {
                name: self.name.clone(),
                option,
                expected,
                found,
            })
        };
        let (wanted, available): (Vec<&String>, &Vec<String>) = match &self.effect {
            FaultEffect::Outputs { changes, delay_s } => {
                if !delay_s.is_finite() {
                    return refuse("delay_s", "a finite number of seconds", *delay_s);
                }
                if let Some(&found) = changes.values().find(|change| !change.is_finite()) {
                    return refuse("changes", "finite numbers", found);
                }
                if changes.values().all(|change| *change == 0.0) {
                    return refuse("changes", "an output that changes", 0.0);
                }
                (changes.keys().collect(), &tags.outputs)
            }
            FaultEffect::ActuatorLag {
                input,
                nominal_s,
                gain,
            } => {
                if !(gain.is_finite() && *gain > 0.0) {
                    return refuse("gain", "a finite number above 0", *gain);
                }
                if !(nominal_s.is_finite() && *nominal_s >= 0.0) {
                    return refuse(
                        "nominal_s",
                        "a finite number of seconds, not below 0",
                        *nominal_s,
                    );
                }
                (vec![input], &tags.inputs)
            }
        };
        let missing: Vec<String> = wanted
            .into_iter()
            .filter(|tag| !available.contains(tag))
            .cloned()
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        Err(FdiError::MissingTags {
            missing,
            available: available.clone(),
        })
    }
}

impl FaultEffect {
    /// The lasting changes of the outputs that would do to the whitened residuals what faults of
    /// known course did: by least squares `g f(t) + h f'(t)` of each, where `g` gives the changes
    /// and `h` the delay. Where a model is wrong about how the inputs answer a fault, that is in
    /// these changes too.
    ///
    /// # Errors
    /// [`FdiError`] when a record lacks a tag, sizes have another length or show no fault.
    pub fn learn(
        generators: &[ResidualGenerator],
        whitening: &JointWhitening,
        pairs: &[EffectPair],
    ) -> Result<Self, FdiError> {
        let tags = Tags::of(generators);
        let size = tags.outputs.len();
        let Some(first) = generators.first() else {
            return Err(FdiError::NoHealthyData);
        };
        // Sums of f^2, f f', f'^2, and of f v and f' v.
        let mut information = [0.0; 3];
        let mut agreement = DMatrix::<f64>::zeros(size, 2);
        for pair in pairs {
            let white = pair.change(generators, whitening)?;
            let mut before = 0.0;
            for (column, &f) in white.column_iter().zip(pair.sizes) {
                let rate = f - before;
                before = f;
                information[0] += f * f;
                information[1] += f * rate;
                information[2] += rate * rate;
                agreement.column_mut(0).axpy(f, &column, 1.0);
                agreement.column_mut(1).axpy(rate, &column, 1.0);
            }
        }
        let [ff, fr, rr] = information;
        let determinant = ff * rr - fr * fr;
        if determinant <= f64::EPSILON * ff * rr {
            return Err(FdiError::NoEffect);
        }
        let (with_size, with_rate) = (agreement.column(0), agreement.column(1));
        let lasting = (with_size * rr - with_rate * fr) / determinant;
        let late = (with_rate * ff - with_size * fr) / determinant;
        let steady = whitening.steady_gain() * tags.steady_gain(generators);
        let changes = steady
            .lu()
            .solve(&lasting)
            .filter(|changes| changes.amax() > 0.0)
            .ok_or(FdiError::NoEffect)?;
        let all = -late.dot(&lasting) / lasting.norm_squared();
        let own = tags.growth_delay(generators, whitening, &changes)?;
        let named = tags.outputs.iter().cloned().zip(changes.iter().copied());
        Ok(Self::Outputs {
            changes: named.collect(),
            delay_s: (all - own) * first.sample_time_s(),
        })
    }
}

impl FaultEffect {
    /// The lag of the actuator behind an input, with the gain that records with lags of known course
    /// show: where the input moves within the sample, or the model errs about what is fast, a lag
    /// does more or less than the model says. By least squares of the whitened residuals' change,
    /// each pair linear round its largest lag; noise in the input would make the gain too small.
    ///
    /// # Errors
    /// As [`FaultEffect::learn`].
    pub fn learn_lag(
        generators: &[ResidualGenerator],
        whitening: &JointWhitening,
        (input, nominal_s): (&str, f64),
        pairs: &[EffectPair],
    ) -> Result<Self, FdiError> {
        let tags = Tags::of(generators);
        let size = tags.outputs.len();
        let Some(first) = generators.first() else {
            return Err(FdiError::NoHealthyData);
        };
        let Some(place) = tags.inputs.iter().position(|tag| tag == input) else {
            return Err(FdiError::MissingTags {
                missing: vec![input.to_owned()],
                available: tags.inputs,
            });
        };
        let (mut agreement, mut energy) = (0.0, 0.0);
        for pair in pairs {
            let white = pair.change(generators, whitening)?;
            let mut drive = Drive::new(DriveParts {
                input: place,
                inputs: tags.inputs.len(),
                sample_time_s: first.sample_time_s(),
                half_width: SHARP,
                lags_s: vec![pair.sizes.iter().copied().fold(0.0, f64::max)],
                generators: tags.linear(generators),
                whitener: whitening.runtime(&DVector::zeros(size), &DVector::repeat(size, 1.0)),
            });
            let own = (pair.faulty, first.sample_time_s());
            let mut channels = Channels::of(own.0, own.1, &tags.inputs, &tags.outputs)?;
            for sample in 0..pair.faulty.len() {
                drive.step(channels.at(sample).0);
                // The drive answers late.
                let Some(then) = sample.checked_sub(SHARP) else {
                    continue;
                };
                let lag_s = pair.sizes[then];
                for (v, d) in white.column(then).iter().zip(drive.change(0)) {
                    agreement += v * lag_s * d;
                    energy += lag_s * lag_s * d * d;
                }
            }
        }
        let gain = agreement / energy;
        if !(gain.is_finite() && gain > 0.0) {
            return Err(FdiError::NoEffect);
        }
        Ok(Self::ActuatorLag {
            input: input.to_owned(),
            nominal_s,
            gain,
        })
    }
}

impl EffectPair<'_> {
    /// The change (m x N) of the whitened residuals.
    fn change(
        &self,
        generators: &[ResidualGenerator],
        whitening: &JointWhitening,
    ) -> Result<DMatrix<f64>, FdiError> {
        let len = self.faulty.len();
        DimensionError::check("fault sizes", len, self.sizes.len())?;
        DimensionError::check("healthy samples", len, self.healthy.len())?;
        check_finite("fault sizes", self.sizes)?;
        let change = residuals(generators, self.faulty)? - residuals(generators, self.healthy)?;
        check_finite("residuals of a fault", change.as_slice())?;
        whitening.response(&change)
    }
}

/// The residuals of all generators over a record.
pub(super) fn residuals(
    generators: &[ResidualGenerator],
    data: &Dataset,
) -> Result<DMatrix<f64>, FdiError> {
    let tags = Tags::of(generators);
    if let Some(first) = generators.first() {
        Channels::of(data, first.sample_time_s(), &tags.inputs, &tags.outputs)?;
    }
    let mut all = DMatrix::zeros(tags.outputs.len(), data.len());
    let mut first = 0;
    for generator in generators {
        let own = generator.residuals(data)?;
        all.rows_mut(first, own.nrows()).copy_from(&own);
        first += own.nrows();
    }
    Ok(all)
}
