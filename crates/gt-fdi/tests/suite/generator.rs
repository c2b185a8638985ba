//! The residual generator: identities, settling, files.

use gt_core::{DimensionError, OperatingPoint, Signal, StateSpace};
use gt_fdi::FdiError;
use gt_fdi::design::{MAX_SETTLE_SAMPLES, ResidualGenerator, SETTLE_LEVEL};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::fixtures::{
    TS, canonical, monic, noise, plain_generator, plain_model, record, transformed,
};

/// A random model with two inputs in random coordinates; its poles come along.
fn random_model() -> impl Strategy<Value = (StateSpace, Vec<f64>)> {
    let poles = prop::collection::vec(-0.8_f64..0.97, 1..6);
    (poles, any::<u64>()).prop_filter_map("T is close to singular", |(poles, seed)| {
        let nx = poles.len();
        let draws = noise(seed, nx * nx + 2 * nx + 2);
        let t =
            DMatrix::identity(nx, nx) + 0.2 * DMatrix::from_column_slice(nx, nx, &draws[..nx * nx]);
        let b = DMatrix::from_column_slice(nx, 2, &draws[nx * nx..nx * nx + 2 * nx]);
        let d = DMatrix::from_column_slice(1, 2, &draws[nx * nx + 2 * nx..]);
        let fits = t
            .clone()
            .try_inverse()
            .is_some_and(|inverse| inverse.norm() < 20.0);
        fits.then(|| (transformed(&canonical(&poles, b, d, "y"), &t), poles))
    })
}

fn data(u: DMatrix<f64>, y: DMatrix<f64>) -> gt_core::Dataset {
    gt_core::Dataset::new(
        Signal::named(&["u0", "u1"]),
        Signal::named(&["y"]),
        u,
        y,
        TS,
    )
    .unwrap()
}

proptest! {
    /// `r = eps / P(z^-1)`: the equation error of the ARX form, filtered by the placed poles. The
    /// record is noise that no model made, so that nothing cancels.
    #[test]
    fn prop_residual_is_the_equation_error_filtered_by_the_poles(
        (model, open) in random_model(),
        first in -0.5_f64..0.9,
        second in -0.5_f64..0.9,
        seed in any::<u64>(),
    ) {
        let len = 200;
        let nx = open.len();
        let u = DMatrix::from_vec(2, len, noise(seed, 2 * len));
        let y = DMatrix::from_vec(1, len, noise(!seed, len));
        let poles: Vec<f64> = (0..nx).map(|i| if i % 2 == 0 { first } else { second }).collect();

        // a(z^-1) from the poles, b(z^-1) = a(z^-1) (D + C B z^-1 + C A B z^-2 + ...).
        let falling = |roots: &[f64]| monic(roots).into_iter().rev().collect::<Vec<f64>>();
        let (a, p) = (falling(&open), falling(&poles));
        let markov = model.markov_parameters(nx + 1);
        let b = |k: usize, j: usize| (0..=k).map(|i| a[i] * markov[k - i][(0, j)]).sum::<f64>();
        let mut filtered: Vec<f64> = Vec::new();
        for t in 0..len {
            let mut value = 0.0;
            for k in 0..=nx.min(t) {
                value += a[k] * y[(0, t - k)];
                value -= b(k, 0) * u[(0, t - k)] + b(k, 1) * u[(1, t - k)];
                if k > 0 {
                    value -= p[k] * filtered[t - k];
                }
            }
            filtered.push(value);
        }

        let generator =
            ResidualGenerator::observer(model, OperatingPoint::zero(2, 1), &poles).unwrap();
        let residual = generator.residuals(&data(u, y)).unwrap().transpose();
        let expected = DMatrix::from_vec(len, 1, filtered);
        // Five poles at 0.9 amplify rounding by up to 1 / (1 - 0.9)^5, random coordinates by their
        // condition: up to 3e-9 among 20 000 cases.
        let error = (&residual - &expected).norm() / expected.norm();
        prop_assert!(error < 1e-7, "{error:e}");
    }

    /// A constant bias of the output's sensor ends up in the residual times
    /// `prod (1 - lambda_i) / prod (1 - p_i)`, lambda the model's poles.
    #[test]
    fn prop_sensor_bias_has_the_dc_gain_of_the_poles(
        (model, open) in random_model(),
        pole in -0.5_f64..0.8,
        bias in 0.1_f64..10.0,
    ) {
        let len = 600;
        let poles = vec![pole; open.len()];
        let y = DMatrix::from_element(1, len, bias);
        let generator =
            ResidualGenerator::observer(model, OperatingPoint::zero(2, 1), &poles).unwrap();
        let residual = generator.residuals(&data(DMatrix::zeros(2, len), y)).unwrap();
        let product = |roots: &[f64]| roots.iter().map(|root| 1.0 - root).product::<f64>();
        let expected = bias * product(&open) / product(&poles);
        // 0.8^600 is below rounding. The gain may be 1e-8: the tolerance is that of its terms.
        let error = (residual[len - 1] - expected).abs();
        prop_assert!(error < 1e-9 * bias * (1.0 + expected.abs() / bias), "{error:e}");
    }
}

