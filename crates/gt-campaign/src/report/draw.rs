//! Charts as plain SVG: no script, no font, no network; colours follow the reader's theme.

use std::fmt::Write as _;

use super::axis::Axis;
use super::chart::{Band, Chart, Form, Series, Stroke};
use super::escape;
use super::reduction::extremes;

/// The rules a chart needs, for stand-alone files and for the page alike.
pub(super) const STYLE: &str = include_str!("assets/chart.css");

/// Columns into which a long series is reduced to its minimum and maximum; more than there are
/// pixels would only make the file large.
const BUCKETS: usize = 600;
/// About the width of a character of a label.
const CHARACTER: f64 = 6.6;
/// Half the size of a cross or ring.
const SYMBOL: f64 = 4.0;

/// The drawing in pixels, before the page scales it, and the rectangle of the curves in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub width: f64,
    pub height: f64,
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

impl Frame {
    pub fn of(form: Form) -> Self {
        let (width, height) = match form {
            Form::Wide => (860.0, 260.0),
            Form::Square => (448.0, 430.0),
        };
        Self {
            width,
            height,
            left: 74.0,
            right: width - 14.0,
            top: 30.0,
            bottom: height - 40.0,
        }
    }
}

impl Chart {
    /// The chart as an `<svg>` element for a page that carries the style itself.
    pub fn inline(&self) -> String {
        self.draw(false)
    }

    /// The chart as a file of its own.
    pub fn stand_alone(&self) -> String {
        self.draw(true)
    }

    /// Both axes over all that is shown.
    pub(super) fn axes(&self, frame: Frame) -> [Axis; 2] {
        let abscissas = self.series.iter().filter_map(|series| series.x.as_ref());
        let x = self.x.iter().chain(abscissas.flatten());
        let bands = self.series.iter().filter_map(|series| series.band.as_ref());
        let edges = bands.flat_map(|band| band.low.iter().chain(&band.high));
        let values = self.series.iter().flat_map(|series| &series.values);
        let y = values.chain(edges).chain(&self.limits);
        let (across, up) = ([frame.left, frame.right], [frame.bottom, frame.top]);
        let margin = match self.form {
            Form::Wide => 0.0,
            Form::Square => 0.06,
        };
        let mut axes = [
            Axis::over(self.x_scale, x.copied(), margin, across),
            Axis::over(self.y_scale, y.copied(), 0.06, up),
        ];
        if self.form == Form::Square {
            let longest = axes.iter().map(Axis::per_pixel).fold(0.0, f64::max);
            for axis in &mut axes {
                axis.widen(longest);
            }
        }
        axes
    }

    fn draw(&self, stand_alone: bool) -> String {
        let frame = Frame::of(self.form);
        let axes = self.axes(frame);
        let mut svg = format!(
            "<svg{} class=\"chart{}\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
            if stand_alone {
                " xmlns=\"http://www.w3.org/2000/svg\""
            } else {
                ""
            },
            if self.form == Form::Square {
                " square"
            } else {
                ""
            },
            frame.width,
            frame.height,
            escape(&self.title)
        );
        if stand_alone {
            let _ = write!(svg, "<style>{STYLE}</style>");
        }
        self.texts(&mut svg, frame);
        // What changes when the reader zooms.
        svg.push_str("<g class=\"view\">");
        grid(&mut svg, &axes, frame);
        for (place, series) in self.series.iter().enumerate() {
            self.curve(&mut svg, place, series, &axes);
        }
        for limit in &self.limits {
            let y = axes[1].pixel(*limit);
            let _ = write!(
                svg,
                "<line class=\"limit\" x1=\"{}\" x2=\"{}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>",
                frame.left, frame.right
            );
        }
        self.marks(&mut svg, &axes[0], frame);
        svg.push_str("</g></svg>");
        svg
    }

    fn curve(&self, svg: &mut String, place: usize, series: &Series, axes: &[Axis; 2]) {
        let x = self.abscissa(series);
        let class = series.class(place);
        if let Some(band) = &series.band {
            let d = area(x, band, axes);
            let _ = write!(svg, "<path class=\"band {class}\" d=\"{d}\"/>");
        }
        let dashed = match series.stroke {
            Stroke::Dashed => " dashed",
            _ => "",
        };
        let d = match series.stroke {
            Stroke::Line | Stroke::Dashed => line(x, &series.values, axes),
            Stroke::Crosses | Stroke::Rings => symbols(x, &series.values, axes, series.stroke),
        };
        let _ = write!(svg, "<path class=\"line {class}{dashed}\" d=\"{d}\"/>");
    }

