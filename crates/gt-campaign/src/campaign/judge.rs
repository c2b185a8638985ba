//! What a bank or an isolator says of a record whose fault is known.

use gt_log::DetectorFile;
use gtfdi::core::Dataset;
use gtfdi::fdi::{Bank, BankRun, FdiError, Isolator, ResidualTest};

use super::naming::{ISOLATOR_STATISTIC, Naming};
use crate::isolation::FaultVerdict;

/// Judges records with a bank or an isolator. All that a campaign says of a record begins here.
#[derive(Debug, Clone)]
pub struct Judge {
    detector: DetectorFile,
    /// Of each test of a bank: its tag (of the output, or `joint`), its statistic, its limit.
    tests: Vec<TestLabel>,
    /// How long after the onset an alarm counts, in seconds.
    horizon_s: f64,
}

#[derive(Debug, Clone)]
struct TestLabel {
    name: String,
    tag: String,
    statistic: &'static str,
    limit: f64,
}

/// The first alarm at or after the onset.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstAlarm {
    /// When it came up, in seconds of the record.
    pub time_s: f64,
    /// How long after the onset, in seconds.
    pub delay_s: f64,
    /// The output whose residual it is about; `joint` of several; of an isolator the fault whose
    /// statistic was furthest above its limit.
    pub tag: String,
    /// The statistic that raised it.
    pub statistic: String,
}

/// What was found in a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// How long a test judged before the onset, in seconds.
    pub healthy_s: f64,
    /// Alarms that came up before the onset.
    pub false_alarms: u64,
    /// The largest ratio of a statistic to its limit before the onset; `None` where nothing was
    /// judged. With a sample above the limit enough for an alarm, a limit `c` times as high would
    /// have raised a false one where this is above `c`. Accumulated statistics stop at twice
    /// their limit, so that ratios above 2 say no more than that.
    pub peak_before: Option<f64>,
    /// The same from the onset to the horizon; `None` in a healthy record.
    pub peak_after: Option<f64>,
    /// The first alarm at or after the onset, however late.
    pub alarm: Option<FirstAlarm>,
    /// Whether that came within the horizon; `None` in a healthy record.
    pub detected: Option<bool>,
    /// What the fault was called; `None` of a bank, which gives no names, and in a healthy record.
    pub naming: Option<Naming>,
}

impl Judge {
    /// A judge with a bank or an isolator; alarms count that come within `horizon_s` after the onset.
    pub fn new(detector: DetectorFile, horizon_s: f64) -> Self {
        let tests = match &detector {
            DetectorFile::Bank(bank) => bank.tests().iter().map(TestLabel::of).collect(),
            DetectorFile::Isolator(_) => Vec::new(),
        };
        Self {
            detector,
            tests,
            horizon_s,
        }
    }

    /// What it judges with.
    pub fn detector(&self) -> &DetectorFile {
        &self.detector
    }

    /// Judges a record with a fault of a name and its onset in seconds; `None` where it is healthy.
    ///
    /// # Errors
    /// As [`Bank::run`] and [`Isolator::run`].
    pub fn judge(
        &self,
        record: &Dataset,
        fault: Option<(&str, f64)>,
    ) -> Result<Judgement, FdiError> {
        match &self.detector {
            DetectorFile::Bank(bank) => self.judge_bank(bank, record, fault),
            DetectorFile::Isolator(isolator) => self.judge_isolator(isolator, record, fault),
        }
    }

    fn judge_bank(
        &self,
        bank: &Bank,
        record: &Dataset,
        fault: Option<(&str, f64)>,
    ) -> Result<Judgement, FdiError> {
        let run = bank.run(record)?;
        let onset = fault.map_or(f64::INFINITY, |(_, onset_s)| onset_s);
        let first = run.alarms.iter().find(|alarm| alarm.time_s >= onset);
        let alarm = first.map(|alarm| {
            let label = self.tests.iter().find(|test| test.name == alarm.tag);
            FirstAlarm {
                time_s: alarm.time_s,
                delay_s: alarm.time_s - onset,
                tag: label.map_or_else(|| alarm.tag.clone(), |test| test.tag.clone()),
                statistic: label.map_or("", |test| test.statistic).to_owned(),
            }
        });
        let before = run.alarms.iter().filter(|alarm| alarm.time_s < onset);
        let judged = Judged {
            ratios: self.ratios(&run),
            sample_time_s: bank.sample_time_s(),
            false_alarms: before.count() as u64,
            alarm,
            naming: None,
        };
        Ok(judged.by(fault.map(|(_, onset_s)| onset_s), self.horizon_s))
    }

