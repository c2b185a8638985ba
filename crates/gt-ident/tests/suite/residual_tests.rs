//! The residual tests: size, power, corrections, identities and refusals.

use gt_core::{DataError, Dataset};
use gt_ident::{
    Arx, ArxModel, IdentError, RecordOrigin, ResidualOptions, ResidualReport, Verdict,
    chi_square_tail, chi_square_threshold, normal_quantile, test_residuals, validate,
};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::common::*;
use crate::known::*;

const RUNS: usize = 200;
const SIGNIFICANCE: f64 = 0.05;

fn options(lags: usize, origin: RecordOrigin) -> ResidualOptions {
    ResidualOptions {
        lags,
        significance: SIGNIFICANCE,
        origin,
    }
}

fn tested(model: &ArxModel, data: &Dataset, lags: usize, origin: RecordOrigin) -> ResidualReport {
    test_residuals(model, data, &options(lags, origin)).unwrap()
}

/// Fails where the number of rejections in [`RUNS`] is not that of a test of 5 %: 10 expected,
/// standard deviation 3.1, and 3.9 of them above: over 1000 runs the rates were 3.1 to 6.9 %.
/// None at all would be a test that never rejects.
fn assert_size(rejections: usize, what: &str) {
    assert!(
        (1..=22).contains(&rejections),
        "{what}: {rejections} of {RUNS} rejected"
    );
}

/// Quantiles and tails as printed in the usual tables (Abramowitz and Stegun, tables 26.1 and
/// 26.8; NIST handbook, 1.3.6.7.4), to the digits printed.
#[test]
fn published_quantiles_of_the_normal_and_the_chi_square_distribution() {
    for (probability, expected) in [
        (0.975, 1.959964),
        (0.995, 2.575829),
        (0.9995, 3.290527),
        (0.5, 0.0),
        (0.05, -1.644854),
    ] {
        assert!((normal_quantile(probability) - expected).abs() < 1e-6);
    }
    for (degrees, probability, expected) in [
        (1.0, 0.05, 3.841),
        (2.0, 0.01, 9.210),
        (10.0, 0.05, 18.307),
        (20.0, 0.01, 37.566),
        (50.0, 0.05, 67.505),
        (100.0, 0.001, 149.449),
    ] {
        assert!((chi_square_threshold(probability, degrees) - expected).abs() < 6e-4);
        assert!(
            (chi_square_tail(expected, degrees) - probability).abs() < 2e-4 * probability.sqrt()
        );
    }
    // Two degrees of freedom are an exponential law: exact far out in the tail.
    let far = chi_square_tail(200.0, 2.0);
    assert!((far / (-100.0_f64).exp() - 1.0).abs() < 1e-12, "{far:e}");
    assert_eq!(chi_square_tail(-1.0, 3.0), 1.0);
    for nan in [
        chi_square_tail(1.0, 0.0),
        chi_square_tail(f64::NAN, 1.0),
        chi_square_threshold(0.0, 1.0),
        chi_square_threshold(0.5, -1.0),
        normal_quantile(1.0),
        normal_quantile(f64::NAN),
    ] {
        assert!(nan.is_nan());
    }
}

