//! What the rows of a campaign say.

use std::collections::BTreeMap;

use gtfdi::fdi::FalseAlarmRate;
use serde::Serialize;

use super::bank_choice::BankChoice;
use super::fault_plan::{FaultPlan, SizeRange};
use super::interval::{Proportion, Quantile};
use super::row::{Row, Status};
use super::spec::Spec;

/// Version of the JSON object; it rises when a key changes its meaning.
const SCHEMA_VERSION: u32 = 1;
/// Seconds of an hour.
const HOUR_S: f64 = 3600.0;
/// Ranges of size of a fault.
const BINS: u32 = 8;
/// Shares of the delays that are told.
const QUANTILES: [f64; 4] = [0.1, 0.5, 0.9, 0.95];
/// Limits of the ROC, as multiples of those of the bank in steps of a twentieth: from what alarms all
/// the time to where accumulated statistics stop.
const ROC_TWENTIETHS: std::ops::RangeInclusive<u32> = 4..=39;

/// How the numbers are computed, for whoever reads them.
const DEFINITION: &str = "\
A run is detected when an alarm comes up at or after the onset and within the horizon; its delay is \
from the onset to that alarm. Delay quantiles are over all runs of the fault, undetected ones \
counting as later than any other, with intervals by order statistics. Alarms before the onset are \
false; their time is that in which a test judged before the onset. Proportions have Wilson's 95 % \
interval, rates the exact one of Poisson counts. ROC: all limits multiplied by one factor; a run has a \
false alarm where a statistic was above before the onset, and a detection where one was from the onset \
to the horizon. Failed runs are in none of these numbers.";

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

/// How a fault is detected.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultSummary {
    /// The paper's number.
    pub case: u64,
    /// Its name.
    pub fault: String,
    /// How it goes with time.
    pub waveform: String,
    /// The unit of its size.
    pub unit: String,
    /// Detected runs of all whole ones.
    pub detected: Proportion,
    /// The same by ranges of size.
    pub sizes: Vec<SizeBin>,
    /// Quantiles of the delay in seconds.
    pub delay_s: Vec<Quantile>,
    /// Delays of the detected runs in seconds, in order.
    #[serde(skip)]
    pub delays: Vec<f64>,
    /// Which test alarmed first, most often first.
    pub first_alarms: Vec<FirstAlarmCount>,
}

/// Detection of sizes in a range.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SizeBin {
    /// Smallest size.
    pub from: f64,
    /// Largest size.
    pub to: f64,
    /// The size in the middle of the range, as the sizes are drawn.
    pub middle: f64,
    /// Detected runs.
    pub detected: Proportion,
}

/// How often a test alarmed first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FirstAlarmCount {
    /// The output that it watches, or `joint`.
    pub tag: String,
    /// Its statistic.
    pub statistic: String,
    /// The number of runs.
    pub runs: u64,
}

/// Detections and false alarms with all limits multiplied by one factor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RocPoint {
    /// The factor.
    pub factor: f64,
    /// Runs with a false alarm before the onset.
    pub false_alarm: Proportion,
    /// The rate of false alarms an hour that gives that share; `None` where every run has one.
    pub false_alarms_per_hour: Option<f64>,
    /// Faulty runs with an alarm from the onset to the horizon.
    pub detected: Proportion,
    /// The same for each fault, in the order of [`Summary::faults`].
    pub detected_by_fault: Vec<Proportion>,
}

/// Which fault was named in the place of which; without names as long as no bank names faults.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Confusion {
    /// The faults that were there.
    pub faults: Vec<String>,
    /// The names that were given.
    pub names: Vec<String>,
    /// Runs: a row a fault, a column a name.
    pub runs: Vec<Vec<u64>>,
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
            arl0_h: match &spec.bank {
                BankChoice::Tests(family) => Some(family.arl0_h),
                BankChoice::File(_) => None,
            },
            horizon_s: spec.record.horizon_s,
            definition: DEFINITION.to_owned(),
            failures: failures(rows),
            false_alarms: false_alarms(&whole),
            roc: roc(&whole, &faults),
            confusion: Confusion {
                faults: faults.iter().map(|fault| fault.fault.clone()).collect(),
                names: Vec::new(),
                runs: vec![Vec::new(); faults.len()],
            },
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

/// The plans whose runs are told apart in the rows: by case and waveform.
fn kinds(spec: &Spec) -> Vec<Vec<&FaultPlan>> {
    let mut kinds: Vec<Vec<&FaultPlan>> = Vec::new();
    for plan in &spec.faults {
        let name = |plan: &FaultPlan| (plan.case, plan.shape.name());
        match kinds.iter_mut().find(|kind| name(kind[0]) == name(plan)) {
            Some(kind) => kind.push(plan),
            None => kinds.push(vec![plan]),
        }
    }
    kinds
}

