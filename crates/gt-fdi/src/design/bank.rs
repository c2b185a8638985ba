//! A bank of output observers with their thresholds, and its run over a record.

use gt_core::Dataset;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::calibration::{Calibration, FalseAlarmSummary, calibrate};
use super::channels::{Channels, check_sample_time, check_unique};
use super::generator::ResidualGenerator;
use super::threshold::{FixedThreshold, ThresholdRule};
use crate::FdiError;
use crate::runtime::{Channel, ChannelVerdict, Detector};

/// The version of the file format of a [`Bank`].
pub const SCHEMA_VERSION: u32 = 1;

/// One output's generator and threshold, with the false alarms counted when it was set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputDetector {
    /// The residual generator.
    pub generator: ResidualGenerator,
    /// The threshold on its residual.
    pub threshold: FixedThreshold,
    /// The false alarms counted when the threshold was set.
    pub false_alarms: FalseAlarmSummary,
}

impl OutputDetector {
    /// A generator with the threshold that was calibrated on its residuals.
    pub fn new(generator: ResidualGenerator, calibration: &Calibration) -> Self {
        let false_alarms = calibration.summary();
        Self {
            generator,
            threshold: calibration.threshold,
            false_alarms,
        }
    }

    /// A generator with a threshold calibrated on healthy records: their residuals without the
    /// first [`ResidualGenerator::settle_samples`] of each.
    ///
    /// # Errors
    /// As [`ResidualGenerator::residual`] and [`calibrate`], whose sample indices count from the
    /// end of the settling; besides when a record is not longer than the settling.
    pub fn calibrate(
        generator: ResidualGenerator,
        healthy: &[Dataset],
        rule: ThresholdRule,
    ) -> Result<Self, FdiError> {
        let settle = generator.settle_samples();
        let mut residuals = Vec::with_capacity(healthy.len());
        for (record, data) in healthy.iter().enumerate() {
            let residual = generator.residual(data)?;
            if residual.len() <= settle {
                let found = residual.len();
                return Err(FdiError::HealthySamples {
                    record,
                    needed: settle + 1,
                    found,
                });
            }
            residuals.push(residual);
        }
        let settled: Vec<&[f64]> = residuals.iter().map(|r| &r.as_slice()[settle..]).collect();
        let calibration = calibrate(&settled, generator.sample_time_s(), rule)?;
        Ok(Self::new(generator, &calibration))
    }

    /// The output's tag.
    pub fn name(&self) -> &str {
        &self.generator.output().name
    }
}

/// One detector an output, all at one sample time.
///
/// Construction and deserialisation both check the format's version, the sample times, the
/// thresholds, and that no output has two detectors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Bank {
    /// The version of the file format, [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// The bank's name.
    pub name: String,
    sample_time_s: f64,
    detectors: Vec<OutputDetector>,
}

/// The fields of a [`Bank`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    schema_version: u32,
    name: String,
    sample_time_s: f64,
    detectors: Vec<OutputDetector>,
}

impl TryFrom<Unchecked> for Bank {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        if raw.schema_version != SCHEMA_VERSION {
            let found = raw.schema_version;
            return Err(FdiError::SchemaVersion {
                expected: SCHEMA_VERSION,
                found,
            });
        }
        let bank = Self::new(raw.name, raw.detectors)?;
        check_sample_time("the bank", bank.sample_time_s, raw.sample_time_s)?;
        Ok(bank)
    }
}

