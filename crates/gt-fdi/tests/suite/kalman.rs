//! Kalman filters: noise, gains, the filter that is not yet steady, the residual generator.

use gt_core::{Dataset, DimensionError, OperatingPoint, Signal, StateSpace};
use gt_fdi::design::{
    Bank, EivKalman, FilterError, KalmanFilter, NoiseCovariance, ResidualGenerator, ResidualTest,
    ThresholdRule, TimeVaryingKalman, calibrate,
};
use gt_fdi::{Detector, FdiError};
use nalgebra::{DMatrix, DVector};

use crate::fixtures::{TS, noise, plain_generator, plain_model, rows};

const INPUT_NOISE: [f64; 2] = [0.3, 0.1];
const OUTPUT_NOISE: [f64; 1] = [0.2];

fn plain_noise() -> NoiseCovariance {
    NoiseCovariance::errors_in_variables(&plain_model("y"), &INPUT_NOISE, &OUTPUT_NOISE).unwrap()
}

fn plain_filter() -> KalmanFilter {
    KalmanFilter::new(plain_model("y"), plain_noise()).unwrap()
}

fn scalar_model() -> StateSpace {
    let matrices = [0.5, 2.0, 1.0, 3.0].map(|value| rows([[value]]));
    StateSpace::new(matrices, TS, Signal::named(&["u"]), Signal::named(&["y"])).unwrap()
}

/// `a = 0.5, b = 2, c = 1, d = 3` with `su = 1, sy = 1`: `q = 4, r = 10, s = +6`.
#[test]
fn covariances_of_errors_in_variables_by_hand() {
    let noise = NoiseCovariance::errors_in_variables(&scalar_model(), &[1.0], &[1.0]).unwrap();
    assert_eq!((noise.q()[0], noise.r()[0], noise.s()[0]), (4.0, 10.0, 6.0));
}

/// The same model: `p = p/4 + 4 - (p/2 + 6)^2 / (p + 10)`, so `p^2 + 9.5 p - 4 = 0`.
#[test]
fn the_two_gains_are_kept_apart() {
    let eiv = EivKalman::new(scalar_model(), &[1.0], &[1.0]).unwrap();
    let filter = eiv.filter();
    let p = (9.5_f64 * 9.5 / 4.0 + 4.0).sqrt() - 9.5 / 2.0;
    // Rounding of a handful of operations.
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found}");
    close(filter.riccati().p[0], p);
    close(filter.innovation_covariance()[0], p + 10.0);
    close(filter.predictor_gain()[0], (0.5 * p + 6.0) / (p + 10.0));
    close(filter.filter_gain()[0], p / (p + 10.0));
    close(filter.filtered_covariance()[0], p - p * p / (p + 10.0));
    close(eiv.output_error_covariance()[0], 1.0 - 1.0 / (p + 10.0));
    close(eiv.input_error_covariance()[0], 1.0 - 9.0 / (p + 10.0));
    let normalised = filter.normalise(&DVector::from_vec(vec![2.0])).unwrap();
    close(normalised[0], 2.0 / (p + 10.0).sqrt());
    let wrong = filter.normalise(&DVector::zeros(2)).unwrap_err();
    assert_eq!(
        wrong.to_string(),
        "rows of the innovation: expected 1, found 2"
    );
}

fn filter_error(result: Result<NoiseCovariance, FdiError>) -> FilterError {
    match result {
        Err(FdiError::Filter(error)) => error,
        other => panic!("{other:?}"),
    }
}

