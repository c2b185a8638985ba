//! What the innovations of a Kalman filter are, over many records whose noise is known.

use gt_core::{Signal, StateSpace};
use gt_fdi::design::{EivKalman, FilterRun, KalmanFilter, NoiseCovariance};
use nalgebra::{DMatrix, DVector};

use crate::fixtures::{TS, noise, rows};

const RUNS: u32 = 200;
const SAMPLES: usize = 2000;
/// The slowest filter here has a radius below 0.8, and `0.8^100` is 2e-10.
const SETTLE: usize = 100;
const LAGS: usize = 20;
/// The 95 % point of chi-square with `2 x 2 x 20` degrees of freedom.
const LIMIT: f64 = 101.879;

const INPUT_NOISE: [f64; 2] = [0.3, 0.1];
const OUTPUT_NOISE: [f64; 2] = [0.2, 0.5];

/// Two inputs, two outputs, three states; `direct` is 1 with the direct term, 0 without it.
fn model(direct: f64) -> StateSpace {
    let a = rows([[0.9, 0.2, 0.0], [-0.2, 0.8, 0.1], [0.0, 0.0, 0.6]]);
    let b = rows([[1.0, 0.0], [0.3, 0.7], [0.5, -1.0]]);
    let c = rows([[1.0, 0.0, 0.5], [0.0, 1.0, 1.0]]);
    let d = direct * rows([[0.8, 0.2], [-0.3, 1.5]]);
    let (inputs, outputs) = (Signal::named(&["u", "v"]), Signal::named(&["y", "z"]));
    StateSpace::new([a, b, c, d], TS, inputs, outputs).unwrap()
}

/// The state, and the channels without and with noise.
struct Record {
    x: DMatrix<f64>,
    clean_u: DMatrix<f64>,
    clean_y: DMatrix<f64>,
    u: DMatrix<f64>,
    y: DMatrix<f64>,
}

/// A record whose inputs are coloured and 5 wide; `factor` times the input noise variances.
fn record(model: &StateSpace, factor: f64, run: u32) -> Record {
    let len = SAMPLES + SETTLE;
    let draws =
        |stream: u64| DMatrix::from_vec(2, len, noise(10 * u64::from(run) + stream, 2 * len));
    let mut clean_u = 5.0 * draws(0);
    for t in 1..len {
        let colour = 0.7 * clean_u.column(t - 1) + 0.5 * clean_u.column(t);
        clean_u.set_column(t, &colour);
    }
    let mut x = DMatrix::zeros(3, len);
    for t in 1..len {
        let next = model.a() * x.column(t - 1) + model.b() * clean_u.column(t - 1);
        x.set_column(t, &next);
    }
    let clean_y = model.simulate(&DVector::zeros(3), &clean_u).unwrap();
    let add = |clean: &DMatrix<f64>, variances: [f64; 2], stream| {
        let mut measured = draws(stream);
        for (mut row, variance) in measured.row_iter_mut().zip(variances) {
            row *= variance.sqrt();
        }
        measured + clean
    };
    Record {
        u: add(&clean_u, INPUT_NOISE.map(|variance| factor * variance), 1),
        y: add(&clean_y, OUTPUT_NOISE, 2),
        x,
        clean_u,
        clean_y,
    }
}

/// From a state that is wrong by what nobody knows at the start.
fn run(filter: &KalmanFilter, record: &Record) -> FilterRun {
    let x0 = DVector::from_vec(vec![1.0, -1.0, 1.0]);
    filter.run(&x0, &record.u, &record.y).unwrap()
}

/// The sum of `a(t) b(t)'` after the start.
fn products(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    a.columns(SETTLE, SAMPLES) * b.columns(SETTLE, SAMPLES).transpose()
}

/// J. R. M. Hosking's multivariate portmanteau statistic (1980):
/// `N^2 sum_l tr(C_l' C_0^-1 C_l C_0^-1) / (N - l)`.
fn hosking(e: &DMatrix<f64>) -> f64 {
    let e = e.columns(SETTLE, SAMPLES);
    let n = SAMPLES as f64;
    let covariance =
        |lag: usize| e.columns(lag, SAMPLES - lag) * e.columns(0, SAMPLES - lag).transpose() / n;
    let inverse = covariance(0).try_inverse().unwrap();
    let terms = (1..=LAGS).map(|lag| {
        let c = covariance(lag);
        (c.transpose() * &inverse * c * &inverse).trace() / (n - lag as f64)
    });
    n * n * terms.sum::<f64>()
}

/// In how many of the runs the innovations pass as white.
fn white(filter: &KalmanFilter, factor: f64) -> usize {
    (0..RUNS)
        .filter(|&index| {
            let record = record(filter.model(), factor, index);
            hosking(&run(filter, &record).innovations) <= LIMIT
        })
        .count()
}

fn filter(direct: f64) -> EivKalman {
    EivKalman::new(model(direct), &INPUT_NOISE, &OUTPUT_NOISE).unwrap()
}

/// 95 % of 200 runs, give or take 3 %: twice the binomial standard deviation, 1.5 %.
#[test]
fn innovations_are_white_under_the_design_and_only_there() {
    for direct in [0.0, 1.0] {
        let eiv = filter(direct);
        let passed = white(eiv.filter(), 1.0);
        println!("D x {direct}: white in {passed} of {RUNS}");
        assert!((184..=196).contains(&passed), "{passed}");
        let passed = white(eiv.filter(), 5.0);
        assert_eq!(passed, 0, "input noise x 5, D x {direct}");
    }
}

