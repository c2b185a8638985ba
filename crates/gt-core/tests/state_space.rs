//! State-space models: identities between the ways of computing a response, and bad matrices.

#![allow(clippy::unwrap_used, clippy::expect_used)] // a test may stop where it fails
#![allow(clippy::float_cmp)] // values compared exactly are sums of small integers

use gt_core::{DimensionError, ModelError, Signal, StateSpace};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

fn names(prefix: &str, count: usize) -> Vec<Signal> {
    (0..count)
        .map(|index| Signal::new(format!("{prefix}{index}"), ""))
        .collect()
}

fn model(nx: usize, nu: usize, ny: usize, entries: &[f64]) -> StateSpace {
    let mut entries = entries.iter().copied().cycle();
    let mut fill = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| entries.next().unwrap());
    // Rows scaled below 1 in sum: stable by Gershgorin.
    let a = fill(nx, nx) * (0.9 / nx as f64);
    StateSpace::new(
        [a, fill(nx, nu), fill(ny, nx), fill(ny, nu)],
        0.1,
        names("u", nu),
        names("y", ny),
    )
    .expect("sizes agree")
}

proptest! {
    /// The response is the convolution of the input with the Markov parameters.
    #[test]
    fn prop_simulation_is_convolution_with_markov_parameters(
        nx in 0usize..5, nu in 1usize..3, ny in 1usize..3,
        entries in prop::collection::vec(-1.0f64..1.0, 60),
        input in prop::collection::vec(-1.0f64..1.0, 24),
    ) {
        let model = model(nx, nu, ny, &entries);
        let count = input.len() / nu;
        let u = DMatrix::from_column_slice(nu, count, &input[..nu * count]);
        let y = model.simulate(&DVector::zeros(nx), &u).expect("sizes agree");
        let markov = model.markov_parameters(count);
        for t in 0..count {
            let mut sum = DVector::zeros(ny);
            for (lag, parameter) in markov.iter().enumerate().take(t + 1) {
                sum += parameter * u.column(t - lag);
            }
            // Sums of at most 24 terms of order one: 1e-12 is a hundred roundings.
            prop_assert!((y.column(t) - sum).amax() < 1e-12);
        }
    }

    /// A stable model's free response vanishes: its spectral radius is below the bound.
    #[test]
    fn prop_spectral_radius_is_bounded_by_the_row_sums(
        nx in 1usize..7, entries in prop::collection::vec(-1.0f64..1.0, 60),
    ) {
        let radius = model(nx, 1, 1, &entries).spectral_radius().expect("converges");
        prop_assert!(radius <= 0.9 + 1e-12);
    }

    #[test]
    fn prop_json_round_trip_is_exact(
        nx in 0usize..4, entries in prop::collection::vec(-1e3f64..1e3, 40),
    ) {
        let model = model(nx, 2, 1, &entries);
        let text = serde_json::to_string(&model).expect("serialises");
        prop_assert_eq!(serde_json::from_str::<StateSpace>(&text).expect("parses"), model);
    }
}

#[test]
fn double_poles_are_finite_numbers() {
    // Similar to a Jordan block at `pole` beside 0.1: the un-scaled decomposition gave a NaN
    // imaginary part for about one in seventy of these, which `spectral_radius` then dropped.
    for k in 1..400 {
        let pole = 0.72 * f64::from(k) / 250.0;
        let t = DMatrix::from_row_slice(3, 3, &[1.0, 0.3, 0.2, 0.7, 1.1, -0.4, 0.1, 0.5, 0.9]);
        let jordan =
            DMatrix::from_row_slice(3, 3, &[pole, 1.0, 0.0, 0.0, pole, 0.0, 0.0, 0.0, 0.1]);
        let a = &t * jordan * t.clone().try_inverse().unwrap();
        let [b, c, d] = [(3, 1), (1, 3), (1, 1)].map(|(m, n)| DMatrix::zeros(m, n));
        let model = StateSpace::new([a, b, c, d], 0.08, names("u", 1), names("y", 1)).unwrap();
        // A double pole moves by the square root of the rounding.
        let radius = model.spectral_radius().unwrap();
        assert!((radius - pole.max(0.1)).abs() < 1e-6, "{pole}: {radius}");
    }
}

