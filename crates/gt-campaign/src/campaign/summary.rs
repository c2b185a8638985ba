//! What the rows of a campaign say.

use std::collections::BTreeMap;

use gtfdi::fdi::FalseAlarmRate;
use serde::Serialize;

use super::fault_summary::{FaultSummary, fault_summaries};
use super::naming_summary::{Confusion, NamingCounts};
use super::roc::{RocPoint, roc};
use super::row::{Row, Status};
use super::spec::Spec;

/// Version of the JSON object; it rises when a key changes its meaning.
const SCHEMA_VERSION: u32 = 1;
/// Seconds of an hour.
const HOUR_S: f64 = 3600.0;
/// How the numbers are computed, for whoever reads them.
const DEFINITION: &str = "\
A run is detected when an alarm comes up at or after the onset and within the horizon; its delay is \
from the onset to that alarm. Delay quantiles are over all runs of the fault, undetected ones \
counting as later than any other, with intervals by order statistics. Alarms before the onset are \
false; their time is that in which a test judged before the onset. Proportions have Wilson's 95 % \
interval, rates the exact one of Poisson counts. ROC: all limits multiplied by one factor; a run has a \
false alarm where a statistic was above before the onset, and a detection where one was from the onset \
to the horizon; its rate of false alarms is that of a Poisson process with that share of runs. Limits of size: where a logistic curve over the logarithm of the size, fitted to all runs of the fault by \
Firth's penalised likelihood, reaches .95; none where that is outside the sizes drawn. A name is that \
which stood five seconds after the alarm; onset and size are those said at the end of the record under \
the hypothesis of the fault that was there, counted over detected runs. Failed runs are in none of \
these numbers.";

/// What the rows of a campaign say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Version of this object.
    pub schema_version: u32,
    /// The campaign's seed.
    pub seed: u64,
    /// Runs, failed ones included.
    pub runs: u64,
    /// Runs with a whole record.
    pub ok: u64,
    /// Runs that the plant did not bear.
    pub failed: u64,
    /// Whole runs without a fault.
    pub healthy: u64,
    /// The maps of the plant.
    pub map_set: String,
    /// The operating profile.
    pub profile: String,
    /// The noise of the sensors.
    pub noise: String,
    /// The mean time between false alarms that was asked for, in hours; `None` of a bank of a file.
    pub arl0_h: Option<f64>,
    /// How long after the onset an alarm counts, in seconds; `None`: to the end of the record.
    pub horizon_s: Option<f64>,
    /// How the numbers are computed.
    pub definition: String,
    /// Failed runs by their reason.
    pub failures: Vec<FailureCount>,
    /// Alarms before the onset; `None` where nothing was judged there.
    pub false_alarms: Option<FalseAlarmRate>,
    /// Detection of each fault.
    pub faults: Vec<FaultSummary>,
    /// Detections against false alarms over the limit.
    pub roc: Vec<RocPoint>,
    /// How faults were named; `None` where a bank judges, which gives no names.
    pub naming: Option<NamingCounts>,
    /// Which fault was named in the place of which.
    pub confusion: Confusion,
}

/// Failed runs of one reason.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FailureCount {
    /// The fault of these runs; `None` of healthy ones.
    pub fault: Option<String>,
    /// The reason.
    pub reason: String,
    /// Their number.
    pub runs: u64,
}

impl Summary {
    /// The summary of a campaign's rows.
    pub fn new(spec: &Spec, rows: &[Row]) -> Self {
        let whole: Vec<&Row> = rows.iter().filter(|row| row.status == Status::Ok).collect();
        let faults = fault_summaries(spec, &whole);
        Self {
            schema_version: SCHEMA_VERSION,
            seed: spec.seed,
            runs: rows.len() as u64,
            ok: whole.len() as u64,
            failed: (rows.len() - whole.len()) as u64,
            healthy: whole.iter().filter(|row| row.case.is_none()).count() as u64,
            map_set: spec.plant.map_set.to_string(),
            profile: spec.plant.profile.clone(),
            noise: spec.plant.noise.to_string(),
            arl0_h: spec.bank.arl0_h(),
            horizon_s: spec.record.horizon_s,
            definition: DEFINITION.to_owned(),
            failures: failures(rows),
            false_alarms: false_alarms(&whole),
            roc: roc(&whole, &faults),
            naming: NamingCounts::of(whole.iter().copied()),
            confusion: Confusion::of(
                &faults
                    .iter()
                    .map(|fault| fault.fault.as_str())
                    .collect::<Vec<_>>(),
                &whole,
            ),
            faults,
        }
    }
}

fn failures(rows: &[Row]) -> Vec<FailureCount> {
    let mut counts: BTreeMap<(Option<&str>, &str), u64> = BTreeMap::new();
    for row in rows {
        if let Some(reason) = &row.reason {
            *counts.entry((row.fault.as_deref(), reason)).or_default() += 1;
        }
    }
    let counts = counts
        .into_iter()
        .map(|((fault, reason), runs)| FailureCount {
            fault: fault.map(str::to_owned),
            reason: reason.to_owned(),
            runs,
        });
    counts.collect()
}

