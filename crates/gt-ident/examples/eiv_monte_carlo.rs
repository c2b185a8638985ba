//! Errors of the errors-in-variables fit over its bound, on systems that are known exactly.
//!
//! `cargo run --release -p gt-ident --example eiv_monte_carlo [runs]`
//!
//! A ratio of 1 is the semiparametric Cramer-Rao bound; a ratio over R runs has a deviation of
//! about `1 / sqrt(2 R)` a parameter. Least squares on the same lags stands beside it.

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../tests/suite/eiv/system.rs"]
mod system;

use std::error::Error;
use std::time::Instant;

use gt_ident::eiv::Eiv;
use gt_ident::{Arx, ArxStructure};
use system::{System, four_outputs, m1, s1, s2};

struct Table {
    bound: Vec<f64>,
    coefficients: usize,
    /// Squared errors over the squared bound, a vector a run.
    errors: Vec<Vec<f64>>,
    least_squares: Vec<Vec<f64>>,
    deviations: Vec<Vec<f64>>,
    seconds: Vec<f64>,
}

/// The geometric mean over some parameters of the root mean square over the runs.
fn ratio(errors: &[Vec<f64>], parameters: std::ops::Range<usize>) -> f64 {
    let count = parameters.len() as f64;
    let logs = parameters.map(|parameter| {
        let sum: f64 = errors.iter().map(|run| run[parameter].powi(2)).sum();
        0.5 * (sum / errors.len() as f64).ln()
    });
    (logs.sum::<f64>() / count).exp()
}

fn run(system: &System, samples: usize, runs: u64) -> Result<Table, Box<dyn Error>> {
    let bound = system.bound(samples);
    let truth = system.point();
    let coefficients = truth.len() - system.channels();
    let order = system.rows[0].lags().order();
    let mut table = Table {
        bound,
        coefficients,
        errors: Vec::new(),
        least_squares: Vec::new(),
        deviations: Vec::new(),
        seconds: Vec::new(),
    };
    let structure = ArxStructure::Diagonal {
        na: order,
        nb: vec![order],
        nk: vec![1],
    };
    for index in 0..runs {
        let data = system.record(samples, 20261126, index);
        let begin = Instant::now();
        let fit = Eiv::new(system.lags()).fit(&data)?;
        table.seconds.push(begin.elapsed().as_secs_f64());
        let noise = fit.output_noise.iter().chain(&fit.input_noise);
        let found: Vec<f64> = fit
            .rows
            .iter()
            .flat_map(|row| row.theta().iter().copied())
            .chain(noise.clone().map(|noise| noise.value))
            .collect();
        let over = |found: &[f64]| -> Vec<f64> {
            let pairs = found.iter().zip(&truth).zip(&table.bound);
            pairs.map(|((f, t), b)| (f - t) / b).collect()
        };
        table.errors.push(over(&found));
        let told = fit
            .row_deviations
            .iter()
            .flat_map(|row| row.iter().copied());
        let told = told.chain(noise.map(|noise| noise.deviation));
        let told: Vec<f64> = told.zip(&table.bound).map(|(d, b)| d / b).collect();
        table.deviations.push(told);

        let model = Arx::new(structure.clone()).fit(&data)?;
        let mut plain = Vec::new();
        for (row, arx) in system.rows.iter().zip(model.rows()) {
            // Recent lags first and inputs interleaved, signs on the right.
            let r = row.lags().inputs();
            let terms = &arx.terms;
            plain.extend(terms[..order].iter().map(|term| -term.coefficient));
            for input in 0..r {
                let own = terms[order..].iter().skip(input).step_by(r);
                plain.extend(own.map(|term| term.coefficient));
            }
        }
        table.least_squares.push(over(&plain));
    }
    Ok(table)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let runs: u64 = arguments.next().map_or(Ok(40), |text| text.parse())?;
    let only = arguments.next();
    println!(
        "{:<16} {:>6} {:>5} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8} {:>8}",
        "system", "N", "runs", "PWML", "noise", "worst", "told", "bias", "LS", "ms/fit"
    );
    let cases: [(&str, System, &[usize], u64); 8] = [
        ("S1 10 dB", s1(10.0), &[2000, 10000], 1),
        ("S1 20 dB", s1(20.0), &[2000, 10000], 1),
        ("M1 10 dB", m1(10.0), &[2000, 10000], 1),
        ("M1 20 dB", m1(20.0), &[2000, 10000], 1),
        ("S2 20 dB", s2(20.0), &[2000, 10000], 1),
        ("S2 10 dB", s2(10.0), &[2000, 10000], 1),
        ("S2 30 dB", s2(30.0), &[2000], 1),
        ("4 outputs 15 dB", four_outputs(15.0), &[1000, 4000], 4),
    ];
    for (name, system, lengths, share) in cases {
        if only.as_ref().is_some_and(|only| !name.contains(only)) {
            continue;
        }
        for &samples in lengths {
            let runs = (runs / share).max(1);
            let table = run(&system, samples, runs)?;
            let (first, all) = (table.coefficients, table.bound.len());
            let worst = table.errors.iter().flat_map(|run| &run[..first]);
            let worst = worst.fold(0.0, |worst: f64, error| worst.max(error.abs()));
            let mut seconds = table.seconds.clone();
            seconds.sort_by(f64::total_cmp);
            // The largest mean error of a coefficient or variance, in bounds.
            let bias = (0..all).map(|parameter| {
                let sum: f64 = table.errors.iter().map(|run| run[parameter]).sum();
                sum / table.errors.len() as f64
            });
            let bias = bias.fold(0.0, |most: f64, value| {
                if value.abs() > most.abs() {
                    value
                } else {
                    most
                }
            });
            println!(
                "{name:<16} {samples:>6} {runs:>5} {:>7.3} {:>7.3} {worst:>7.2} {:>7.3} {bias:>7.2} {:>8.1} {:>8.1}",
                ratio(&table.errors, 0..first),
                ratio(&table.errors, first..all),
                ratio(&table.deviations, 0..all),
                ratio(&table.least_squares, 0..first),
                1e3 * seconds[seconds.len() / 2],
            );
        }
    }
    println!(
        "\nPWML, LS: geometric mean over the coefficients of RMSE / bound; noise: the same of the \
         variances;\nworst: largest error of a coefficient in bounds; told: the estimate's own \
         deviations / bound;\nbias: largest mean error of a parameter in bounds; ms/fit: median."
    );
    Ok(())
}