/// What the model itself makes, round its operating point, leaves no residual.
#[test]
fn simulated_output_leaves_no_residual() {
    let generator = plain_generator("y");
    let du = DMatrix::from_vec(2, 400, noise(3, 800));
    let dy = generator.model().simulate(&DVector::zeros(2), &du).unwrap();
    let u = DMatrix::from_fn(2, 400, |row, k| du[(row, k)] + generator.point().u[row]);
    let residual = generator.residuals(&data(u, dy.add_scalar(100.0))).unwrap();
    // Values of 100 are rounded to 1.4e-14 each; gains are of order 1.
    assert!(residual.amax() < 1e-12, "{}", residual.amax());
}

#[test]
fn deadbeat_generator_settles_in_as_many_samples_as_states() {
    let generator =
        ResidualGenerator::observer(plain_model("y"), OperatingPoint::zero(2, 1), &[0.0, 0.0]);
    assert_eq!(generator.unwrap().settle_samples(), 2);
}

/// One state: `|p|^k < 1e-4`: 0.5^14 = 6.1e-5, 0.9^88 = 9.4e-5, 0.125^5 = 3.1e-5.
#[test]
fn one_state_settles_by_its_pole() {
    for (pole, samples) in [(0.5, 14), (-0.5, 14), (0.9, 88), (0.125, 5)] {
        let model = canonical(&[0.7], DMatrix::zeros(1, 2), DMatrix::zeros(1, 2), "y");
        let generator = ResidualGenerator::observer(model, OperatingPoint::zero(2, 1), &[pole]);
        assert_eq!(generator.unwrap().settle_samples(), samples, "{pole}");
    }
}

/// Checked against the powers and their singular values: at the settling the norm is below the
/// level and stays there, one sample earlier it is not.
#[test]
fn settling_is_the_last_crossing_of_the_level() {
    let generator =
        ResidualGenerator::observer(plain_model("y"), OperatingPoint::zero(2, 1), &[0.9, 0.85])
            .unwrap();
    let closed = generator.model().a() - generator.gain() * generator.model().c();
    let norm = |k: usize| {
        closed
            .pow(u32::try_from(k).unwrap())
            .singular_values()
            .max()
    };
    let settle = generator.settle_samples();
    assert!(norm(settle - 1) >= SETTLE_LEVEL, "{}", norm(settle - 1));
    assert!((settle..settle + 200).all(|k| norm(k) < SETTLE_LEVEL));
}

/// A free response that dips below the level and comes back has not settled. Poles 0.8 and -0.8
/// with the second state in units 50 times larger: even powers are `0.8^k I`, below 1e-4 from 42
/// on, odd ones have the norm `50 x 0.8^(k-1)`, which is still 1.2e-4 at 59 and 7.7e-5 at 61.
#[test]
fn a_response_that_comes_back_has_not_settled() {
    let canonical = canonical(&[0.9, 0.6], DMatrix::zeros(2, 2), DMatrix::zeros(1, 2), "y");
    let units = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 0.02]));
    let model = transformed(&canonical, &units);
    let generator = ResidualGenerator::observer(model, OperatingPoint::zero(2, 1), &[0.8, -0.8]);
    assert_eq!(generator.unwrap().settle_samples(), 60);
}

/// The paper's designs, eight poles at 0.7, 0.3 and 0.4, settle, slower ones later.
#[test]
fn eight_equal_poles_settle() {
    let open = [0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.3, 0.1];
    let settle = |pole: f64| {
        let model = canonical(&open, DMatrix::zeros(8, 2), DMatrix::zeros(1, 2), "y");
        let generator = ResidualGenerator::observer(model, OperatingPoint::zero(2, 1), &[pole; 8]);
        generator.unwrap().settle_samples()
    };
    let samples = [0.0, 0.3, 0.4, 0.7].map(settle);
    assert_eq!(samples[0], 8);
    assert!(
        samples.is_sorted_by(|left, right| left < right),
        "{samples:?}"
    );
    // One pole at 0.7 alone takes 26 samples; eight take longer, and not for ever.
    assert!(samples[3] > 26 && samples[3] < 500, "{samples:?}");
}

