//! Line charts as plain SVG: no script, no font, no network; colours follow the reader's theme.

use std::fmt::Write as _;

use super::escape;

/// Pixels of the drawing, before the page scales it.
const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 40.0;
/// Columns into which a long series is reduced to its minimum and maximum; more than there are
/// pixels would only make the file large.
const BUCKETS: usize = 600;
/// Ticks aimed at on an axis.
const TICKS: f64 = 6.0;

/// The rules a chart needs, for stand-alone files and for the page alike.
pub const STYLE: &str = "\
.chart{font:12px system-ui,-apple-system,'Segoe UI',sans-serif;--ink:#1d2733;--soft:#66717f;\
--grid:#dde3ea;--s0:#0b62a8;--s1:#c2510a;--s2:#0b7a55;--s3:#a2387d;--mark:#b3261e;--halo:#fff}\
@media(prefers-color-scheme:dark){.chart{--ink:#e6ebf1;--soft:#9aa7b5;--grid:#2c3642;\
--s0:#6bb5f2;--s1:#f2a067;--s2:#5fcaa0;--s3:#e391c6;--mark:#ff8a80;--halo:#12171d}}\
.chart text{fill:var(--soft)}.chart .title{fill:var(--ink);font-weight:600;font-size:13px}\
.chart .grid{stroke:var(--grid)}.chart .axis{stroke:var(--soft)}\
.chart .line{fill:none;stroke-width:1.4;stroke-linejoin:round}\
.chart .c0{stroke:var(--s0)}.chart .c1{stroke:var(--s1)}.chart .c2{stroke:var(--s2)}\
.chart .c3{stroke:var(--s3)}.chart .limit{stroke:var(--mark);stroke-dasharray:5 4}\
.chart .mark{stroke:var(--mark)}.chart .marktext{fill:var(--mark);stroke:var(--halo);\
stroke-width:4px;paint-order:stroke}\
.chart .dashed{stroke-dasharray:4 3}";

/// One curve.
#[derive(Debug, Clone)]
pub struct Series {
    /// The legend's text.
    pub label: String,
    /// Values, one a sample of the chart's abscissa.
    pub values: Vec<f64>,
    /// Whether the line is dashed.
    pub dashed: bool,
}

/// A vertical line with a text, for an onset or an alarm.
#[derive(Debug, Clone)]
pub struct Mark {
    /// Position on the abscissa.
    pub at: f64,
    /// What happens there.
    pub label: String,
}

/// A line chart over one common abscissa.
#[derive(Debug, Clone)]
pub struct Chart {
    /// File name without extension, unique in a report.
    pub id: String,
    /// The heading inside the drawing.
    pub title: String,
    /// Abscissa label with unit.
    pub x_label: String,
    /// Ordinate label with unit.
    pub y_label: String,
    /// Abscissa values, increasing.
    pub x: Vec<f64>,
    /// The curves; at most four are told apart by colour.
    pub series: Vec<Series>,
    /// Horizontal dashed lines, for thresholds.
    pub limits: Vec<f64>,
    /// Vertical lines.
    pub marks: Vec<Mark>,
}

/// A linear map from data to pixels on one axis.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    fn pixel(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Round tick values (1, 2 or 5 times a power of ten apart).
    fn ticks(&self) -> Vec<f64> {
        let raw = (self.high - self.low) / TICKS;
        let power = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|factor| factor * power)
            .find(|step| *step >= raw)
            .unwrap_or(raw);
        let mut ticks = Vec::new();
        let mut index = (self.low / step).ceil();
        while index * step <= self.high + 1e-9 * step && ticks.len() < 50 {
            ticks.push(index * step);
            index += 1.0;
        }
        ticks
    }
}

/// The extent of finite values, widened a little; a flat or empty extent becomes a visible band.
fn extent(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low > high {
        return (0.0, 1.0);
    }
    let span = high - low;
    // Below this share of the value itself the curve is flat to the reader.
    if span <= 1e-9 * low.abs().max(high.abs()) {
        let band = low.abs().max(1.0) * 0.01;
        return (low - band, high + band);
    }
    (low - margin * span, high + margin * span)
}

