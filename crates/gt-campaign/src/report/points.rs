//! What the page's script needs of a chart so that its reader can zoom: the numbers behind it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

use super::axis::Scale;
use super::chart::{Chart, Form, Series, Stroke};
use super::draw::Frame;
use super::reduction::extremes;

/// Buckets of a long curve, of which the least and the greatest value are kept.
const BUCKETS: usize = 1500;
/// From so many numbers on they are coded in two bytes each.
const CODED_FROM: usize = 64;
/// The code of what is not finite; the others share the range.
const GAP: u16 = u16::MAX;
/// By how much of their distance values may be off an even grid and still be called even.
const EVEN: f64 = 1e-6;

/// A row of numbers in as few characters as they need.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
enum Numbers {
    /// `count` numbers from `from` on, `step` apart.
    Even { from: f64, step: f64, count: usize },
    /// Base64 of little-endian 16-bit integers: 0 is `low`, 65534 is `high`, 65535 is a gap.
    Coded { low: f64, high: f64, code: String },
    /// As they are; null is a gap.
    Plain(Vec<Option<f64>>),
}

impl Numbers {
    fn of(values: &[f64], scale: Scale) -> Self {
        if let Some(even) = Self::even(values) {
            return even;
        }
        // Along a logarithmic axis a share of the range is too coarse at its low end.
        if values.len() < CODED_FROM || scale == Scale::Logarithmic {
            let finite = |value: &f64| value.is_finite().then_some(*value);
            return Self::Plain(values.iter().map(finite).collect());
        }
        Self::coded(values)
    }

    fn even(values: &[f64]) -> Option<Self> {
        let [from, .., last] = values else {
            return None;
        };
        let step = (last - from) / (values.len() - 1) as f64;
        let off = |(k, value): (usize, &f64)| (value - (from + k as f64 * step)).abs();
        let even = values.iter().enumerate().map(off);
        // What is not a number is not even either.
        let even = step > 0.0 && even.into_iter().all(|off| off <= EVEN * step);
        even.then_some(Self::Even {
            from: *from,
            step,
            count: values.len(),
        })
    }

    fn coded(values: &[f64]) -> Self {
        let finite = values.iter().copied().filter(|value| value.is_finite());
        let low = finite.clone().fold(f64::INFINITY, f64::min).min(f64::MAX);
        let high = finite.fold(low, f64::max);
        let span = if high > low { high - low } else { 1.0 };
        let most = f64::from(GAP - 1);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // within 0..=65534
        let code = |value: &f64| {
            if value.is_finite() {
                ((value - low) / span * most).round() as u16
            } else {
                GAP
            }
        };
        let bytes: Vec<u8> = values.iter().map(code).flat_map(u16::to_le_bytes).collect();
        Self::Coded {
            low,
            high: low + span,
            code: STANDARD.encode(bytes),
        }
    }
}

/// A curve.
#[derive(Serialize)]
struct Curve<'a> {
    label: &'a str,
    class: String,
    stroke: &'static str,
    x: Numbers,
    y: Numbers,
    #[serde(skip_serializing_if = "Option::is_none")]
    band: Option<[Numbers; 2]>,
}

/// A chart.
#[derive(Serialize)]
struct Points<'a> {
    /// Left, right, top and bottom of the curves, in pixels of the drawing.
    frame: [f64; 4],
    /// The axes at first: from, to.
    axes: [[f64; 2]; 2],
    logarithmic: [bool; 2],
    square: bool,
    x_label: &'a str,
    curves: Vec<Curve<'a>>,
    limits: &'a [f64],
    marks: Vec<(f64, &'a str)>,
    /// The most samples that share a point, where some do.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples_a_bucket: Option<usize>,
}

/// The most samples of a curve that one bucket of it stands for; `None` where all are there.
pub(super) fn samples_a_bucket(chart: &Chart) -> Option<usize> {
    let longest = chart.series.iter().map(|own| own.values.len()).max()?;
    (longest > 2 * BUCKETS).then(|| longest.div_ceil(BUCKETS))
}

/// The numbers as JSON that may stand in a `<script>` element.
pub(super) fn json(chart: &Chart) -> Result<String, serde_json::Error> {
    let Frame {
        left,
        right,
        top,
        bottom,
        ..
    } = Frame::of(chart.form);
    let [x_axis, y_axis] = chart.axes(Frame::of(chart.form));
    let points = Points {
        frame: [left, right, top, bottom],
        axes: [[x_axis.low, x_axis.high], [y_axis.low, y_axis.high]],
        logarithmic: [chart.x_scale, chart.y_scale].map(|own| own == Scale::Logarithmic),
        square: chart.form == Form::Square,
        x_label: &chart.x_label,
        curves: chart
            .series
            .iter()
            .enumerate()
            .map(|(place, series)| curve(chart, place, series))
            .collect(),
        limits: &chart.limits,
        marks: chart
            .marks
            .iter()
            .map(|mark| (mark.at, mark.label.as_str()))
            .collect(),
        samples_a_bucket: samples_a_bucket(chart),
    };
    // `<` in a label could end the element.
    Ok(serde_json::to_string(&points)?.replace('<', "\\u003c"))
}

