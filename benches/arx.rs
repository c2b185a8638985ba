//! ARX fit of 100 000 samples, order 8, 2 inputs, against QR and the normal equations of the same
//! regressors in nalgebra, with the accuracy of each beside its speed.
//!
//! `cargo bench -p gtfdi --bench arx`

mod timing;

use std::error::Error;
use std::hint::black_box;

use gtfdi::core::Dataset;
use gtfdi::ident::{Arx, ArxModel, ArxStructure, Channel};
use gtfdi::plant::{NoiseLevel, Scenario, simulate};
use nalgebra::{DMatrix, DVector};

/// Samples of the record.
const SAMPLES: usize = 100_000;
/// Lags of the output, and lags of each input.
const ORDER: usize = 8;
/// Largest relative difference of our coefficients from those of nalgebra's QR: two backward stable
/// solutions differ by the condition times some units of rounding.
const AGREEMENT_PER_CONDITION: f64 = 1e-13;

fn main() -> Result<(), Box<dyn Error>> {
    for noise in [NoiseLevel::None, NoiseLevel::Table8] {
        let scenario = Scenario {
            duration_s: SAMPLES as f64 * gtfdi::plant::SAMPLE_TIME_S,
            noise: noise.into(),
            ..Scenario::default()
        };
        let data = simulate(&scenario)?
            .measured
            .select(&["a_v", "M_f"], &["t3"])?;
        compare(&noise.to_string(), &data)?;
    }
    println!(
        "/ [i]: speed over that of row i, median of rounds. All rows remove the means and build \
         the {} regressors; row 2 also computes the condition. Error: |theta - theta[0]| / \
         |theta[0]|. RSS: residual sum of squares over that of [0].",
        3 * ORDER
    );
    Ok(())
}

fn compare(noise: &str, data: &Dataset) -> Result<(), Box<dyn Error>> {
    let (nb, nk) = (vec![ORDER], vec![1]);
    let arx = Arx::new(ArxStructure::Diagonal { na: ORDER, nb, nk });
    let model = arx.fit(data)?;
    let condition = model.condition()[0];
    let ours = by_channel(&model);
    let reference = householder(data).ok_or("nalgebra's QR: singular")?;
    let error = |theta: &DVector<f64>| (theta - &reference).norm() / reference.norm();
    println!(
        "ARX, noise {noise}: N = {SAMPLES}, {} regressors, condition {condition:.1e}",
        reference.len()
    );
    let limit = AGREEMENT_PER_CONDITION * condition;
    if error(&ours).is_nan() || error(&ours) > limit {
        return Err(format!("coefficients differ by {:e}, limit {limit:e}", error(&ours)).into());
    }

    let times = timing::race(vec![
        (
            "nalgebra QR",
            Box::new(|| {
                black_box(householder(black_box(data)));
            }),
        ),
        (
            "nalgebra normal equations",
            Box::new(|| {
                black_box(normal_equations(black_box(data)));
            }),
        ),
        (
            "gtfdi Arx::fit",
            Box::new(|| {
                let _ = black_box(arx.fit(black_box(data)));
            }),
        ),
    ]);
    let (design, target) = regression(data);
    let rss = |theta: &DVector<f64>| (&target - &design * theta).norm_squared();
    let notes = [Some(reference.clone()), normal_equations(data), Some(ours)].map(|theta| {
        theta.map_or("not positive definite".to_owned(), |theta| {
            format!(
                "{:>8.1e}  {:.9}",
                error(&theta),
                rss(&theta) / rss(&reference)
            )
        })
    });
    let milliseconds = |seconds: f64| 1e3 * seconds;
    times.print("ms", milliseconds, &[0, 1], ("   error  RSS", &notes));
    println!();
    Ok(())
}

/// Regressors and target in deviations from the means: lags 1 to 8 of the output, then of each
/// input.
fn regression(data: &Dataset) -> (DMatrix<f64>, DVector<f64>) {
    let mean = data.mean();
    let rows = data.len() - ORDER;
    let (u, y) = (data.u(), data.y());
    let design = DMatrix::from_fn(rows, 3 * ORDER, |row, column| {
        let t = row + ORDER - (column % ORDER + 1);
        match column / ORDER {
            0 => y[(0, t)] - mean.y[0],
            channel => u[(channel - 1, t)] - mean.u[channel - 1],
        }
    });
    let target = DVector::from_fn(rows, |row, _| y[(0, row + ORDER)] - mean.y[0]);
    (design, target)
}

fn householder(data: &Dataset) -> Option<DVector<f64>> {
    let (design, mut target) = regression(data);
    let columns = design.ncols();
    let qr = design.qr();
    qr.q_tr_mul(&mut target);
    qr.r().solve_upper_triangular(&target.rows(0, columns))
}

fn normal_equations(data: &Dataset) -> Option<DVector<f64>> {
    let (design, target) = regression(data);
    let gram = design.tr_mul(&design);
    Some(gram.cholesky()?.solve(&design.tr_mul(&target)))
}

/// The coefficients of a fitted model in the order of [`regression`].
fn by_channel(model: &ArxModel) -> DVector<f64> {
    let mut theta = DVector::zeros(3 * ORDER);
    for term in &model.rows()[0].terms {
        let block = match term.channel {
            Channel::Output(_) => 0,
            Channel::Input(input) => input + 1,
        };
        theta[block * ORDER + term.lag - 1] = term.coefficient;
    }
    theta
}
