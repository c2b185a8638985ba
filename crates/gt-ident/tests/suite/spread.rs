//! Ridge, standard errors, correlated equation errors, index sets, and the words of errors.

use gt_core::Dataset;
use gt_ident::{
    Arx, ArxModel, ArxStructure, CanonicalForm, EquationErrors, IdentError, OrderKind, SolvedBy,
    index_table, order_table,
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::common::*;

fn full(na: usize, nb: usize, nk: usize) -> ArxStructure {
    ArxStructure::Full {
        na,
        nb: vec![nb],
        nk: vec![nk],
    }
}

fn canonical(indices: &[usize]) -> ArxStructure {
    ArxStructure::Canonical {
        indices: indices.to_vec(),
        feedthrough: false,
    }
}

fn theta(model: &ArxModel, output: usize) -> DVector<f64> {
    let terms = &model.rows()[output].terms;
    DVector::from_iterator(terms.len(), terms.iter().map(|term| term.coefficient))
}

/// Indices (2, 1) with the output 1 at lag 0 in the row of output 2: coefficients
/// (0.4, 0.3, 0.4, 2) of y1(t), y1(t-1), y2(t-1), u(t-1).
fn recursive() -> CanonicalForm {
    CanonicalForm::new(
        vec![2, 1],
        vec![
            vec![vec![-0.5, 1.0], vec![0.1]],
            vec![vec![0.3, 0.4], vec![0.4]],
        ],
        vec![vec![vec![1.0], vec![0.5]], vec![vec![2.0]]],
    )
    .unwrap()
}

/// A record of [`recursive`] with equation errors of unit variance and the given correlation.
fn correlated_record(seed: u64, samples: usize, correlation: f64) -> Dataset {
    let mut rng = generator(seed);
    let u = normal_matrix(&mut rng, 1, samples);
    let mut e = normal_matrix(&mut rng, 2, samples);
    for t in 0..samples {
        e[(1, t)] = correlation * e[(0, t)] + (1.0 - correlation * correlation).sqrt() * e[(1, t)];
    }
    let y = difference_equation(&recursive(), &u, &e);
    Dataset::new(signals("u", 1), signals("y", 2), u, y, 1.0).unwrap()
}

/// The true coefficients of row 2 in the order of its terms.
fn row_two() -> DVector<f64> {
    DVector::from_vec(vec![0.4, 0.3, 0.4, 2.0])
}

/// With a correlation of 0.8 least squares is far off however long the record; estimated jointly,
/// 2e5 samples leave errors within five of their standard errors (a chance of 1e-6 each), which
/// are below 0.01.
#[test]
fn correlated_equation_errors_do_not_bias_the_joint_estimate() {
    let data = correlated_record(11, 200_000, 0.8);
    let arx = Arx::new(canonical(&[2, 1]));
    let alone = theta(&arx.fit(&data).unwrap(), 1);
    // Another implementation measured (0.74, 0.18, 0.29, 1.83) on such a record.
    let biased = DVector::from_vec(vec![0.74, 0.18, 0.29, 1.83]);
    assert!((&alone - &biased).amax() < 0.02, "{alone}");
    let joint = arx
        .equation_errors(EquationErrors::Correlated)
        .fit_in_full(&[&data])
        .unwrap();
    assert_eq!(joint.solved_by, [SolvedBy::Joint; 2]);
    let error = theta(&joint.model, 1) - row_two();
    let errors = &joint.model.standard_errors().unwrap()[1];
    for (error, deviation) in error.iter().zip(errors) {
        assert!(*deviation < 0.01, "{errors:?}");
        assert!(error.abs() < 5.0 * deviation, "{error} of {deviation}");
    }
    // Unit variances; 2e5 samples leave 0.3 % of deviation.
    for row in joint.model.rows() {
        assert!((row.residual_variance - 1.0).abs() < 0.02);
    }
}

/// Standard errors are the spread of the estimates: over 400 runs a sample deviation is within
/// 20 % of the true one (its own deviation is 1/sqrt(800) = 3.5 %, and the mean of the squared
/// standard errors adds less), for least squares on uncorrelated errors and for the joint estimate.
#[test]
fn standard_errors_are_the_spread_of_the_estimates() {
    for (errors, correlation) in [
        (EquationErrors::Uncorrelated, 0.0),
        (EquationErrors::Correlated, 0.8),
    ] {
        let runs = 400;
        let mut squares = DVector::zeros(4);
        let mut predicted = DVector::zeros(4);
        for run in 0..runs {
            let data = correlated_record(5000 + run, 1000, correlation);
            let model = Arx::new(canonical(&[2, 1]))
                .equation_errors(errors)
                .fit(&data)
                .unwrap();
            let error = theta(&model, 1) - row_two();
            squares += error.component_mul(&error);
            let deviations = DVector::from_vec(model.standard_errors().unwrap()[1].clone());
            predicted += deviations.component_mul(&deviations);
        }
        let ratios = squares
            .component_div(&predicted)
            .map(|ratio: f64| ratio.sqrt());
        for ratio in &ratios {
            assert!((ratio - 1.0).abs() < 0.2, "{errors:?}: {ratios}");
        }
    }
}

/// Without an excluded lag that moves the other output there is nothing to identify the term at
/// lag 0 from; without noise the joint estimate is the exact one.
#[test]
fn joint_estimation_says_what_it_cannot_identify() {
    let mut rng = generator(13);
    let quiet = {
        let u = normal_matrix(&mut rng, 1, 400);
        let y = difference_equation(&recursive(), &u, &DMatrix::zeros(2, 400));
        Dataset::new(signals("u", 1), signals("y", 2), u, y, 1.0).unwrap()
    };
    let joint = |data: &Dataset| {
        Arx::new(canonical(&[2, 1]))
            .equation_errors(EquationErrors::Correlated)
            .fit(data)
    };
    // Exact data: only the means, which the transient moves, are not zero.
    let exact = Arx::new(canonical(&[2, 1])).fit(&quiet).unwrap();
    let found = joint(&quiet).unwrap();
    assert!((theta(&found, 1) - theta(&exact, 1)).amax() < 0.05);
    // y1 of order one: y1(t) is a combination of y1(t-1), u(t-1) and its error, so that only
    // chance in the record tells its instrument from them.
    let u = normal_matrix(&mut rng, 1, 400);
    let mut y = DMatrix::zeros(2, 400);
    for t in 1..400 {
        y[(0, t)] = 0.5 * y[(0, t - 1)] + u[t - 1];
        y[(1, t)] = 0.4 * y[(1, t - 1)] + y[(0, t)];
    }
    let weak = Dataset::new(signals("u", 1), signals("y", 2), u, y, 1.0).unwrap();
    let zero = Arx::new(canonical(&[2, 1])).centre(gt_ident::Centre::Zero);
    let error = zero
        .equation_errors(EquationErrors::Correlated)
        .fit(&weak)
        .unwrap_err();
    assert!(
        matches!(&error, IdentError::RankDeficient { output, .. } if output == "y1" || output == "y2"),
        "{error}"
    );
    assert_eq!(
        Arx::new(canonical(&[2, 1]))
            .ridge(0.5)
            .equation_errors(EquationErrors::Correlated)
            .fit(&quiet)
            .unwrap_err()
            .to_string(),
        "option ridge: expected 0 with correlated equation errors, found 0.5"
    );
}

proptest! {
    #![proptest_config(cases(60))]

    /// The ridge by its definition: the gradient of what it minimises is zero, its covariance is
    /// the sandwich. A condition below 1e3 leaves rounding below 1e-9.
    #[test]
    fn prop_ridge_is_its_definition(seed: u64, exponent in -6_i32..3) {
        let mut rng = generator(seed);
        let truth = random_form(&mut rng, &[2], 2, false);
        let data = record(&mut rng, &truth, 200, 0.5);
        let weight = 10_f64.powi(exponent);
        let fit = Arx::new(full(3, 3, 1)).ridge(weight).fit_in_full(&[&data]).unwrap();
        let mean = data.mean();
        let terms = &fit.model.rows()[0].terms;
        let design = DMatrix::from_fn(197, 9, |row, column| {
            let term = terms[column];
            let t = 3 + row - term.lag;
            match term.channel {
                gt_ident::Channel::Output(_) => data.y()[t] - mean.y[0],
                gt_ident::Channel::Input(index) => data.u()[(index, t)] - mean.u[index],
            }
        });
        let target = DVector::from_fn(197, |row, _| data.y()[row + 3] - mean.y[0]);
        let gram = design.tr_mul(&design);
        let penalty = DMatrix::from_diagonal(&(gram.diagonal() * weight));
        let coefficients = theta(&fit.model, 0);
        let gradient = (&gram + &penalty) * &coefficients - design.tr_mul(&target);
        prop_assert!(gradient.norm() < 1e-9 * design.tr_mul(&target).norm());
        let rss = (&target - &design * &coefficients).norm_squared();
        let variance = fit.model.rows()[0].residual_variance;
        prop_assert!((variance * 197.0 - rss).abs() < 1e-9 * rss);
        let inverse = (&gram + &penalty).try_inverse().unwrap();
        let covariance = &inverse * &gram * &inverse * (rss / 188.0);
        let gap = (&fit.covariance[0] - &covariance).norm() / covariance.norm();
        prop_assert!(gap < 1e-9, "{gap:e}");
    }
}

#[test]
fn ridges_out_of_range_and_of_dependent_regressors() {
    let mut rng = generator(3);
    let u = normal_matrix(&mut rng, 1, 100);
    let twice = DMatrix::from_fn(2, 100, |_, t| u[t]);
    let y = normal_matrix(&mut rng, 1, 100);
    let data = Dataset::new(signals("u", 2), signals("y", 1), twice, y, 1.0).unwrap();
    let arx = Arx::new(full(1, 1, 1));
    for found in [-1.0, f64::INFINITY] {
        let error = arx.clone().ridge(found).fit(&data).unwrap_err();
        assert_eq!(error, IdentError::Ridge { found });
    }
    assert!(arx.clone().ridge(f64::NAN).fit(&data).is_err());
    assert_eq!(
        arx.fit(&data).unwrap_err().to_string().split("e1").next(),
        Some("output `y1`: expected independent regressors (condition at most 1")
    );
    // Equal columns share the coefficient; the condition is that of [1 1; 1 1] with the ridge on
    // its diagonal, about sqrt((2 + 0.01) / 0.01) = 14.
    let model = arx.clone().ridge(0.01).fit(&data).unwrap();
    let terms = &model.rows()[0].terms;
    assert!((terms[1].coefficient - terms[2].coefficient).abs() < 1e-12);
    assert!((model.condition()[0] / 14.2 - 1.0).abs() < 0.05);
}

#[test]
fn dependent_regressors_say_on_what() {
    let mut rng = generator(5);
    let u = normal_matrix(&mut rng, 3, 120);
    let y = normal_matrix(&mut rng, 1, 120);
    let text = |change: &dyn Fn(&mut DMatrix<f64>)| -> String {
        let mut u = u.clone();
        change(&mut u);
        let data = Dataset::new(signals("u", 3), signals("y", 1), u, y.clone(), 1.0).unwrap();
        let text = Arx::new(full(1, 2, 1)).fit(&data).unwrap_err().to_string();
        let found = text.find("`u").map(|at| text[at..].to_owned());
        found.unwrap_or(text)
    };
    let multiple = text(&|u| u.set_row(2, &(u.row(0) * -250.0)));
    assert_eq!(multiple, "`u3` at lag 1 is -250.000000 times `u1` at lag 1");
    let combination = text(&|u| u.set_row(2, &(u.row(0) + u.row(1))));
    assert_eq!(
        combination,
        "`u3` at lag 1 follows from `u1` at lag 1, `u2` at lag 1"
    );
    // A sine is known from two of its lags; the mean of whole periods is zero.
    let sine = |u: &mut DMatrix<f64>| {
        for t in 0..120 {
            u[(2, t)] = (std::f64::consts::TAU * t as f64 / 12.0).sin();
        }
    };
    let mut u = u.clone();
    sine(&mut u);
    let data = Dataset::new(signals("u", 3), signals("y", 1), u, y.clone(), 1.0).unwrap();
    let error = Arx::new(full(1, 3, 1)).fit(&data).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "`u3` at lag 3 follows from its own other lags or stands still in the rows used: the \
             channel does not excite so many lags"
        ),
        "{error}"
    );
}