/// The fit takes `na` degrees of freedom where the errors alone move the output, almost none where
/// the input does, and a fresh record adds them.
#[test]
fn the_degrees_of_freedom_that_the_fit_takes() {
    let mut rng = generator(3);
    let weak = second_order_record(&mut rng, 0.001, 0.0, 4000);
    let model = Arx::new(diagonal(2, 2)).fit(&weak).unwrap();
    let report = tested(&model, &weak, 25, RecordOrigin::Fitted);
    let test = report.ljung_box[0].unwrap();
    // Two up to what 25 lags leave out and to sampling errors of 1 / sqrt(4000).
    assert!((test.correction + 2.0).abs() < 0.1, "{}", test.correction);
    assert_eq!(test.degrees_of_freedom, 25.0 + test.correction);
    // A projection takes mean and variance alike.
    assert!((test.scale - 1.0).abs() < 0.02, "{}", test.scale);
    // One output: the joint test is that of Box and Pierce with the weights of Ljung and Box.
    let joint = report.hosking.unwrap();
    assert!((joint.correction - test.correction).abs() < 1e-9);
    let count = report.rows as f64;
    assert!((joint.statistic * (count + 2.0) / count / test.statistic - 1.0).abs() < 1e-9);
    let fresh = tested(&model, &weak, 25, RecordOrigin::Fresh);
    let fresh = fresh.ljung_box[0].unwrap();
    // Two directions of variance 2 among 23 of variance 1: mean 27, half the variance 31.
    assert!((fresh.scale - 31.0 / 27.0).abs() < 0.02, "{}", fresh.scale);
    assert!((fresh.degrees_of_freedom - 27.0 * 27.0 / 31.0).abs() < 0.1);

    let strong = second_order_record(&mut rng, 10.0, 0.0, 4000);
    let model = Arx::new(diagonal(2, 2)).fit(&strong).unwrap();
    let test = tested(&model, &strong, 25, RecordOrigin::Fitted).ljung_box[0].unwrap();
    assert!(
        (-0.2..0.0).contains(&test.correction),
        "{}",
        test.correction
    );
    // The regressors u(t-1), u(t-2) leave 23 of the 25 past inputs to test.
    let report = tested(&model, &strong, 25, RecordOrigin::Fitted);
    let independence = report.independence[0].unwrap();
    assert_eq!(independence.degrees_of_freedom, 23.0);
    assert_eq!(independence.correction, -2.0);
    let cross = report.cross_correlation("y1", "u1").unwrap();
    assert_eq!(cross.lags, (-25..=25).collect::<Vec<i64>>());
    for lag in [1, 2] {
        // Rows before sample 2 are missing from one side of the sum only.
        assert!(cross.values[25 + lag].abs() < 1e-9, "lag {lag}");
    }
    let fresh = tested(&model, &strong, 25, RecordOrigin::Fresh);
    assert_eq!(fresh.independence[0].unwrap().degrees_of_freedom, 25.0);
}

/// Counts rejections of Ljung-Box, independence, feedback and one autocorrelation band.
fn rejections(gain: f64, pole: f64, origin: RecordOrigin, seed: u64) -> [usize; 4] {
    let mut counts = [0; 4];
    for run in 0..RUNS as u64 {
        let mut rng = generator(seed + run);
        let training = second_order_record(&mut rng, gain, pole, 500);
        let model = Arx::new(diagonal(2, 2)).fit(&training).unwrap();
        let data = match origin {
            RecordOrigin::Fitted => training,
            RecordOrigin::Fresh => second_order_record(&mut rng, gain, pole, 500),
        };
        let report = tested(&model, &data, 15, origin);
        let cross = &report.cross_correlations[0];
        let auto = &report.autocorrelations[0];
        let found = [
            report.ljung_box[0].unwrap().rejects(SIGNIFICANCE),
            cross.independence.unwrap().rejects(SIGNIFICANCE),
            cross.feedback.unwrap().rejects(SIGNIFICANCE),
            auto.values[1].abs() > auto.bands[1],
        ];
        for (count, rejected) in counts.iter_mut().zip(found) {
            *count += usize::from(rejected);
        }
    }
    counts
}

#[test]
fn tests_of_a_right_model_keep_their_size() {
    let mut seed = 20_000;
    for (name, gain, pole) in [
        ("strong white input", 5.0, 0.0),
        ("weak coloured input", 0.3, 0.9),
        ("no input to speak of", 0.01, 0.5),
    ] {
        for origin in [RecordOrigin::Fitted, RecordOrigin::Fresh] {
            let counts = rejections(gain, pole, origin, seed);
            seed += 10_000;
            println!("{name}, {origin:?}: {counts:?} of {RUNS}");
            for (what, count) in ["Ljung-Box", "independence", "feedback", "band at lag 2"]
                .iter()
                .zip(counts)
            {
                assert_size(count, &format!("{name}, {origin:?}, {what}"));
            }
        }
    }
}

