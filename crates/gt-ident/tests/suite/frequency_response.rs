//! The frequency response and its bands, and the covariance that they come from.

use gt_core::DimensionError;
use gt_ident::{
    Arx, ArxModel, ArxStructure, IdentError, dc_gains, frequency_response, parameter_covariance,
};
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;

use crate::common::*;
use crate::known::*;

/// Half the sampling rate of the records of `known`.
const NYQUIST_HZ: f64 = 1.0;

fn zero_covariances(model: &ArxModel) -> Vec<DMatrix<f64>> {
    let sizes = model.rows().iter().map(|row| row.terms.len());
    sizes.map(|size| DMatrix::zeros(size, size)).collect()
}

/// `C (z I - A)^-1 B + D`, solved directly.
fn of_state_space(model: &ArxModel, z: Complex<f64>) -> DMatrix<Complex<f64>> {
    let space = model.state_space().unwrap();
    let complex = |matrix: &DMatrix<f64>| matrix.map(|value| Complex::new(value, 0.0));
    let shifted = DMatrix::identity(space.nx(), space.nx()) * z - complex(space.a());
    let states = shifted.lu().solve(&complex(space.b())).unwrap();
    complex(space.c()) * states + complex(space.d())
}

/// A fitted model of any structure.
fn fitted(kind: usize, direct: bool, seed: u64) -> (ArxModel, gt_core::Dataset) {
    let mut rng = generator(seed);
    let truth = random_form(&mut rng, &[2, 1], 2, direct);
    let data = record(&mut rng, &truth, 300, 0.3);
    let nk = usize::from(!direct);
    let structure = match kind {
        0 => ArxStructure::Diagonal {
            na: 2,
            nb: vec![2, 1],
            nk: vec![nk, 2],
        },
        1 => ArxStructure::Full {
            na: 1,
            nb: vec![3],
            nk: vec![nk],
        },
        _ => ArxStructure::Canonical {
            indices: vec![2, 1],
            feedthrough: direct,
        },
    };
    (Arx::new(structure).fit(&data).unwrap(), data)
}

proptest! {
    #![proptest_config(cases(100))]

    /// Beside a pole the response is large and rounding with it: relative to its size.
    #[test]
    fn prop_response_is_that_of_the_realised_state_space(
        kind in 0_usize..3, direct: bool, seed: u64, frequency in 0.0..0.5,
    ) {
        let (model, _) = fitted(kind, direct, seed);
        let points = frequency_response(&model, &zero_covariances(&model), &[frequency]).unwrap();
        let z = Complex::from_polar(1.0, std::f64::consts::TAU * frequency);
        let expected = of_state_space(&model, z);
        let size = expected.iter().map(|value| value.norm()).fold(1.0, f64::max);
        let error = (&points[0].response - expected).map(Complex::norm).max();
        prop_assert!(error < 1e-9 * size * size, "{:e}", error);
        // Without uncertainty no error, and at frequency 0 the gain.
        prop_assert_eq!(points[0].magnitude_error.amax(), 0.0);
        let dc = dc_gains(&model, &zero_covariances(&model)).unwrap();
        let at_zero = of_state_space(&model, Complex::new(1.0, 0.0));
        for (output, row) in dc.iter().enumerate() {
            for (input, gain) in row.iter().enumerate() {
                let expected = at_zero[(output, input)].re;
                prop_assert!((gain.value - expected).abs() < 1e-9 * expected.powi(2).max(1.0));
            }
        }
    }

    /// The standard errors are those of derivatives by differences: with the covariance `h h'` of
    /// one coefficient they are the absolute derivative. Central differences of step 1e-6 leave
    /// 1e-12 of third derivatives and 1e-10 of rounding, both growing where a pole is close.
    #[test]
    fn prop_errors_are_absolute_derivatives(
        kind in 0_usize..3, seed: u64, frequency in 0.0..0.5, pick in 0_usize..100,
    ) {
        let (model, _) = fitted(kind, true, seed);
        let row = pick % model.rows().len();
        let term = (pick / 2) % model.rows()[row].terms.len();
        let mut covariances = zero_covariances(&model);
        covariances[row][(term, term)] = 1.0;
        let point = &frequency_response(&model, &covariances, &[frequency]).unwrap()[0];
        let step = 1e-6;
        let moved = |by: f64| {
            let mut value = serde_json::to_value(&model).unwrap();
            let place = &mut value["rows"][row]["terms"][term]["coefficient"];
            *place = (place.as_f64().unwrap() + by).into();
            let model: ArxModel = serde_json::from_value(value).unwrap();
            frequency_response(&model, &covariances, &[frequency]).unwrap().remove(0).response
        };
        let (above, below) = (moved(step), moved(-step));
        for (index, gain) in point.response.iter().enumerate() {
            let slope = (above[index].norm() - below[index].norm()) / (2.0 * step);
            let size = gain.norm();
            prop_assume!(size > 1e-2 && point.magnitude_error[index] < 1e2);
            let tolerance = 1e-6 * (1.0 + point.magnitude_error[index]).powi(3);
            prop_assert!((slope.abs() - point.magnitude_error[index]).abs() < tolerance);
            let turn = (above[index] / below[index]).arg() / (2.0 * step);
            prop_assert!((turn.abs() - point.phase_error_rad[index]).abs() < tolerance / size.powi(3).min(1.0));
        }
    }
}

