//! Least squares with stable poles and known gains.

use gt_core::qp::QpError;
use gt_core::{DataError, Dataset};
use gt_ident::constrained::{ActiveConstraint, ConstrainedArx, DcGain};
use gt_ident::{Arx, ArxModel, ArxRow, ArxStructure, Channel, IdentError};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::common::*;

fn diagonal(na: usize, nb: &[usize]) -> ArxStructure {
    ArxStructure::Diagonal {
        na,
        nb: nb.to_vec(),
        nk: vec![1],
    }
}

/// A short record of a slow system: `y(t) = 2 r cos(w) y(t-1) - r^2 y(t-2) + ..` with r near 1, and
/// white noise of the given deviation on the output. Least squares is often unstable on it.
fn slow_record(seed: u64, nu: usize, samples: usize, radius: f64, deviation: f64) -> Dataset {
    let mut rng = generator(seed);
    let u = normal_matrix(&mut rng, nu, samples);
    let noise = normal_matrix(&mut rng, 1, samples) * deviation;
    let angle = 0.02 + 0.2 * noise[0].abs();
    let mut x = DMatrix::zeros(1, samples);
    for t in 2..samples {
        x[t] = 2.0 * radius * angle.cos() * x[t - 1] - radius * radius * x[t - 2];
        for input in 0..nu {
            x[t] += u[(input, t - 1)] - 0.4 * u[(input, t - 2)];
        }
    }
    Dataset::new(signals("u", nu), signals("y", 1), u, x + noise, 1.0).unwrap()
}

/// `A(1)` and `B(1)` of one input.
fn sums(row: &ArxRow, input: usize) -> (f64, f64) {
    let sum = |channel| -> f64 {
        let terms = row.terms.iter().filter(|term| term.channel == channel);
        terms.map(|term| term.coefficient).sum()
    };
    (1.0 - sum(Channel::Output(0)), sum(Channel::Input(input)))
}

fn residual_variance(model: &ArxModel, data: &Dataset) -> f64 {
    let lag = model.max_lag();
    let e = model.equation_error(data).unwrap();
    let e = e.columns(lag, data.len() - lag);
    e.norm_squared() / e.ncols() as f64
}

