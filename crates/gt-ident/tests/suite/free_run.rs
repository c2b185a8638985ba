//! Where a free run starts from.

use gt_core::Dataset;
use gt_ident::{
    Arx, ArxStructure, IdentError, Start, ValidationOptions, validate, validate_records,
};
use nalgebra::DMatrix;

use crate::common::{generator, largest_difference, normal_matrix, random_form, record, signals};

fn canonical() -> ArxStructure {
    ArxStructure::Canonical {
        indices: vec![2, 1],
        feedthrough: false,
    }
}

/// The record with white noise on its outputs.
fn noisy(data: &Dataset, deviation: f64, seed: u64) -> Dataset {
    let y = data.y() + normal_matrix(&mut generator(seed), data.ny(), data.len()) * deviation;
    with_outputs(data, y)
}

fn with_outputs(data: &Dataset, y: DMatrix<f64>) -> Dataset {
    let (inputs, outputs) = (data.inputs().to_vec(), data.outputs().to_vec());
    Dataset::new(inputs, outputs, data.u().clone(), y, data.sample_time_s()).unwrap()
}

/// The squared error over all samples, each output over its variance: what the start minimises.
fn error(data: &Dataset, run: &DMatrix<f64>) -> f64 {
    let rows = data.y().row_iter().zip(run.row_iter());
    rows.map(|(y, run)| (y - run).norm_squared() / y.variance())
        .sum()
}

/// No other start comes closer: moving any of the first outputs either way makes the error grow,
/// and the two sides agree (the error is a parabola with its foot there).
#[test]
fn a_fitted_start_is_the_closest_one() {
    for seed in 0..8 {
        let mut rng = generator(seed);
        let truth = random_form(&mut rng, &[2, 1], 1, false);
        let clean = record(&mut rng, &truth, 400, 0.0);
        let model = Arx::new(canonical()).fit(&clean).unwrap();
        let data = noisy(&clean, 0.5, seed + 100);
        let run = model.simulate_from(&data, Start::Fitted).unwrap();
        assert_eq!(run.diverges_at, [None, None]);
        let least = error(&data, &run.y);
        let measured = model.simulate(&data).unwrap();
        assert!(least < error(&data, &measured.y));
        for output in 0..2 {
            for lag in 0..2 {
                // Started from the fitted outputs, moved: the error is taken to the same record.
                let [up, down] = [0.01, -0.01].map(|step| {
                    let mut y = data.y().clone();
                    y.columns_mut(0, 2).copy_from(&run.y.columns(0, 2));
                    y[(output, lag)] += step;
                    let moved = model.simulate(&with_outputs(&data, y)).unwrap();
                    error(&data, &moved.y) - least
                });
                // y(0) of the second output, which no row looks back at, stays as measured.
                assert!(
                    up > 0.0 && down > 0.0,
                    "{seed} {output} {lag}: {up:e} {down:e}"
                );
                // Rounding of a sum of 800 squares against a difference of 1e-4.
                assert!((up - down).abs() < 1e-6 * (up + down), "{up:e} {down:e}");
            }
        }
    }
}

/// Without noise, and with the model that made the record, the measured start is the closest.
#[test]
fn a_fitted_start_leaves_a_clean_record_alone() {
    let mut rng = generator(3);
    let truth = random_form(&mut rng, &[2, 1], 1, false);
    let data = record(&mut rng, &truth, 400, 0.0);
    let model = Arx::new(canonical())
        .centre(gt_ident::Centre::Zero)
        .fit(&data)
        .unwrap();
    let run = model.simulate_from(&data, Start::Fitted).unwrap();
    // Rounding of 400 steps of a stable system.
    assert!(largest_difference(&run.y, data.y()) < 1e-10);
}

