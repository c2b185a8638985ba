//! Starting points of one output without any outside help.

use gt_core::Stop;
use nalgebra::{DMatrix, DVector};

use super::moments::Moments;
use super::reflection::stabilised;

/// Shares of the noise that the inputs bear, from nearly none to nearly all.
const SHARES: [f64; 8] = [0.002, 0.01, 0.04, 0.12, 0.3, 0.6, 0.88, 0.985];
/// How much more than the others one input may bear.
const EMPHASIS: f64 = 12.0;
/// Reweightings of a direction; they converge linearly and fast, and the fit goes on from there.
const REWEIGHTINGS: usize = 4;

/// A point of one output: its relation `theta_bar` and variances (output, inputs).
pub(super) struct Start {
    pub relation: DVector<f64>,
    pub variances: Vec<f64>,
}

/// A point for each of several directions in the space of the noise variances.
///
/// Where the variances are known up to a factor, the maximum likelihood estimate for an arbitrary
/// input minimises `mean_w h S h^H / (h D h^H)`. With the denominator kept from the step before
/// this is a generalised eigenvalue problem (iterated generalised total least squares, Pintelon
/// and Schoukens, System Identification, 2012, chapter 9); its smallest eigenvalue is the factor.
/// The directions mix the intercepts of the Frisch surface (`largest`).
pub(super) fn starts(moments: &Moments<'_>, largest: &[f64], stop: &dyn Stop) -> Vec<Start> {
    let inputs = largest.len() - 1;
    let mut starts = Vec::new();
    let first = [vec![1.0; moments.frequencies()], moments.output_spectrum()];
    let patterns = if inputs > 1 { inputs + 1 } else { 1 };
    for pattern in 0..patterns {
        for share in SHARES {
            let direction: Vec<f64> = largest
                .iter()
                .enumerate()
                .map(|(channel, largest)| match channel {
                    0 => (1.0 - share) * largest,
                    _ if pattern == 0 || pattern == channel => share * largest,
                    _ => share * largest / EMPHASIS,
                })
                .collect();
            for weight in &first {
                if stop.is_stopped() {
                    return starts;
                }
                starts.extend(along(moments, &direction, weight.clone()));
            }
        }
    }
    starts
}

/// The point whose variances are a multiple of `direction`, from a first weight.
fn along(moments: &Moments<'_>, direction: &[f64], mut weight: Vec<f64>) -> Option<Start> {
    let mut last = None;
    for _ in 0..REWEIGHTINGS {
        let signal = moments.signal(&weight);
        let noise = moments.noise(&weight, direction);
        let Some((relation, factor)) = smallest_pair(&signal, &noise) else {
            break;
        };
        weight = moments.weight(&relation, direction);
        last = Some((relation, factor, signal - noise * factor));
    }
    let (relation, factor, signal) = last?;
    let variances = direction.iter().map(|value| value * factor).collect();
    Some(Start {
        relation: stable(moments, relation, &signal),
        variances,
    })
}

/// The smallest `mu` with `det(signal - mu noise) = 0`, and its vector with first entry 1.
fn smallest_pair(signal: &DMatrix<f64>, noise: &DMatrix<f64>) -> Option<(DVector<f64>, f64)> {
    let factor = signal.clone().cholesky()?;
    let lower = factor.l();
    let mut inner = noise.clone();
    if !lower.solve_lower_triangular_mut(&mut inner) {
        return None;
    }
    let mut inner = inner.transpose();
    if !lower.solve_lower_triangular_mut(&mut inner) {
        return None;
    }
    if !inner.iter().all(|value| value.is_finite()) {
        return None;
    }
    let eigen = inner.symmetric_eigen();
    let (index, largest) = eigen.eigenvalues.argmax();
    let vector = eigen.eigenvectors.column(index).into_owned();
    let vector = lower.tr_solve_lower_triangular(&vector)?;
    let found = &vector / vector[0];
    let usable = largest > 0.0 && found.iter().all(|value| value.is_finite());
    usable.then(|| (found, 1.0 / largest))
}

/// The relation with stable output coefficients; where that changes them, the input coefficients
/// are fitted again, `signal` being the covariance without noise.
fn stable(
    moments: &Moments<'_>,
    mut relation: DVector<f64>,
    signal: &DMatrix<f64>,
) -> DVector<f64> {
    let outputs = moments
        .columns()
        .iter()
        .filter(|column| column.0 == 0)
        .count();
    let Some(moved) = stabilised(&relation.as_slice()[1..outputs]) else {
        return relation;
    };
    relation.as_mut_slice()[1..outputs].copy_from_slice(&moved);
    let inputs = relation.len() - outputs;
    let block = signal
        .view((outputs, outputs), (inputs, inputs))
        .into_owned();
    let cross = signal.view((outputs, 0), (inputs, outputs));
    let target = -(cross * relation.rows(0, outputs));
    if let Some(fitted) = block.cholesky().map(|factor| factor.solve(&target)) {
        relation.rows_mut(outputs, inputs).copy_from(&fitted);
    }
    relation
}
