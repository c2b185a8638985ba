//! Poles and zeros, with their regions of confidence.

use gtfdi::ident::pole_zero::{PoleZeroReport, Root, pole_zero};
use gtfdi::ident::{ArxModel, Estimate, IdentError};
use nalgebra::Matrix2;

use super::{Certainty, show};
use crate::report::Figure;
use crate::report::chart::{Chart, Colour, Form, Series, Stroke};
use crate::report::page::{Cell, Page};
use crate::report::text::digits;
use crate::reports::signals::figure_id;

/// The chi-square value of two degrees of freedom that 95 % lie below: `-2 ln .05`.
const REGION: f64 = 5.991464547107979;
/// The map reaches at least so far from the origin, and a tenth beyond the outermost pole.
const REACH: f64 = 1.5;
/// Corners of a drawn ellipse.
const CORNERS: u32 = 48;

/// A table of the poles and a map for each output.
pub(super) fn section(
    page: &mut Page,
    figures: &mut Vec<Figure>,
    model: &ArxModel,
    certainty: &Certainty,
) {
    page.section("poles", "Poles and zeros");
    let found = match pole_zero(model, &certainty.covariances) {
        Ok(found) => found,
        Err(error) => {
            page.paragraph(&format!("Not computed: {error}."));
            return;
        }
    };
    table(page, model, &found, certainty.known);
    page.note(if certainty.known {
        "Errors follow from the covariance of the coefficients to first order; ellipses hold the \
         truth with probability .95. A pole that a zero cancels within error in every channel may be \
         one order too many."
    } else {
        "The method gives no covariance of the coefficients, so that no error is known."
    });
    show(page, figures, maps(model, &found, certainty.known));
}

/// A map of poles and zeros for each output.
///
/// # Errors
/// As [`pole_zero`].
pub(crate) fn pole_figures(
    model: &ArxModel,
    certainty: &Certainty,
) -> Result<Vec<Figure>, IdentError> {
    let found = pole_zero(model, &certainty.covariances)?;
    Ok(maps(model, &found, certainty.known))
}

fn maps(model: &ArxModel, found: &PoleZeroReport, known: bool) -> Vec<Figure> {
    let outputs = model.outputs().iter().enumerate();
    let maps = outputs.map(|(output, signal)| {
        let poles = found
            .poles
            .iter()
            .filter(|pole| pole.output.is_none_or(|own| own == output));
        let poles: Vec<&Root> = poles.map(|pole| &pole.root).collect();
        let channels = found.channels.iter().filter(|own| own.output == output);
        let zeros: Vec<&Root> = channels.flat_map(|own| &own.zeros).collect();
        map(output, &signal.name, &poles, &zeros, known)
    });
    maps.collect()
}

fn table(page: &mut Page, model: &ArxModel, found: &PoleZeroReport, known: bool) {
    let sample_time_s = model.sample_time_s();
    let text = |own: Option<Estimate>| {
        own.map_or_else(
            || "-".to_owned(),
            |own| match own.standard_error.filter(|_| known) {
                Some(error) => format!("{} ({})", digits(own.value, 5), digits(error, 2)),
                None => digits(own.value, 5),
            },
        )
    };
    let rows: Vec<Vec<Cell>> = found
        .poles
        .iter()
        .enumerate()
        // One of each pair.
        .filter(|(_, pole)| pole.root.value.im >= 0.0)
        .map(|(place, pole)| {
            let root = &pole.root;
            let output = pole.output.map(|own| model.outputs()[own].name.clone());
            let superfluous = known && found.superfluous_poles.contains(&place);
            vec![
                Cell::plain(output.unwrap_or_else(|| "all".to_owned())),
                Cell::plain(format!(
                    "{}{}",
                    digits(root.value.re, 5),
                    if root.value.im > 0.0 {
                        format!(" \u{b1} {}i", digits(root.value.im, 5))
                    } else {
                        String::new()
                    }
                )),
                Cell::plain(text(Some(root.magnitude()))),
                Cell::plain(text(root.time_constant_s(sample_time_s))),
                Cell::plain(text(root.natural_frequency_hz(sample_time_s))),
                Cell::plain(text(root.damping())),
                Cell::plain(if superfluous { "yes" } else { "" }),
            ]
        })
        .collect();
    page.table(
        &[
            "output",
            "pole",
            "modulus (error)",
            "time constant s",
            "natural frequency Hz",
            "damping",
            "cancelled",
        ],
        &rows,
    );
}

