//! Line charts as plain SVG: no script, no font, no network; colours follow the reader's theme.

use std::fmt::Write as _;

use super::axis::{Axis, Scale};
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
#[derive(Debug, Clone, Default)]
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
    /// How the abscissa runs.
    pub x_scale: Scale,
    /// How the ordinate runs.
    pub y_scale: Scale,
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
        let values = self
            .series
            .iter()
            .flat_map(|series| series.values.iter().copied());
        let values = values.chain(self.limits.iter().copied());
        let x_axis = Axis::over(
            self.x_scale,
            self.x.iter().copied(),
            0.0,
            [LEFT, WIDTH - RIGHT],
        );
        let y_axis = Axis::over(self.y_scale, values, 0.06, [HEIGHT - BOTTOM, TOP]);
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
        for (tick, label) in y_axis.ticks() {
            let y = y_axis.pixel(tick);
            let _ = write!(
                svg,
                "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>\
                 <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                LEFT - 6.0,
                y + 4.0
            );
        }
        for (tick, label) in x_axis.ticks() {
            let x = x_axis.pixel(tick);
            let _ = write!(
                svg,
                "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{bottom}\"/>\
                 <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
                bottom + 16.0
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
        let (along, up) = (x_axis.pixel(x[index]), y_axis.pixel(values[index]));
        if !(along.is_finite() && up.is_finite()) {
            pen_down = false;
            return;
        }
        let command = if pen_down { 'L' } else { 'M' };
        pen_down = true;
        let _ = write!(text, "{command}{along:.1} {up:.1}");
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
            ..Chart::default()
        }
    }

    #[test]
    fn a_single_peak_survives_the_reduction() {
        let mut values = vec![0.0; 50_000];
        values[31_234] = 7.0;
        let chart = chart(values);
        let axis = |high: f64, ends| Axis::over(Scale::Linear, [0.0, high].into_iter(), 0.0, ends);
        let y_axis = axis(7.0, [100.0, 0.0]);
        let x_axis = axis(50_000.0, [0.0, 1000.0]);
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

    /// Decades are equally far apart, and what has no logarithm interrupts the line.
    #[test]
    fn logarithmic_axes_draw_what_is_above_zero() {
        let values = vec![0.01, 1.0, 0.0, -3.0, 100.0];
        let drawn = Chart {
            y_scale: Scale::Logarithmic,
            ..chart(values.clone())
        };
        let svg = drawn.inline();
        let path = svg.split(" d=\"").nth(1).expect("a path");
        let path = &path[..path.find('"').expect("its end")];
        assert_eq!(path.matches('M').count(), 2, "{path}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let axis = Axis::over(Scale::Logarithmic, values.into_iter(), 0.0, [0.0, 4.0]);
        assert!((axis.pixel(0.1) - 1.0).abs() < 1e-12);
        assert!((axis.pixel(10.0) - 3.0).abs() < 1e-12);
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
}
