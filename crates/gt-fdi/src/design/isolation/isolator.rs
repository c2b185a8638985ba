//! Generators, whitening, hypotheses and limits together.

use gt_core::DimensionError;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::effect::{FaultEffect, FaultHypothesis};
use super::linear::Tags;
use crate::FdiError;
use crate::design::channels::{check_sample_time, check_unique};
use crate::design::generator::ResidualGenerator;
use crate::design::joint_whitening::JointWhitening;
use crate::design::mean_time::MeanTime;
use crate::runtime::fingerprint::Fingerprint;
use crate::runtime::{
    Core, CoreParts, DiagnosisOptions, Drive, DriveParts, HypothesisKind, HypothesisParts, LAGS,
    LagParts, LevelParts,
};

/// The version of the file format of an [`Isolator`].
pub const ISOLATION_SCHEMA_VERSION: u32 = 2;

/// What tells faults apart: residual generators, their joint whitening, hypotheses, and limits that
/// healthy records set for a false-alarm rate of all of them together.
///
/// For each hypothesis the statistic is the generalised likelihood ratio of a fault that grows
/// evenly since an unknown onset, in the direction that the fault gives the whitened residuals. One
/// more, for a change in any direction, finds faults that nobody thought of. Healthy residuals
/// wander more over long times than white ones where models err; each statistic is divided by how
/// much, so that what remains has one scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Isolator {
    /// The version of the file format, [`ISOLATION_SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Its name.
    pub name: String,
    pub(super) fields: Fields,
}

/// All numbers of an [`Isolator`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Fields {
    pub(super) sample_time_s: f64,
    pub(super) generators: Vec<ResidualGenerator>,
    pub(super) whitening: JointWhitening,
    /// Robust standard deviations of the whitened residuals (m).
    pub(super) scale: DVector<f64>,
    /// Multiples of `scale` beyond which a burst is cut.
    pub(super) limiter: f64,
    /// Samples in a row beyond that: more are no burst.
    pub(super) burst: usize,
    /// Samples on either side of the one whose rate of an input is taken.
    pub(super) half_width: usize,
    /// How far back onsets are looked for, in samples.
    pub(super) longest: usize,
    pub(super) hypotheses: Vec<FaultHypothesis>,
    /// Of each hypothesis, of a drive: the healthy mean of its agreement, and its noise's energy.
    pub(super) drives: Vec<DriveNoise>,
    pub(super) limits: Vec<f64>,
    /// By the memory's level: covariance (m x m, by rows) of the normalised sums.
    pub(super) wander: Vec<Vec<Vec<f64>>>,
    /// Of each hypothesis, by the memory's level: variance of its normalised agreement.
    pub(super) driven_variance: Vec<Vec<f64>>,
    /// The promise of each limit.
    pub(super) mean_times: Vec<MeanTime>,
    pub(super) confidence: f64,
    pub(super) direction_tolerance: f64,
}

/// What healthy running says of a drive.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DriveNoise {
    pub(super) offset: f64,
    pub(super) floor: f64,
    /// Round each lag tried for the size.
    pub(super) lags: Vec<LagNoise>,
}

/// What is known of a drive round one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LagNoise {
    /// Healthy mean of the agreement with the residuals.
    pub(super) offset: f64,
    /// Energy of the drive's own noise, a sample.
    pub(super) floor: f64,
    /// What the drive would agree with itself if its rate were not smoothed, over its energy.
    pub(super) gain: f64,
}

/// The fields of an [`Isolator`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    schema_version: u32,
    name: String,
    fields: Fields,
}

impl TryFrom<Unchecked> for Isolator {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        if raw.schema_version != ISOLATION_SCHEMA_VERSION {
            return Err(FdiError::SchemaVersion {
                expected: ISOLATION_SCHEMA_VERSION,
                found: raw.schema_version,
            });
        }
        Self::checked(raw.name, raw.fields)
    }
}

