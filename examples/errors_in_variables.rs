//! Noise on the input too: least squares is biased and does not say so, maximum likelihood finds
//! the relation and the noise of both channels, and a Kalman filter for that noise gives white
//! residuals.
//!
//! `cargo run -p gtfdi --example errors_in_variables`

use std::error::Error;

use gtfdi::core::{Dataset, Signal};
use gtfdi::fdi::{NoiseCovariance, ResidualGenerator};
use gtfdi::ident::eiv::EivIdentification;
use gtfdi::ident::{Arx, OrderChoice, OrderKind, Term};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const SAMPLES: usize = 4000;
/// The plant: y(t) = 0.8 y(t-1) + u(t-1).
const POLE: f64 = 0.8;
/// Standard deviations of the noise.
const INPUT_NOISE: f64 = 0.5;
const OUTPUT_NOISE: f64 = 1.0;

/// A record of the plant, each channel with white noise of its own.
fn record(seed: u64) -> Result<Dataset, Box<dyn Error>> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
    let (mut u, mut y) = (DMatrix::zeros(1, SAMPLES), DMatrix::zeros(1, SAMPLES));
    for t in 1..SAMPLES {
        u[t] = 0.6 * u[t - 1] + normal();
        y[t] = POLE * y[t - 1] + u[t - 1];
    }
    u.iter_mut()
        .for_each(|value| *value += INPUT_NOISE * normal());
    y.iter_mut()
        .for_each(|value| *value += OUTPUT_NOISE * normal());
    let (inputs, outputs) = (Signal::named(&["u"]), Signal::named(&["y"]));
    Ok(Dataset::new(inputs, outputs, u, y, 1.0)?)
}

fn coefficients(terms: &[Term]) -> Vec<f64> {
    terms.iter().map(|term| term.coefficient).collect()
}

/// The correlation of a residual with itself a sample earlier.
fn correlation(residual: &[f64]) -> f64 {
    let square: f64 = residual.iter().map(|value| value * value).sum();
    let product: f64 = residual.windows(2).map(|pair| pair[0] * pair[1]).sum();
    product / square
}

fn main() -> Result<(), Box<dyn Error>> {
    let (train, fresh) = (record(1)?, record(2)?);
    println!("truth:         [{POLE}, 1.0]");

    let structure = OrderKind::Full { nk: vec![1] }.structure(1, 1)?;
    let biased = Arx::new(structure).fit(&train)?;
    println!(
        "least squares: {:.3?}",
        coefficients(&biased.rows()[0].terms)
    );

    let found = EivIdentification::new(OrderChoice::Automatic).identify(&train)?;
    let relation = found.model.relation();
    println!(
        "likelihood:    {:.3?}",
        coefficients(&relation.rows()[0].terms)
    );
    for (signal, noise) in found.model.noise() {
        println!(
            "noise of {}: standard deviation {:.3}, the record tells it: {}",
            signal.name,
            noise.variance.sqrt(),
            noise.identifiable() == Some(true)
        );
    }

    let variances = |noise: &[gtfdi::ident::eiv::ChannelNoise]| -> Vec<f64> {
        noise.iter().map(|channel| channel.variance).collect()
    };
    let (inputs, outputs) = (found.model.input_noise(), found.model.output_noise());
    let part = relation.output_model(0)?;
    let noise =
        NoiseCovariance::errors_in_variables(&part.model, &variances(inputs), &variances(outputs))?;
    let filter = ResidualGenerator::kalman(part.model, part.point, noise)?;
    let biased = biased.output_model(0)?;
    let predictor = ResidualGenerator::observer(biased.model, biased.point, &[0.0])?;
    for (name, generator) in [("least squares", predictor), ("Kalman filter", filter)] {
        let residuals = generator.residuals(&fresh)?;
        let settled = &residuals.as_slice()[generator.settle_samples()..];
        println!(
            "residual of {name}: correlation with the one before {:+.3}",
            correlation(settled)
        );
    }
    Ok(())
}