/// A file of a version without standard errors is read; wrong ones are refused.
#[test]
fn standard_errors_in_a_model_file() {
    let data = correlated_record(1, 200, 0.0);
    let model = Arx::new(canonical(&[2, 1])).fit(&data).unwrap();
    let mut value = serde_json::to_value(&model).unwrap();
    assert_eq!(value["standard_errors"][1].as_array().unwrap().len(), 4);
    value["standard_errors"][1][2] = (-1.0).into();
    assert_eq!(
        serde_json::from_value::<ArxModel>(value.clone())
            .unwrap_err()
            .to_string(),
        "standard errors of row 1: expected finite numbers of at least 0, found -1"
    );
    value["standard_errors"][1].as_array_mut().unwrap().pop();
    assert_eq!(
        serde_json::from_value::<ArxModel>(value.clone())
            .unwrap_err()
            .to_string(),
        "standard errors of row 1: expected 4, found 3"
    );
    value.as_object_mut().unwrap().remove("standard_errors");
    let old: ArxModel = serde_json::from_value(value.clone()).unwrap();
    assert_eq!(old.standard_errors(), None);
    assert_eq!(old.rows(), model.rows());
    assert_eq!(serde_json::to_value(&old).unwrap(), value);
}

/// The index sets near the generic ones hold the true set, and MDL finds it: (1, 3) is two away
/// from the generic (2, 2). A set with more lags in a row nests the true one, so that only the
/// penalty decides; with 3000 samples of weak noise 10 of 10 runs are right.
#[test]
fn index_table_finds_the_true_indices() {
    for run in 0..10 {
        let mut rng = generator(900 + run);
        let truth = CanonicalForm::new(
            vec![1, 3],
            vec![
                vec![vec![0.6], vec![0.5]],
                vec![vec![0.3], vec![0.4, -0.7, 0.9]],
            ],
            vec![vec![vec![1.0]], vec![vec![0.8], vec![-0.5], vec![1.0]]],
        );
        let truth = truth.unwrap();
        let data = record(&mut rng, &truth, 3000, 0.1);
        let table = index_table(&data, 2..=5, 1, false).unwrap();
        assert_eq!(table.rows[0].indices, [1, 1]);
        assert!(
            table
                .rows
                .iter()
                .all(|row| row.indices.iter().sum::<usize>() == row.order)
        );
        assert_eq!(table.best_mdl().indices, [1, 3], "run {run}");
        assert!(table.best_aic().order >= 4, "run {run}");
        assert_eq!(table.window_rows, 3000 - 4);
        // A row is that of a fit on the same window.
        for row in &table.rows {
            let model = Arx::new(canonical(&row.indices))
                .first_row(4)
                .fit(&data)
                .unwrap();
            let error = model.equation_error(&data).unwrap();
            let error = error.columns(4, 2996).into_owned();
            let covariance = &error * error.transpose() / 2996.0;
            assert!((row.ln_det - covariance.determinant().ln()).abs() < 1e-9);
        }
    }
    let data = correlated_record(1, 200, 0.0);
    // (70, 1) has 70 lags and 70 + 70 + 1 coefficients in its first row.
    let error = index_table(&data, 71..=71, 40, false).unwrap_err();
    assert!(matches!(error, IdentError::TooFewRows { .. }), "{error}");
    let wide = Dataset::new(
        signals("u", 1),
        signals("y", 8),
        normal_matrix(&mut generator(1), 1, 300),
        normal_matrix(&mut generator(2), 8, 300),
        1.0,
    )
    .unwrap();
    assert_eq!(
        index_table(&wide, 24..=24, 2, false)
            .unwrap_err()
            .to_string(),
        "index sets: expected at most 5000 within 2 of the generic indices"
    );
    assert_eq!(
        index_table(&data, 0..=3, 1, false).unwrap_err(),
        IdentError::OrderRange { first: 0, last: 3 }
    );
}

