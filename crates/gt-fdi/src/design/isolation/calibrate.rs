//! Limits, scales and what else healthy records tell an isolator.

use std::collections::BTreeMap;

use gt_core::Dataset;
use nalgebra::{DMatrix, DVector};

use super::drive_noise::{lag_curve, noise_energy};
use super::effect::{FaultEffect, FaultHypothesis, residuals};
use super::isolator::{DriveNoise, Fields, Isolator};
use super::linear::Tags;
use crate::FdiError;
use crate::design::calibration::check_finite;
use crate::design::channels::Channels;
use crate::design::generator::ResidualGenerator;
use crate::design::joint_whitening::JointWhitening;
use crate::design::mean_time::MeanTime;
use crate::design::tail::Tail;
use crate::runtime::Core;

/// Scans of the statistics between two peaks that count as two.
const RELEASE_SCANS: usize = 256;
/// Samples between two scans.
const SAMPLES_A_SCAN: usize = 8;
/// Ratio of a normal variable's standard deviation to its median modulus.
const DEVIATION_OVER_MEDIAN: f64 = 1.482_602_218_505_602;

/// How an [`Isolator`] is made.
#[derive(Debug, Clone)]
pub struct IsolationDesign {
    faults: Vec<FaultHypothesis>,
    arl0_hours: f64,
    limiter: f64,
    half_width: usize,
    longest_s: f64,
    confidence: f64,
    direction_tolerance: f64,
    input_deviations: BTreeMap<String, f64>,
}

impl IsolationDesign {
    /// A design for these faults, one false alarm in 24 h of all statistics together.
    pub fn new(faults: Vec<FaultHypothesis>) -> Self {
        Self {
            faults,
            arl0_hours: 24.0,
            limiter: 2.5,
            half_width: 0,
            longest_s: 600.0,
            confidence: 0.99,
            direction_tolerance: 0.1,
            input_deviations: BTreeMap::new(),
        }
    }

    /// Hours between false alarms of all statistics together.
    #[must_use]
    pub fn arl0_hours(mut self, hours: f64) -> Self {
        self.arl0_hours = hours;
        self
    }

    /// Robust standard deviations beyond which a burst of a whitened residual is cut: 2.5 for
    /// residuals that are mostly model errors, 4 and more for normal noise. What an actuator's lag
    /// does comes in bursts too, so that a low limiter makes large lags look smaller.
    #[must_use]
    pub fn limiter(mut self, deviations: f64) -> Self {
        self.limiter = deviations;
        self
    }

    /// The rate of an actuator's demand is the slope over `samples` on either side: none for inputs
    /// without noise. All evidence is as late.
    #[must_use]
    pub fn half_width(mut self, samples: usize) -> Self {
        self.half_width = samples;
        self
    }

    /// How far back onsets are looked for, in seconds.
    #[must_use]
    pub fn longest_s(mut self, seconds: f64) -> Self {
        self.longest_s = seconds;
        self
    }

    /// The probability from which on a fault is named.
    #[must_use]
    pub fn confidence(mut self, probability: f64) -> Self {
        self.confidence = probability;
        self
    }

    /// How far a fault's direction in the residuals may be from what its hypothesis says, as a share
    /// of its length.
    #[must_use]
    pub fn direction_tolerance(mut self, share: f64) -> Self {
        self.direction_tolerance = share;
        self
    }

    /// Standard deviation of the noise of an input, in its unit, which makes the rate of that input
    /// uncertain.
    #[must_use]
    pub fn input_deviation(mut self, input: impl Into<String>, deviation: f64) -> Self {
        self.input_deviations.insert(input.into(), deviation);
        self
    }