/// A model known beforehand whose errors are coloured and independent of a coloured input: the
/// independence tests keep their size, the whiteness tests reject always.
#[test]
fn independence_keeps_its_size_where_errors_and_input_are_coloured() {
    let model = known_model(diagonal(2, 2), 1, &[&[1.5, -0.7, 1.0, 0.5]], 1_000_000);
    let mut counts = [0; 3];
    for run in 0..RUNS as u64 {
        let mut rng = generator(5000 + run);
        let u = coloured(&normal_matrix(&mut rng, 1, 1200), 0.8);
        let e = coloured(&normal_matrix(&mut rng, 1, 1200), 0.6);
        let data = settled(&second_order(1.0), &u, &e);
        let report = tested(&model, &data, 15, RecordOrigin::Fresh);
        let cross = &report.cross_correlations[0];
        // The band holds at each lag: lag 3 stands for them.
        let found = [
            cross.independence.unwrap().rejects(SIGNIFICANCE),
            cross.values[15 + 3].abs() > cross.band,
            !report.ljung_box[0].unwrap().rejects(SIGNIFICANCE),
        ];
        for (count, rejected) in counts.iter_mut().zip(found) {
            *count += usize::from(rejected);
        }
    }
    println!("coloured errors: {counts:?} of {RUNS}");
    assert_size(counts[0], "independence");
    assert_size(counts[1], "band");
    assert_eq!(counts[2], 0);
}

/// Two outputs with correlated errors in a full structure.
#[test]
fn joint_whiteness_keeps_its_size_and_sees_what_each_output_alone_does_not() {
    let (mut size, mut joint, mut single) = (0, 0, 0);
    for run in 0..RUNS as u64 {
        let mut rng = generator(8000 + run);
        let form = random_form(&mut generator(4), &[1, 1], 1, false);
        let u = normal_matrix(&mut rng, 1, 700);
        let mut e = normal_matrix(&mut rng, 2, 700);
        for t in 0..700 {
            e[(1, t)] = 0.8 * e[(0, t)] + 0.6 * e[(1, t)];
        }
        let data = settled(&form, &u, &e);
        let model = Arx::new(full(1, 1)).fit(&data).unwrap();
        let report = tested(&model, &data, 10, RecordOrigin::Fitted);
        size += usize::from(report.hosking.unwrap().rejects(SIGNIFICANCE));
        // Each error white, the second the first three samples later: only a joint test sees it.
        for t in (3..700).rev() {
            e[(1, t)] += e[(0, t - 3)] * 0.3;
        }
        let data = settled(&form, &u, &e);
        let model = Arx::new(full(1, 1)).fit(&data).unwrap();
        let report = tested(&model, &data, 10, RecordOrigin::Fitted);
        joint += usize::from(report.hosking.unwrap().rejects(SIGNIFICANCE));
        let alone = |index: usize| report.ljung_box[index].unwrap().rejects(SIGNIFICANCE);
        single += usize::from(alone(0));
    }
    println!("Hosking: size {size}, power {joint}, first output alone {single} of {RUNS}");
    assert_size(size, "Hosking");
    // The correlation of 0.3 at lag 3 is seven standard deviations at 500 samples.
    assert!(joint > 195, "{joint}");
    assert!(single < 40, "{single}");
}