/// The covariance against the textbook formula on a well-conditioned record.
#[test]
fn covariance_is_that_of_the_normal_equations() {
    let (model, data) = fitted(0, false, 4);
    let found = parameter_covariance(&model, &data).unwrap();
    let errors = model.equation_error(&data).unwrap();
    let point = model.operating_point();
    for (output, covariance) in found.iter().enumerate() {
        let lag = model.max_lag();
        let rows = data.len() - lag;
        let terms = &model.rows()[output].terms;
        let phi = DMatrix::from_fn(rows, terms.len(), |t, k| {
            let sample = lag + t - terms[k].lag;
            match terms[k].channel {
                gt_ident::Channel::Output(j) => data.y()[(j, sample)] - point.y[j],
                gt_ident::Channel::Input(j) => data.u()[(j, sample)] - point.u[j],
            }
        });
        let squares = errors.row(output).columns(lag, rows).norm_squared();
        let spare = (rows - terms.len()) as f64;
        let expected = phi.tr_mul(&phi).try_inverse().unwrap() * (squares / spare);
        let error = largest_difference(covariance, &expected);
        assert!(error < 1e-10 * expected.amax(), "{error:e}");
    }
}

/// Standard errors against the spread of 300 fits, whose deviations have a relative standard error
/// of 1 / sqrt(600) = 4 %: four of them, and a few per cent for the second order.
#[test]
fn errors_are_the_spread_over_monte_carlo_runs() {
    const TOLERANCE: f64 = 0.2;
    const RUNS: u32 = 300;
    let frequencies = [0.0, 0.05, 0.15, 0.4, NYQUIST_HZ];
    let mut values = vec![Vec::new(); 11];
    let mut errors = vec![0.0; 11];
    for run in 0..RUNS {
        let mut rng = generator(u64::from(run) + 40);
        let data = second_order_record(&mut rng, 1.0, 0.3, 800);
        let model = Arx::new(diagonal(2, 2)).fit(&data).unwrap();
        let covariances = parameter_covariance(&model, &data).unwrap();
        let points = frequency_response(&model, &covariances, &frequencies).unwrap();
        let mut found = Vec::new();
        for point in &points {
            found.push(point.magnitude(0, 0).unwrap());
            found.push(point.phase_rad(0, 0).unwrap());
        }
        found.push(dc_gains(&model, &covariances).unwrap()[0][0]);
        for (index, estimate) in found.iter().enumerate() {
            // The phase at half the sampling rate is 0 or pi, up to a turn.
            values[index].push(estimate.value.abs());
            errors[index] += estimate.standard_error.unwrap() / f64::from(RUNS);
        }
    }
    for (index, (values, error)) in values.iter().zip(errors).enumerate() {
        let count = f64::from(RUNS);
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let spread = (squares / count).sqrt();
        println!("{index}: mean {mean:.4}, spread {spread:.5}, error {error:.5}");
        if index % 2 == 1 && (index == 1 || index == 9) {
            // At both ends of the axis the response is real: its phase has no error.
            assert!(spread < 1e-12 && error < 1e-12);
        } else {
            assert!(
                (error / spread - 1.0).abs() < TOLERANCE,
                "{index}: {error} of {spread}"
            );
        }
    }
}