fn map(output: usize, name: &str, poles: &[&Root], zeros: &[&Root], known: bool) -> Figure {
    let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / 200.0;
    let circle = Series::line("", (0..=200).map(|k| angle(k).sin()).collect())
        .over((0..=200).map(|k| angle(k).cos()).collect())
        .coloured(Colour::Soft);
    let places = |label: &str, roots: &[&Root], stroke| {
        Series::line(label, roots.iter().map(|root| root.value.im).collect())
            .over(roots.iter().map(|root| root.value.re).collect())
            .drawn(stroke)
    };
    let outermost = poles.iter().map(|root| root.value.norm());
    let reach = outermost.fold(REACH, |reach, own| reach.max(1.1 * own));
    let (near, far): (Vec<&Root>, Vec<&Root>) = zeros
        .iter()
        .copied()
        .partition(|root| root.value.norm() <= reach);
    let mut series = vec![
        places("poles", poles, Stroke::Crosses),
        places("zeros", &near, Stroke::Rings),
        circle,
    ];
    if known {
        series.push(regions(poles).coloured(Colour::Of(0)));
        series.push(regions(&near).coloured(Colour::Of(1)));
    }
    let chart = Chart {
        id: figure_id("poles", output, name),
        title: format!("poles and zeros of {name}"),
        x_label: "real part".to_owned(),
        y_label: "imaginary part".to_owned(),
        series,
        form: Form::Square,
        ..Chart::default()
    };
    let with = if known {
        ", with ellipses that hold the truth with probability .95."
    } else {
        "."
    };
    Figure::new(
        chart,
        format!(
            "Poles and zeros of {name} and the unit circle{with}{}",
            beyond(&far)
        ),
    )
}

/// The zeros that lie so far out that the map would show little else, in words.
fn beyond(far: &[&Root]) -> String {
    if far.is_empty() {
        return String::new();
    }
    let places: Vec<String> = far
        .iter()
        .filter(|root| root.value.im >= 0.0)
        .map(|root| match root.value.im {
            im if im > 0.0 => format!("{} \u{b1} {}i", digits(root.value.re, 4), digits(im, 4)),
            _ => digits(root.value.re, 4),
        })
        .collect();
    format!(" Zeros beyond the map: {}.", places.join(", "))
}

/// The regions of confidence as one curve with gaps. An ellipse that is wider than the unit circle
/// says no more than that nothing is known, and would only shrink the map.
fn regions(roots: &[&Root]) -> Series {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for root in roots {
        let Some(covariance) = root.covariance else {
            continue;
        };
        let Some(axes) = principal(&covariance) else {
            continue;
        };
        for corner in 0..=CORNERS {
            let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(CORNERS);
            let (sin, cos) = angle.sin_cos();
            x.push(root.value.re + axes[0][0] * cos + axes[1][0] * sin);
            y.push(root.value.im + axes[0][1] * cos + axes[1][1] * sin);
        }
        x.push(f64::NAN);
        y.push(f64::NAN);
    }
    Series::line("", y).over(x)
}

/// The half axes of the region of confidence; `None` where there is none to draw.
fn principal(covariance: &Matrix2<f64>) -> Option<[[f64; 2]; 2]> {
    let eigen = covariance.symmetric_eigen();
    let half = eigen.eigenvalues.map(|own| (own.max(0.0) * REGION).sqrt());
    let drawn = half.iter().all(|own| own.is_finite() && *own < 1.0) && half.max() > 0.0;
    drawn.then(|| {
        [0, 1].map(|axis| {
            let direction = eigen.eigenvectors.column(axis);
            [half[axis] * direction[0], half[axis] * direction[1]]
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every corner of the region lies at the chi-square value.
    #[test]
    fn the_region_is_that_of_95_percent() {
        let covariance = Matrix2::new(4e-4, 1e-4, 1e-4, 2e-4);
        let axes = principal(&covariance).expect("an ellipse");
        let inverse = covariance.try_inverse().expect("positive definite");
        for k in 0..12 {
            let (sin, cos) = f64::from(k).sin_cos();
            let corner = nalgebra::Vector2::new(
                axes[0][0] * cos + axes[1][0] * sin,
                axes[0][1] * cos + axes[1][1] * sin,
            );
            let distance = (corner.transpose() * inverse * corner)[0];
            assert!((distance - REGION).abs() < 1e-9, "{distance}");
        }
        assert!((REGION + 2.0 * 0.05_f64.ln()).abs() < 1e-12);
        assert!(principal(&Matrix2::zeros()).is_none());
        assert!(principal(&Matrix2::new(1e3, 0.0, 0.0, 1.0)).is_none());
    }
}