/// A number as a tick label: as many digits as the spacing needs.
fn label(value: f64, step: f64) -> String {
    let magnitude = value.abs().max(step);
    if !(1e-3..1e6).contains(&magnitude) {
        if value == 0.0 {
            return "0".to_owned();
        }
        let digits = (value.abs().log10().floor() - step.log10().floor()).clamp(0.0, 12.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to 0..=12
        return format!("{value:.*e}", digits as usize);
    }
    let decimals = (-step.log10().floor()).clamp(0.0, 12.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to 0..=12
    let text = format!("{value:.*}", decimals as usize);
    if text
        .trim_start_matches('-')
        .chars()
        .all(|digit| digit == '0' || digit == '.')
    {
        "0".to_owned()
    } else {
        text
    }
}

impl Chart {
    /// The chart as an `<svg>` element for a page that carries [`STYLE`] itself.
    pub fn inline(&self) -> String {
        self.draw(false)
    }

    /// The chart as a file of its own.
    pub fn stand_alone(&self) -> String {
        self.draw(true)
    }

    /// The data behind the chart as CSV: the abscissa, then a column a curve.
    pub fn csv(&self) -> String {
        let mut text = quote(&self.x_label);
        for series in &self.series {
            text.push(',');
            text.push_str(&quote(&series.label));
        }
        text.push('\n');
        for (index, x) in self.x.iter().enumerate() {
            let _ = write!(text, "{x}");
            for series in &self.series {
                match series.values.get(index) {
                    Some(value) if value.is_finite() => {
                        let _ = write!(text, ",{value}");
                    }
                    _ => text.push(','),
                }
            }
            text.push('\n');
        }
        text
    }

    fn draw(&self, stand_alone: bool) -> String {
        let (x_low, x_high) = extent(self.x.iter().copied(), 0.0);
        let values = self
            .series
            .iter()
            .flat_map(|series| series.values.iter().copied());
        let (y_low, y_high) = extent(values.chain(self.limits.iter().copied()), 0.06);
        let x_axis = Axis {
            low: x_low,
            high: x_high,
            from: LEFT,
            to: WIDTH - RIGHT,
        };
        let y_axis = Axis {
            low: y_low,
            high: y_high,
            from: HEIGHT - BOTTOM,
            to: TOP,
        };
        let mut svg = format!(
            "<svg{} class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" \
             aria-label=\"{}\">",
            if stand_alone {
                " xmlns=\"http://www.w3.org/2000/svg\""
            } else {
                ""
            },
            escape(&self.title)
        );
        if stand_alone {
            let _ = write!(svg, "<style>{STYLE}</style>");
        }
        self.frame(&mut svg, &x_axis, &y_axis);
        for (index, series) in self.series.iter().enumerate() {
            let dashed = if series.dashed { " dashed" } else { "" };
            let _ = write!(
                svg,
                "<path class=\"line c{}{dashed}\" d=\"{}\"/>",
                index % 4,
                path(&self.x, &series.values, &x_axis, &y_axis)
            );
        }
        for limit in &self.limits {
            let y = y_axis.pixel(*limit);
            let _ = write!(
                svg,
                "<line class=\"limit\" x1=\"{LEFT}\" x2=\"{}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>",
                WIDTH - RIGHT
            );
        }
        for (index, mark) in self.marks.iter().enumerate() {
            let x = x_axis.pixel(mark.at);
            // Two rows of texts, so that an onset and an alarm close to it both stay readable.
            let y = TOP + 12.0 + 14.0 * (index % 2) as f64;
            let (anchor, shift) = if x > WIDTH * 0.8 {
                ("end", -4.0)
            } else {
                ("start", 4.0)
            };
            let _ = write!(
                svg,
                "<line class=\"mark\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{}\"/>\
                 <text class=\"marktext\" x=\"{:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}\
                 </text>",
                HEIGHT - BOTTOM,
                x + shift,
                escape(&mark.label)
            );
        }
        svg.push_str("</svg>");
        svg
    }

    /// Grid, ticks, title, axis labels and legend.
    fn frame(&self, svg: &mut String, x_axis: &Axis, y_axis: &Axis) {
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        let y_ticks = y_axis.ticks();
        let y_step = y_ticks.get(1).map_or(1.0, |second| second - y_ticks[0]);
        for tick in y_ticks {
            let y = y_axis.pixel(tick);
            let _ = write!(
                svg,
                "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>\
                 <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 6.0,
                y + 4.0,
                label(tick, y_step)
            );
        }
        let x_ticks = x_axis.ticks();
        let x_step = x_ticks.get(1).map_or(1.0, |second| second - x_ticks[0]);
        for tick in x_ticks {
            let x = x_axis.pixel(tick);
            let _ = write!(
                svg,
                "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{bottom}\"/>\
                 <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                bottom + 16.0,
                label(tick, x_step)
            );
        }
        let _ = write!(
            svg,
            "<line class=\"axis\" x1=\"{LEFT}\" x2=\"{right}\" y1=\"{bottom}\" y2=\"{bottom}\"/>\
             <text class=\"title\" x=\"{LEFT}\" y=\"16\">{}</text>\
             <text x=\"{right}\" y=\"{}\" text-anchor=\"end\">{}</text>\
             <text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escape(&self.title),
            HEIGHT - 6.0,
            escape(&self.x_label),
            f64::midpoint(TOP, bottom),
            escape(&self.y_label)
        );
        if self.series.len() > 1 {
            let mut x = right;
            for (index, series) in self.series.iter().enumerate().rev() {
                // About 6.6 px a character at 12 px.
                x -= 6.6 * series.label.chars().count() as f64;
                let dashed = if series.dashed { " dashed" } else { "" };
                let _ = write!(
                    svg,
                    "<text x=\"{x:.1}\" y=\"16\">{}</text>\
                     <line class=\"line c{}{dashed}\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"12\" \
                     y2=\"12\"/>",
                    escape(&series.label),
                    index % 4,
                    x - 24.0,
                    x - 5.0
                );
                x -= 36.0;
            }
        }
    }
}

/// A cell of a CSV header.
fn quote(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// The path of one curve; long curves keep the minimum and the maximum of every bucket, so that no
/// peak is lost. Gaps (values that are not finite) interrupt the line.
fn path(x: &[f64], values: &[f64], x_axis: &Axis, y_axis: &Axis) -> String {
    let count = x.len().min(values.len());
    let mut text = String::new();
    let mut pen_down = false;
    let mut draw = |index: usize| {
        let value = values[index];
        if !value.is_finite() {
            pen_down = false;
            return;
        }
        let command = if pen_down { 'L' } else { 'M' };
        pen_down = true;
        let _ = write!(
            text,
            "{command}{:.1} {:.1}",
            x_axis.pixel(x[index]),
            y_axis.pixel(value)
        );
    };
    if count <= 2 * BUCKETS {
        (0..count).for_each(&mut draw);
        return text;
    }
    for bucket in 0..BUCKETS {
        let (start, end) = (bucket * count / BUCKETS, (bucket + 1) * count / BUCKETS);
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let finite = || (start..end).filter(|index| values[*index].is_finite());
        match (finite().min_by(by_value), finite().max_by(by_value)) {
            (Some(low), Some(high)) if low != high => {
                draw(low.min(high));
                draw(low.max(high));
            }
            (Some(only), _) => draw(only),
            _ => draw(start),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(values: Vec<f64>) -> Chart {
        Chart {
            id: "c".into(),
            title: "a < b & \"c\"".into(),
            x_label: "time [s]".into(),
            y_label: "y".into(),
            x: (0..values.len()).map(|k| k as f64).collect(),
            series: vec![Series {
                label: "y, raw".into(),
                values,
                dashed: false,
            }],
            limits: vec![],
            marks: vec![],
        }
    }

    #[test]
    fn a_single_peak_survives_the_reduction() {
        let mut values = vec![0.0; 50_000];
        values[31_234] = 7.0;
        let chart = chart(values);
        let y_axis = Axis {
            low: 0.0,
            high: 7.0,
            from: 100.0,
            to: 0.0,
        };
        let x_axis = Axis {
            low: 0.0,
            high: 50_000.0,
            from: 0.0,
            to: 1000.0,
        };
        let drawn = path(&chart.x, &chart.series[0].values, &x_axis, &y_axis);
        assert!(
            drawn.contains("624.7 0.0"),
            "the peak at sample 31234 is lost"
        );
        assert!(
            drawn.matches(['M', 'L']).count() <= 2 * BUCKETS,
            "not reduced"
        );
    }

    #[test]
    fn a_gap_interrupts_the_line() {
        let drawn = chart(vec![0.0, 1.0, f64::NAN, 1.0, 0.0]).inline();
        let path = drawn.split(" d=\"").nth(1).expect("a path");
        let path = &path[..path.find('"').expect("its end")];
        assert_eq!(path.matches('M').count(), 2);
        assert!(!drawn.contains("NaN"));
    }

    #[test]
    fn texts_are_escaped_and_flat_or_empty_series_still_draw() {
        for values in [vec![], vec![f64::NAN; 3], vec![5.0; 10], vec![0.0; 10]] {
            let drawn = chart(values).stand_alone();
            assert!(drawn.contains("a &lt; b &amp; &quot;c&quot;"));
            assert!(!drawn.contains("NaN") && !drawn.contains("inf"), "{drawn}");
        }
    }

    #[test]
    fn csv_leaves_missing_values_empty_and_quotes_commas() {
        assert_eq!(
            chart(vec![1.5, f64::NAN]).csv(),
            "time [s],\"y, raw\"\n0,1.5\n1,\n"
        );
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let axis = Axis {
            low: 566.4,
            high: 588.1,
            from: 0.0,
            to: 1.0,
        };
        assert_eq!(axis.ticks(), [570.0, 575.0, 580.0, 585.0]);
        assert_eq!(label(206000.0, 1000.0), "206000");
        assert_eq!(label(0.00012, 0.00002), "1.2e-4");
        assert_eq!(label(-1e-17, 0.5), "0");
    }
}