#[test]
fn noise_that_is_none_is_refused() {
    let one = rows([[1.0]]);
    for (matrix, q, r, s, found) in [
        ("Q", -1.0, 1.0, 0.0, -1.0),
        ("R", 1.0, -4.0, 0.0, -1.0),
        ("[Q S; S' R]", 1.0, 4.0, 2.5, -0.25),
        ("[Q S; S' R]", 0.0, 1.0, 0.5, -0.2071067811865475),
    ] {
        let error = filter_error(NoiseCovariance::new(&(q * &one), &(r * &one), &(s * &one)));
        match error {
            FilterError::NotSemidefinite {
                matrix: name,
                found: value,
            } => {
                // Rounding of a two by two eigenvalue.
                assert!(name == matrix && (value - found).abs() < 1e-15, "{value}");
            }
            other => panic!("{other:?}"),
        }
    }
    // As far as it goes: S of full correlation.
    assert!(NoiseCovariance::new(&one, &(4.0 * &one), &(2.0 * &one)).is_ok());

    let model = plain_model("y");
    for (found, input, output, signal) in [
        (-1.0, [0.1, -1.0], 0.1, "u1"),
        (f64::INFINITY, [0.1, 0.1], f64::INFINITY, "y"),
    ] {
        let error = filter_error(NoiseCovariance::errors_in_variables(
            &model,
            &input,
            &[output],
        ));
        let signal = signal.to_owned();
        assert_eq!(error, FilterError::Variance { signal, found });
    }
    let error = NoiseCovariance::errors_in_variables(&model, &[0.1], &[0.1]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "input noise variances: expected 2, found 1"
    );
    let error = KalmanFilter::new(scalar_model(), plain_noise()).unwrap_err();
    assert_eq!(error.to_string(), "rows of Q (states): expected 1, found 2");
}

#[test]
fn noise_from_a_file_is_checked() {
    let text = serde_json::to_string(&plain_noise()).unwrap();
    let read: NoiseCovariance = serde_json::from_str(&text).unwrap();
    assert_eq!(read, plain_noise());
    let mut huge: serde_json::Value = serde_json::from_str(&text).unwrap();
    huge["q"][1] = u64::MAX.into();
    let error = serde_json::from_value::<NoiseCovariance>(huge).unwrap_err();
    let expected = "matrix: expected 18446744073709551615 x 2 entries, found 4";
    assert_eq!(error.to_string(), expected);
    let r = text.replace(&format!("{}", plain_noise().r()[0]), "-1.0");
    assert_ne!(r, text);
    let error = serde_json::from_str::<NoiseCovariance>(&r).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("R: expected a positive semidefinite")
    );
}

#[test]
fn records_of_other_sizes_are_refused() {
    let filter = plain_filter();
    let (x, u, y) = (
        DVector::zeros(2),
        DMatrix::zeros(2, 5),
        DMatrix::zeros(1, 5),
    );
    let cases = [
        (
            filter.run(&DVector::zeros(3), &u, &y),
            "rows of x0 (states)",
            2,
            3,
        ),
        (filter.run(&x, &y, &y), "rows of u (inputs)", 2, 1),
        (filter.run(&x, &u, &u), "rows of y (outputs)", 1, 2),
        (
            filter.run(&x, &u, &DMatrix::zeros(1, 4)),
            "columns of y (samples)",
            5,
            4,
        ),
    ];
    for (result, what, expected, found) in cases {
        let what = what.to_owned();
        let error = DimensionError {
            what,
            expected,
            found,
        };
        assert_eq!(result, Err(error));
    }
}

/// Covariances and gains reach the steady ones from far above and from nothing, at the square of
/// the closed loop's rate, and stay there.
#[test]
fn time_varying_filter_becomes_the_steady_one() {
    let steady = plain_filter();
    let p = &steady.riccati().p;
    let (u, y) = (DVector::zeros(2), DVector::zeros(1));
    let start = |p0: &DMatrix<f64>| {
        TimeVaryingKalman::new(plain_model("y"), plain_noise(), DVector::zeros(2), p0).unwrap()
    };
    for (p0, steps) in [
        (1e6 * DMatrix::identity(2, 2), 200),
        (DMatrix::zeros(2, 2), 200),
        (p.clone(), 0),
    ] {
        let mut filter = start(&p0);
        for _ in 0..steps {
            filter.step(&u, &y).unwrap();
        }
        let innovation = filter.step(&u, &y).unwrap();
        // Rounding: the loop forgets.
        let close = |found: &DMatrix<f64>, expected: &DMatrix<f64>| {
            let error = (found - expected).amax() / expected.amax();
            assert!(error < 1e-12, "{error:e}");
        };
        close(filter.covariance(), p);
        close(filter.predictor_gain(), steady.predictor_gain());
        close(filter.filter_gain(), steady.filter_gain());
        close(&innovation.covariance, &steady.innovation_covariance());
    }
}

