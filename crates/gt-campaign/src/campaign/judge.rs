//! What a bank says of a record whose onset is known.

use gtfdi::core::Dataset;
use gtfdi::fdi::{Bank, BankRun, FdiError};

/// Judges records with a bank. All that a campaign says of a record begins here.
#[derive(Debug, Clone)]
pub struct Judge {
    bank: Bank,
    /// Of each test: its tag (of the output, or `joint`), its statistic, its limit.
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
    /// The output whose residual it is about; `joint` of several.
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
}

impl Judge {
    /// A judge with a bank; alarms count that come within `horizon_s` after the onset.
    pub fn new(bank: Bank, horizon_s: f64) -> Self {
        let tests = bank.tests().iter().map(|test| TestLabel {
            name: test.name.clone(),
            tag: match &test.outputs[..] {
                [tag] => tag.clone(),
                _ => crate::bank_design::JOINT_TEST.to_owned(),
            },
            statistic: statistic_name(&test.evaluation.statistic),
            limit: test.threshold.limit,
        });
        Self {
            tests: tests.collect(),
            bank,
            horizon_s,
        }
    }

    /// The bank.
    pub fn bank(&self) -> &Bank {
        &self.bank
    }

    /// Judges a record; `onset_s` is `None` where it is healthy.
    ///
    /// # Errors
    /// As [`Bank::run`].
    pub fn judge(&self, record: &Dataset, onset_s: Option<f64>) -> Result<Judgement, FdiError> {
        let run = self.bank.run(record)?;
        let onset = onset_s.unwrap_or(f64::INFINITY);
        let end = onset + self.horizon_s;
        let ratios = self.ratios(&run);
        let healthy = ratios.iter().filter(|(time_s, _)| *time_s < onset);
        let after = ratios
            .iter()
            .filter(|(time_s, _)| (onset..=end).contains(time_s));
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
        Ok(Judgement {
            healthy_s: healthy.clone().count() as f64 * self.bank.sample_time_s(),
            false_alarms: run
                .alarms
                .iter()
                .filter(|alarm| alarm.time_s < onset)
                .count() as u64,
            peak_before: healthy.map(|(_, ratio)| *ratio).reduce(f64::max),
            peak_after: after.map(|(_, ratio)| *ratio).reduce(f64::max),
            detected: onset_s.map(|_| alarm.as_ref().is_some_and(|alarm| alarm.time_s <= end)),
            alarm,
        })
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
