//! What a fit says beside its numbers, and what it must not depend on.

use gt_core::Dataset;
use gt_ident::eiv::{Eiv, EivRow, NoiseVariances};
use nalgebra::DVector;

use super::monte_carlo::{found, is_stable};
use super::system::{Arma, System, four_outputs, m1, row, s1, s2};

/// The same record in other units and around another point.
fn moved(data: &Dataset, units: &[f64], shift: f64) -> Dataset {
    let (mut u, mut y) = (data.u().clone(), data.y().clone());
    let m = y.nrows();
    for (output, mut row) in y.row_iter_mut().enumerate() {
        row.apply(|value| *value = (*value + shift) * units[output]);
    }
    for (input, mut row) in u.row_iter_mut().enumerate() {
        row.apply(|value| *value = (*value - shift) * units[m + input]);
    }
    let (inputs, outputs) = (data.inputs().to_vec(), data.outputs().to_vec());
    Dataset::new(inputs, outputs, u, y, data.sample_time_s()).unwrap()
}

/// Units and operating points change the numbers as they must and nothing else.
#[test]
fn estimate_keeps_to_the_units_of_the_record() {
    let system = m1(20.0);
    let data = system.record(1000, 41, 0);
    let units = [1e4, 1e-3, 50.0];
    let other = moved(&data, &units, 7.0);
    let (plain, scaled) = [&data, &other]
        .map(|data| Eiv::new(system.lags()).fit(data).unwrap())
        .into();
    let factor = [1.0, 1.0, 1e7, 1e7, 200.0, 200.0, 1e8, 1e-6, 2500.0];
    let deviations: Vec<f64> = plain
        .covariance
        .diagonal()
        .iter()
        .map(|v| v.sqrt())
        .collect();
    let others: Vec<f64> = scaled
        .covariance
        .diagonal()
        .iter()
        .map(|v| v.sqrt())
        .collect();
    for (index, factor) in factor.iter().enumerate() {
        let (left, right) = (found(&plain)[index], found(&scaled)[index] / factor);
        // The descent stops within 1e-12 of f, which is 1e-4 of a deviation here.
        assert!(
            (left - right).abs() < 1e-3 * deviations[index],
            "{index}: {left} {right}"
        );
        let error = (others[index] / factor / deviations[index] - 1.0).abs();
        assert!(error < 1e-3, "{index}: {error:e}");
    }
    assert!((plain.criterion - scaled.criterion).abs() < 1e-9);
    let mean = (data.y().mean() + 7.0) * units[0];
    assert!((scaled.operating_point.y[0] - mean).abs() < 1e-9 * mean.abs());
    // What the estimate says of itself.
    assert_eq!(plain.row_deviations[0].as_slice(), &deviations[..6]);
    assert_eq!(plain.output_noise[0].deviation, deviations[6]);
    assert_eq!(plain.input_noise[1].deviation, deviations[8]);
    assert_eq!((plain.samples, plain.frequencies), (1000, 256));
    assert_eq!(plain.autoregression_order, 41);
    let noise = plain.noise(0).unwrap();
    assert_eq!(noise.inputs[1], plain.input_noise[1].value);
    assert_eq!(plain.noise(1), None);
}

/// Starting at the truth, or far off and unstable, ends where the built-in starts end.
#[test]
fn given_starts_lead_to_the_same_minimum() {
    let system = s1(20.0);
    let data = system.record(1000, 42, 0);
    let noise = |output, input| NoiseVariances {
        output,
        inputs: DVector::from_element(1, input),
    };
    let own = Eiv::new(system.lags()).fit(&data).unwrap();
    let wild = row(&[-2.5, 1.7], &[&[9.0, -4.0]]);
    for (row, noise) in [
        (
            system.rows[0].clone(),
            noise(system.noise[0], system.noise[1]),
        ),
        (wild, noise(0.0, 1e9)),
    ] {
        let fit = Eiv::new(system.lags())
            .start(vec![(row, noise)])
            .fit(&data)
            .unwrap();
        assert!((fit.criterion - own.criterion).abs() < 1e-9);
    }
    // Several outputs: starts hold a relation and a noise each, and are followed too.
    let system = four_outputs(15.0);
    let data = system.record(600, 43, 0);
    let start: Vec<(EivRow, NoiseVariances)> = system
        .rows
        .iter()
        .zip(&system.noise)
        .map(|(row, &output)| {
            let inputs = DVector::from_column_slice(&system.noise[4..]);
            (row.clone(), NoiseVariances { output, inputs })
        })
        .collect();
    let own = Eiv::new(system.lags()).fit(&data).unwrap();
    let fit = Eiv::new(system.lags()).start(start).fit(&data).unwrap();
    assert!((fit.criterion - own.criterion).abs() < 1e-9);
    assert!(own.rows.iter().all(|row| is_stable(row.a())));
    assert_eq!(own.frequencies, 128);
}

