//! What the API says of machines.

use serde::Serialize;

use crate::hub::Cell;
use crate::pipeline::{Alarm, Band, Machine, MachineState, Quality};

/// A number that JSON has, or null.
fn shown(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The detector of a machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DetectorView {
    name: String,
    kind: &'static str,
    sha256: String,
}

/// A signal with its last value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SignalView {
    tag: String,
    unit: String,
    quality: Quality,
    value: Option<f64>,
}

/// A statistic with its limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StatisticView {
    name: String,
    value: Option<f64>,
    limit: f64,
}

/// A machine at a glance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MachineView {
    name: String,
    state: MachineState,
    reason: Option<String>,
    detector: Option<DetectorView>,
    last_time_ms: Option<i64>,
    inputs: Vec<SignalView>,
    outputs: Vec<SignalView>,
    statistics: Vec<StatisticView>,
    worst_ratio: Option<f64>,
    open_alarms: usize,
    samples: u64,
    missing_samples: u64,
}

impl MachineView {
    /// Of a machine, which is locked.
    pub fn of(cell: &Cell, machine: &Machine, now_ns: i64) -> Self {
        let watch = machine.watch();
        let state = machine.state(now_ns);
        let last = machine.last();
        let reason = match state {
            MachineState::NoData => Some("no reading has come yet".to_owned()),
            MachineState::Stale => Some(silent(machine)),
            MachineState::Settling => Some(settling(machine)),
            _ => None,
        };
        let signal = |(place, signal): (usize, &gtfdi::core::Signal)| {
            let value = last.and_then(|sample| sample.values.get(place));
            let quality = last.and_then(|sample| sample.qualities.get(place));
            SignalView {
                tag: signal.name.clone(),
                unit: signal.unit.clone(),
                quality: quality.copied().unwrap_or(Quality::Stale),
                value: value.copied().and_then(shown),
            }
        };
        let inputs = watch.inputs().iter().enumerate().map(signal);
        let first = watch.inputs().len();
        let outputs = watch.outputs().iter().enumerate();
        let outputs = outputs.map(|(place, own)| signal((first + place, own)));
        let limits = watch.limits().iter().zip(watch.statistics());
        let ratios = limits.clone().map(|(limit, value)| value / limit);
        let worst = ratios.filter(|ratio| ratio.is_finite()).reduce(f64::max);
        let statistics = watch.statistic_names().iter().zip(limits);
        Self {
            name: machine.name().to_owned(),
            state,
            reason,
            detector: Some(DetectorView {
                name: watch.name().to_owned(),
                kind: watch.kind(),
                sha256: cell.sha256(),
            }),
            last_time_ms: last.map(|sample| sample.time_ns / 1_000_000),
            inputs: inputs.collect(),
            outputs: outputs.collect(),
            statistics: statistics
                .map(|(name, (limit, value))| StatisticView {
                    name: name.clone(),
                    value: shown(*value),
                    limit: *limit,
                })
                .collect(),
            worst_ratio: worst,
            open_alarms: machine.alarms().open().count(),
            samples: machine.counts().samples,
            missing_samples: machine.counts().missing,
        }
    }
}

/// What does not come.
fn silent(machine: &Machine) -> String {
    let frozen: Vec<&str> = machine.frozen_tags().collect();
    let stale = machine.stale_tags();
    let silent: Vec<&str> = stale.filter(|tag| !frozen.contains(tag)).collect();
    let stands = format!("the same value of {} for too long", frozen.join(", "));
    let none = format!("no good value of {} for too long", silent.join(", "));
    match (frozen.is_empty(), silent.is_empty()) {
        (true, false) if silent.len() < machine.tags().count() => none,
        (true, _) => "nothing comes from its source".to_owned(),
        (false, true) => stands,
        (false, false) => format!("{none}; {stands}"),
    }
}

/// Why a machine is not judged.
fn settling(machine: &Machine) -> String {
    let unusable = machine.last().map(|sample| {
        let qualities = sample.qualities.iter().zip(machine.tags());
        let tags = qualities.filter(|(quality, _)| !quality.is_usable());
        tags.map(|(_, tag)| tag).collect::<Vec<_>>()
    });
    match unusable {
        Some(tags) if !tags.is_empty() => format!("no usable value of {}", tags.join(", ")),
        _ => "the detector settles after a start or a gap".to_owned(),
    }
}

/// A series of the trend.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SeriesView {
    kind: &'static str,
    tag: String,
    unit: String,
    limit: Option<f64>,
    min: Vec<Option<f64>>,
    max: Vec<Option<f64>>,
}

/// The recent past of a machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrendView {
    machine: String,
    bucket_ms: i64,
    times_ms: Vec<i64>,
    series: Vec<SeriesView>,
}

impl TrendView {
    /// The last `seconds` of a machine in at most `points`.
    pub fn of(machine: &Machine, seconds: f64, points: usize) -> Self {
        let watch = machine.watch();
        let (bucket_ms, times_ms, bands) = machine.trend().last(seconds, points);
        let signals = |kind, of: &[gtfdi::core::Signal]| {
            let signals = of.iter();
            signals
                .map(|signal| (kind, signal.name.clone(), signal.unit.clone(), None))
                .collect::<Vec<_>>()
        };
        let mut heads = signals("input", watch.inputs());
        heads.extend(signals("output", watch.outputs()));
        heads.extend(signals("residual", watch.outputs()));
        let statistics = watch.statistic_names().iter().zip(watch.limits());
        heads.extend(
            statistics
                .map(|(name, limit)| ("statistic", name.clone(), String::new(), Some(*limit))),
        );
        let ends =
            |bands: &[Band], end: usize| bands.iter().map(|band| Some((*band)?[end])).collect();
        let series = heads.into_iter().zip(&bands);
        Self {
            machine: machine.name().to_owned(),
            bucket_ms,
            times_ms,
            series: series
                .map(|((kind, tag, unit, limit), bands)| SeriesView {
                    kind,
                    tag,
                    unit,
                    limit,
                    min: ends(bands, 0),
                    max: ends(bands, 1),
                })
                .collect(),
        }
    }
}

/// A list of alarms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlarmsView {
    /// The alarms.
    pub alarms: Vec<Alarm>,
}
