//! Hypotheses about faults.

use std::collections::BTreeMap;

use gt_core::Dataset;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::linear::Tags;
use crate::FdiError;
use crate::design::channels::Channels;
use crate::design::generator::ResidualGenerator;

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
    /// The lasting changes of the outputs that explain, by least squares, what faults of known
    /// course changed of the residuals: `d f(t)` and, for the delay, `e f'(t)`, each through the
    /// generators. Residuals weigh by their root mean square change.
    ///
    /// # Errors
    /// [`FdiError`] when a record lacks a tag, sizes have another length or show no fault.
    pub fn learn(generators: &[ResidualGenerator], pairs: &[EffectPair]) -> Result<Self, FdiError> {
        let tags = Tags::of(generators);
        let size = tags.outputs.len();
        let sample_time_s = generators
            .first()
            .map_or(1.0, ResidualGenerator::sample_time_s);
        let mut changes: Vec<DMatrix<f64>> = Vec::new();
        for pair in pairs {
            gt_core::DimensionError::check("fault sizes", pair.faulty.len(), pair.sizes.len())?;
            gt_core::DimensionError::check(
                "healthy samples",
                pair.faulty.len(),
                pair.healthy.len(),
            )?;
            super::super::calibration::check_finite("fault sizes", pair.sizes)?;
            changes
                .push(residuals(generators, pair.faulty)? - residuals(generators, pair.healthy)?);
        }
        let weights: Vec<f64> = (0..size)
            .map(|row| {
                let squares: f64 = changes.iter().map(|own| own.row(row).norm_squared()).sum();
                if squares > 0.0 {
                    squares.sqrt().recip()
                } else {
                    1.0
                }
            })
            .collect();
        let mut information = DMatrix::<f64>::zeros(2 * size, 2 * size);
        let mut agreement = DVector::<f64>::zeros(2 * size);
        for (pair, change) in pairs.iter().zip(&changes) {
            let rates: Vec<f64> = (0..pair.sizes.len())
                .map(|t| {
                    t.checked_sub(1)
                        .map_or(0.0, |before| pair.sizes[t] - pair.sizes[before])
                })
                .collect();
            let mut regressors: Vec<DMatrix<f64>> = Vec::with_capacity(2 * size);
            for course in [pair.sizes, &rates] {
                for output in 0..size {
                    let mut y = DMatrix::zeros(size, course.len());
                    y.row_mut(output).copy_from_slice(course);
                    let u = DMatrix::zeros(tags.inputs.len(), course.len());
                    regressors.push(weighted(&tags.response(generators, &u, &y), &weights));
                }
            }
            let change = weighted(change, &weights);
            for (i, left) in regressors.iter().enumerate() {
                agreement[i] += left.dot(&change);
                for (j, right) in regressors.iter().enumerate().take(i + 1) {
                    let product = left.dot(right);
                    information[(i, j)] += product;
                    if i != j {
                        information[(j, i)] += product;
                    }
                }
            }
        }
        let solved = information
            .svd(true, true)
            .solve(&agreement, f64::EPSILON * 1e3)
            .ok()
            .filter(|solved| solved.rows(0, size).amax() > 0.0)
            .ok_or(FdiError::NoEffect)?;
        let lasting = solved.rows(0, size);
        let late = -solved.rows(size, size).dot(&lasting) / lasting.norm_squared();
        let named = tags.outputs.iter().cloned().zip(lasting.iter().copied());
        Ok(Self::Outputs {
            changes: named.collect(),
            delay_s: late * sample_time_s,
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
    // Nothing is known of a sample without a residual.
    Ok(all.map(|value| if value.is_finite() { value } else { 0.0 }))
}

fn weighted(change: &DMatrix<f64>, weights: &[f64]) -> DMatrix<f64> {
    let mut scaled = change.clone();
    for (mut row, weight) in scaled.row_iter_mut().zip(weights) {
        row *= *weight;
    }
    scaled
}