fn fault_summaries(spec: &Spec, whole: &[&Row]) -> Vec<FaultSummary> {
    let kinds = kinds(spec);
    let summaries = kinds.iter().map(|plans| {
        let (case, waveform) = (plans[0].case, plans[0].shape.name());
        let rows: Vec<&Row> = whole
            .iter()
            .filter(|row| is_of(row, case.name(), waveform))
            .copied()
            .collect();
        let detected = |row: &&Row| row.detected == Some(true);
        let found = rows.iter().filter(|row| detected(row));
        let mut delays: Vec<f64> = found.clone().filter_map(|row| row.delay_s).collect();
        delays.sort_by(f64::total_cmp);
        let mut first: BTreeMap<(&str, &str), u64> = BTreeMap::new();
        for row in found {
            if let (Some(tag), Some(statistic)) = (&row.alarm_tag, &row.alarm_statistic) {
                *first.entry((tag, statistic)).or_default() += 1;
            }
        }
        let first = first
            .into_iter()
            .map(|((tag, statistic), runs)| FirstAlarmCount {
                tag: tag.to_owned(),
                statistic: statistic.to_owned(),
                runs,
            });
        let mut first_alarms: Vec<FirstAlarmCount> = first.collect();
        first_alarms.sort_by_key(|count| std::cmp::Reverse(count.runs));
        FaultSummary {
            case: case.number() as u64,
            fault: case.name().to_owned(),
            waveform: waveform.to_owned(),
            unit: case.unit().to_owned(),
            detected: Proportion::of(rows.iter().map(detected)),
            sizes: size_bins(&range_of(plans), &rows),
            delay_s: QUANTILES
                .map(|share| Quantile::new(share, &delays, rows.len()))
                .to_vec(),
            delays,
            first_alarms,
        }
    });
    summaries.collect()
}

fn is_of(row: &Row, fault: &str, waveform: &str) -> bool {
    row.fault.as_deref() == Some(fault) && row.waveform.as_deref() == Some(waveform)
}

/// The range that holds those of all plans, with the spacing of the first.
fn range_of(plans: &[&FaultPlan]) -> SizeRange {
    let ends = plans.iter().map(|plan| plan.size.ends());
    let low = ends
        .clone()
        .map(|[low, _]| low)
        .fold(f64::INFINITY, f64::min);
    let high = ends.map(|[_, high]| high).fold(0.0, f64::max);
    match plans[0].size {
        SizeRange::Uniform(_) => SizeRange::Uniform([low, high]),
        SizeRange::LogUniform(_) => SizeRange::LogUniform([low, high]),
    }
}

fn size_bins(range: &SizeRange, rows: &[&Row]) -> Vec<SizeBin> {
    let [low, high] = range.ends();
    // A single size is one range.
    let bins = if low < high { BINS } else { 1 };
    let edge = |bin: f64| range.at(bin / f64::from(bins));
    let found = (0..bins).map(|bin| {
        let (from, to) = (edge(f64::from(bin)), edge(f64::from(bin) + 1.0));
        let last = bin + 1 == bins;
        let inside = |size: f64| size >= from && (size < to || last);
        let own = rows.iter().filter(|row| row.size.is_some_and(inside));
        SizeBin {
            from,
            to,
            middle: edge(f64::from(bin) + 0.5),
            detected: Proportion::of(own.map(|row| row.detected == Some(true))),
        }
    });
    found.collect()
}

fn roc(whole: &[&Row], faults: &[FaultSummary]) -> Vec<RocPoint> {
    let judged = whole.iter().filter(|row| row.peak_before.is_some());
    let count = judged.clone().count() as f64;
    let mean_h = judged.clone().filter_map(|row| row.healthy_s).sum::<f64>() / HOUR_S / count;
    let points = ROC_TWENTIETHS.map(|twentieths| {
        let factor = f64::from(twentieths) / 20.0;
        let above = |peak: Option<f64>| peak.is_some_and(|peak| peak > factor);
        let faulty = whole.iter().filter(|row| row.case.is_some());
        let false_alarm = Proportion::of(judged.clone().map(|row| above(row.peak_before)));
        let rate = false_alarm.share.map(|share| -(-share).ln_1p() / mean_h);
        RocPoint {
            factor,
            false_alarm,
            false_alarms_per_hour: rate
                .filter(|rate| rate.is_finite())
                .map(|rate| rate.max(0.0)),
            detected: Proportion::of(faulty.clone().map(|row| above(row.peak_after))),
            detected_by_fault: faults
                .iter()
                .map(|fault| {
                    let own = faulty
                        .clone()
                        .filter(|row| is_of(row, &fault.fault, &fault.waveform));
                    Proportion::of(own.map(|row| above(row.peak_after)))
                })
                .collect(),
        }
    });
    points.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
