//! The order search: criteria against separate fits, and the orders it finds.

use gt_ident::{Arx, CanonicalForm, IdentError, OrderChoice, OrderKind, order_table};

use crate::common::*;
use crate::fit::mirrored_record;

#[test]
fn order_table_is_that_of_separate_fits_on_the_same_window() {
    let mut rng = generator(5);
    let truth = random_form(&mut rng, &[2, 1], 2, false);
    let data = record(&mut rng, &truth, 600, 0.2);
    for kind in [
        OrderKind::Diagonal { nk: vec![1] },
        OrderKind::Full { nk: vec![0, 1] },
        OrderKind::Canonical { feedthrough: true },
    ] {
        let table = order_table(&data, 2..=7, &kind).unwrap();
        let longest = kind.structure(7, 2).unwrap().max_lag(2);
        assert_eq!(table.window_rows, 600 - longest);
        let t = table.window_rows as f64;
        assert_eq!(table.rows.len(), 6);
        for (row, order) in table.rows.iter().zip(2..) {
            assert_eq!(row.order, order);
            let structure = kind.structure(order, 2).unwrap();
            let model = Arx::new(structure.clone())
                .first_row(longest)
                .fit(&data)
                .unwrap();
            assert_eq!(model.rows_used(), table.window_rows);
            let count: usize = model.rows().iter().map(|row| row.terms.len()).sum();
            assert_eq!(row.parameters, count);
            assert_eq!(row.parameters, structure.parameters(2, 2));
            let error = model.equation_error(&data).unwrap();
            let error = error.columns(longest, table.window_rows).into_owned();
            let covariance = &error * error.transpose() / t;
            for output in 0..2 {
                // Another factorisation of the same numbers: 1e-9 leaves room for the condition.
                let expected = covariance[(output, output)];
                assert!((row.residual_variance[output] - expected).abs() < 1e-9 * expected);
            }
            let determinant = covariance.determinant();
            assert!((row.ln_det - determinant.ln()).abs() < 1e-9);
            let d = count as f64;
            assert!((row.aic - (t * determinant.ln() + 2.0 * d)).abs() < 1e-6);
            assert!((row.mdl - (t * determinant.ln() + d * t.ln())).abs() < 1e-6);
            let fpe = determinant * ((t + d / 2.0) / (t - d / 2.0)).powi(2);
            assert!((row.fpe - fpe).abs() < 1e-9 * fpe);
            let mut relative = 0.0;
            for output in 0..2 {
                let y = data
                    .y()
                    .row(output)
                    .columns(longest, table.window_rows)
                    .into_owned();
                relative += error.row(output).variance() / y.variance();
            }
            let ppcre = 100.0 * (relative / 2.0).sqrt();
            assert!((row.ppcre_percent - ppcre).abs() < 1e-9 * ppcre);
        }
    }
}

/// MDL is consistent: with 2000 samples and strong coefficients it finds the order in each of 20
/// runs; AIC and FPE may overestimate (about one run in four) but never underestimate here.
#[test]
fn order_table_finds_the_true_order() {
    for run in 0..20 {
        let mut rng = generator(400 + run);
        let truth = CanonicalForm::new(
            vec![3],
            vec![vec![vec![0.5, -0.9, 1.1]]],
            vec![vec![vec![0.4], vec![-0.6], vec![1.0]]],
        )
        .unwrap();
        let data = record(&mut rng, &truth, 2000, 0.3);
        let table = order_table(&data, 1..=8, &OrderKind::Diagonal { nk: vec![1] }).unwrap();
        assert_eq!(table.best_mdl(), 3, "run {run}");
        assert!(table.best_aic() >= 3 && table.best_fpe() >= 3, "run {run}");
    }
}

/// Two outputs of indices (2, 1): total order 3.
#[test]
fn order_table_finds_the_true_canonical_order() {
    for run in 0..10 {
        let mut rng = generator(700 + run);
        let truth = CanonicalForm::new(
            vec![2, 1],
            vec![
                vec![vec![-0.5, 1.0], vec![0.2]],
                vec![vec![0.3, 0.0], vec![0.6]],
            ],
            vec![vec![vec![1.0], vec![0.5]], vec![vec![2.0]]],
        )
        .unwrap();
        let data = record(&mut rng, &truth, 2000, 0.3);
        let kind = OrderKind::Canonical { feedthrough: false };
        assert_eq!(
            order_table(&data, 2..=8, &kind).unwrap().best_mdl(),
            3,
            "run {run}"
        );
    }
}

/// Without noise the orders above the true one have dependent regressors: they are listed with
/// their condition and are never best.
#[test]
fn order_table_without_noise_stops_at_the_true_order() {
    let (data, _) = mirrored_record(21, &[3], 1, false);
    let table = order_table(&data, 1..=6, &OrderKind::Diagonal { nk: vec![1] }).unwrap();
    assert_eq!(
        [table.best_aic(), table.best_mdl(), table.best_fpe()],
        [3, 3, 3]
    );
    for row in &table.rows {
        assert_eq!(
            row.condition > gt_ident::CONDITION_LIMIT,
            row.order > 3,
            "order {}",
            row.order
        );
        let ratio = row.ppcre_percent / 100.0;
        // Rounding of the data at order 3 and above.
        assert_eq!(
            ratio < 1e-12,
            row.order >= 3,
            "order {}: {ratio:e}",
            row.order
        );
    }
}

#[test]
fn an_order_is_chosen_as_far_as_the_record_bears() {
    let mut rng = generator(31);
    let truth = random_form(&mut rng, &[2, 1], 1, false);
    let data = record(&mut rng, &truth, 600, 0.2);
    let canonical = OrderKind::Canonical { feedthrough: false };
    let chosen = canonical.choose(&data, &OrderChoice::Given(5)).unwrap();
    assert_eq!(chosen.structure, canonical.structure(5, 2).unwrap());
    assert_eq!((chosen.orders, chosen.shortened), (None, None));
    // An order of 1 has no state for the second output.
    for (wish, orders) in [
        (OrderChoice::Search(1..=6), 2..=6),
        (OrderChoice::Automatic, 2..=12),
    ] {
        let chosen = canonical.choose(&data, &wish).unwrap();
        let table = order_table(&data, orders, &canonical).unwrap();
        let best = canonical.structure(table.best_mdl(), 2).unwrap();
        assert_eq!(chosen.structure, best);
        assert_eq!((chosen.orders, chosen.shortened), (Some(table), None));
    }
    // Order n of one input and two outputs takes n + 3 n + 1 rows.
    let full = OrderKind::Full { nk: vec![1] };
    let short = data.rows(0..31).unwrap();
    let chosen = full.choose(&short, &OrderChoice::Automatic).unwrap();
    assert_eq!(chosen.shortened, Some(1..=7));
    assert_eq!(chosen.orders.unwrap().rows.len(), 7);
    let refused = |wish| canonical.choose(&data, &wish).unwrap_err();
    let small = IdentError::OrderTooSmall {
        order: 1,
        outputs: 2,
    };
    assert_eq!(refused(OrderChoice::Given(1)), small);
    assert_eq!(refused(OrderChoice::Search(1..=1)), small);
    let error = full.choose(&short, &OrderChoice::Search(1..=12));
    assert!(matches!(error, Err(IdentError::TooFewRows { .. })));
}