/// Models that lack something are rejected every time, by the test that should.
#[test]
fn wrong_models_are_rejected() {
    for run in 0..20 {
        let mut rng = generator(300 + run);
        let data = second_order_record(&mut rng, 1.0, 0.5, 1000);
        let other = second_order_record(&mut rng, 1.0, 0.5, 1000);
        // An order too low.
        let low = Arx::new(diagonal(1, 1)).fit(&data).unwrap();
        let report = tested(&low, &other, 20, RecordOrigin::Fresh);
        assert!(report.ljung_box[0].unwrap().p_value < 1e-6);
        let verdict = &validate(&low, &other).unwrap().residuals.unwrap();
        assert_eq!(verdict.outputs[0].whiteness, Verdict::Rejected);
        assert_eq!(verdict.joint_whiteness, Verdict::Rejected);
        // A missing input lag: the input is found out also on the record of the fit.
        let short = Arx::new(diagonal(2, 1)).fit(&data).unwrap();
        let report = tested(&short, &data, 20, RecordOrigin::Fitted);
        assert_eq!(report.verdict().outputs[0].independence, Verdict::Rejected);
        // The right one passes at a level that 20 runs of 2 tests cannot miss by chance.
        let right = Arx::new(diagonal(2, 2)).fit(&data).unwrap();
        let report = tested(&right, &other, 20, RecordOrigin::Fresh);
        assert!(report.ljung_box[0].unwrap().p_value > 1e-5);
        assert!(report.independence[0].unwrap().p_value > 1e-5);
    }
}

/// `u(t) = -0.5 y(t) + w(t)`: independent of the past, not of the future.
#[test]
fn feedback_shows_beside_the_past_only() {
    let mut rng = generator(17);
    let (e, w) = (
        normal_matrix(&mut rng, 1, 2000),
        normal_matrix(&mut rng, 1, 2000),
    );
    let (mut u, mut y) = (DMatrix::zeros(1, 2000), DMatrix::zeros(1, 2000));
    for t in 1..2000 {
        y[t] = 0.8 * y[t - 1] + u[t - 1] + e[t];
        u[t] = w[t] - 0.5 * y[t];
    }
    let data = dataset(u, y);
    let model = Arx::new(diagonal(1, 1)).fit(&data).unwrap();
    let report = tested(&model, &data, 10, RecordOrigin::Fitted);
    let cross = &report.cross_correlations[0];
    assert!(cross.feedback.unwrap().p_value < 1e-10);
    assert!(cross.independence.unwrap().p_value > 1e-3);
    // u(t) holds -0.5 e(t): a correlation of about -0.4, its deviation is 0.02.
    assert!(cross.values[10] < -5.0 * cross.band, "lag 0");
}