proptest! {
    #![proptest_config(cases(150))]

    /// Whatever the record: the poles lie inside, the gains hold, the cost is at least that of
    /// least squares and at most that of reflected poles.
    #[test]
    fn prop_constraints_hold_and_cost_little(
        na in 1_usize..7, nb in 1_usize..4, nu in 1_usize..3, samples in 40_usize..90,
        pole in 0.9..1.01_f64, deviation in 0.01..3.0_f64, kind in 0_usize..5,
        radius_kind in 0_usize..3, seed: u64,
    ) {
        let data = slow_record(seed, nu, samples, pole, deviation);
        let structure = diagonal(na, &[nb]);
        let free = Arx::new(structure.clone()).fit(&data).unwrap();
        let max_radius = [0.999, 0.97, 1.0][radius_kind];
        let mut options = ConstrainedArx::new(structure).max_radius(max_radius);
        let gain = [
            None,
            Some(DcGain::Positive),
            Some(DcGain::Negative),
            Some(DcGain::Equal(1.5)),
            Some(DcGain::Between(-0.5, 2.0)),
        ][kind];
        if let Some(gain) = gain {
            options = options.dc_gain("y1", "u1", gain);
        }
        let fit = options.fit(&data).unwrap();
        let report = &fit.rows[0];
        prop_assert!(report.radius <= max_radius);
        // The realisation has the same poles; rounding of 1e-16 may move a pole of multiplicity m
        // by its m-th root, 1e-5 covers three of them close together.
        let realised = fit.model.state_space().unwrap().spectral_radius().unwrap();
        prop_assert!(realised <= max_radius + 1e-5, "{}", realised);
        let (a, b) = sums(&fit.model.rows()[0], 0);
        // 1e-7 is what the field may ask for; the last correction leaves rounding.
        let tolerance = 1e-7 * b.abs().max(1.0);
        match gain {
            Some(DcGain::Positive) => prop_assert!(b >= -tolerance),
            Some(DcGain::Negative) => prop_assert!(b <= tolerance),
            Some(DcGain::Equal(gain)) => prop_assert!((b - gain * a).abs() < tolerance),
            Some(DcGain::Between(low, high)) => {
                prop_assert!(b - low * a > -tolerance && high * a - b > -tolerance);
            }
            None => {}
        }
        prop_assert!(report.cost_ratio >= 1.0);
        if let Some(reflected) = report.reflected_cost_ratio {
            prop_assert!(report.cost_ratio <= reflected);
        }
        // The report's ratio is that of the residuals, computed here from the equation errors;
        // 1e-8 covers the condition of the regressors.
        let ratio = residual_variance(&fit.model, &data) / residual_variance(&free, &data);
        prop_assert!((ratio / report.cost_ratio - 1.0).abs() < 1e-8, "{} {}", ratio, report.cost_ratio);
        prop_assert!((fit.model.rows()[0].residual_variance / residual_variance(&fit.model, &data) - 1.0)
            .abs() < 1e-8);
        if report.iterations == 0 && report.active.is_empty() && report.cost_ratio == 1.0 {
            prop_assert!(report.least_squares_radius <= max_radius);
        }
    }

    /// Where least squares meets the constraints, it is the answer; 1e-9 is rounding times the
    /// condition.
    #[test]
    fn prop_a_fit_that_meets_the_constraints_is_least_squares(
        na in 1_usize..4, samples in 100_usize..300, seed: u64,
    ) {
        let data = slow_record(seed, 2, samples, 0.8, 0.1);
        let free = Arx::new(diagonal(na, &[2])).fit(&data).unwrap();
        let radius = free.state_space().unwrap().spectral_radius().unwrap();
        prop_assume!(radius < 0.99);
        let (a, b) = sums(&free.rows()[0], 0);
        let gain = DcGain::Between(b / a - 0.1, b / a + 0.1);
        let fit = ConstrainedArx::new(diagonal(na, &[2]))
            .dc_gain("y1", "u1", gain)
            .fit(&data)
            .unwrap();
        prop_assert_eq!((fit.rows[0].cost_ratio, fit.rows[0].iterations), (1.0, 0));
        for (left, right) in fit.model.rows()[0].terms.iter().zip(&free.rows()[0].terms) {
            prop_assert!((left.coefficient - right.coefficient).abs() < 1e-9);
        }
    }
}

/// Third order, 60 samples, as in the literature on stable identification: unstable fits become
/// stable for next to nothing, and reflecting the poles costs several times more.
#[test]
fn unstable_fits_become_stable_for_less_than_reflected_poles() {
    let (mut constrained, mut reflected) = (Vec::new(), Vec::new());
    for seed in 0..400 {
        let data = slow_record(seed, 1, 60, 0.999, 0.5);
        let fit = ConstrainedArx::new(diagonal(3, &[3])).fit(&data).unwrap();
        let row = &fit.rows[0];
        assert!(row.radius <= 0.999);
        if row.least_squares_radius > 1.0 {
            constrained.push(row.cost_ratio);
            reflected.push(row.reflected_cost_ratio.unwrap());
            assert!(matches!(row.active[0], ActiveConstraint::Stability { .. }));
        }
    }
    let count = constrained.len();
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (constrained, reflected) = (median(&mut constrained), median(&mut reflected));
    assert!(count > 20, "{count}");
    assert!(constrained < 1.01, "{constrained}");
    assert!(reflected - 1.0 > 3.0 * (constrained - 1.0), "{reflected}");
}