    /// Vertical lines with their texts, which lie in two rows so that an onset and an alarm close to
    /// it both stay readable; a text without room is left out.
    fn marks(&self, svg: &mut String, axis: &Axis, frame: Frame) {
        let mut taken = [f64::NEG_INFINITY; 2];
        for mark in &self.marks {
            let x = axis.pixel(mark.at);
            let _ = write!(
                svg,
                "<line class=\"mark\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{}\" y2=\"{}\"/>",
                frame.top, frame.bottom
            );
            let length = CHARACTER * mark.label.chars().count() as f64;
            let (anchor, at, from, to) = if x + length > frame.right {
                ("end", x - 4.0, x - 4.0 - length, x)
            } else {
                ("start", x + 4.0, x, x + 4.0 + length)
            };
            let Some(row) = (0..2).find(|row| from >= taken[*row]) else {
                continue;
            };
            taken[row] = to;
            let _ = write!(
                svg,
                "<text class=\"marktext\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}\
                 </text>",
                frame.top + 12.0 + 14.0 * row as f64,
                escape(&mark.label)
            );
        }
    }

    /// Title, axis labels and legend.
    fn texts(&self, svg: &mut String, frame: Frame) {
        let Frame {
            left,
            right,
            top,
            bottom,
            height,
            ..
        } = frame;
        let _ = write!(
            svg,
            "<line class=\"axis\" x1=\"{left}\" x2=\"{right}\" y1=\"{bottom}\" y2=\"{bottom}\"/>\
             <text class=\"title\" x=\"{left}\" y=\"16\">{}</text>\
             <text x=\"{right}\" y=\"{}\" text-anchor=\"end\">{}</text>\
             <text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escape(&self.title),
            height - 6.0,
            escape(&self.x_label),
            f64::midpoint(top, bottom),
            escape(&self.y_label)
        );
        let labelled = self.series.iter().enumerate();
        let labelled = labelled.filter(|(_, series)| !series.label.is_empty());
        let labelled: Vec<_> = labelled.collect();
        if labelled.len() < 2 {
            return;
        }
        // A square has no room beside the title.
        let y = match self.form {
            Form::Wide => 16.0,
            Form::Square => height - 6.0,
        };
        let mut x = match self.form {
            Form::Wide => right,
            Form::Square => right - CHARACTER * (self.x_label.chars().count() as f64 + 2.0),
        };
        for (place, series) in labelled.into_iter().rev() {
            x -= CHARACTER * series.label.chars().count() as f64;
            let class = series.class(place);
            let (from, to) = (x - 24.0, x - 5.0);
            let middle = f64::midpoint(from, to);
            let key = match series.stroke {
                Stroke::Line | Stroke::Dashed => format!("M{from:.1} {0}L{to:.1} {0}", y - 4.0),
                stroke => symbol(middle, y - 4.0, stroke),
            };
            let dashed = match series.stroke {
                Stroke::Dashed => " dashed",
                _ => "",
            };
            let _ = write!(
                svg,
                "<text x=\"{x:.1}\" y=\"{y}\">{}</text><path class=\"line {class}{dashed}\" \
                 d=\"{key}\"/>",
                escape(&series.label),
            );
            x -= 36.0;
        }
    }
}

/// Grid lines with the values beside them.
fn grid(svg: &mut String, [x_axis, y_axis]: &[Axis; 2], frame: Frame) {
    let Frame {
        left,
        right,
        top,
        bottom,
        ..
    } = frame;
    for (tick, label) in y_axis.ticks() {
        let y = y_axis.pixel(tick);
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{left}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>\
             <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            left - 6.0,
            y + 4.0
        );
    }
    for (tick, label) in x_axis.ticks() {
        let x = x_axis.pixel(tick);
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{top}\" y2=\"{bottom}\"/>\
             <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
            bottom + 16.0
        );
    }
}

/// The path of one curve; values that are not finite interrupt the line.
fn line(x: &[f64], values: &[f64], [x_axis, y_axis]: &[Axis; 2]) -> String {
    let count = x.len().min(values.len());
    let mut text = String::new();
    let mut pen_down = false;
    for index in extremes(&values[..count], BUCKETS) {
        let (along, up) = (x_axis.pixel(x[index]), y_axis.pixel(values[index]));
        if !(along.is_finite() && up.is_finite()) {
            pen_down = false;
            continue;
        }
        let command = if pen_down { 'L' } else { 'M' };
        pen_down = true;
        let _ = write!(text, "{command}{along:.1} {up:.1}");
    }
    text
}

/// The outline of a band: a closed figure for every stretch of it.
fn area(x: &[f64], band: &Band, [x_axis, y_axis]: &[Axis; 2]) -> String {
    let edges = band.low.iter().zip(&band.high);
    let corners: Vec<Option<[f64; 3]>> = x
        .iter()
        .zip(edges)
        .map(|(x, (low, high))| {
            let corner = [x_axis.pixel(*x), y_axis.pixel(*low), y_axis.pixel(*high)];
            corner.iter().all(|own| own.is_finite()).then_some(corner)
        })
        .collect();
    let mut text = String::new();
    for stretch in corners.split(Option::is_none) {
        let corners: Vec<&[f64; 3]> = stretch.iter().flatten().collect();
        let there = corners.iter().map(|[x, _, high]| [x, high]);
        let back = corners.iter().rev().map(|[x, low, _]| [x, low]);
        for (place, [x, y]) in there.chain(back).enumerate() {
            let command = if place == 0 { 'M' } else { 'L' };
            let _ = write!(text, "{command}{x:.1} {y:.1}");
        }
        if !corners.is_empty() {
            text.push('Z');
        }
    }
    text
}