    /// The isolator of these generators: whitening, scales, dispersions and limits from healthy
    /// records. Each of the `n + 1` statistics of `n` hypotheses gets the `n + 1`th part of the
    /// false alarms; its limit is that of the peaks over a level (exponential heights), with what
    /// they promise.
    ///
    /// # Errors
    /// [`FdiError`] when an option is out of its range, a record lacks a tag or is shorter than the
    /// generators settle, residuals are not finite or do not move, or the records show too few peaks
    /// ([`FdiError::TooFewPeaks`]).
    pub fn calibrate(
        &self,
        name: impl Into<String>,
        generators: Vec<ResidualGenerator>,
        healthy: &[Dataset],
    ) -> Result<Isolator, FdiError> {
        self.check()?;
        let Some(first) = generators.first() else {
            return Err(FdiError::EmptyBank { name: name.into() });
        };
        if healthy.is_empty() {
            return Err(FdiError::NoHealthyData);
        }
        let sample_time_s = first.sample_time_s();
        let settled = settled_residuals(&generators, healthy)?;
        let whitening = JointWhitening::estimate(&settled.iter().collect::<Vec<_>>())?;
        let scale = robust_scale(&whitening, &settled)?;
        drop(settled);
        let (count, size) = (self.faults.len(), scale.len());
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked
        let longest = (self.longest_s / sample_time_s).round().max(1.0) as usize;
        let waiting = MeanTime {
            asked_hours: self.arl0_hours,
            hours: None,
            hours_low: None,
            hours_high: None,
            peaks: 0,
            healthy_hours: 0.0,
            healthy_hours_needed: 0.0,
        };
        let mut fields = Fields {
            sample_time_s,
            generators,
            whitening,
            scale,
            limiter: self.limiter,
            half_width: self.half_width,
            longest,
            hypotheses: self.faults.clone(),
            drives: vec![DriveNoise::default(); count],
            limits: vec![f64::INFINITY; count + 1],
            wander: vec![identity(size)],
            driven_variance: vec![vec![1.0]; count],
            mean_times: vec![waiting; count + 1],
            confidence: self.confidence,
            direction_tolerance: self.direction_tolerance,
        };
        let name = name.into();
        // Checked before the long work.
        let _ = Isolator::checked(name.clone(), fields.clone())?;
        fields.drives = self.drive_noise(&fields, healthy)?;
        (fields.wander, fields.driven_variance) = wander(&fields, healthy)?;
        let (limits, mean_times) = self.limits(&fields, healthy)?;
        (fields.limits, fields.mean_times) = (limits, mean_times);
        Isolator::checked(name, fields)
    }

    /// The joint whitening that [`IsolationDesign::calibrate`] uses, for [`FaultEffect::learn`].
    ///
    /// # Errors
    /// As [`IsolationDesign::calibrate`].
    pub fn whitening(
        generators: &[ResidualGenerator],
        healthy: &[Dataset],
    ) -> Result<JointWhitening, FdiError> {
        let settled = settled_residuals(generators, healthy)?;
        JointWhitening::estimate(&settled.iter().collect::<Vec<_>>())
    }

    fn check(&self) -> Result<(), FdiError> {
        let positive = [
            ("arl0_hours", self.arl0_hours),
            ("limiter", self.limiter),
            ("longest_s", self.longest_s),
        ];
        for (option, found) in positive {
            if !(found.is_finite() && found > 0.0) {
                return Err(FdiError::Option {
                    option,
                    expected: "a positive finite number",
                    found,
                });
            }
        }
        let bad = |deviation: &&f64| !(deviation.is_finite() && **deviation >= 0.0);
        if let Some(&found) = self.input_deviations.values().find(bad) {
            return Err(FdiError::Option {
                option: "input_deviation",
                expected: "a finite number, not below 0",
                found,
            });
        }
        Ok(())
    }