/// With one parameter the answer is known: `y(t) = alpha y(t-1)` with alpha limited to 0.9 costs
/// exactly the quadratic's rise from its minimum to 0.9.
#[test]
fn a_first_order_fit_ends_at_the_limit() {
    let mut rng = generator(3);
    let u = normal_matrix(&mut rng, 1, 200);
    let mut y = DMatrix::zeros(1, 200);
    for t in 1..200 {
        y[t] = 0.98 * y[t - 1] + u[t - 1];
    }
    let data = Dataset::new(signals("u", 1), signals("y", 1), u, y, 1.0).unwrap();
    let fit = ConstrainedArx::new(diagonal(1, &[1]))
        .max_radius(0.9)
        .fit(&data)
        .unwrap();
    // Every centre gives up 1 % of the distance that is left; the last ones gain below 1e-6.
    let alpha = fit.model.rows()[0].terms[0].coefficient;
    assert!((0.9 - alpha).abs() < 1e-4 && alpha <= 0.9, "{alpha}");
}

#[test]
fn an_equal_gain_is_the_least_squares_on_the_plane() {
    // Substituting B(1) = g A(1) by hand: with na = 1, nb = 1, beta = g (1 - alpha), so that
    // y(t) - g u(t-1) = alpha (y(t-1) - g u(t-1)), one coefficient.
    let data = slow_record(5, 1, 80, 0.8, 0.3);
    let gain = 0.7;
    let point = data.mean();
    let free = data.relative_to(&point).unwrap();
    let (mut above, mut below) = (0.0, 0.0);
    for t in 1..80 {
        let moved = free.y()[t - 1] - gain * free.u()[t - 1];
        above += moved * (free.y()[t] - gain * free.u()[t - 1]);
        below += moved * moved;
    }
    let fit = ConstrainedArx::new(diagonal(1, &[1]))
        .dc_gain("y1", "u1", DcGain::Equal(gain))
        .fit(&data)
        .unwrap();
    let row = &fit.model.rows()[0];
    // The solver's 1e-10, scaled.
    assert!((row.terms[0].coefficient - above / below).abs() < 1e-7);
    assert!((row.terms[1].coefficient - gain * (1.0 - above / below)).abs() < 1e-7);
    let input = "u1".to_owned();
    assert_eq!(fit.rows[0].active, [ActiveConstraint::DcGain { input }]);
}

/// The limit case of no poles: two weights with a known sum, by substitution a single weight.
#[test]
fn a_finite_impulse_response_takes_a_gain_too() {
    let data = slow_record(6, 1, 80, 0.8, 0.3);
    let free = data.relative_to(&data.mean()).unwrap();
    let (u, y) = (free.u(), free.y());
    let (mut above, mut below) = (0.0, 0.0);
    for t in 2..80 {
        let moved = u[t - 1] - u[t - 2];
        above += moved * (y[t] - 2.0 * u[t - 2]);
        below += moved * moved;
    }
    let fit = ConstrainedArx::new(diagonal(0, &[2]))
        .dc_gain("y1", "u1", DcGain::Equal(2.0))
        .fit(&data)
        .unwrap();
    let terms = &fit.model.rows()[0].terms;
    // The solver's 1e-10, scaled; the sum itself holds to rounding.
    assert!((terms[0].coefficient - above / below).abs() < 1e-7);
    assert!((terms[0].coefficient + terms[1].coefficient - 2.0).abs() < 1e-14);
}