#[test]
fn requests_that_the_residuals_do_not_allow() {
    let mut rng = generator(5);
    let data = second_order_record(&mut rng, 1.0, 0.0, 60);
    let model = Arx::new(diagonal(2, 2)).fit(&data).unwrap();
    let refuse = |data: &Dataset, options: &ResidualOptions| {
        test_residuals(&model, data, options).unwrap_err()
    };
    for found in [0, 2, 58, usize::MAX] {
        let error = refuse(&data, &options(found, RecordOrigin::Fresh));
        assert_eq!(
            error,
            IdentError::ResidualLags {
                lowest: 3,
                highest: 57,
                found
            }
        );
    }
    assert_eq!(
        refuse(&data, &options(58, RecordOrigin::Fitted)).to_string(),
        "option lags: expected 3 to 57, found 58"
    );
    for found in [0.0, 1.0, -0.1] {
        let wrong = ResidualOptions {
            significance: found,
            ..ResidualOptions::default()
        };
        assert_eq!(refuse(&data, &wrong), IdentError::Significance { found });
    }
    let nan = ResidualOptions {
        significance: f64::NAN,
        ..ResidualOptions::default()
    };
    assert!(matches!(
        refuse(&data, &nan),
        IdentError::Significance { .. }
    ));

    let short = data.rows(0..8).unwrap();
    assert_eq!(
        refuse(&short, &options(3, RecordOrigin::Fresh)).to_string(),
        "samples: expected at least 9 for diagonal na=2 nb=2 nk=1, found 8"
    );
    // Validation says so without failing.
    assert_eq!(validate(&model, &short).unwrap().residuals, None);
    let mut y = data.y().clone();
    y[(0, 7)] = f64::INFINITY;
    assert_eq!(
        refuse(&dataset(data.u().clone(), y), &ResidualOptions::default()),
        IdentError::Data(DataError::NotFinite {
            channel: "y1".to_owned(),
            sample: 7,
            found: f64::INFINITY
        })
    );
    let report = tested(&model, &data, 5, RecordOrigin::Fitted);
    for (output, input, name) in [("y2", "u1", "y2"), ("y1", "y1", "y1")] {
        let error = report.cross_correlation(output, input).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
        assert!(matches!(
            error,
            IdentError::Data(DataError::UnknownChannel { .. })
        ));
    }
    // Data that the model explains leave nothing to test.
    let model = known_model(diagonal(2, 2), 1, &[&[1.5, -0.7, 1.0, 0.5]], 100);
    let u = normal_matrix(&mut rng, 1, 400);
    let exact = settled(&second_order(1.0), &u, &DMatrix::zeros(1, 400));
    assert_eq!(
        test_residuals(&model, &exact, &ResidualOptions::default()).unwrap_err(),
        IdentError::NoResidual {
            output: "y1".to_owned()
        }
    );
    assert_eq!(validate(&model, &exact).unwrap().residuals, None);
}

/// An input at rest is no reason to fail: there is nothing to test about it.
#[test]
fn an_input_that_rests_is_untested() {
    let mut rng = generator(6);
    let training = second_order_record(&mut rng, 1.0, 0.0, 300);
    let model = Arx::new(diagonal(2, 2)).fit(&training).unwrap();
    let e = normal_matrix(&mut rng, 1, 500);
    let data = settled(&second_order(1.0), &DMatrix::zeros(1, 500), &e);
    let report = tested(&model, &data, 10, RecordOrigin::Fresh);
    assert_eq!(report.independence, vec![None]);
    assert_eq!(report.cross_correlations[0].band, 0.0);
    assert_eq!(report.verdict().outputs[0].independence, Verdict::Untested);
    assert_ne!(report.verdict().outputs[0].whiteness, Verdict::Untested);
}

proptest! {
    #![proptest_config(cases(40))]

    /// Units do not matter: statistics of a record in other units, fitted anew, are the same.
    /// 1e-6: the condition of the regressors, below 1e5 here, times rounding.
    #[test]
    fn prop_tests_do_not_depend_on_units(seed: u64, scale_u in 1e-3..1e3, scale_y in 1e-3..1e3) {
        let mut rng = generator(seed);
        let form = random_form(&mut rng, &[1, 2], 2, false);
        let u = coloured(&normal_matrix(&mut rng, 2, 400), 0.5);
        let e = normal_matrix(&mut rng, 2, 400);
        let data = settled(&form, &u, &e);
        let scaled = dataset(data.u() * scale_u, data.y() * scale_y);
        let report = |data: &Dataset| {
            let model = Arx::new(full(2, 2)).fit(data).unwrap();
            tested(&model, data, 12, RecordOrigin::Fitted)
        };
        let (left, right) = (report(&data), report(&scaled));
        let all = |report: &ResidualReport| -> Vec<f64> {
            let tests = report.ljung_box.iter().chain(&report.independence).chain([&report.hosking]);
            tests.map(|test| test.unwrap().statistic).collect()
        };
        for (a, b) in all(&left).into_iter().zip(all(&right)) {
            prop_assert!((a - b).abs() < 1e-6 * a.abs().max(1.0), "{} and {}", a, b);
        }
        for test in left.ljung_box.iter().chain(&left.independence) {
            prop_assert!((0.0..=1.0).contains(&test.unwrap().p_value));
        }
    }
}
