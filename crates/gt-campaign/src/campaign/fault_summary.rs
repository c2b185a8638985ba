//! How each fault is detected.

use std::collections::BTreeMap;

use serde::Serialize;

use super::fault_plan::{FaultPlan, SizeRange};
use super::interval::{Proportion, Quantile};
use super::naming_summary::NamingCounts;
use super::row::Row;
use super::size_limit::{DetectionCurve, SizeLimit};
use super::spec::Spec;

/// Ranges of size of a fault.
const BINS: u32 = 8;
/// Shares of the delays that are told.
const QUANTILES: [f64; 4] = [0.1, 0.5, 0.9, 0.95];
/// Probability of detection at a limit of size.
const DETECTION_PROBABILITY: f64 = 0.95;
/// Times after the onset for which limits of size are told, and the shortest as a share of the
/// longest.
const TIMES: u32 = 12;
const SHORTEST_TIME: f64 = 0.05;
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
    /// The size detected with probability .95 within a time after the onset.
    pub size_limits: Vec<SizeLimitInTime>,
    /// How it was named; `None` where a bank judges.
    pub naming: Option<NamingCounts>,
}

/// The size from which a fault is found within a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SizeLimitInTime {
    /// The time after the onset, in seconds.
    pub within_s: f64,
    /// The size detected with probability .95.
    #[serde(flatten)]
    pub limit: SizeLimit,
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

/// Those of all kinds of faults.
pub(super) fn fault_summaries(spec: &Spec, whole: &[&Row]) -> Vec<FaultSummary> {
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
            size_limits: size_limits(spec, &rows),
            naming: NamingCounts::of(rows.iter().copied()),
        }
    });
    summaries.collect()
}

/// Whether a row is of a fault that goes with time so.
pub(super) fn is_of(row: &Row, fault: &str, waveform: &str) -> bool {
    row.fault.as_deref() == Some(fault) && row.waveform.as_deref() == Some(waveform)
}

/// The sizes found with probability [`DETECTION_PROBABILITY`] within times up to the horizon.
fn size_limits(spec: &Spec, rows: &[&Row]) -> Vec<SizeLimitInTime> {
    let left_s = spec.record.duration_s - spec.record.onset_s[1];
    let longest_s = spec.record.horizon_s.unwrap_or(left_s);
    (1..=TIMES)
        .map(|place| {
            let within_s =
                longest_s * SHORTEST_TIME.powf(1.0 - f64::from(place) / f64::from(TIMES));
            let found = |row: &&Row| row.delay_s.is_some_and(|delay_s| delay_s <= within_s);
            SizeLimitInTime {
                within_s,
                limit: size_limit(rows, found),
            }
        })
        .collect()
}

/// The size that `found` holds for with probability [`DETECTION_PROBABILITY`].
pub(super) fn size_limit(rows: &[&Row], found: impl Fn(&&Row) -> bool) -> SizeLimit {
    let runs = rows.iter().filter_map(|row| Some((row.size?, found(row))));
    let curve = DetectionCurve::fit(&runs.collect::<Vec<_>>());
    curve.map_or(
        SizeLimit {
            size: None,
            low: None,
            high: None,
        },
        |curve| curve.limit(DETECTION_PROBABILITY),
    )
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
