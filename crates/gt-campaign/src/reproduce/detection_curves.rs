//! Detection over the size of a fault, at each level of noise.

use gtfdi::plant::NoiseLevel;

use super::limits::Table10Row;
use crate::report::chart::{Chart, Series};
use crate::report::{Figure, Scale};

/// Points of a curve.
const POINTS: u32 = 200;
/// By how much the curves go on beyond the smallest and the largest size.
const BEYOND: f64 = 1.2;

/// The levels of noise in the order of a row's numbers, with their names in a legend.
pub(super) const LEVELS: [(NoiseLevel, &str); 3] = [
    (NoiseLevel::None, "no noise"),
    (NoiseLevel::Table8, "Table 8"),
    (NoiseLevel::Tables4And5, "Tables 4 and 5"),
];

/// The share of runs in which a fault of a size is found within the delay, from the smallest size
/// found in each run (ascending, infinite where none was), a curve a level of noise; `None` where
/// nothing was found at any.
pub(super) fn detection_curves(row: &Table10Row, smallest: [Option<&[f64]>; 3]) -> Option<Figure> {
    let found = smallest.into_iter().flatten().flatten();
    let [low, high] = found
        .filter(|size| size.is_finite())
        .fold([f64::INFINITY, 0.0], |[low, high], size| {
            [size.min(low), size.max(high)]
        });
    if high <= 0.0 {
        return None;
    }
    let [from, to] = [(low / BEYOND).ln(), (high * BEYOND).ln()];
    let x: Vec<f64> = (0..=POINTS)
        .map(|point| (from + (to - from) * f64::from(point) / f64::from(POINTS)).exp())
        .collect();
    let curves = LEVELS.iter().zip(smallest);
    let curves = curves.filter_map(|((_, name), sizes)| Some((*name, sizes?)));
    let curves = curves.map(|(name, sizes)| {
        let share = |size: &f64| {
            sizes.partition_point(|smallest| smallest <= size) as f64 / sizes.len().max(1) as f64
        };
        Series::line(name, x.iter().map(share).collect())
    });
    let ambient = if row.ambient_varies { "_ambient" } else { "" };
    let varying = if row.ambient_varies {
        ", ambient varying"
    } else {
        ""
    };
    Some(Figure {
        chart: Chart {
            id: format!(
                "detection_{}{ambient}_case{}_{:.0}s",
                row.map_set, row.case, row.delay_s
            ),
            title: format!(
                "case {}: found within {:.0} s, {} maps{varying}",
                row.case, row.delay_s, row.map_set
            ),
            x_label: format!("size [{}]", row.unit),
            y_label: "share of runs".to_owned(),
            series: curves.collect(),
            x,
            limits: vec![row.detection_probability],
            x_scale: Scale::Logarithmic,
            ..Chart::default()
        },
        caption: format!(
            "Share of {} seeded runs in which {}, grown evenly to a size within {:.0} s, is found \
             within them, over that size; dashed: {}, where Table 10 reads its sizes.",
            row.runs,
            row.name.replace('_', " "),
            row.delay_s,
            row.detection_probability
        ),
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "shares of four runs are exact")]

    use super::*;

    fn row() -> Table10Row {
        Table10Row {
            case: 2,
            name: "some_fault".into(),
            map_set: "paper".into(),
            ambient_varies: true,
            output: "p7".into(),
            delay_s: 30.0,
            noise_free_percent: None,
            noisy_percent: None,
            noisy_accuracy_percent: None,
            sizes: [None; 3],
            unit: "%".into(),
            effect_percent: None,
            paper_percent: None,
            arl0_h: 24.0,
            detection_probability: 0.95,
            runs: 4,
            interval: [None; 3],
            paper_scheme_percent: [None; 3],
            mean_delay_s: [None; 3],
            delay_bound_s: [None; 3],
        }
    }

    /// A curve at a size is the share of runs whose smallest size is not above it; a run without
    /// one holds its curve below 1.
    #[test]
    fn curves_are_shares_of_runs() {
        let figure = detection_curves(
            &row(),
            [
                None,
                Some(&[0.1, 0.2, 0.4, f64::INFINITY]),
                Some(&[1.0, 2.0, 3.0, 4.0]),
            ],
        )
        .expect("there are sizes");
        let chart = &figure.chart;
        assert_eq!(chart.id, "detection_paper_ambient_case2_30s");
        let labels: Vec<&str> = chart.series.iter().map(|own| own.label.as_str()).collect();
        assert_eq!(labels, ["Table 8", "Tables 4 and 5"]);
        let at = |size: f64, curve: usize| {
            let place = chart.x.partition_point(|x| *x < size);
            chart.series[curve].values[place]
        };
        for (size, first, second) in [(0.15, 0.25, 0.0), (0.3, 0.5, 0.0), (2.5, 0.75, 0.5)] {
            assert_eq!([at(size, 0), at(size, 1)], [first, second], "{size}");
        }
        assert_eq!(
            [chart.series[0].values[0], chart.series[1].values[0]],
            [0.0; 2]
        );
        assert_eq!(
            [chart.series[0].values[200], chart.series[1].values[200]],
            [0.75, 1.0]
        );
    }

    #[test]
    fn what_is_never_found_has_no_figure() {
        assert!(detection_curves(&row(), [Some(&[f64::INFINITY]), None, None]).is_none());
    }
}