#[test]
fn cross_term_is_needed_with_a_direct_term() {
    let model = model(1.0);
    let full = NoiseCovariance::errors_in_variables(&model, &INPUT_NOISE, &OUTPUT_NOISE).unwrap();
    assert!(full.s().amax() > 0.1);
    for (sign, s) in [("none", 0.0 * full.s()), ("the opposite", -full.s())] {
        let wrong = NoiseCovariance::new(full.q(), full.r(), &s).unwrap();
        let filter = KalmanFilter::new(model.clone(), wrong).unwrap();
        assert_eq!(white(&filter, 1.0), 0, "{sign}");
    }
}

/// The common factor of all noise does not change the gain: whiteness does not see it, the
/// normalised square does.
#[test]
fn level_of_the_noise_is_seen_by_the_normalised_square_only() {
    let eiv = EivKalman::new(
        model(1.0),
        &INPUT_NOISE.map(|variance| 2.0 * variance),
        &OUTPUT_NOISE.map(|variance| 2.0 * variance),
    )
    .unwrap();
    let right = filter(1.0);
    let difference = eiv.filter().predictor_gain() - right.filter().predictor_gain();
    // Rounding of two solutions of the same equation.
    assert!(difference.amax() < 1e-12, "{difference}");
    let record = record(&model(1.0), 1.0, 0);
    let normalised = run(eiv.filter(), &record).normalised;
    let square = products(&normalised, &normalised).trace() / SAMPLES as f64;
    // Half of ny = 2; 4 standard errors sqrt(2 / (ny N)) of one run.
    assert!(
        (square - 1.0).abs() < 4.0 * (0.5 / SAMPLES as f64).sqrt(),
        "{square}"
    );
}

/// Sums over all runs of a record's products, over their number.
fn mean(of: impl Fn(&Record, &FilterRun) -> DMatrix<f64>, eiv: &EivKalman) -> DMatrix<f64> {
    let sums = (0..RUNS).map(|index| {
        let record = record(eiv.filter().model(), 1.0, index);
        of(&record, &run(eiv.filter(), &record))
    });
    let total = sums.reduce(|sum, term| sum + term).unwrap();
    total / (f64::from(RUNS) * SAMPLES as f64)
}

/// Entries of the sample covariance of white vectors have the standard errors
/// `sqrt((L_ii L_jj + L_ij^2) / n)`; at most 4 of them away, and 1 % of the diagonal.
#[test]
fn covariance_of_the_innovations_is_that_of_the_design() {
    for direct in [0.0, 1.0] {
        let eiv = filter(direct);
        let expected = eiv.filter().innovation_covariance();
        let found = mean(|_, run| products(&run.innovations, &run.innovations), &eiv);
        let normalised = mean(|_, run| products(&run.normalised, &run.normalised), &eiv);
        let identity = DMatrix::identity(2, 2);
        for (what, found, expected) in [
            ("innovations", &found, &expected),
            ("normalised", &normalised, &identity),
        ] {
            println!("{what}, D x {direct}: {found}expected {expected}");
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let error = (found[(i, j)] - expected[(i, j)]).abs();
                let product = expected[(i, i)] * expected[(j, j)];
                let deviation = (product + expected[(i, j)].powi(2)).sqrt();
                let standard_error = deviation / (f64::from(RUNS) * SAMPLES as f64).sqrt();
                assert!(error < 4.0 * standard_error, "{what} {i} {j}: {error}");
                assert!(error < 0.01 * product.sqrt(), "{what} {i} {j}: {error}");
            }
        }
    }
}

/// Errors of every estimate have the variances of the theory to 1.5 %: errors of the state are
/// correlated over up to ten samples, so 400 000 of them say a variance to 0.7 % or better.
#[test]
fn errors_of_the_estimates_have_the_variances_of_the_theory() {
    const LIMIT: f64 = 0.015;
    for direct in [0.0, 1.0] {
        let eiv = filter(direct);
        let square = |error: DMatrix<f64>| products(&error, &error);
        let cases = [
            (
                "x(t|t-1)",
                mean(|record, run| square(&record.x - &run.predicted), &eiv),
                eiv.filter().riccati().p.clone(),
            ),
            (
                "x(t|t)",
                mean(|record, run| square(&record.x - &run.filtered), &eiv),
                eiv.filter().filtered_covariance(),
            ),
            (
                "y*(t|t)",
                mean(
                    |record, run| square(&record.clean_y - eiv.outputs(&record.y, run).unwrap()),
                    &eiv,
                ),
                eiv.output_error_covariance(),
            ),
            (
                "u*(t|t)",
                mean(
                    |record, run| square(&record.clean_u - eiv.inputs(&record.u, run).unwrap()),
                    &eiv,
                ),
                eiv.input_error_covariance(),
            ),
            (
                "u*(t|t+1)",
                mean(
                    |record, run| {
                        let smoothed = eiv.smoothed_inputs(&record.u, run).unwrap();
                        square(&record.clean_u - smoothed)
                    },
                    &eiv,
                ),
                eiv.smoothed_input_error_covariance(),
            ),
        ];
        for (what, found, expected) in cases {
            for index in 0..found.nrows() {
                let ratio = found[(index, index)] / expected[(index, index)];
                println!("{what} {index}, D x {direct}: {ratio:.4}");
                assert!((ratio - 1.0).abs() < LIMIT, "{what} {index}: {ratio}");
            }
        }
        // Estimates use the noise: better than the measurement, where there is something to use.
        for (index, variance) in OUTPUT_NOISE.into_iter().enumerate() {
            assert!(eiv.output_error_covariance()[(index, index)] < 0.95 * variance);
        }
        for (index, variance) in INPUT_NOISE.into_iter().enumerate() {
            let now = eiv.input_error_covariance()[(index, index)];
            let later = eiv.smoothed_input_error_covariance()[(index, index)];
            assert!(later < now && now <= variance);
            assert_eq!(now < variance, direct > 0.0);
        }
    }
}