    fn judge_isolator(
        &self,
        isolator: &Isolator,
        record: &Dataset,
        fault: Option<(&str, f64)>,
    ) -> Result<Judgement, FdiError> {
        let mut ratios = Vec::with_capacity(record.len());
        let run = isolator.run_with(record, |verdict| {
            if !verdict.settling {
                ratios.push((verdict.time_s, verdict.worst_ratio(isolator.limits())));
            }
        })?;
        let names = isolator.statistic_names();
        let hypotheses = &names[..isolator.hypotheses().len()];
        let place = fault.and_then(|(name, _)| hypotheses.iter().position(|own| *own == name));
        let onset = fault.map_or(f64::INFINITY, |(_, onset_s)| onset_s);
        let sample_time_s = isolator.sample_time_s();
        let verdict = FaultVerdict::of(&run, place, onset, sample_time_s);
        let alarm = verdict.alarm.map(|(time_s, leading)| FirstAlarm {
            time_s,
            delay_s: time_s - onset,
            tag: names.get(leading).copied().unwrap_or_default().to_owned(),
            statistic: ISOLATOR_STATISTIC.to_owned(),
        });
        let judged = Judged {
            ratios,
            sample_time_s,
            false_alarms: verdict.false_alarms,
            alarm,
            naming: fault.map(|_| Naming::of(&verdict, place, &names)),
        };
        Ok(judged.by(fault.map(|(_, onset_s)| onset_s), self.horizon_s))
    }

    /// The judged samples: time, and the largest ratio of a statistic to its limit.
    fn ratios(&self, run: &BankRun) -> Vec<(f64, f64)> {
        let samples = run.time_s.iter().zip(run.statistics.column_iter());
        let largest = samples.filter_map(|(&time_s, statistics)| {
            let ratios = statistics.iter().zip(&self.tests);
            let ratios = ratios.map(|(statistic, test)| statistic / test.limit);
            let largest = ratios.filter(|ratio| ratio.is_finite()).reduce(f64::max);
            largest.map(|ratio| (time_s, ratio))
        });
        largest.collect()
    }
}

/// What a bank and an isolator have in common.
struct Judged {
    /// The judged samples: time, and the largest ratio of a statistic to its limit.
    ratios: Vec<(f64, f64)>,
    sample_time_s: f64,
    false_alarms: u64,
    alarm: Option<FirstAlarm>,
    naming: Option<Naming>,
}

impl Judged {
    /// The judgement, with what lies before and after the onset told apart.
    fn by(self, onset_s: Option<f64>, horizon_s: f64) -> Judgement {
        let onset = onset_s.unwrap_or(f64::INFINITY);
        let end = onset + horizon_s;
        let ratios = self.ratios.iter();
        let healthy = ratios.clone().filter(|(time_s, _)| *time_s < onset);
        let after = ratios.filter(|(time_s, _)| (onset..=end).contains(time_s));
        let alarm = self.alarm.as_ref();
        Judgement {
            healthy_s: healthy.clone().count() as f64 * self.sample_time_s,
            false_alarms: self.false_alarms,
            peak_before: healthy.map(|(_, ratio)| *ratio).reduce(f64::max),
            peak_after: after.map(|(_, ratio)| *ratio).reduce(f64::max),
            detected: onset_s.map(|_| alarm.is_some_and(|alarm| alarm.time_s <= end)),
            alarm: self.alarm,
            naming: self.naming,
        }
    }
}

impl TestLabel {
    fn of(test: &ResidualTest) -> Self {
        Self {
            name: test.name.clone(),
            tag: match &test.outputs[..] {
                [tag] => tag.clone(),
                _ => crate::bank_design::JOINT_TEST.to_owned(),
            },
            statistic: statistic_name(&test.evaluation.statistic),
            limit: test.threshold.limit,
        }
    }
}

/// The name of a statistic, as in a campaign's file.
fn statistic_name(kind: &gtfdi::fdi::StatisticKind) -> &'static str {
    use crate::statistic_choice::StatisticName as Name;
    use gtfdi::fdi::StatisticKind as Kind;
    let name = match kind {
        Kind::Modulus => Name::Threshold,
        Kind::Cusum { .. } => Name::Cusum,
        Kind::Glr { .. } => Name::Glr,
        Kind::MovingAverage { .. } => Name::MovingAverage,
        Kind::ChiSquare { .. } => Name::Chi2,
        Kind::ShiryaevRoberts { .. } => Name::ShiryaevRoberts,
        Kind::Variance { .. } => Name::Variance,
        Kind::Whiteness { .. } => Name::Whiteness,
    };
    name.text()
}
