//! Refinement on the free-run error.

use gt_core::Dataset;
use gt_ident::constrained::ConstrainedArx;
use gt_ident::output_error::{InitialOutputs, OutputErrorRefinement};
use gt_ident::{Arx, ArxModel, ArxStructure, IdentError};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::common::*;

/// `y = B/A u + noise` with poles 0.9 and 0.7, B = 0.5 z^-1 + 0.3 z^-2.
const TRUTH: [f64; 4] = [1.6, -0.63, 0.5, 0.3];

fn second_order() -> ArxStructure {
    ArxStructure::Diagonal {
        na: 2,
        nb: vec![2],
        nk: vec![1],
    }
}

/// White noise of `deviation` on the output only.
fn output_error_record(seed: u64, samples: usize, deviation: f64) -> Dataset {
    let mut rng = generator(seed);
    let u = normal_matrix(&mut rng, 1, samples);
    let noise = normal_matrix(&mut rng, 1, samples) * deviation;
    let mut x = DMatrix::zeros(1, samples);
    for t in 2..samples {
        let past = [x[t - 1], x[t - 2], u[t - 1], u[t - 2]];
        x[t] = past.iter().zip(&TRUTH).map(|(a, b)| a * b).sum();
    }
    Dataset::new(signals("u", 1), signals("y", 1), u, x + noise, 1.0).unwrap()
}

fn distance(model: &ArxModel) -> f64 {
    let terms = model.rows()[0].terms.iter().zip(&TRUTH);
    let squares = terms.map(|(term, truth)| (term.coefficient - truth).powi(2));
    squares.sum::<f64>().sqrt()
}

#[test]
fn an_output_error_system_is_recovered_where_least_squares_is_biased() {
    let hold_out = output_error_record(100, 400, 0.5);
    let mut mean = Vec::new();
    for samples in [500, 8000] {
        let (mut start, mut refined) = (0.0, 0.0);
        for seed in 0..10 {
            let train = output_error_record(seed, samples, 0.5);
            let model = Arx::new(second_order()).fit(&train).unwrap();
            let result = OutputErrorRefinement::new()
                .refine(&model, &train, &hold_out)
                .unwrap();
            let report = &result.outputs[0];
            assert!(report.accepted);
            assert!(report.train_after < report.train_before);
            assert!(report.hold_out_after < report.hold_out_before);
            assert!(report.radius < 1.0);
            start += distance(&model) / 10.0;
            refined += distance(&result.model) / 10.0;
        }
        mean.push((start, refined));
    }
    // Least squares keeps its bias with 16 times the samples, the refined model has a quarter of
    // the error: 1/sqrt(16), with a factor 1.6 for ten runs.
    assert!(mean[1].0 > 0.9 * mean[0].0 && mean[1].0 > 0.3);
    assert!(mean[1].1 < 0.4 * mean[0].1);
    assert!(mean[1].1 < 0.03 * mean[1].0);
}

/// The search starts at the truth of an exact record and stays there.
#[test]
fn an_exact_model_has_nothing_to_gain() {
    let train = output_error_record(1, 300, 0.0);
    let point = train.mean();
    let centred = Dataset::new(
        train.inputs().to_vec(),
        train.outputs().to_vec(),
        train.relative_to(&point).unwrap().u().clone(),
        train.relative_to(&point).unwrap().y().clone(),
        1.0,
    )
    .unwrap();
    let model = Arx::new(second_order()).fit(&centred).unwrap();
    for initial in [InitialOutputs::Measured, InitialOutputs::Estimated] {
        let result = OutputErrorRefinement::new()
            .initial(initial)
            .refine(&model, &centred, &centred)
            .unwrap();
        let report = &result.outputs[0];
        assert!(report.train_after <= report.train_before);
    }
}

/// Estimated initial outputs free the coefficients from the noise of the measured ones.
#[test]
fn initial_outputs_matter_on_short_records() {
    let hold_out = output_error_record(200, 400, 0.0);
    let (mut measured, mut estimated) = (0.0, 0.0);
    for seed in 0..40 {
        let train = output_error_record(seed, 80, 0.5);
        let start = Arx::new(second_order())
            .fit(&output_error_record(300 + seed, 2000, 0.2))
            .unwrap();
        for (initial, sum) in [
            (InitialOutputs::Measured, &mut measured),
            (InitialOutputs::Estimated, &mut estimated),
        ] {
            let result = OutputErrorRefinement::new()
                .initial(initial)
                .refine(&start, &train, &hold_out)
                .unwrap();
            *sum += result.outputs[0].hold_out_after.unwrap().ln() / 40.0;
        }
    }
    assert!(estimated < measured);
}