#[test]
fn poles_of_a_companion_matrix() {
    // (z - 0.5)(z - 0.2)(z + 0.3) = z^3 - 0.4 z^2 - 0.11 z + 0.03
    let a = DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, -0.03, 0.11, 0.4]);
    let model = StateSpace::new(
        [
            a,
            DMatrix::zeros(3, 0),
            DMatrix::zeros(0, 3),
            DMatrix::zeros(0, 0),
        ],
        1.0,
        vec![],
        vec![],
    )
    .expect("an autonomous model");
    let mut poles: Vec<f64> = model
        .poles()
        .expect("converges")
        .iter()
        .map(|pole| pole.re)
        .collect();
    poles.sort_by(f64::total_cmp);
    for (found, expected) in poles.iter().zip([-0.3, 0.2, 0.5]) {
        assert!(
            (found - expected).abs() < 1e-12,
            "{found} is not {expected}"
        );
    }
}

#[test]
fn wrong_sizes_are_named() {
    let build = |a: (usize, usize), b: (usize, usize), c: (usize, usize), d: (usize, usize)| {
        let zero = |(rows, columns): (usize, usize)| DMatrix::zeros(rows, columns);
        StateSpace::new(
            [zero(a), zero(b), zero(c), zero(d)],
            1.0,
            names("u", 1),
            names("y", 1),
        )
        .map_err(|error| error.to_string())
    };
    let cases = [
        (
            (2, 3),
            (2, 1),
            (1, 2),
            (1, 1),
            "columns of A: expected 2, found 3",
        ),
        (
            (2, 2),
            (3, 1),
            (1, 2),
            (1, 1),
            "rows of B: expected 2, found 3",
        ),
        (
            (2, 2),
            (2, 2),
            (1, 2),
            (1, 1),
            "columns of B (inputs): expected 1, found 2",
        ),
        (
            (2, 2),
            (2, 1),
            (2, 2),
            (1, 1),
            "rows of C (outputs): expected 1, found 2",
        ),
        (
            (2, 2),
            (2, 1),
            (1, 1),
            (1, 1),
            "columns of C: expected 2, found 1",
        ),
        (
            (2, 2),
            (2, 1),
            (1, 2),
            (0, 1),
            "rows of D (outputs): expected 1, found 0",
        ),
        (
            (2, 2),
            (2, 1),
            (1, 2),
            (1, 0),
            "columns of D (inputs): expected 1, found 0",
        ),
    ];
    for (a, b, c, d, message) in cases {
        assert_eq!(build(a, b, c, d), Err(message.to_owned()));
    }
    assert!(build((2, 2), (2, 1), (1, 2), (1, 1)).is_ok());
}

#[test]
fn a_file_cannot_smuggle_in_a_bad_model() {
    let good = serde_json::to_value(model(2, 1, 1, &[0.5])).expect("serialises");
    let mut bad = good.clone();
    bad["sample_time_s"] = serde_json::json!(-1.0);
    let error = serde_json::from_value::<StateSpace>(bad).expect_err("negative sample time");
    assert_eq!(
        error.to_string(),
        "sample time: expected a positive number of seconds, found -1"
    );
    // 2^63 rows of 2 would be no entries at all, modulo 2^64.
    for (a, found) in [
        (
            serde_json::json!([[0.5, 0.1, 0.2], 2, 2]),
            "2 x 2 entries, found 3",
        ),
        (
            serde_json::json!([[], 1_u64 << 63, 2]),
            "9223372036854775808 x 2 entries, found 0",
        ),
    ] {
        let mut bad = good.clone();
        bad["a"] = a;
        let error = serde_json::from_value::<StateSpace>(bad).expect_err(found);
        assert_eq!(error.to_string(), format!("matrix: expected {found}"));
    }
    let mut unknown = good;
    unknown["e"] = serde_json::json!(1);
    assert!(
        serde_json::from_value::<StateSpace>(unknown).is_err(),
        "unknown key accepted"
    );
}

#[test]
fn an_infinite_entry_is_named() {
    let error = StateSpace::new(
        [
            DMatrix::from_element(1, 1, 0.5),
            DMatrix::from_element(1, 1, f64::INFINITY),
            DMatrix::zeros(1, 1),
            DMatrix::zeros(1, 1),
        ],
        1.0,
        names("u", 1),
        names("y", 1),
    );
    assert_eq!(
        error,
        Err(ModelError::NotFinite {
            matrix: 'B',
            row: 0,
            column: 0,
            found: f64::INFINITY
        })
    );
}

#[test]
fn simulate_refuses_a_wrong_state_or_input() {
    let model = model(2, 1, 1, &[0.5]);
    assert_eq!(
        model.simulate(&DVector::zeros(3), &DMatrix::zeros(1, 4)),
        Err(DimensionError {
            what: "rows of x0 (states)".into(),
            expected: 2,
            found: 3
        })
    );
    assert_eq!(
        model.simulate(&DVector::zeros(2), &DMatrix::zeros(2, 4)),
        Err(DimensionError {
            what: "rows of u (inputs)".into(),
            expected: 1,
            found: 2
        })
    );
}