impl Bank {
    /// A checked bank; its sample time is that of its detectors.
    ///
    /// # Errors
    /// [`FdiError`] when there is no detector, sample times differ, an output has two detectors or
    /// a threshold is out of range.
    pub fn new(name: impl Into<String>, detectors: Vec<OutputDetector>) -> Result<Self, FdiError> {
        let name = name.into();
        let Some(first) = detectors.first() else {
            return Err(FdiError::EmptyBank { name });
        };
        let sample_time_s = first.generator.sample_time_s();
        for detector in &detectors {
            let what = format!("the generator of `{}`", detector.name());
            check_sample_time(&what, sample_time_s, detector.generator.sample_time_s())?;
            detector.threshold.validate()?;
        }
        let tags: Vec<&String> = detectors
            .iter()
            .map(|detector| &detector.generator.output().name)
            .collect();
        check_unique("outputs of the bank", &tags)?;
        Ok(Self {
            schema_version: SCHEMA_VERSION,
            name,
            sample_time_s,
            detectors,
        })
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// The detectors, one an output.
    pub fn detectors(&self) -> &[OutputDetector] {
        &self.detectors
    }

    /// Tags of all inputs that a generator reads, each once, in the order of first appearance.
    pub fn inputs(&self) -> Vec<String> {
        let mut tags: Vec<String> = Vec::new();
        for signal in self
            .detectors
            .iter()
            .flat_map(|detector| detector.generator.inputs())
        {
            if !tags.contains(&signal.name) {
                tags.push(signal.name.clone());
            }
        }
        tags
    }

    /// Tags of the outputs, in the order of the detectors.
    pub fn outputs(&self) -> Vec<String> {
        self.detectors
            .iter()
            .map(|detector| detector.name().to_owned())
            .collect()
    }

    /// Runs the bank over a record that has its channels, by name, in any order and among others:
    /// the online [`Detector`], sample by sample.
    ///
    /// # Errors
    /// [`FdiError::MissingTags`] and [`FdiError::SampleTime`] when the record does not fit.
    pub fn run(&self, data: &Dataset) -> Result<BankRun, FdiError> {
        let (inputs, outputs) = (self.inputs(), self.outputs());
        let mut channels = Channels::of(data, self.sample_time_s, &inputs, &outputs)?;
        let mut detector = Detector::new(self);
        let mut log = AlarmLog::new(self);
        let mut residuals = DMatrix::zeros(outputs.len(), data.len());
        let mut time_s = Vec::with_capacity(data.len());
        for (sample, mut column) in residuals.column_iter_mut().enumerate() {
            let (u, y) = channels.at(sample);
            let verdict = detector.step(data.time_s(sample), u, y)?;
            time_s.push(verdict.time_s);
            for (index, channel) in verdict.channels.iter().enumerate() {
                column[index] = channel.residual;
                log.take(verdict.time_s, index, channel);
            }
        }
        let share_above_limit = log.shares();
        let judged = log.counts.iter().map(|&(judged, _)| judged).collect();
        Ok(BankRun {
            time_s,
            outputs,
            residuals,
            alarms: log.alarms,
            judged,
            share_above_limit,
        })
    }
}

impl Detector {
    /// The online detector of a bank, with every generator in its initial state.
    pub fn new(bank: &Bank) -> Self {
        let inputs = bank.inputs();
        let channels = bank.detectors.iter().map(|detector| {
            let generator = &detector.generator;
            let own = generator.inputs().iter();
            let places = own
                .filter_map(|signal| inputs.iter().position(|tag| *tag == signal.name))
                .collect();
            let threshold = &detector.threshold;
            Channel::new(
                generator.runtime(places),
                threshold.limit,
                threshold.consecutive,
                generator.settle_samples(),
            )
        });
        let channels = channels.collect();
        Self::from_parts(inputs, bank.outputs(), bank.sample_time_s, channels)
    }
}

/// An alarm event.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alarm {
    /// Time at which the alarm came up, in seconds.
    pub time_s: f64,
    /// Time of the first sample above the limit, in seconds: the onset estimate.
    pub first_exceedance_s: f64,
    /// The output's tag.
    pub tag: String,
    /// The residual when the alarm came up, with its sign, in the output's unit.
    pub residual: f64,
    /// The limit that `|residual|` exceeds.
    pub threshold: f64,
    /// Time of the first sample no longer above the limit (or without a residual), in seconds;
    /// `None` when the record ends before.
    pub end_s: Option<f64>,
}

/// What a bank says of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct BankRun {
    /// Times of the samples in seconds (N).
    pub time_s: Vec<f64>,
    /// Tags of the outputs, the rows of `residuals`.
    pub outputs: Vec<String>,
    /// Residuals (one row a detector, N columns), settling included; NaN where a sample is missing.
    pub residuals: DMatrix<f64>,
    /// Alarm events in order of time.
    pub alarms: Vec<Alarm>,
    /// For each detector the samples that were judged: settled, with a residual.
    pub judged: Vec<usize>,
    /// For each detector the share of its judged samples (settled, with a residual) above the
    /// limit; NaN when none was judged.
    pub share_above_limit: Vec<f64>,
}

/// Collects alarm events and counts exceedances while a bank runs.
struct AlarmLog<'a> {
    detectors: &'a [OutputDetector],
    alarms: Vec<Alarm>,
    /// For each detector the position of its open alarm.
    open: Vec<Option<usize>>,
    /// For each detector the judged samples and those above the limit.
    counts: Vec<(usize, usize)>,
}

impl<'a> AlarmLog<'a> {
    fn new(bank: &'a Bank) -> Self {
        let size = bank.detectors.len();
        let (open, counts) = (vec![None; size], vec![(0, 0); size]);
        Self {
            detectors: &bank.detectors,
            alarms: Vec::new(),
            open,
            counts,
        }
    }

    fn take(&mut self, time_s: f64, index: usize, channel: &ChannelVerdict) {
        if !channel.settling && channel.residual.is_finite() {
            self.counts[index].0 += 1;
            self.counts[index].1 += usize::from(channel.exceeds);
        }
        if channel.new_alarm {
            self.open[index] = Some(self.alarms.len());
            self.alarms.push(Alarm {
                time_s,
                first_exceedance_s: channel.first_exceedance_s.unwrap_or(time_s),
                tag: self.detectors[index].name().to_owned(),
                residual: channel.residual,
                threshold: self.detectors[index].threshold.limit,
                end_s: None,
            });
        } else if !channel.alarm
            && let Some(open) = self.open[index].take()
        {
            self.alarms[open].end_s = Some(time_s);
        }
    }

    fn shares(&self) -> Vec<f64> {
        self.counts
            .iter()
            .map(|&(judged, above)| above as f64 / judged as f64)
            .collect()
    }
}