/// Rows may differ in order and delay.
#[test]
fn rows_of_different_orders_are_fitted_together() {
    let system = System::new(
        vec![row(&[-0.8], &[&[1.0, 0.4]]), row(&[-1.5, 0.7], &[&[0.5]])],
        vec![Arma::new(&[1.0], &[1.0, -0.7])],
        20.0,
    );
    assert_eq!(system.rows[0].lags().nk(), &[0]);
    assert_eq!(system.rows[1].lags().nk(), &[2]);
    let fit = Eiv::new(system.lags())
        .fit(&system.record(2000, 44, 0))
        .unwrap();
    for ((found, truth), bound) in found(&fit)
        .iter()
        .zip(system.point())
        .zip(system.bound(2000))
    {
        assert!(
            (found - truth).abs() < 5.0 * bound,
            "{found} {truth} {bound}"
        );
    }
}

/// `N < 20 n (m + r)`.
#[test]
fn short_records_are_marked() {
    let system = s1(20.0);
    for (samples, short) in [(79, true), (80, false)] {
        let fit = Eiv::new(system.lags())
            .fit(&system.record(samples, 45, 0))
            .unwrap();
        assert_eq!(fit.short_record, short, "{samples}");
    }
}

/// In S2 at 10 dB the bound of the input noise is 0.27 of it at N = 2000, 0.86 at 200 and 0.085 at
/// 20 000.
#[test]
fn variances_that_the_record_does_not_tell_are_marked() {
    let system = s2(10.0);
    let fit = |samples| {
        Eiv::new(system.lags())
            .fit(&system.record(samples, 46, 0))
            .unwrap()
    };
    let (short, long) = (fit(200), fit(20000));
    assert!(!short.input_noise[0].identifiable());
    assert!(long.input_noise[0].identifiable() && long.output_noise[0].identifiable());
}

/// Without noise on the input its variance goes to the lower bound of the search in about half of
/// the records, and is never called identifiable.
#[test]
fn variances_at_their_bound_are_reported() {
    let mut system = s1(20.0);
    system.noise[1] = 0.0;
    let mut at_bound = 0;
    for index in 0..10 {
        let fit = Eiv::new(system.lags())
            .fit(&system.record(500, 47, index))
            .unwrap();
        let noise = fit.input_noise[0];
        assert!(!fit.output_noise[0].at_lower_bound && !fit.output_noise[0].at_upper_bound);
        assert!(fit.output_noise[0].identifiable());
        if noise.at_lower_bound {
            assert!(!noise.identifiable());
            // A ten thousandth of what the covariances admit, 0.6 here.
            assert!(noise.value < 2e-4, "{}", noise.value);
            at_bound += 1;
        }
    }
    assert!((1..=9).contains(&at_bound), "{at_bound}");
}

/// The prior trades likelihood for denominators away from the unit circle: the sum of both is no
/// worse than at the estimate without it, and its own part is better.
#[test]
fn a_prior_on_the_poles_trades_likelihood_for_damping() {
    // S1 has two poles: three of five are not told by the record.
    let system = s1(10.0);
    let lags = vec![gt_ident::eiv::EivLags::new(5, vec![1]).unwrap()];
    for run in 0..6 {
        let data = system.record(1000, 47, run);
        let [plain, damped] = [0.0, 10.0].map(|weight| {
            let fit = Eiv::new(lags.clone()).pole_prior(weight).fit(&data);
            fit.unwrap()
        });
        let needless = |fit: &gt_ident::eiv::EivEstimate| -> f64 {
            // prod (1 - k^2) is the ratio of prediction error to variance of 1 / A, by Levinson.
            reflections(fit.rows[0].a())
                .iter()
                .map(|k| -(1.0 - k * k).ln())
                .sum()
        };
        assert!(needless(&damped) < needless(&plain), "{run}");
        let objective =
            |fit: &gt_ident::eiv::EivEstimate| fit.criterion + 10.0 / 1000.0 * needless(fit);
        // The descent stops within 1e-12 of f.
        assert!(objective(&damped) < objective(&plain) + 1e-9, "{run}");
    }
    for found in [-1.0, f64::INFINITY] {
        let refused = Eiv::new(lags.clone()).pole_prior(found);
        assert_eq!(
            refused.fit(&system.record(1000, 47, 0)).unwrap_err(),
            gt_ident::IdentError::PolePrior { found }
        );
    }
}

/// Reflection coefficients of `1 + a_1 q^-1 + ..`, by the step-down recursion.
fn reflections(a: &[f64]) -> Vec<f64> {
    let mut a = a.to_vec();
    let mut found = Vec::new();
    while let Some(k) = a.pop() {
        let mirrored: Vec<f64> = a.iter().rev().copied().collect();
        let pairs = a.iter_mut().zip(mirrored);
        pairs.for_each(|(a, other)| *a = (*a - k * other) / (1.0 - k * k));
        found.push(k);
    }
    found
}