/// Fourteen coefficients and forty noisy samples: the training error falls, the hold-out's rises.
#[test]
fn a_short_record_is_over_fitted_and_refused() {
    let structure = ArxStructure::Diagonal {
        na: 6,
        nb: vec![6],
        nk: vec![1],
    };
    let hold_out = output_error_record(100, 600, 0.1);
    let mut refused = 0;
    for seed in 0..20 {
        let long = output_error_record(500 + seed, 3000, 0.1);
        let start = Arx::new(structure.clone()).fit(&long).unwrap();
        let short = output_error_record(seed, 40, 1.0);
        let result = OutputErrorRefinement::new()
            .refine(&start, &short, &hold_out)
            .unwrap();
        let report = &result.outputs[0];
        assert!(report.train_after < report.train_before);
        if !report.accepted {
            refused += 1;
            assert_eq!(result.model, start);
            let bound = report.hold_out_before.unwrap();
            assert!(report.hold_out_after.is_none_or(|after| after >= bound));
        }
    }
    assert_eq!(refused, 20);
}

proptest! {
    #![proptest_config(cases(60))]

    /// Whatever the records: training errors do not rise, poles stay inside, and a row is new
    /// exactly where the hold-out record says that it is better.
    #[test]
    fn prop_only_what_the_hold_out_record_confirms_is_kept(
        na in 1_usize..4, nb in 1_usize..4, samples in 30_usize..120,
        deviation in 0.01..2.0_f64, measured: bool, seed: u64,
    ) {
        let mut rng = generator(seed);
        let form = random_form(&mut rng, &[2, 2], 1, false);
        let train = record(&mut rng, &form, samples, deviation);
        let hold_out = record(&mut rng, &form, 60, deviation);
        let structure = ArxStructure::Diagonal { na, nb: vec![nb], nk: vec![1] };
        let start = ConstrainedArx::new(structure).fit(&train).unwrap().model;
        let mut options = OutputErrorRefinement::new();
        if measured {
            options = options.initial(InitialOutputs::Measured);
        }
        let refined = options.refine(&start, &train, &hold_out).unwrap();
        let errors = |model: &ArxModel| {
            let run = model.simulate(&hold_out).unwrap();
            prop_assert_eq!(&run.diverges_at, &vec![None, None]);
            let lag = model.max_lag();
            let e = (hold_out.y() - run.y).columns(lag, 60 - lag).into_owned();
            Ok((e.component_mul(&e).column_mean()).map(f64::sqrt))
        };
        let (before, after) = (errors(&start)?, errors(&refined.model)?);
        for (index, report) in refined.outputs.iter().enumerate() {
            prop_assert!(report.train_after <= report.train_before);
            prop_assert!(report.radius <= 0.9999);
            let same = refined.model.rows()[index] == start.rows()[index];
            prop_assert!(report.accepted || same);
            let (reported_before, reported_after) =
                (report.hold_out_before.unwrap(), report.hold_out_after.unwrap());
            prop_assert_eq!(report.accepted, reported_after < reported_before);
            // Rounding of sums of at most 60 squares.
            prop_assert!((before[index] / reported_before - 1.0).abs() < 1e-12);
            let kept = if report.accepted { reported_after } else { reported_before };
            prop_assert!((after[index] / kept - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn what_cannot_be_refined() {
    let data = output_error_record(1, 200, 0.1);
    let full = ArxStructure::Full {
        na: 1,
        nb: vec![1],
        nk: vec![1],
    };
    let model = Arx::new(full).fit(&data).unwrap();
    let options = OutputErrorRefinement::new();
    assert_eq!(
        options
            .refine(&model, &data, &data)
            .unwrap_err()
            .to_string(),
        "output-error refinement: expected a diagonal structure (own-output lags only), found \
         full na=1 nb=1 nk=1"
    );
    let model = Arx::new(second_order()).fit(&data).unwrap();
    assert_eq!(
        options
            .max_radius(1.0)
            .refine(&model, &data, &data)
            .unwrap_err(),
        IdentError::OptionRange {
            option: "max_radius",
            expected: "above 0 and below 1",
            found: 1.0
        }
    );
    let error = options.max_radius(0.5).refine(&model, &data, &data);
    assert!(
        matches!(&error, Err(IdentError::UnstableStart { limit: 0.5, found, .. }) if *found > 0.8),
        "{error:?}"
    );
    // Longest lag 2, two initial outputs, four coefficients, one to spare.
    assert_eq!(
        options
            .refine(&model, &data, &data.rows(0..8).unwrap())
            .unwrap_err(),
        IdentError::TooFewRows {
            structure: second_order().to_string(),
            needed: 9,
            found: 8
        }
    );
    assert!(
        options
            .refine(&model, &data, &data.rows(0..9).unwrap())
            .is_ok()
    );
    let other = data.select(&["u1"], &["u1"]);
    assert!(other.is_err());
    let swapped = data.select(&["y1"], &["u1"]).unwrap();
    assert!(matches!(
        options.refine(&model, &data, &swapped).unwrap_err(),
        IdentError::ChannelName { .. }
    ));
}
