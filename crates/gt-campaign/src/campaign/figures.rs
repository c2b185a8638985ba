//! The charts of a campaign.

use super::fault_summary::FaultSummary;
use super::summary::Summary;
use crate::report::chart::{Chart, Series};

/// Points of a distribution's curve.
const POINTS: u32 = 200;

/// A chart with what it shows.
pub(super) struct Figure {
    pub chart: Chart,
    pub caption: String,
}

/// All charts.
pub(super) fn figures(summary: &Summary) -> Vec<Figure> {
    let faults = summary.faults.iter().filter(|fault| fault.detected.of > 0);
    let mut figures: Vec<Figure> = faults.filter_map(detection).collect();
    figures.extend(delays(summary));
    figures.extend(roc(summary));
    figures
}

fn name(fault: &FaultSummary) -> String {
    format!("case {} ({})", fault.case, fault.waveform)
}

fn series(label: &str, values: Vec<f64>, dashed: bool) -> Series {
    Series {
        label: label.to_owned(),
        values,
        dashed,
    }
}

/// Detection probability against size.
fn detection(fault: &FaultSummary) -> Option<Figure> {
    let bins: Vec<_> = fault
        .sizes
        .iter()
        .filter(|bin| bin.detected.of > 0)
        .collect();
    if bins.len() < 2 {
        return None;
    }
    let of = |value: fn(&super::interval::Proportion) -> f64| -> Vec<f64> {
        bins.iter().map(|bin| value(&bin.detected)).collect()
    };
    Some(Figure {
        caption: format!(
            "{}: share of runs that are detected, with its 95 % interval, over the size at the \
             middle of each range.",
            fault.fault
        ),
        chart: Chart {
            id: format!("detection_{}_{}", fault.case, fault.waveform),
            title: format!("Detection of {}", name(fault)),
            x_label: format!("size [{}]", fault.unit),
            y_label: "share detected".to_owned(),
            x: bins.iter().map(|bin| bin.middle).collect(),
            series: vec![
                series(
                    "detected",
                    of(|found| found.share.unwrap_or(f64::NAN)),
                    false,
                ),
                series("low", of(|found| found.low), true),
                series("high", of(|found| found.high), true),
            ],
            limits: Vec::new(),
            marks: Vec::new(),
        },
    })
}

/// How many runs are detected by which time after the onset.
fn delays(summary: &Summary) -> Option<Figure> {
    let last = summary
        .faults
        .iter()
        .filter_map(|fault| fault.delays.last());
    let longest_s = last.fold(0.0, |longest: f64, last| longest.max(*last));
    if longest_s <= 0.0 {
        return None;
    }
    let x: Vec<f64> = (0..=POINTS)
        .map(|point| longest_s * f64::from(point) / f64::from(POINTS))
        .collect();
    let curves = summary.faults.iter().filter(|fault| fault.detected.of > 0);
    let curves = curves.map(|fault| {
        let share = |time_s: &f64| {
            let by = fault.delays.partition_point(|delay| delay <= time_s);
            by as f64 / fault.detected.of as f64
        };
        series(&name(fault), x.iter().map(share).collect(), false)
    });
    Some(Figure {
        caption: "Share of all runs of a fault that are detected by a time after the onset."
            .to_owned(),
        chart: Chart {
            id: "delays".to_owned(),
            title: "Delay of detection".to_owned(),
            x_label: "time after the onset [s]".to_owned(),
            y_label: "share detected".to_owned(),
            series: curves.collect(),
            x,
            limits: Vec::new(),
            marks: Vec::new(),
        },
    })
}

/// Detections against false alarms.
fn roc(summary: &Summary) -> Option<Figure> {
    // Higher limits first, so that the false alarms grow; of equal shares the best is the curve.
    let mut points: Vec<_> = summary.roc.iter().rev().collect();
    points.dedup_by(|next, kept| {
        let same = next.false_alarm.count == kept.false_alarm.count;
        if same {
            *kept = *next;
        }
        same
    });
    let x: Vec<f64> = points
        .iter()
        .filter_map(|point| point.false_alarm.share)
        .collect();
    if x.len() < 2 {
        return None;
    }
    let faults = summary
        .faults
        .iter()
        .enumerate()
        .filter(|(_, fault)| fault.detected.of > 0);
    let curves = faults.map(|(place, fault)| {
        let shares = points.iter().map(|point| {
            let found = point.detected_by_fault.get(place);
            found.and_then(|found| found.share).unwrap_or(f64::NAN)
        });
        series(&name(fault), shares.collect(), false)
    });
    Some(Figure {
        caption: "All limits multiplied by one factor: share of the faulty runs with a detection \
                  against share of all runs with a false alarm before the onset."
            .to_owned(),
        chart: Chart {
            id: "roc".to_owned(),
            title: "Detections against false alarms".to_owned(),
            x_label: "share of runs with a false alarm".to_owned(),
            y_label: "share detected".to_owned(),
            series: curves.collect(),
            x,
            limits: Vec::new(),
            marks: Vec::new(),
        },
    })
}
