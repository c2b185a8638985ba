//! What a chart shows: curves over an abscissa, limits, marks; drawn by `draw`, alive by `points`.

use std::fmt::Write as _;

use super::axis::Scale;

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stroke {
    /// A line through all values; one that is not finite interrupts it.
    #[default]
    Line,
    /// A dashed line.
    Dashed,
    /// A cross at each value.
    Crosses,
    /// A ring at each value.
    Rings,
}

/// The colour of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Colour {
    /// That of its place among the curves; four are told apart.
    #[default]
    Own,
    /// That of the curve at this place.
    Of(usize),
    /// That of axes, for what is only there for comparison.
    Soft,
}

/// What surrounds a curve, one value a sample: an interval of confidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// The lower edge.
    pub low: Vec<f64>,
    /// The upper edge.
    pub high: Vec<f64>,
}

/// One curve.
#[derive(Debug, Clone, Default)]
pub struct Series {
    /// The legend's text; empty for a curve that needs none.
    pub label: String,
    /// Values, one a sample of the abscissa.
    pub values: Vec<f64>,
    /// The curve's own abscissa; the chart's where there is none.
    pub x: Option<Vec<f64>>,
    /// How it is drawn.
    pub stroke: Stroke,
    /// Its colour.
    pub colour: Colour,
    /// What surrounds it.
    pub band: Option<Band>,
}

impl Series {
    /// A line over the chart's abscissa.
    pub fn line(label: impl Into<String>, values: Vec<f64>) -> Self {
        Self {
            label: label.into(),
            values,
            ..Self::default()
        }
    }

    /// A dashed line over the chart's abscissa.
    pub fn dashed(label: impl Into<String>, values: Vec<f64>) -> Self {
        Self::line(label, values).drawn(Stroke::Dashed)
    }

    /// The same values, drawn otherwise.
    #[must_use]
    pub fn drawn(mut self, stroke: Stroke) -> Self {
        self.stroke = stroke;
        self
    }

    /// The same curve over an abscissa of its own.
    #[must_use]
    pub fn over(mut self, x: Vec<f64>) -> Self {
        self.x = Some(x);
        self
    }

    /// The same curve in another colour.
    #[must_use]
    pub fn coloured(mut self, colour: Colour) -> Self {
        self.colour = colour;
        self
    }

    /// The same curve with what surrounds it.
    #[must_use]
    pub fn within(mut self, low: Vec<f64>, high: Vec<f64>) -> Self {
        self.band = Some(Band { low, high });
        self
    }

    /// The style's name of the colour of the curve at a place.
    pub(super) fn class(&self, place: usize) -> String {
        match self.colour {
            Colour::Own => format!("c{}", place % 4),
            Colour::Of(other) => format!("c{}", other % 4),
            Colour::Soft => "soft".to_owned(),
        }
    }
}

/// A vertical line with a text, for an onset or an alarm.
#[derive(Debug, Clone)]
pub struct Mark {
    /// Position on the abscissa.
    pub at: f64,
    /// What happens there.
    pub label: String,
}

/// The form of the drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// As wide as the page; both axes are stretched to what is there.
    #[default]
    Wide,
    /// A square in which a unit is as long on both axes, so that circles are round.
    Square,
}

/// Curves over an abscissa.
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
    /// The form of the drawing.
    pub form: Form,
}

impl Chart {
    /// The abscissa of a curve.
    pub(super) fn abscissa<'a>(&'a self, series: &'a Series) -> &'a [f64] {
        series.x.as_deref().unwrap_or(&self.x)
    }

    /// The data behind the chart as CSV: the abscissa and a column a curve, each band's edges beside
    /// it; curves with an abscissa of their own bring it as a column.
    pub fn csv(&self) -> String {
        let columns = self.columns();
        let heads: Vec<String> = columns.iter().map(|(head, _)| quote(head)).collect();
        let mut text = heads.join(",");
        text.push('\n');
        let rows = columns.iter().map(|(_, values)| values.len()).max();
        for row in 0..rows.unwrap_or(0) {
            for (place, (_, values)) in columns.iter().enumerate() {
                if place > 0 {
                    text.push(',');
                }
                if let Some(value) = values.get(row).filter(|value| value.is_finite()) {
                    let _ = write!(text, "{value}");
                }
            }
            text.push('\n');
        }
        text
    }

    fn columns(&self) -> Vec<(String, &[f64])> {
        let mut columns: Vec<(String, &[f64])> = Vec::new();
        if self.series.iter().any(|series| series.x.is_none()) {
            columns.push((self.x_label.clone(), &self.x));
        }
        for series in &self.series {
            if let Some(x) = &series.x {
                let head = format!("{} of {}", self.x_label, series.label);
                columns.push((head.trim_end_matches(" of ").to_owned(), x));
            }
            let label = match series.label.as_str() {
                "" => &self.y_label,
                label => label,
            };
            columns.push((label.to_owned(), &series.values));
            if let Some(band) = &series.band {
                columns.push((format!("{label}, low"), &band.low));
                columns.push((format!("{label}, high"), &band.high));
            }
        }
        columns
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_leaves_missing_values_empty_and_quotes_commas() {
        let chart = Chart {
            x_label: "time [s]".into(),
            x: vec![0.0, 1.0],
            series: vec![Series::line("y, raw", vec![1.5, f64::NAN])],
            ..Chart::default()
        };
        assert_eq!(chart.csv(), "time [s],\"y, raw\"\n0,1.5\n1,\n");
    }

    #[test]
    fn csv_has_bands_and_abscissas_of_their_own() {
        let band = Series::line("gain", vec![2.0]).within(vec![1.0], vec![3.0]);
        let own = Series::line("poles", vec![0.1, 0.2]).over(vec![0.8, 0.9]);
        let chart = Chart {
            x_label: "re".into(),
            x: vec![5.0],
            series: vec![band, own],
            ..Chart::default()
        };
        assert_eq!(
            chart.csv(),
            "re,gain,\"gain, low\",\"gain, high\",re of poles,poles\n5,2,1,3,0.8,0.1\n,,,,0.9,0.2\n"
        );
    }
}