fn curve<'a>(chart: &'a Chart, place: usize, series: &'a Series) -> Curve<'a> {
    let x = chart.abscissa(series);
    let count = x.len().min(series.values.len());
    let kept = extremes(&series.values[..count], BUCKETS);
    let pick = |values: &[f64], scale| {
        let picked: Vec<f64> = kept
            .iter()
            .map(|k| values.get(*k).copied().unwrap_or(f64::NAN))
            .collect();
        Numbers::of(&picked, scale)
    };
    Curve {
        label: &series.label,
        class: series.class(place),
        stroke: match series.stroke {
            Stroke::Line => "line",
            Stroke::Dashed => "dashed",
            Stroke::Crosses => "crosses",
            Stroke::Rings => "rings",
        },
        x: pick(x, chart.x_scale),
        y: pick(&series.values, chart.y_scale),
        band: series.band.as_ref().map(|band| {
            [
                pick(&band.low, chart.y_scale),
                pick(&band.high, chart.y_scale),
            ]
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(numbers: &Numbers) -> Vec<f64> {
        match numbers {
            Numbers::Even { from, step, count } => {
                (0..*count).map(|k| from + k as f64 * step).collect()
            }
            Numbers::Coded { low, high, code } => STANDARD
                .decode(code)
                .expect("base64")
                .chunks_exact(2)
                .map(|pair| match u16::from_le_bytes([pair[0], pair[1]]) {
                    GAP => f64::NAN,
                    own => low + f64::from(own) / 65534.0 * (high - low),
                })
                .collect(),
            Numbers::Plain(values) => {
                let value = |own: &Option<f64>| own.unwrap_or(f64::NAN);
                values.iter().map(value).collect()
            }
        }
    }

    /// Half a step of the code, which is far below a pixel.
    #[test]
    fn coded_numbers_come_back_to_half_a_step() {
        let mut values: Vec<f64> = (0..1000)
            .map(|k| (f64::from(k) * 0.37).sin() * 5e4)
            .collect();
        values[17] = f64::NAN;
        values[18] = f64::INFINITY;
        let numbers = Numbers::of(&values, Scale::Linear);
        assert!(matches!(numbers, Numbers::Coded { .. }));
        let back = decoded(&numbers);
        assert_eq!(back.len(), values.len());
        for (value, back) in values.iter().zip(back) {
            if value.is_finite() {
                assert!(
                    (value - back).abs() <= 0.5 * 1e5 / 65534.0 * 1.001,
                    "{value} {back}"
                );
            } else {
                assert!(back.is_nan());
            }
        }
    }

    #[test]
    fn even_numbers_are_three() {
        let times: Vec<f64> = (0..5000).map(|k| 12.0 + 0.08 * f64::from(k)).collect();
        let numbers = Numbers::of(&times, Scale::Linear);
        assert!(matches!(numbers, Numbers::Even { count: 5000, .. }));
        for (time, back) in times.iter().zip(decoded(&numbers)) {
            assert!((time - back).abs() < 1e-9);
        }
        for uneven in [vec![], vec![1.0], vec![0.0, 1.0, 3.0], vec![2.0, 1.0]] {
            assert!(matches!(
                Numbers::of(&uneven, Scale::Linear),
                Numbers::Plain(_)
            ));
        }
    }

    #[test]
    fn flat_and_missing_curves_have_codes() {
        for values in [vec![7.0; 100], vec![f64::NAN; 100], vec![f64::MAX; 100]] {
            let back = decoded(&Numbers::of(&values, Scale::Linear));
            let bits =
                |values: &[f64]| -> Vec<u64> { values.iter().map(|own| own.to_bits()).collect() };
            let there = values[0].is_finite();
            assert!(!there || bits(&back) == bits(&values), "{back:?}");
            assert!(there || back.iter().all(|own| own.is_nan()), "{back:?}");
        }
    }

    #[test]
    fn labels_cannot_end_the_script() {
        let chart = Chart {
            x: vec![0.0],
            series: vec![Series::line("</script><b>", vec![1.0])],
            ..Chart::default()
        };
        let json = json(&chart).expect("JSON");
        assert!(!json.contains('<'));
        let back: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        assert_eq!(back["curves"][0]["label"], "</script><b>");
    }

    #[test]
    fn long_curves_are_short_and_say_so() {
        let chart = Chart {
            x: (0..100_000).map(f64::from).collect(),
            series: vec![Series::line(
                "y",
                (0..100_000).map(|k| f64::from(k % 97)).collect(),
            )],
            ..Chart::default()
        };
        assert_eq!(samples_a_bucket(&chart), Some(67));
        // Two numbers of two bytes each for two points a bucket, four characters for three bytes.
        let most = 2 * 2 * BUCKETS * 2 * 4 / 3 + 1000;
        let length = json(&chart).expect("JSON").len();
        assert!(length < most, "{length}");
    }
}