/// A slow pole carries the noise of the first samples through the record; with a fitted start the
/// free run of the true model is closer to it, and `validate_records` says by how much.
#[test]
fn validation_from_a_fitted_start_forgets_the_noise_of_the_first_samples() {
    let count = 300;
    let u = normal_matrix(&mut generator(5), 1, count);
    let mut y = DMatrix::zeros(1, count);
    for t in 1..count {
        y[t] = 0.995 * y[t - 1] + 0.1 * u[t - 1];
    }
    let clean = Dataset::new(signals("u", 1), signals("y", 1), u, y, 1.0).unwrap();
    let structure = ArxStructure::Canonical {
        indices: vec![1],
        feedthrough: false,
    };
    let model = Arx::new(structure)
        .centre(gt_ident::Centre::Zero)
        .fit(&clean)
        .unwrap();
    // One bad first sample, by three deviations of the output.
    let mut y = clean.y().clone();
    y[0] += 3.0 * clean.y().variance().sqrt();
    let data = with_outputs(&clean, y);
    let measured = validate(&model, &data).unwrap().outputs.remove(0);
    let options = ValidationOptions {
        start: Start::Fitted,
        residual_tests: false,
        ..ValidationOptions::default()
    };
    let mut fitted = validate_records(&model, &[&data], options).unwrap();
    assert_eq!(fitted.residuals, None);
    let fitted = fitted.outputs.remove(0);
    assert_eq!(measured.sse_prediction, fitted.sse_prediction);
    // The error 3 x 0.995^t over 300 samples has a mean square of 9 (1 - e^-3) / 3 = 2.85.
    assert!((measured.sse_simulation.unwrap() / 2.85 - 1.0).abs() < 0.1);
    // One sample against about 100 that say otherwise: 2.85 / 100^2 is left.
    assert!(fitted.sse_simulation.unwrap() < 1e-3);
}

/// A run that diverges is reported as before.
#[test]
fn a_run_that_diverges_keeps_its_report() {
    let mut rng = generator(7);
    let truth = random_form(&mut rng, &[2, 1], 1, false);
    let data = record(&mut rng, &truth, 400, 0.0);
    let model = Arx::new(canonical()).fit(&data).unwrap();
    let short = data.rows(0..2).unwrap();
    assert!(matches!(
        model.simulate_from(&short, Start::Fitted),
        Err(IdentError::TooFewRows {
            needed: 3,
            found: 2,
            ..
        })
    ));
    // An unstable relation from a record of an unstable plant.
    let u = DMatrix::from_fn(1, 400, |_, t| f64::from(u8::from(t % 7 < 3)));
    let mut y = DMatrix::<f64>::zeros(1, 400);
    for t in 1..400 {
        y[t] = 1.2 * y[t - 1] - 1.2 * (y[t - 1] / 50.0_f64).powi(3) + u[t - 1];
    }
    let data = Dataset::new(signals("u", 1), signals("y", 1), u, y, 1.0).unwrap();
    let structure = ArxStructure::Canonical {
        indices: vec![1],
        feedthrough: false,
    };
    let model = Arx::new(structure).fit(&data.rows(0..12).unwrap()).unwrap();
    let [measured, fitted] =
        [Start::Measured, Start::Fitted].map(|start| model.simulate_from(&data, start).unwrap());
    assert!(measured.diverges_at[0].is_some());
    assert_eq!(measured.diverges_at, fitted.diverges_at);
}

/// Delays of the inputs make no unknowns; more of them than the limit leave the start as measured.
#[test]
fn long_delays_and_long_memories_are_bounded() {
    let count = 2500;
    let u = normal_matrix(&mut generator(9), 1, count);
    let y = normal_matrix(&mut generator(10), 4, count);
    let data = Dataset::new(signals("u", 1), signals("y", 4), u, y, 1.0).unwrap();
    let fit = |na: usize, nk: usize| {
        let structure = ArxStructure::Diagonal {
            na,
            nb: vec![1],
            nk: vec![nk],
        };
        Arx::new(structure).fit(&data).unwrap()
    };
    let delayed = fit(1, 1025);
    let run = delayed.simulate_from(&data, Start::Fitted).unwrap();
    let moved = run.y.columns(0, 1025) - data.y().columns(0, 1025);
    // Only the last sample before the run is looked back at. (Means go off and on again: rounding.)
    assert!(moved.columns(0, 1024).amax() < 1e-12);
    assert!(moved.column(1024).amax() > 1e-6);
    // Four times 129 samples are more than the limit.
    let long = fit(129, 1);
    let [measured, fitted] =
        [Start::Measured, Start::Fitted].map(|start| long.simulate_from(&data, start).unwrap());
    assert!(largest_difference(&measured.y, &fitted.y) < 1e-9);
}
