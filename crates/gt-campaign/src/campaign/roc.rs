//! Detections against false alarms.

use serde::Serialize;

use super::fault_summary::{FaultSummary, is_of, size_limit};
use super::interval::Proportion;
use super::row::Row;
use super::size_limit::SizeLimit;

/// Seconds of an hour.
const HOUR_S: f64 = 3600.0;
/// Limits of the ROC, as multiples of those of the bank in steps of a twentieth: from what alarms all
/// the time to where accumulated statistics stop.
const ROC_TWENTIETHS: std::ops::RangeInclusive<u32> = 4..=39;

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
    /// The same for each fault, in the order of [`super::Summary::faults`].
    pub detected_by_fault: Vec<Proportion>,
    /// Of each fault the size detected with probability .95 by the horizon.
    pub size_limit_by_fault: Vec<SizeLimit>,
}

/// The points of all factors, from low limits to high ones.
pub(super) fn roc(whole: &[&Row], faults: &[FaultSummary]) -> Vec<RocPoint> {
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
            size_limit_by_fault: faults
                .iter()
                .map(|fault| {
                    let own = faulty
                        .clone()
                        .filter(|row| is_of(row, &fault.fault, &fault.waveform));
                    let own: Vec<&Row> = own.copied().collect();
                    size_limit(&own, |row| above(row.peak_after))
                })
                .collect(),
        }
    });
    points.collect()
}
