//! Limits, scales and what else healthy records tell an isolator.

use std::collections::BTreeMap;

use gt_core::Dataset;
use nalgebra::{DMatrix, DVector};

use super::drive_noise::{Actuator, drive_noise};
use super::effect::{FaultEffect, FaultHypothesis, residuals};
use super::isolator::{DriveNoise, Fields, Isolator};
use super::linear::Tags;
use super::wander::{identity, wander};
use crate::FdiError;
use crate::design::calibration::check_finite;
use crate::design::channels::Channels;
use crate::design::generator::ResidualGenerator;
use crate::design::joint_whitening::JointWhitening;
use crate::design::mean_time::MeanTime;
use crate::design::tail::Tail;
use crate::runtime::{Core, DriveSums, LAGS};

/// Scans of the statistics between two peaks that count as two.
const RELEASE_SCANS: usize = 256;
/// Samples between two scans.
pub(super) const SAMPLES_A_SCAN: usize = 8;
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
    /// does comes in bursts too: it is judged by residuals as they are.
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
    /// ([`FdiError::HealthyHours`]).
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
            // Nothing lasts so long.
            burst: usize::MAX >> 1,
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
        fields.burst = longest_burst(&fields, healthy)?;
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
        // Sums of the agreements round the nominal lag and each of those tried.
        let mut sums = vec![(vec![0.0; 1 + LAGS.len()], 0_usize); fields.hypotheses.len()];
        run(fields, healthy, |core| {
            let signals = core.last_sample();
            let places = fields.hypotheses.iter().enumerate();
            let own =
                places.filter(|(_, own)| matches!(own.effect, FaultEffect::ActuatorLag { .. }));
            for (drive, (place, _)) in own.enumerate() {
                let at = DriveSums::of(size, drive);
                if signals[at.energy] > 0.0 {
                    let (agreements, samples) = &mut sums[place];
                    agreements[0] += signals[at.agreement];
                    for (lag, sum) in agreements[1..].iter_mut().enumerate() {
                        *sum += signals[at.lag(lag)[0]];
                    }
                    *samples += 1;
                }
            }
        })?;
        let noise = fields.hypotheses.iter().zip(sums);
        noise
            .map(|(hypothesis, (agreements, samples))| {
                let FaultEffect::ActuatorLag {
                    input, nominal_s, ..
                } = &hypothesis.effect
                else {
                    return Ok(DriveNoise::default());
                };
                let actuator = Actuator {
                    input,
                    nominal_s: *nominal_s,
                    deviation: self.input_deviations.get(input).copied().unwrap_or(0.0),
                };
                let mut noise = drive_noise(fields, &tags, actuator, healthy)?;
                // Only noise that both share agrees however little the input moves.
                if actuator.deviation > 0.0 {
                    let mean = |sum: f64| sum / samples.max(1) as f64;
                    noise.offset = mean(agreements[0]);
                    for (lag, sum) in noise.lags.iter_mut().zip(&agreements[1..]) {
                        lag.offset = mean(*sum);
                    }
                }
                Ok(noise)
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
            let scans: usize = rows.iter().map(|row| row.len()).sum();
            let hours = scans as f64 * scan_s / 3600.0;
            let promise = |tail| MeanTime::of(asked_hours, scan_s, hours, RELEASE_SCANS, tail);
            let tail =
                Tail::fit(&rows, RELEASE_SCANS, run_length).map_err(|cause| match cause {
                    FdiError::TooFewPeaks { .. } => FdiError::HealthyHours {
                        asked_hours: self.arl0_hours,
                        needed_hours: (10.0 * promise(None).healthy_hours_needed).ceil() / 10.0,
                        found_hours: (1000.0 * hours).floor() / 1000.0,
                    },
                    other => other,
                })?;
            let limit = tail.limit_for(run_length);
            mean_times.push(promise(Some((tail, limit))));
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
pub(super) fn run(
    fields: &Fields,
    records: &[Dataset],
    mut visit: impl FnMut(&Core),
) -> Result<(), FdiError> {
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

/// Twice as many samples as healthy residuals ever were beyond the limiter in a row, a scan's at
/// least.
fn longest_burst(fields: &Fields, healthy: &[Dataset]) -> Result<usize, FdiError> {
    let mut longest = 0;
    run(fields, healthy, |core| longest = longest.max(core.beyond()))?;
    Ok((2 * longest).max(SAMPLES_A_SCAN))
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
