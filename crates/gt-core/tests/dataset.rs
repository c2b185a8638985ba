//! Datasets: shapes, selection, ranges and the errors of each.

#![allow(clippy::unwrap_used, clippy::expect_used)] // a test may stop where it fails
#![allow(clippy::float_cmp)] // values compared exactly are sums of small integers

use gt_core::{DataError, Dataset, DimensionError, Signal};
use nalgebra::DMatrix;

fn record() -> Dataset {
    Dataset::new(
        Signal::named(&["u1", "u2"]),
        vec![Signal::new("y1", "K")],
        DMatrix::from_row_slice(2, 4, &[1.0, 2.0, 3.0, 4.0, 10.0, 20.0, 30.0, 40.0]),
        DMatrix::from_row_slice(1, 4, &[5.0, 6.0, 7.0, 8.0]),
        0.5,
    )
    .expect("a valid record")
}

#[test]
fn a_column_is_a_sample() {
    assert_eq!(
        record().u().as_slice(),
        [1.0, 10.0, 2.0, 20.0, 3.0, 30.0, 4.0, 40.0]
    );
}

#[test]
fn rows_keep_names_and_time() {
    let part = record().starting_at(10.0).rows(1..3).expect("rows 1 and 2");
    assert_eq!(part.len(), 2);
    assert_eq!(part.time_s(0), 10.5);
    assert_eq!(part.y().as_slice(), [6.0, 7.0]);
    assert_eq!(part.outputs()[0].unit, "K");
}

#[test]
fn an_empty_or_long_range_is_refused() {
    for (start, end) in [(2, 2), (3, 1), (0, 5)] {
        assert_eq!(
            record().rows(start..end),
            Err(DataError::Range { start, end, len: 4 })
        );
    }
}

#[test]
fn select_crosses_sides_and_keeps_order() {
    let swapped = record().select(&["y1", "u2"], &["u1"]).expect("all there");
    assert_eq!(swapped.u().row(1), record().u().row(1));
    assert_eq!(swapped.y().row(0), record().u().row(0));
    assert_eq!(swapped.inputs()[0].name, "y1");
}

#[test]
fn select_names_what_is_missing_and_what_there_is() {
    let error = record()
        .select(&["u9"], &["y1"])
        .expect_err("there is no u9");
    assert_eq!(
        error.to_string(),
        "channel `u9`: not found; there are: u1, u2, y1"
    );
    let error = record().select(&["u1"], &["u1"]).expect_err("u1 twice");
    assert_eq!(error, DataError::DuplicateName { name: "u1".into() });
}

#[test]
fn shapes_and_sample_times_are_checked() {
    let build = |nu: usize, columns: usize, sample_time_s: f64| {
        Dataset::new(
            Signal::named(&["u"]),
            Signal::named(&["y"]),
            DMatrix::zeros(nu, 3),
            DMatrix::zeros(1, columns),
            sample_time_s,
        )
    };
    assert_eq!(
        build(2, 3, 1.0),
        Err(DataError::Dimension(DimensionError {
            what: "rows of u (inputs)".into(),
            expected: 1,
            found: 2
        }))
    );
    assert_eq!(
        build(1, 4, 1.0).map_err(|error| error.to_string()),
        Err("columns of y (samples): expected 3, found 4".into())
    );
    assert_eq!(build(1, 3, 0.0), Err(DataError::SampleTime { found: 0.0 }));
    assert!(matches!(
        build(1, 3, f64::NAN),
        Err(DataError::SampleTime { .. })
    ));
}

#[test]
fn the_first_bad_sample_is_named() {
    let mut y = DMatrix::zeros(1, 4);
    y[(0, 2)] = f64::INFINITY;
    let data = Dataset::new(vec![], Signal::named(&["y"]), DMatrix::zeros(0, 4), y, 1.0)
        .expect("infinity is stored");
    assert_eq!(
        data.check_finite().map_err(|error| error.to_string()),
        Err("channel `y`, sample 2: expected a finite number, found inf".into())
    );
    assert_eq!(record().check_finite(), Ok(()));
}

#[test]
fn the_mean_is_removed_exactly() {
    let data = record();
    let centred = data.relative_to(&data.mean()).expect("same channels");
    assert_eq!(centred.mean().u.as_slice(), [0.0, 0.0]);
    assert_eq!(centred.y().as_slice(), [-1.5, -0.5, 0.5, 1.5]);
}
