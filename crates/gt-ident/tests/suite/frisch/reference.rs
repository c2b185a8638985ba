//! Public records and systems with reference estimates, in the folder that
//! `GTFDI_REFERENCE_DATA` names.

use std::path::PathBuf;

use gt_core::Dataset;
use gt_ident::eiv::EivLags;
use gt_ident::frisch::{Criterion, Frisch};
use gt_ident::{Arx, ArxStructure};
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use serde_json::Value;

use super::systems::{dataset, noisy, respond, with_burn_in};
use crate::common::generator;

/// Runs of the reference means and deviations, and of those here.
const RUNS: u32 = 200;

fn folder(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("GTFDI_REFERENCE_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: {test}: GTFDI_REFERENCE_DATA is not set");
    }
    folder
}

fn json(path: PathBuf) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn list(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().unwrap().iter();
    numbers.map(|number| number.as_f64().unwrap()).collect()
}

/// The record of the file's note: 1023 samples, a random binary input, ten times as much signal as
/// noise in variance on both channels.
fn binary_record(a: &[f64], b: &[f64], seed: u64) -> Dataset {
    const SAMPLES: usize = 1023;
    let mut rng = generator(seed);
    let u = DMatrix::from_fn(1, with_burn_in(SAMPLES), |_, _| {
        if rng.random_bool(0.5) { 1.0 } else { -1.0 }
    });
    let y = respond(a, &[b.to_vec()], &u);
    let variance = y.row(0).iter().map(|v| v * v).sum::<f64>() / y.len() as f64;
    noisy(&mut rng, &u, &y, &[variance / 10.0, 0.1])
}

fn least_squares(record: &Dataset, order: usize) -> DVector<f64> {
    let structure = ArxStructure::Diagonal {
        na: order,
        nb: vec![order],
        nk: vec![1],
    };
    let model = Arx::new(structure).fit(record).unwrap();
    let terms = model.rows()[0].terms.iter().enumerate();
    // A row of an ARX model has its output lags on the right of the equation.
    DVector::from_iterator(
        2 * order,
        terms.map(|(index, term)| {
            if index < order {
                -term.coefficient
            } else {
                term.coefficient
            }
        }),
    )
}

#[test]
fn published_systems_have_a_tenth_of_the_bias_of_least_squares() {
    let Some(folder) = folder("published_systems_have_a_tenth_of_the_bias_of_least_squares") else {
        return;
    };
    let reference = json(folder.join("eiv_reference.json"));
    for name in ["first_order", "second_order"] {
        let case = &reference[name];
        let (a, b) = (list(&case["a"]), list(&case["b"]));
        let order = a.len();
        let truth = DVector::from_vec([a.clone(), b.clone()].concat());
        let lags = EivLags::new(order, vec![1]).unwrap();
        let records: Vec<Dataset> = (0..RUNS)
            .map(|run| binary_record(&a, &b, u64::from(run)))
            .collect();
        let mean = |estimate: &dyn Fn(&Dataset) -> DVector<f64>| {
            let sum = records
                .iter()
                .fold(DVector::zeros(2 * order), |s, r| s + estimate(r));
            sum / f64::from(RUNS)
        };
        let ls = mean(&|record| least_squares(record, order));
        // The deviation of a mean over 200 runs, theirs and ours: below 0.005 for least squares.
        assert!((&ls - DVector::from_vec(list(&case["ls_mean"]))).amax() < 0.01);
        for criterion in [Criterion::CovarianceMatch { lags: 5 }, Criterion::default()] {
            let frisch = Frisch::new(lags.clone()).criterion(criterion);
            let fit = |record: &Dataset| frisch.fit(record, 0).unwrap().row.theta().clone();
            let found = mean(&fit);
            let ratio = (&found - &truth).component_div(&(&ls - &truth));
            println!(
                "{name} {criterion:?}: bias over that of least squares {:.3?}",
                ratio.as_slice()
            );
            assert!(ratio.amax() < 0.1, "{name} {criterion:?}: {ratio}");
            // The reference estimates are of another criterion of the same kind: the means agree
            // to four of their own errors, the deviations to a third.
            let deviation = mean(&|record| (fit(record) - &found).map(|e| e * e)).map(f64::sqrt);
            let (means, stds) = (list(&case["frisch_mean"]), list(&case["frisch_std"]));
            for index in 0..2 * order {
                let error = (stds[index].powi(2) * 2.0 / f64::from(RUNS)).sqrt();
                assert!(
                    (found[index] - means[index]).abs() < 4.0 * error,
                    "{name} {found}"
                );
                assert!((deviation[index] / stds[index] - 1.0).abs() < 1.0 / 3.0);
            }
        }
    }
}

/// 90 rows, 5 inputs, 3 outputs; the noise on every channel is known.
#[test]
fn published_destillation_column() {
    let Some(folder) = folder("published_destillation_column") else {
        return;
    };
    let text = std::fs::read_to_string(folder.join("destill_n10.csv")).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .map(|field| field.trim().parse().unwrap())
                .collect()
        })
        .collect();
    let block = |first: usize, count: usize| {
        DMatrix::from_fn(count, rows.len(), |row, sample| rows[sample][first + row])
    };
    let record = dataset(block(0, 5), block(5, 3));
    let truth = json(folder.join("destill_noise_truth.json"));
    let frisch = Frisch::new(EivLags::new(3, vec![1; 5]).unwrap());
    let listed = list(&truth["destill_n10"]["var_y"]);
    let near = |found: f64, output: usize| {
        let ratio = found / listed[output];
        println!("output {output}: noise variance over the true one {ratio:.2}");
        assert!((1.0 / 2.5..2.5).contains(&ratio), "{ratio}");
    };
    for output in 0..3 {
        let found = frisch.fit(&record, output).unwrap();
        near(found.noise.output, output);
        assert!(
            found.channels[1..]
                .iter()
                .all(|noise| !noise.is_identifiable())
        );
    }
    let found = frisch.fit_shared(&record).unwrap();
    for output in 0..3 {
        near(found.output_noise[output], output);
    }
    assert!(
        found.channels[3..]
            .iter()
            .all(|noise| !noise.is_identifiable())
    );
}