fn false_alarms(whole: &[&Row]) -> Option<FalseAlarmRate> {
    let hours = whole.iter().filter_map(|row| row.healthy_s).sum::<f64>() / HOUR_S;
    let alarms: u64 = whole.iter().filter_map(|row| row.false_alarms).sum();
    FalseAlarmRate::from_counts(usize::try_from(alarms).ok()?, hours).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::fault_plan::FaultPlan;

    fn spec() -> Spec {
        toml::from_str(
            "seed = 1\nruns = 8\n[record]\nduration_s = 90.0\nonset_s = [36.0, 36.0]\n\
             horizon_s = 30.0\n\
             [[faults]]\ncase = 1\nsize = { uniform = [1.0, 1.0] }\n\
             [[faults]]\ncase = 3\nsize = { uniform = [0.0, 8.0] }",
        )
        .expect("a campaign")
    }

    /// A whole run with 36 s of healthy running.
    fn row(fault: &FaultPlan, size: f64, peaks: [f64; 2], delay_s: Option<f64>) -> Row {
        Row {
            case: Some(fault.case.number() as u64),
            fault: Some(fault.case.name().to_owned()),
            waveform: Some(fault.shape.name().to_owned()),
            size: Some(size),
            status: Status::Ok,
            reason: None,
            healthy_s: Some(36.0),
            false_alarms: Some(u64::from(peaks[0] > 1.0)),
            peak_before: Some(peaks[0]),
            peak_after: Some(peaks[1]),
            detected: Some(delay_s.is_some_and(|delay| delay <= 30.0)),
            delay_s,
            alarm_tag: Some("t3".to_owned()),
            alarm_statistic: Some("cusum".to_owned()),
            ..Row::blank()
        }
    }

    #[test]
    fn what_is_counted_is_what_the_rows_say() {
        let spec = spec();
        let (first, second) = (&spec.faults[0], &spec.faults[1]);
        let failed = Row {
            reason: Some("left".to_owned()),
            fault: Some("turbine_damage".to_owned()),
            ..Row::blank()
        };
        let rows = [
            row(first, 1.0, [0.4, 2.0], Some(2.0)),
            row(first, 1.0, [0.6, 1.6], Some(4.0)),
            row(first, 1.0, [1.2, 0.5], None),
            // Too late: an alarm, and no detection.
            row(first, 1.0, [0.5, 0.9], Some(31.0)),
            row(second, 0.5, [0.1, 0.3], None),
            row(second, 8.0, [0.1, 1.1], Some(10.0)),
            failed.clone(),
            failed,
        ];
        let summary = Summary::new(&spec, &rows);
        assert_eq!((summary.runs, summary.ok, summary.failed), (8, 6, 2));
        assert_eq!(summary.failures.len(), 1);
        assert_eq!(summary.failures[0].runs, 2);
        let rate = summary.false_alarms.expect("a rate");
        // 6 times 36 s.
        assert_eq!((rate.alarms, rate.hours), (1, 0.06));
        let [one, other] = &summary.faults[..] else {
            panic!("two faults");
        };
        assert_eq!((one.detected.count, one.detected.of), (2, 4));
        assert_eq!(one.delays, [2.0, 4.0]);
        let delay = |place: usize| one.delay_s[place].value;
        assert_eq!((delay(0), delay(1), delay(2)), (Some(2.0), Some(4.0), None));
        assert_eq!(one.sizes.len(), 1);
        assert_eq!(one.first_alarms[0].runs, 2);
        let counts: Vec<(u64, u64)> = other
            .sizes
            .iter()
            .map(|bin| (bin.detected.count, bin.detected.of))
            .collect();
        assert_eq!((counts[0], counts[7], counts.len()), ((0, 1), (1, 1), 8));
        assert!(counts[1..7].iter().all(|&(_, of)| of == 0));
        let at = |factor: f64| {
            let mut points = summary.roc.iter();
            points
                .find(|point| (point.factor - factor).abs() < 1e-9)
                .expect("a factor")
        };
        assert_eq!((at(1.0).false_alarm.count, at(1.0).false_alarm.of), (1, 6));
        assert_eq!((at(1.0).detected.count, at(1.0).detected.of), (3, 6));
        assert_eq!(at(0.45).false_alarm.count, 3);
        assert_eq!(at(1.5).detected_by_fault[0].count, 2);
        // One in six has one in 0.01 h.
        let expected = -(5.0_f64 / 6.0).ln() / 0.01;
        let rate = at(1.0).false_alarms_per_hour.expect("a rate");
        assert!((rate - expected).abs() < 1e-9, "{rate}");
    }
}