impl Isolator {
    pub(super) fn checked(name: String, fields: Fields) -> Result<Self, FdiError> {
        fields.check(&name)?;
        Ok(Self {
            schema_version: ISOLATION_SCHEMA_VERSION,
            name,
            fields,
        })
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.fields.sample_time_s
    }

    /// The generators.
    pub fn generators(&self) -> &[ResidualGenerator] {
        &self.fields.generators
    }

    /// The hypotheses.
    pub fn hypotheses(&self) -> &[FaultHypothesis] {
        &self.fields.hypotheses
    }

    /// The joint whitening of the residuals.
    pub fn whitening(&self) -> &JointWhitening {
        &self.fields.whitening
    }

    /// A limit a hypothesis and, last, that of a change in any direction.
    pub fn limits(&self) -> &[f64] {
        &self.fields.limits
    }

    /// What healthy records promise of each limit.
    pub fn mean_times(&self) -> &[MeanTime] {
        &self.fields.mean_times
    }

    /// By the age of an onset (doubling from one entry to the next): the covariance (m x m, by rows)
    /// of the normalised sums of healthy residuals. The identity for white ones; more is how much,
    /// and in which directions, the models err over such times.
    pub fn wander(&self) -> &[Vec<Vec<f64>>] {
        &self.fields.wander
    }

    /// Tags of the inputs, in the order of the detector.
    pub fn inputs(&self) -> Vec<String> {
        Tags::of(&self.fields.generators).inputs
    }

    /// Tags of the outputs, in the order of the detector.
    pub fn outputs(&self) -> Vec<String> {
        Tags::of(&self.fields.generators).outputs
    }

    /// Samples before anything is judged.
    pub fn settle_samples(&self) -> usize {
        self.fields.settle_samples() + self.fields.whitening.order()
    }

    /// The directions (m) of the hypotheses in the whitened residuals for one unit of each, where
    /// they have one; what an actuator's lag does depends on its movements.
    pub fn directions(&self) -> Vec<Option<DVector<f64>>> {
        self.fields.directions()
    }

    pub(super) fn core(&self) -> Result<Core, FdiError> {
        self.fields.core()
    }

    /// A number that tells two isolators apart: the hash of all that they are made of.
    pub(super) fn fingerprint(&self) -> u64 {
        let mut print = Fingerprint::new();
        // Debug prints every digit, and never fails.
        print.add_text(&format!("{:?}", self.fields));
        print.value()
    }
}

