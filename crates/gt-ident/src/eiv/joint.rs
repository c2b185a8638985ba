//! Estimates of one output by itself and of several outputs together.

use gt_core::Stop;

use super::layout::Layout;
use super::moments::Moments;
use super::refine::{Problem, Refined};
use super::row::EivLags;
use super::spectrum::Spectrum;
use super::start::starts;
use crate::IdentError;

/// Roots of the cancelling factors.
const CANCELLING: [f64; 3] = [0.5, -0.5, 0.85];

/// The estimate of one output, in units of the channels' deviations.
///
/// Beside the given points and those of [`starts`] it starts from the estimate of the order below,
/// times factors that cancel: where an order adds little, that is where its minimum lies. Without
/// that estimate it climbs from the lowest order there is.
fn one_output(
    spectrum: &Spectrum,
    lags: &EivLags,
    given: &[Vec<f64>],
    below: Option<&Refined>,
    prior: f64,
    stop: &dyn Stop,
) -> Option<Refined> {
    if stop.is_stopped() {
        return None;
    }
    let moments = Moments::new(spectrum, lags);
    let largest = moments.largest_variances()?;
    let mut points = given.to_vec();
    if let Ok(lower) = EivLags::new(lags.order() - 1, lags.nk().to_vec()) {
        let climbed = if below.is_none() {
            one_output(spectrum, &lower, &[], None, prior, stop)
        } else {
            None
        };
        if let Some(end) = below.or(climbed.as_ref()) {
            let rows = std::slice::from_ref(&lower);
            points.extend(CANCELLING.map(|root| extended(rows, &end.point, root)));
        }
    }
    for start in starts(&moments, &largest, stop) {
        let (a, b) = start.relation.as_slice()[1..].split_at(lags.order());
        let mut point = a.to_vec();
        point.extend(b.iter().map(|value| -value));
        point.extend(start.variances);
        points.push(point);
    }
    let own = std::slice::from_ref(lags);
    let mut problem = Problem::new(own, spectrum, &largest, prior, stop).ok()?;
    problem.solve(&points, given.len())
}

/// A point of the next order with the same transfer functions: both sides of every relation times
/// `1 - root q^-1`.
fn extended(rows: &[EivLags], point: &[f64], root: f64) -> Vec<f64> {
    let times = |part: &[f64], first: f64| {
        let before = std::iter::once(&first).chain(part);
        let after = part.iter().chain(std::iter::once(&0.0));
        let product: Vec<f64> = after.zip(before).map(|(a, b)| a - root * b).collect();
        product
    };
    let mut rest = point;
    let mut longer = Vec::with_capacity(2 * point.len());
    for lags in rows {
        let (a, inputs) = rest.split_at(lags.order());
        longer.extend(times(a, 1.0));
        rest = inputs;
        for input in 0..lags.inputs() {
            let (b, after) = rest.split_at(lags.input_terms(input));
            longer.push(b[0]);
            longer.extend(times(&b[1..], b[0]));
            rest = after;
        }
    }
    longer.extend(rest);
    longer
}

/// The estimate of all outputs together, and of each one by itself.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    pub together: Refined,
    singles: Vec<Refined>,
}

/// The estimate of all outputs together, in units of the channels' deviations. `given` are points
/// of all outputs to start from beside those found here; `below` is the estimate with every order
/// less by one, where there is one.
///
/// Several outputs are first estimated one by one; their points, with the mean and with the least
/// of their input variances, are where the joint descent starts. `prior` is the weight of the prior on
/// the poles over the number of samples.
pub(super) fn estimate(
    spectrum: &Spectrum,
    lags: &[EivLags],
    given: &[Vec<f64>],
    below: Option<&Joint>,
    prior: f64,
    stop: &dyn Stop,
) -> Result<Joint, IdentError> {
    let layout = Layout::new(lags)?;
    let (m, r) = (layout.outputs, layout.inputs);
    let row_starts = layout.row_starts();
    let first = layout.coefficients();
    let mut largest = vec![f64::INFINITY; m + r];
    let mut singles = Vec::with_capacity(m);
    for (output, (own, start)) in lags.iter().zip(&row_starts).enumerate() {
        let selected: Vec<usize> = std::iter::once(output).chain(m..m + r).collect();
        let marginal = spectrum.marginal(&selected)?;
        let found = Moments::new(&marginal, own)
            .largest_variances()
            .ok_or(IdentError::EivNoStart { output })?;
        largest[output] = found[0];
        for (largest, found) in largest[m..].iter_mut().zip(&found[1..]) {
            *largest = largest.min(*found);
        }
        let coefficients = own.parameters();
        let given: Vec<Vec<f64>> = given
            .iter()
            .map(|point| {
                let mut single = point[*start..start + coefficients].to_vec();
                single.push(point[first + output]);
                single.extend(&point[first + m..]);
                single
            })
            .collect();
        let below = below.map(|below| &below.singles[output]);
        let single = one_output(&marginal, own, &given, below, prior, stop);
        stop.check()?;
        singles.push(single.ok_or(IdentError::EivNoStart { output })?);
    }
    if m == 1 {
        let together = singles[0].clone();
        return Ok(Joint { together, singles });
    }
    let mut points: Vec<Vec<f64>> = given.to_vec();
    points.extend([false, true].map(|least| combined(lags, &singles, least)));
    if let Some(below) = below {
        let lower: Result<Vec<EivLags>, IdentError> = lags
            .iter()
            .map(|lags| EivLags::new(lags.order() - 1, lags.nk().to_vec()))
            .collect();
        let lower = lower?;
        points.extend(CANCELLING.map(|root| extended(&lower, &below.together.point, root)));
    }
    let together = Problem::new(lags, spectrum, &largest, prior, stop)?.solve(&points, given.len());
    stop.check()?;
    let mut together = together.ok_or(IdentError::EivNoStart { output: 0 })?;
    together.evaluations += singles
        .iter()
        .map(|single| single.evaluations)
        .sum::<usize>();
    Ok(Joint { together, singles })
}

/// The point of all outputs from those of each one, with the mean or the least of their input
/// variances.
fn combined(lags: &[EivLags], singles: &[Refined], least: bool) -> Vec<f64> {
    let mut point = Vec::new();
    for (single, own) in singles.iter().zip(lags) {
        point.extend(&single.point[..own.parameters()]);
    }
    let noise =
        |single: &Refined, own: &EivLags, channel: usize| single.point[own.parameters() + channel];
    let pairs = || singles.iter().zip(lags);
    point.extend(pairs().map(|(single, own)| noise(single, own, 0)));
    for input in 1..=lags[0].inputs() {
        let values = pairs().map(|(single, own)| noise(single, own, input));
        point.push(if least {
            values.fold(f64::INFINITY, f64::min)
        } else {
            values.sum::<f64>() / singles.len() as f64
        });
    }
    point
}