fn symbols(x: &[f64], values: &[f64], [x_axis, y_axis]: &[Axis; 2], stroke: Stroke) -> String {
    let places = x
        .iter()
        .zip(values)
        .map(|(x, value)| [x_axis.pixel(*x), y_axis.pixel(*value)]);
    places
        .filter(|place| place.iter().all(|own| own.is_finite()))
        .map(|[x, y]| symbol(x, y, stroke))
        .collect()
}

/// A cross or a ring around a place.
fn symbol(x: f64, y: f64, stroke: Stroke) -> String {
    let (left, size) = (x - SYMBOL, 2.0 * SYMBOL);
    if stroke == Stroke::Rings {
        return format!(
            "M{left:.1} {y:.1}a{SYMBOL} {SYMBOL} 0 1 0 {size} 0a{SYMBOL} {SYMBOL} 0 1 0 -{size} 0"
        );
    }
    let top = y - SYMBOL;
    format!("M{left:.1} {top:.1}l{size} {size}m0 -{size}l-{size} {size}")
}

#[cfg(test)]
mod tests {
    use super::super::axis::Scale;
    use super::super::chart::Mark;
    use super::*;

    fn chart(values: Vec<f64>) -> Chart {
        Chart {
            id: "c".into(),
            title: "a < b & \"c\"".into(),
            x_label: "time [s]".into(),
            y_label: "y".into(),
            x: (0..values.len()).map(|k| k as f64).collect(),
            series: vec![Series::line("y, raw", values)],
            ..Chart::default()
        }
    }

    /// The path of the first curve.
    fn first_path(svg: &str, class: &str) -> String {
        let path = svg.split(&format!("<path class=\"{class}")).nth(1);
        let path = path
            .expect("a curve")
            .split(" d=\"")
            .nth(1)
            .expect("a path");
        path[..path.find('"').expect("its end")].to_owned()
    }

    #[test]
    fn a_single_peak_is_drawn_of_a_long_curve() {
        let mut values = vec![0.0; 50_000];
        values[31_234] = 7.0;
        let chart = chart(values);
        let axis = |high: f64, ends| Axis::over(Scale::Linear, [0.0, high].into_iter(), 0.0, ends);
        let axes = [axis(50_000.0, [0.0, 1000.0]), axis(7.0, [100.0, 0.0])];
        let drawn = line(&chart.x, &chart.series[0].values, &axes);
        assert!(
            drawn.contains("624.7 0.0"),
            "the peak at sample 31234 is lost"
        );
    }

    #[test]
    fn a_gap_interrupts_the_line() {
        let drawn = chart(vec![0.0, 1.0, f64::NAN, 1.0, 0.0]).inline();
        assert_eq!(first_path(&drawn, "line").matches('M').count(), 2);
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
        let path = first_path(&svg, "line");
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
    fn a_band_is_closed_around_each_stretch() {
        let mut drawn = chart(vec![1.0; 5]);
        drawn.series[0].band = Some(Band {
            low: vec![0.0, 0.0, f64::NAN, 0.0, 0.0],
            high: vec![2.0; 5],
        });
        let path = first_path(&drawn.inline(), "band");
        assert_eq!(path.matches('Z').count(), 2, "{path}");
        // There and back over two samples each.
        assert_eq!(path.matches(['M', 'L']).count(), 8, "{path}");
    }

    /// A circle of radius 1 is as wide as it is high.
    #[test]
    fn a_square_chart_has_one_scale() {
        let angle = |k: i32| f64::from(k) * std::f64::consts::TAU / 40.0;
        let circle = Series::line("", (0..=40).map(|k| angle(k).sin()).collect())
            .over((0..=40).map(|k| angle(k).cos()).collect());
        let far = Series::default().drawn(Stroke::Rings);
        let drawn = Chart {
            form: Form::Square,
            series: vec![
                circle,
                Series {
                    values: vec![0.0],
                    ..far.over(vec![3.0])
                },
            ],
            ..Chart::default()
        };
        let [x, y] = drawn.axes(Frame::of(Form::Square));
        let (wide, high) = (x.pixel(1.0) - x.pixel(-1.0), y.pixel(-1.0) - y.pixel(1.0));
        assert!((wide - high).abs() < 1e-9, "{wide} x {high}");
        assert!(x.pixel(3.0) <= Frame::of(Form::Square).right);
    }

    #[test]
    fn texts_of_marks_do_not_lie_on_each_other() {
        let mut drawn = chart((0..1000).map(f64::from).collect());
        drawn.marks = (0..20)
            .map(|k| Mark {
                at: 500.0 + f64::from(k),
                label: format!("alarm {k}"),
            })
            .collect();
        let svg = drawn.inline();
        assert_eq!(svg.matches("class=\"mark\"").count(), 20);
        assert_eq!(svg.matches("class=\"marktext\"").count(), 2);
    }
}