/// From the steady covariance both filters do the same to a record of noise that no model made.
#[test]
fn both_filters_have_the_same_innovations() {
    let steady = plain_filter();
    let (u, y) = (
        DMatrix::from_vec(2, 300, noise(1, 600)),
        DMatrix::from_vec(1, 300, noise(2, 300)),
    );
    let x0 = DVector::from_vec(vec![1.0, -2.0]);
    let run = steady.run(&x0, &u, &y).unwrap();
    let p0 = &steady.riccati().p;
    let mut filter = TimeVaryingKalman::new(plain_model("y"), plain_noise(), x0, p0).unwrap();
    for t in 0..300 {
        let predicted = filter.state() - run.predicted.column(t);
        let filter_gain = filter.filter_gain().clone();
        let found = filter
            .step(&u.column(t).into_owned(), &y.column(t).into_owned())
            .unwrap();
        // Rounding of P; the signals are of size 1.
        let close = |error: f64| assert!(error.abs() < 1e-12, "{t}: {error:e}");
        close(predicted.amax());
        close(found.value[0] - run.innovations[t]);
        close(found.normalised[0] - run.normalised[t]);
        close(found.squared - run.normalised[t].powi(2));
        let filtered = run.predicted.column(t) + filter_gain * found.value;
        close((filtered - run.filtered.column(t)).amax());
    }
}

#[test]
fn errors_of_a_step_leave_the_filter_as_it_was() {
    let identity = DMatrix::identity(2, 2);
    let new =
        |x0, p0: &DMatrix<f64>| TimeVaryingKalman::new(plain_model("y"), plain_noise(), x0, p0);
    let mut filter = new(DVector::zeros(2), &identity).unwrap();
    let error = filter
        .step(&DVector::zeros(1), &DVector::zeros(1))
        .unwrap_err();
    assert_eq!(error.to_string(), "rows of u (inputs): expected 2, found 1");
    let error = filter
        .step(&DVector::zeros(2), &DVector::zeros(2))
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "rows of y (outputs): expected 1, found 2"
    );
    assert_eq!(filter.covariance(), &identity);

    let error = new(DVector::zeros(1), &identity).unwrap_err();
    assert_eq!(
        error.to_string(),
        "rows of x0 (states): expected 2, found 1"
    );
    let error = new(DVector::zeros(2), &-identity).unwrap_err();
    let expected = FilterError::NotSemidefinite {
        matrix: "P(0)",
        found: -1.0,
    };
    assert_eq!(error, FdiError::Filter(expected));
}

fn generator() -> ResidualGenerator {
    let point = plain_generator("y").point().clone();
    ResidualGenerator::kalman(plain_model("y"), point, plain_noise()).unwrap()
}

/// Noise round the operating point of the plain generator.
fn record(len: usize) -> Dataset {
    let draws = DMatrix::from_vec(3, len, noise(5, 3 * len));
    let u = DMatrix::from_fn(2, len, |row, t| [10.0, -3.0][row] + draws[(row, t)]);
    let y = DMatrix::from_fn(1, len, |_, t| 100.0 + draws[(2, t)]);
    Dataset::new(
        Signal::named(&["u0", "u1"]),
        Signal::named(&["y"]),
        u,
        y,
        TS,
    )
    .unwrap()
}