    /// Offsets and floors of the drives.
    fn drive_noise(
        &self,
        fields: &Fields,
        healthy: &[Dataset],
    ) -> Result<Vec<DriveNoise>, FdiError> {
        let tags = Tags::of(&fields.generators);
        let size = tags.outputs.len();
        let mut sums = vec![(0.0, 0_usize); fields.hypotheses.len()];
        run(fields, healthy, |core| {
            let driven = core.last_sample()[size..].chunks_exact(size + 2);
            let places = fields.hypotheses.iter().enumerate();
            let own =
                places.filter(|(_, own)| matches!(own.effect, FaultEffect::ActuatorLag { .. }));
            for ((place, _), signals) in own.zip(driven) {
                if signals[1] > 0.0 {
                    sums[place].0 += signals[0];
                    sums[place].1 += 1;
                }
            }
        })?;
        let noise = fields.hypotheses.iter().zip(sums);
        noise
            .map(|(hypothesis, (sum, samples))| {
                let FaultEffect::ActuatorLag { input, nominal_s } = &hypothesis.effect else {
                    return Ok(DriveNoise::default());
                };
                let deviation = self.input_deviations.get(input).copied().unwrap_or(0.0);
                Ok(DriveNoise {
                    // Only noise that both share agrees however little the input moves.
                    offset: if deviation > 0.0 {
                        sum / samples.max(1) as f64
                    } else {
                        0.0
                    },
                    floor: noise_energy(fields, &tags, (input, *nominal_s), deviation),
                    curve: lag_curve(fields, &tags, (input, *nominal_s), deviation, healthy)?,
                })
            })
            .collect()
    }

    fn limits(
        &self,
        fields: &Fields,
        healthy: &[Dataset],
    ) -> Result<(Vec<f64>, Vec<MeanTime>), FdiError> {
        let count = fields.hypotheses.len() + 1;
        let mut series: Vec<Vec<Vec<f64>>> = vec![Vec::new(); count];
        for data in healthy {
            let mut own: Vec<Vec<f64>> = vec![Vec::new(); count];
            run(fields, std::slice::from_ref(data), |core| {
                for (values, value) in own.iter_mut().zip(&core.verdict().statistics) {
                    values.push(*value);
                }
            })?;
            for (all, own) in series.iter_mut().zip(own) {
                // One value a scan.
                all.push(own.into_iter().step_by(SAMPLES_A_SCAN).collect());
            }
        }
        let asked_hours = self.arl0_hours * count as f64;
        let scan_s = SAMPLES_A_SCAN as f64 * fields.sample_time_s;
        let run_length = asked_hours * 3600.0 / scan_s;
        let mut limits = Vec::with_capacity(count);
        let mut mean_times = Vec::with_capacity(count);
        for records in &series {
            let rows: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
            let tail = Tail::fit(&rows, RELEASE_SCANS, run_length)?;
            let limit = tail.limit_for(run_length);
            let scans: usize = rows.iter().map(|row| row.len()).sum();
            let hours = scans as f64 * scan_s / 3600.0;
            mean_times.push(MeanTime::of(
                asked_hours,
                scan_s,
                hours,
                RELEASE_SCANS,
                Some((tail, limit)),
            ));
            limits.push(limit);
        }
        Ok((limits, mean_times))
    }
}

/// The residuals of each record without those in which the generators settle.
fn settled_residuals(
    generators: &[ResidualGenerator],
    healthy: &[Dataset],
) -> Result<Vec<DMatrix<f64>>, FdiError> {
    let settles = generators.iter().map(ResidualGenerator::settle_samples);
    let settle = settles.max().unwrap_or(0);
    let records = healthy.iter().enumerate();
    records
        .map(|(record, data)| {
            if data.len() <= settle {
                return Err(FdiError::HealthySamples {
                    record,
                    needed: settle + 1,
                    found: data.len(),
                });
            }
            let own = residuals(generators, data)?;
            let own = own.columns(settle, own.ncols() - settle).into_owned();
            check_finite(&format!("healthy residual {record}"), own.as_slice())?;
            Ok(own)
        })
        .collect()
}