/// Three hundred orders from one factorisation: residuals fall, and the orders compared are those
/// of separate fits (1e-9: another factorisation of the same numbers, condition below 100).
#[test]
fn order_table_of_three_hundred_orders() {
    let mut rng = generator(19);
    let truth = random_form(&mut rng, &[3], 1, false);
    let data = record(&mut rng, &truth, 2500, 0.5);
    let table = order_table(&data, 1..=300, &OrderKind::Diagonal { nk: vec![1] }).unwrap();
    let variances: Vec<f64> = table
        .rows
        .iter()
        .map(|row| row.residual_variance[0])
        .collect();
    assert!(
        variances
            .windows(2)
            .all(|pair| pair[1] <= pair[0] * (1.0 + 1e-12))
    );
    for order in [1, 3, 32, 33, 150, 300] {
        let model = Arx::new(full(order, order, 1))
            .first_row(300)
            .fit(&data)
            .unwrap();
        let expected = model.rows()[0].residual_variance;
        let found = variances[order - 1];
        assert!((found - expected).abs() < 1e-9 * expected, "order {order}");
        let ratio = table.rows[order - 1].condition / model.condition()[0];
        // Beyond 64 regressors an estimate from below.
        assert!((0.7..1.0 + 1e-9).contains(&ratio), "order {order}: {ratio}");
    }
}
