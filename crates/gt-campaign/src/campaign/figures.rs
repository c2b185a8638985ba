//! The charts of a campaign.

use super::fault_summary::FaultSummary;
use super::roc::RocPoint;
use super::summary::Summary;
use crate::report::chart::{Chart, Mark, Series};
use crate::report::{Figure, Scale};

/// Points of a distribution's curve.
const POINTS: u32 = 200;

/// All charts.
pub(super) fn figures(summary: &Summary) -> Vec<Figure> {
    let faults = summary.faults.iter().filter(|fault| fault.detected.of > 0);
    let mut figures: Vec<Figure> = faults.filter_map(detection).collect();
    figures.extend(delays(summary));
    figures.extend(limits_in_time(summary));
    figures.extend(roc(summary));
    figures.extend(limits_over_rate(summary));
    figures
}

fn name(fault: &FaultSummary) -> String {
    format!("case {} ({})", fault.case, fault.waveform)
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
                Series::line("detected", of(|found| found.share.unwrap_or(f64::NAN)))
                    .within(of(|found| found.low), of(|found| found.high)),
            ],
            ..Chart::default()
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
        Series::line(name(fault), x.iter().map(share).collect())
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
            ..Chart::default()
        },
    })
}

/// The size that is found, over the time that there is for it.
fn limits_in_time(summary: &Summary) -> Option<Figure> {
    let faults = summary.faults.iter().filter(|fault| fault.detected.of > 0);
    let seen = |fault: &&FaultSummary| fault.size_limits.iter().any(|own| own.limit.size.is_some());
    let faults: Vec<&FaultSummary> = faults.filter(seen).collect();
    let first = faults.first()?;
    let curves = faults.iter().map(|fault| {
        let sizes = fault.size_limits.iter().map(|own| own.limit.size);
        let label = format!("{} [{}]", name(fault), fault.unit);
        let sizes = sizes.map(|size| size.unwrap_or(f64::NAN));
        Series::line(label, sizes.collect())
    });
    Some(Figure {
        caption:
            "The size that is detected with probability .95 within a time after the onset; no \
                  point where it is none of the sizes drawn."
                .to_owned(),
        chart: Chart {
            id: "limits_in_time".to_owned(),
            title: "Detectable size".to_owned(),
            x_label: "time after the onset [s]".to_owned(),
            y_label: "size".to_owned(),
            series: curves.collect(),
            x: first.size_limits.iter().map(|own| own.within_s).collect(),
            x_scale: Scale::Logarithmic,
            y_scale: Scale::Logarithmic,
            ..Chart::default()
        },
    })
}

/// Rates of false alarms from low to high, each with the best point that has it.
fn by_rate(summary: &Summary) -> Vec<(f64, &RocPoint)> {
    // Higher limits first, so that the false alarms grow.
    let points = summary.roc.iter().rev();
    let rates = points.filter_map(|point| Some((point.false_alarms_per_hour?, point)));
    let mut points: Vec<_> = rates.filter(|(rate, _)| *rate > 0.0).collect();
    // Of equal rates the lowest limits, which detect most.
    points.dedup_by(|next, kept| {
        let same = next.1.false_alarm.count == kept.1.false_alarm.count;
        if same {
            *kept = *next;
        }
        same
    });
    points
}

/// What lower and higher limits would give, over the rate of false alarms that they would.
fn over_rate(
    summary: &Summary,
    value: impl Fn(&RocPoint, usize) -> Option<f64>,
    label: impl Fn(&FaultSummary) -> String,
) -> Option<Chart> {
    let points = by_rate(summary);
    if points.len() < 2 {
        return None;
    }
    let faults = summary.faults.iter().enumerate();
    let faults = faults.filter(|(_, fault)| fault.detected.of > 0);
    let curves = faults.filter_map(|(place, fault)| {
        let values = points.iter().map(|(_, point)| value(point, place));
        let values: Vec<f64> = values.map(|own| own.unwrap_or(f64::NAN)).collect();
        let seen = values.iter().any(|own| own.is_finite());
        seen.then(|| Series::line(label(fault), values))
    });
    Some(Chart {
        x_label: "false alarms an hour".to_owned(),
        x: points.iter().map(|(rate, _)| *rate).collect(),
        series: curves.collect(),
        x_scale: Scale::Logarithmic,
        marks: summary
            .arl0_h
            .into_iter()
            .map(|hours| Mark {
                at: 1.0 / hours,
                label: "asked for".to_owned(),
            })
            .filter(|mark| points.first().is_some_and(|(least, _)| mark.at >= *least))
            .collect(),
        ..Chart::default()
    })
    .filter(|chart| !chart.series.is_empty())
}

/// Detections against false alarms, as events.
fn roc(summary: &Summary) -> Option<Figure> {
    let share = |point: &RocPoint, place: usize| point.detected_by_fault.get(place)?.share;
    let chart = over_rate(summary, share, name)?;
    Some(Figure {
        caption:
            "All limits multiplied by one factor: share of the faults that are detected by the \
                  horizon, over the rate of alarms without a fault."
                .to_owned(),
        chart: Chart {
            id: "roc".to_owned(),
            title: "Detections against false alarms".to_owned(),
            y_label: "share detected".to_owned(),
            ..chart
        },
    })
}

/// What another false-alarm rate would cost.
fn limits_over_rate(summary: &Summary) -> Option<Figure> {
    let size = |point: &RocPoint, place: usize| point.size_limit_by_fault.get(place)?.size;
    let label = |fault: &FaultSummary| format!("{} [{}]", name(fault), fault.unit);
    let chart = over_rate(summary, size, label)?;
    Some(Figure {
        caption:
            "All limits multiplied by one factor: the size that is detected with probability .95 \
                  by the horizon, over the rate of alarms without a fault."
                .to_owned(),
        chart: Chart {
            id: "limits_over_rate".to_owned(),
            title: "Detectable size against false alarms".to_owned(),
            y_label: "size".to_owned(),
            y_scale: Scale::Logarithmic,
            ..chart
        },
    })
}