impl Fields {
    fn check(&self, name: &str) -> Result<(), FdiError> {
        let (Some(first), false) = (self.generators.first(), self.hypotheses.is_empty()) else {
            return Err(FdiError::EmptyBank {
                name: name.to_owned(),
            });
        };
        check_sample_time("the isolator", first.sample_time_s(), self.sample_time_s)?;
        for generator in &self.generators {
            check_sample_time("a generator", self.sample_time_s, generator.sample_time_s())?;
        }
        let tags = Tags::of(&self.generators);
        check_unique(
            "outputs of the isolator",
            &tags.outputs.iter().collect::<Vec<_>>(),
        )?;
        let names: Vec<&String> = self.hypotheses.iter().map(|own| &own.name).collect();
        check_unique("hypotheses", &names)?;
        for hypothesis in &self.hypotheses {
            hypothesis.check(&tags)?;
        }
        let (size, count) = (tags.outputs.len(), self.hypotheses.len());
        let sizes = [
            ("whitened residuals", size, self.whitening.mean().len()),
            ("scales", size, self.scale.len()),
            ("drives", count, self.drives.len()),
            ("limits", count + 1, self.limits.len()),
            (
                "lags of drives",
                LAGS.len()
                    * self
                        .drives
                        .iter()
                        .filter(|own| !own.lags.is_empty())
                        .count(),
                self.drives.iter().map(|own| own.lags.len()).sum(),
            ),
            ("variances of drives", count, self.driven_variance.len()),
            ("promises", count + 1, self.mean_times.len()),
        ];
        for (what, expected, found) in sizes {
            DimensionError::check(&format!("isolator, {what}"), expected, found)?;
        }
        let above_zero = self.scale.iter().chain(&self.limits).chain([&self.limiter]);
        let options = above_zero
            .map(|value| ("scale, limits, limiter", *value, *value > 0.0))
            .chain(
                self.driven_variance
                    .iter()
                    .flatten()
                    .map(|value| ("driven_variance", *value, *value >= 1.0)),
            )
            .chain(
                self.drives
                    .iter()
                    .flat_map(|own| &own.lags)
                    .map(|own| ("gain", own.gain, own.gain > 0.0)),
            )
            .chain([
                (
                    "confidence",
                    self.confidence,
                    self.confidence > 0.5 && self.confidence < 1.0,
                ),
                (
                    "direction_tolerance",
                    self.direction_tolerance,
                    self.direction_tolerance >= 0.0,
                ),
            ]);
        for (option, found, holds) in options {
            // Limits are infinite while they are being found.
            if !holds || found.is_nan() {
                return Err(FdiError::Option {
                    option,
                    expected: "a number in its range: above 0, driven_variance from 1 on, confidence \
                               between 0.5 and 1",
                    found,
                });
            }
        }
        for level in &self.wander {
            DimensionError::check("isolator, rows of wander", size, level.len())?;
            for row in level {
                DimensionError::check("isolator, columns of wander", size, row.len())?;
            }
        }
        let lengths = [
            ("longest", self.longest, 1 << 24),
            ("half_width", self.half_width, 1 << 12),
        ];
        for (option, found, most) in lengths {
            if found > most {
                return Err(FdiError::Option {
                    option,
                    expected: "a number of samples below 16 million (longest) or 4096 (half_width)",
                    found: found as f64,
                });
            }
        }
        Ok(())
    }

    pub(super) fn settle_samples(&self) -> usize {
        let own = self
            .generators
            .iter()
            .map(ResidualGenerator::settle_samples);
        own.max().unwrap_or(0)
    }

    fn directions(&self) -> Vec<Option<DVector<f64>>> {
        let tags = Tags::of(&self.generators);
        let steady = self.whitening.steady_gain() * tags.steady_gain(&self.generators);
        let own = self
            .hypotheses
            .iter()
            .map(|hypothesis| match &hypothesis.effect {
                FaultEffect::Outputs { changes, .. } => {
                    let change = tags
                        .outputs
                        .iter()
                        .map(|tag| changes.get(tag).copied().unwrap_or(0.0));
                    let change = DVector::from_iterator(tags.outputs.len(), change);
                    Some((&steady * change).component_div(&self.scale))
                }
                FaultEffect::ActuatorLag { .. } => None,
            });
        own.collect()
    }