#[test]
fn generator_gives_the_innovations() {
    let (generator, record, filter) = (generator(), record(400), plain_filter());
    assert_eq!(generator.poles(), &[] as &[f64]);
    assert_eq!(generator.noise(), Some(&plain_noise()));
    assert_eq!(plain_generator("y").noise(), None);
    assert_eq!(
        generator.gain().as_slice(),
        filter.predictor_gain().as_slice()
    );
    let radius = filter.riccati().spectral_radius;
    // A free response of `radius^k` falls below 1e-4 at ln(1e-4) / ln(radius) or soon after.
    let expected = 1e-4_f64.ln() / radius.ln();
    let settle = generator.settle_samples() as f64;
    assert!(
        settle > 0.7 * expected && settle < 2.0 * expected,
        "{settle} {expected}"
    );

    let centred = |matrix: &DMatrix<f64>, at: &[f64]| {
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, t| {
            matrix[(i, t)] - at[i]
        })
    };
    let (u, y) = (
        centred(record.u(), &[10.0, -3.0]),
        centred(record.y(), &[100.0]),
    );
    let run = filter.run(&DVector::zeros(2), &u, &y).unwrap();
    let residual = generator.residuals(&record).unwrap();
    // Rounding of signals of size 1 taken from 100.
    assert!((residual - run.innovations).amax() < 1e-12);
}

#[test]
fn generator_is_written_and_read_with_its_noise() {
    let text = serde_json::to_string(&generator()).unwrap();
    assert_eq!(
        serde_json::from_str::<ResidualGenerator>(&text).unwrap(),
        generator()
    );
    // Files of placed poles are what they were.
    assert!(
        !serde_json::to_string(&plain_generator("y"))
            .unwrap()
            .contains("noise")
    );

    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let gain = generator().gain()[1];
    value["gain"][0][1] = (gain + 0.01).into();
    let error = serde_json::from_value::<ResidualGenerator>(value.clone()).unwrap_err();
    let expected = "generator of `y`, gain: expected that of its noise, ";
    assert!(error.to_string().starts_with(expected), "{error}");
    value["gain"][0][1] = gain.into();
    value["poles"] = serde_json::json!([0.5]);
    let error = serde_json::from_value::<ResidualGenerator>(value).unwrap_err();
    assert_eq!(error.to_string(), "poles: expected 0, one a state, found 1");
}

#[test]
fn generator_runs_in_a_bank_as_it_does_alone() {
    let (generator, record) = (generator(), record(400));
    let residual = generator.residuals(&record).unwrap();
    let rule = ThresholdRule::Margin {
        factor: 2.0,
        consecutive: 2,
    };
    let calibration = calibrate(&[residual.as_slice()], TS, rule).unwrap();
    let test = ResidualTest::modulus(&generator, &calibration);
    let bank = Bank::new("kalman", vec![generator], vec![test]).unwrap();
    let mut online = Detector::new(&bank);
    for t in 0..record.len() {
        let (u, y) = (record.u().column(t), record.y().column(t));
        let verdict = online
            .step(t as f64 * TS, u.as_slice(), y.as_slice())
            .unwrap();
        assert_eq!(verdict.channels[0].residual, residual[t]);
    }
}

#[test]
fn generator_has_the_outputs_of_its_model_and_noise_of_its_size() {
    let two = StateSpace::new(
        [
            rows([[0.5]]),
            DMatrix::zeros(1, 0),
            rows([[1.0], [1.0]]),
            DMatrix::zeros(2, 0),
        ],
        TS,
        vec![],
        Signal::named(&["y", "z"]),
    )
    .unwrap();
    let noise = || NoiseCovariance::errors_in_variables(&two, &[], &[1.0, 1.0]).unwrap();
    let point = OperatingPoint::zero(0, 2);
    let both = ResidualGenerator::kalman(two.clone(), point, noise()).unwrap();
    let filter = KalmanFilter::new(two.clone(), noise()).unwrap();
    assert_eq!(both.gain(), filter.predictor_gain());
    assert_eq!(both.outputs(), two.outputs());
    let point = OperatingPoint::zero(1, 1);
    let error = ResidualGenerator::kalman(scalar_model(), point, noise()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "rows of R (outputs): expected 1, found 2"
    );
}