/// Runs the core over records, calling `visit` after every settled sample.
fn run(fields: &Fields, records: &[Dataset], mut visit: impl FnMut(&Core)) -> Result<(), FdiError> {
    let tags = Tags::of(&fields.generators);
    let mut core = fields.core()?;
    for data in records {
        core.reset();
        let mut channels = Channels::of(data, fields.sample_time_s, &tags.inputs, &tags.outputs)?;
        for sample in 0..data.len() {
            let (u, y) = channels.at(sample);
            if !core.step(data.time_s(sample), u, y).settling {
                visit(&core);
            }
        }
    }
    Ok(())
}

/// The identity by rows.
fn identity(size: usize) -> Vec<Vec<f64>> {
    by_rows(&DMatrix::identity(size, size))
}

fn by_rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let rows = matrix.row_iter();
    rows.map(|row| row.iter().copied().collect()).collect()
}

/// By the memory's level the covariance of the normalised sums of healthy residuals, by rows, and
/// of each hypothesis the variance of its normalised agreement where it is driven. White residuals
/// have the identity and 1; no direction counts as quieter than that.
type Wander = (Vec<Vec<Vec<f64>>>, Vec<Vec<f64>>);

fn wander(fields: &Fields, healthy: &[Dataset]) -> Result<Wander, FdiError> {
    // Of both signs: the square of either half is the same.
    let mut symmetric = fields.clone();
    for hypothesis in &mut symmetric.hypotheses {
        hypothesis.both_signs = true;
    }
    let (size, count) = (fields.scale.len(), fields.hypotheses.len());
    let levels = fields.core()?.levels();
    let mut covariances = vec![(DMatrix::<f64>::zeros(size, size), 0_usize); levels];
    let mut squares = vec![vec![(0.0, 0_usize); levels]; count];
    let mut samples = 0_usize;
    run(&symmetric, healthy, |core| {
        samples += 1;
        // Sums overlap so much that one in many tells as much as all.
        if samples.is_multiple_of(8 * SAMPLES_A_SCAN) {
            core.normalised(|level, place, values| {
                if place < count {
                    let (sum, number) = &mut squares[place][level];
                    *sum += values[0] * values[0];
                    *number += 1;
                } else {
                    let (sum, number) = &mut covariances[level];
                    let values = DVector::from_column_slice(values);
                    sum.ger(1.0, &values, &values, 1.0);
                    *number += 1;
                }
            });
        }
    })?;
    let mut last = DMatrix::identity(size, size);
    let wander = covariances.into_iter().map(|(sum, number)| {
        if number > size {
            let mut parts = (sum / number as f64).symmetric_eigen();
            parts.eigenvalues.apply(|value| *value = value.max(1.0));
            last = parts.recompose();
        }
        by_rows(&last)
    });
    let wander = wander.collect();
    let driven = squares.into_iter().map(|levels| {
        let mut last = 1.0_f64;
        let own = levels.into_iter().map(|(sum, number)| {
            if number > 0 {
                last = (sum / number as f64).max(1.0);
            }
            last
        });
        own.collect()
    });
    Ok((wander, driven.collect()))
}

fn robust_scale(
    whitening: &JointWhitening,
    settled: &[DMatrix<f64>],
) -> Result<DVector<f64>, FdiError> {
    let size = whitening.mean().len();
    let mut moduli: Vec<Vec<f64>> = vec![Vec::new(); size];
    for record in settled {
        let white = whitening.whiten(record)?;
        for (own, row) in moduli.iter_mut().zip(white.row_iter()) {
            own.extend(row.iter().skip(whitening.order()).map(|value| value.abs()));
        }
    }
    let scale = moduli.iter_mut().enumerate().map(|(index, own)| {
        let middle = own.len() / 2;
        if own.is_empty() {
            return Err(FdiError::NoHealthyData);
        }
        let (_, median, _) = own.select_nth_unstable_by(middle, f64::total_cmp);
        if *median > 0.0 {
            Ok(DEVIATION_OVER_MEDIAN * *median)
        } else {
            Err(FdiError::ConstantResidual {
                index,
                found: *median,
            })
        }
    });
    Ok(DVector::from_vec(scale.collect::<Result<_, _>>()?))
}