    pub(super) fn core(&self) -> Result<Core, FdiError> {
        let tags = Tags::of(&self.generators);
        let mut drives = Vec::new();
        let mut hypotheses = Vec::new();
        let directions = self.directions();
        let own_directions = directions.clone();
        let mut answer = 0;
        for ((hypothesis, direction), noise) in
            self.hypotheses.iter().zip(directions).zip(&self.drives)
        {
            let (kind, delay) = match (&hypothesis.effect, direction) {
                (
                    FaultEffect::ActuatorLag {
                        input, nominal_s, ..
                    },
                    _,
                ) => {
                    drives.push(self.drive(&tags, input, *nominal_s, self.half_width));
                    (HypothesisKind::Driven(drives.len() - 1), 0.0)
                }
                (FaultEffect::Outputs { changes, delay_s }, Some(direction)) => {
                    let change = tags
                        .outputs
                        .iter()
                        .map(|tag| changes.get(tag).copied().unwrap_or(0.0));
                    let change = DVector::from_iterator(tags.outputs.len(), change);
                    let own = tags.growth_delay(&self.generators, &self.whitening, &change)?;
                    let delay = own + delay_s / self.sample_time_s;
                    let (generators, whitening) = (&self.generators, &self.whitening);
                    let tolerance = self.direction_tolerance;
                    let own = tags.answer_time(generators, whitening, &change, tolerance)?;
                    answer = answer.max(own);
                    (
                        HypothesisKind::Direction(direction.as_slice().to_vec()),
                        delay,
                    )
                }
                (FaultEffect::Outputs { .. }, None) => continue,
            };
            hypotheses.push(HypothesisParts {
                kind,
                both_signs: hypothesis.both_signs,
                offset: noise.offset,
                floor: noise.floor,
                delay,
                lags: self.lag_parts(noise, &hypothesis.effect),
            });
        }
        let delay = if drives.is_empty() {
            0
        } else {
            self.half_width
        };
        for hypothesis in &mut hypotheses {
            // All evidence is late by as much.
            hypothesis.delay += delay as f64;
        }
        Ok(Core::new(CoreParts {
            generators: tags.runtime(&self.generators),
            whitener: self.whitening.runtime(self.whitening.mean(), &self.scale),
            limiter: self.limiter,
            burst: self.burst,
            hypotheses,
            drives,
            delay,
            settle: self.settle_samples(),
            answer,
            longest: self.longest,
            limits: self.limits.clone(),
            levels: self.level_parts(&own_directions)?,
            options: DiagnosisOptions {
                confidence: self.confidence,
                direction_tolerance: self.direction_tolerance,
            },
        }))
    }

    fn level_parts(
        &self,
        directions: &[Option<DVector<f64>>],
    ) -> Result<Vec<LevelParts>, FdiError> {
        let size = self.scale.len();
        let levels = self.wander.iter().enumerate();
        levels
            .map(|(index, rows)| {
                let covariance = DMatrix::from_fn(size, size, |i, j| rows[i][j]);
                let metric =
                    covariance
                        .cholesky()
                        .map(|root| root.inverse())
                        .ok_or(FdiError::Option {
                            option: "wander",
                            expected: "positive definite matrices",
                            found: index as f64,
                        })?;
                let mut parts = LevelParts {
                    metric: metric.transpose().as_slice().to_vec(),
                    projected: Vec::new(),
                    scale: Vec::new(),
                };
                for (direction, variances) in directions.iter().zip(&self.driven_variance) {
                    if let Some(direction) = direction {
                        let projected = &metric * direction;
                        parts.scale.push(projected.dot(direction));
                        parts.projected.push(projected.as_slice().to_vec());
                    } else {
                        let own = variances.get(index).or(variances.last());
                        parts.scale.push(own.copied().unwrap_or(1.0));
                        parts.projected.push(Vec::new());
                    }
                }
                Ok(parts)
            })
            .collect()
    }

    fn lag_parts(&self, noise: &DriveNoise, effect: &FaultEffect) -> Vec<LagParts> {
        let FaultEffect::ActuatorLag { gain, .. } = effect else {
            return Vec::new();
        };
        let lags = noise.lags.iter().zip(LAGS);
        lags.map(|(own, lag)| LagParts {
            lag_s: lag * self.sample_time_s,
            offset: own.offset,
            floor: own.floor,
            gain: own.gain * gain,
        })
        .collect()
    }

    /// The drive of an actuator, its rate over `half_width` samples on either side.
    pub(super) fn drive(
        &self,
        tags: &Tags,
        input: &str,
        nominal_lag_s: f64,
        half_width: usize,
    ) -> Drive {
        let zero = DVector::zeros(self.scale.len());
        Drive::new(DriveParts {
            input: tags.inputs.iter().position(|tag| tag == input).unwrap_or(0),
            inputs: tags.inputs.len(),
            sample_time_s: self.sample_time_s,
            half_width,
            lags_s: [nominal_lag_s]
                .into_iter()
                .chain(LAGS.map(|lag| lag * self.sample_time_s))
                .collect(),
            generators: tags.linear(&self.generators),
            whitener: self.whitening.runtime(&zero, &self.scale),
        })
    }
}