#[test]
fn requests_that_the_model_cannot_answer() {
    let (model, data) = fitted(0, false, 1);
    let covariances = parameter_covariance(&model, &data).unwrap();
    for found in [-0.1, 0.6, f64::INFINITY] {
        assert_eq!(
            frequency_response(&model, &covariances, &[0.1, found]).unwrap_err(),
            IdentError::Frequency {
                nyquist_hz: 0.5,
                found
            }
        );
    }
    assert_eq!(
        frequency_response(&model, &covariances[..1], &[0.1]).unwrap_err(),
        IdentError::Dimension(
            DimensionError::check("covariances (one per output)", 2, 1).unwrap_err()
        )
    );
    let mut wrong = covariances.clone();
    wrong[1] = DMatrix::zeros(5, 4);
    let what = "columns of covariance 1 (coefficients of the row)";
    assert_eq!(
        frequency_response(&model, &wrong, &[0.1]).unwrap_err(),
        IdentError::Dimension(DimensionError::check(what, 5, 4).unwrap_err())
    );
    let mut wrong = covariances.clone();
    wrong[0][(1, 1)] = -1.0;
    assert_eq!(
        dc_gains(&model, &wrong).unwrap_err().to_string(),
        "covariance 0: expected finite numbers, none below 0 on the diagonal, found -1"
    );
    let integrator = known_model(diagonal(1, 1), 1, &[&[1.0, 1.0]], 100);
    assert_eq!(
        dc_gains(&integrator, &zero_covariances(&integrator)).unwrap_err(),
        IdentError::ResponseAtPole { frequency_hz: 0.0 }
    );
    let short = data.rows(0..7).unwrap();
    assert_eq!(
        parameter_covariance(&model, &short)
            .unwrap_err()
            .to_string(),
        "samples: expected at least 8 for diagonal na=2 nb=2,1 nk=1,2, found 7"
    );
    // An input at rest over the record leaves its coefficients undetermined.
    let (model, data) = fitted(1, false, 1);
    let mut u = data.u().clone();
    u.row_mut(1).fill(model.operating_point().u[1]);
    let rest = gt_core::Dataset::new(signals("u", 2), signals("y", 2), u, data.y().clone(), 1.0);
    assert!(matches!(
        parameter_covariance(&model, &rest.unwrap()).unwrap_err(),
        IdentError::RankDeficient { channel, .. } if channel == "u2"
    ));
}

#[test]
fn a_response_that_is_zero_has_no_phase() {
    let model = known_model(diagonal(1, 1), 1, &[&[0.5, 0.0]], 100);
    let covariances = vec![DMatrix::identity(2, 2) * 0.01];
    let point = &frequency_response(&model, &covariances, &[0.3]).unwrap()[0];
    assert_eq!(point.magnitude(0, 0).unwrap().value, 0.0);
    assert!(point.magnitude_error[(0, 0)] > 0.0);
    assert_eq!(point.phase_rad(0, 0).unwrap().standard_error, None);
    assert!(point.phase_rad(0, 0).unwrap().interval(0.95).is_none());
    assert!(point.magnitude(1, 0).is_none());
    let [low, high] = point.magnitude(0, 0).unwrap().interval(0.95).unwrap();
    let half = 1.959963984540054 * point.magnitude_error[(0, 0)];
    assert!((high - half).abs() < 1e-12 && (low + half).abs() < 1e-12);
}