/// Each output has its own row: a constraint on one leaves the others at least squares.
#[test]
fn a_constraint_on_one_output_leaves_the_others_alone() {
    let one = slow_record(7, 2, 200, 0.8, 0.3);
    let two = slow_record(8, 2, 200, 0.8, 0.3);
    let mut y = DMatrix::zeros(2, 200);
    y.set_row(0, &one.y().row(0));
    y.set_row(1, &(two.y().row(0) + one.y().row(0)));
    let data = Dataset::new(signals("u", 2), signals("y", 2), one.u().clone(), y, 1.0).unwrap();
    let fit = ConstrainedArx::new(diagonal(2, &[2, 1]))
        .dc_gain("y2", "u2", DcGain::Equal(-3.0))
        .dc_gain("y2", "u1", DcGain::Negative)
        .fit(&data)
        .unwrap();
    let free = Arx::new(diagonal(2, &[2, 1])).fit(&data).unwrap();
    for (left, right) in fit.model.rows()[0].terms.iter().zip(&free.rows()[0].terms) {
        assert!((left.coefficient - right.coefficient).abs() < 1e-9);
    }
    let gain = fit.model.state_space().unwrap();
    // C (I - A)^-1 B of the realisation is what was asked for.
    let system = DMatrix::identity(gain.nx(), gain.nx()) - gain.a();
    let at_rest = gain.c() * system.lu().solve(gain.b()).unwrap() + gain.d();
    assert!((at_rest[(1, 1)] + 3.0).abs() < 1e-7);
    assert!(at_rest[(1, 0)] < 1e-7);
    assert!(fit.rows[1].cost_ratio > 1.0 && fit.rows[0].cost_ratio == 1.0);
}

/// Units are arbitrary: pascals or megapascals, the cost ratio is the same, up to the last centre
/// that gains less than 1e-6.
#[test]
fn units_do_not_matter() {
    for seed in 0..20 {
        let data = slow_record(seed, 1, 60, 0.999, 0.5);
        let scaled = Dataset::new(
            signals("u", 1),
            signals("y", 1),
            data.u() * 1e-7,
            data.y() * 1e6,
            1.0,
        )
        .unwrap();
        let options = ConstrainedArx::new(diagonal(3, &[3]));
        let ratio = |data: &Dataset, gain: f64| {
            let options = options.clone().dc_gain("y1", "u1", DcGain::Equal(gain));
            options.fit(data).unwrap().rows[0].cost_ratio
        };
        let (left, right) = (ratio(&data, 30.0), ratio(&scaled, 30.0e13));
        assert!((left / right - 1.0).abs() < 1e-4, "{seed}: {left} {right}");
    }
}

#[test]
fn what_cannot_be_asked_for() {
    let data = slow_record(1, 2, 60, 0.9, 0.1);
    let full = ArxStructure::Full {
        na: 1,
        nb: vec![1],
        nk: vec![1],
    };
    assert_eq!(
        ConstrainedArx::new(full)
            .fit(&data)
            .unwrap_err()
            .to_string(),
        "stability-constrained least squares: expected a diagonal structure (own-output lags \
         only), found full na=1 nb=1 nk=1"
    );
    for found in [0.0, 1.5, f64::INFINITY] {
        assert_eq!(
            ConstrainedArx::new(diagonal(1, &[1]))
                .max_radius(found)
                .fit(&data)
                .unwrap_err(),
            IdentError::OptionRange {
                option: "max_radius",
                expected: "above 0 and at most 1",
                found
            }
        );
    }
    let refused = |nb: &[usize], input: &str, gain| {
        let options = ConstrainedArx::new(diagonal(1, nb)).dc_gain("y1", input, gain);
        options.fit(&data).unwrap_err()
    };
    assert_eq!(
        refused(&[1], "u1", DcGain::Between(2.0, 1.0)).to_string(),
        "gain of `u1` on `y1`: expected finite limits with lower <= upper, found 2 and 1"
    );
    assert!(matches!(
        refused(&[1], "u1", DcGain::Equal(f64::INFINITY)),
        IdentError::GainRange { .. }
    ));
    assert_eq!(
        refused(&[1, 0], "u2", DcGain::Positive),
        IdentError::GainWithoutTerms {
            output: "y1".to_owned(),
            input: "u2".to_owned()
        }
    );
    assert!(matches!(
        refused(&[1], "valve", DcGain::Positive),
        IdentError::Data(DataError::UnknownChannel { .. })
    ));
    assert_eq!(
        IdentError::Programme {
            output: "y1".to_owned(),
            source: QpError::Infeasible
        }
        .to_string(),
        "output `y1`: constraints: expected a point that satisfies them all, found a proof of none"
    );
}
