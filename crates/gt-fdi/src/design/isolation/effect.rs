//! Hypotheses about faults.

use std::collections::BTreeMap;

use gt_core::Dataset;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::linear::Tags;
use crate::FdiError;
use crate::design::calibration::check_finite;
use crate::design::channels::Channels;
use crate::design::generator::ResidualGenerator;
use crate::design::joint_whitening::JointWhitening;

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
    },
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
            FaultEffect::ActuatorLag { input, nominal_s } => {
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
            gt_core::DimensionError::check("fault sizes", pair.faulty.len(), pair.sizes.len())?;
            gt_core::DimensionError::check(
                "healthy samples",
                pair.faulty.len(),
                pair.healthy.len(),
            )?;
            check_finite("fault sizes", pair.sizes)?;
            let change = residuals(generators, pair.faulty)? - residuals(generators, pair.healthy)?;
            check_finite("residuals of a fault", change.as_slice())?;
            let white = whitening.response(&change)?;
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