#[test]
fn a_pole_too_slow_to_settle_is_refused() {
    let model = canonical(&[0.7], DMatrix::zeros(1, 2), DMatrix::zeros(1, 2), "y");
    let slow = 0.999_99;
    let error = ResidualGenerator::observer(model, OperatingPoint::zero(2, 1), &[slow]);
    match error {
        Err(FdiError::DoesNotSettle {
            output,
            limit,
            spectral_radius,
            ..
        }) => {
            assert_eq!((output.as_str(), limit), ("y", MAX_SETTLE_SAMPLES));
            assert!((spectral_radius - slow).abs() < 1e-12, "{spectral_radius}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn channels_are_found_by_name() {
    let data = record(1);
    let generator = plain_generator("q");
    let ordered = data.select(&["u0", "u1"], &["q"]).unwrap();
    assert_eq!(
        generator.residuals(&data).unwrap(),
        generator.residuals(&ordered).unwrap()
    );
}

#[test]
fn records_that_do_not_fit_are_refused() {
    let generator = plain_generator("y");
    let other = gt_core::Dataset::new(
        Signal::named(&["u1"]),
        Signal::named(&["z"]),
        DMatrix::zeros(1, 3),
        DMatrix::zeros(1, 3),
        TS,
    )
    .unwrap();
    let missing = vec!["u0".to_owned(), "y".to_owned()];
    let available = vec!["u1".to_owned(), "z".to_owned()];
    assert_eq!(
        generator.residuals(&other),
        Err(FdiError::MissingTags { missing, available })
    );

    let slow = gt_core::Dataset::new(
        Signal::named(&["u0", "u1"]),
        Signal::named(&["y"]),
        DMatrix::zeros(2, 3),
        DMatrix::zeros(1, 3),
        0.1,
    )
    .unwrap();
    let what = "the record".to_owned();
    let expected = FdiError::SampleTime {
        what,
        expected_s: TS,
        found_s: 0.1,
    };
    assert_eq!(generator.residuals(&slow), Err(expected));
}

#[test]
fn operating_points_of_other_sizes_are_refused() {
    let error =
        ResidualGenerator::observer(plain_model("y"), OperatingPoint::zero(3, 1), &[0.1, 0.1]);
    let expected = DimensionError {
        what: "inputs of the operating point".to_owned(),
        expected: 2,
        found: 3,
    };
    assert_eq!(error, Err(FdiError::Dimension(expected)));

    let mut point = OperatingPoint::zero(2, 1);
    point.y[0] = f64::INFINITY;
    let error = ResidualGenerator::observer(plain_model("y"), point, &[0.1, 0.1]);
    let (output, what) = ("y".to_owned(), "operating point y");
    assert_eq!(
        error,
        Err(FdiError::NotFinite {
            output,
            what,
            found: f64::INFINITY
        })
    );
}

#[test]
fn a_generator_that_reads_its_own_output_as_an_input_is_refused() {
    let error =
        ResidualGenerator::observer(plain_model("u1"), OperatingPoint::zero(2, 1), &[0.1, 0.1]);
    let place = "signals of a generator";
    assert_eq!(
        error,
        Err(FdiError::DuplicateTag {
            place,
            tag: "u1".to_owned()
        })
    );
}

#[test]
fn files_are_checked() {
    let generator = plain_generator("y");
    let json = serde_json::to_value(&generator).unwrap();
    let back: ResidualGenerator = serde_json::from_value(json.clone()).unwrap();
    assert_eq!(back, generator);

    let error = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut changed = json.clone();
        change(&mut changed);
        serde_json::from_value::<ResidualGenerator>(changed)
            .unwrap_err()
            .to_string()
    };
    // A gain of 0 leaves the model's own poles, 0.9 and 0.6, which are stable; 10 does not.
    let unstable = error(&|v| {
        v["gain"] = serde_json::to_value(DMatrix::from_vec(2, 1, vec![10.0, 0.0])).unwrap()
    });
    assert!(
        unstable.contains("generator of `y`: expected a stable A - K C"),
        "{unstable}"
    );
    let short =
        error(&|v| v["gain"] = serde_json::to_value(DMatrix::from_vec(1, 1, vec![1.0])).unwrap());
    assert_eq!(short, "rows of the gain (states): expected 2, found 1");
    let poles = error(&|v| v["poles"] = serde_json::json!([0.4, 1.0]));
    assert_eq!(poles, "pole 1: expected a modulus below 1, found 1");
    let unknown = error(&|v| v["colour"] = serde_json::json!("red"));
    assert!(unknown.starts_with("unknown field `colour`"), "{unknown}");
}
