//! All poles and zeros of a model.

use gt_core::{Signal, StateSpace};
use nalgebra::{Complex, DMatrix};
use serde::Serialize;

use super::gradient::Part;
use super::polynomial::roots;
use super::{Cancellation, Root, invariant_zeros};
use crate::parameter_covariance::check_covariances;
use crate::{ArxModel, ArxRow, ArxStructure, CanonicalForm, Channel, IdentError, Term};

/// A computed zero of a coupled model below this radius is taken for one at the origin, a delay:
/// rounding moves a zero of multiplicity 5 there by about as much.
pub const ORIGIN_RADIUS: f64 = 1e-3;

/// A pole of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pole {
    /// Its place and error.
    pub root: Root,
    /// The output (0-based) that it belongs to in a diagonal structure; `None` for a pole of the
    /// whole model.
    pub output: Option<usize>,
}

/// The zeros of the channel from one input to one output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelZeros {
    /// 0-based output.
    pub output: usize,
    /// 0-based input.
    pub input: usize,
    /// The finite zeros; those at the origin, which the lags alone put there, are without error.
    pub zeros: Vec<Root>,
    /// Zeros that are not told from a pole of the channel.
    pub cancellations: Vec<Cancellation>,
}

/// The poles and zeros of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PoleZeroReport {
    /// The poles: the roots of each row's own polynomial in a diagonal structure, the eigenvalues
    /// of `A` otherwise. Poles at the origin that only the input lags make are left out.
    pub poles: Vec<Pole>,
    /// The zeros of each channel, all inputs of the first output first.
    pub channels: Vec<ChannelZeros>,
    /// Indices of poles that a zero cancels, within error, in every channel where they could show
    /// (those of their row in a diagonal structure): the order may be too high by as many.
    pub superfluous_poles: Vec<usize>,
}

/// The poles and zeros of `model` with standard errors from the covariances of each row's
/// coefficients.
///
/// A root `z` of `det S(z)` moves by `-tr(adj(S) dS) / tr(adj(S) S'(z))`. As in
/// [`crate::frequency_response`], the rows are taken as estimated independently of one another.
///
/// # Errors
/// [`IdentError::Dimension`] and [`IdentError::ModelValue`] for covariances that are not those of
/// the model's rows; [`IdentError::Model`] where eigenvalues do not converge; as
/// [`ArxModel::state_space`].
pub fn pole_zero(
    model: &ArxModel,
    covariances: &[DMatrix<f64>],
) -> Result<PoleZeroReport, IdentError> {
    check_covariances(model, covariances)?;
    let diagonal = matches!(model.structure(), ArxStructure::Diagonal { .. });
    let (poles, mut channels) = if diagonal {
        (
            diagonal_poles(model, covariances)?,
            diagonal_zeros(model, covariances)?,
        )
    } else {
        (
            coupled_poles(model, covariances)?,
            coupled_zeros(model, covariances)?,
        )
    };
    let shows = |pole: &Pole, output: usize| pole.output.is_none_or(|own| own == output);
    for channel in &mut channels {
        for (index, pole) in poles.iter().enumerate() {
            if !shows(pole, channel.output) {
                continue;
            }
            let zeros = channel.zeros.iter().enumerate();
            let pairs = zeros
                .filter_map(|zero| Cancellation::between((index, &pole.root), zero, covariances));
            let nearest = pairs.min_by(|a, b| a.standard_errors.total_cmp(&b.standard_errors));
            channel.cancellations.extend(nearest);
        }
    }
    let cancelled = |channel: &ChannelZeros, pole: usize| {
        let zeroed = channel.cancellations.iter().any(|pair| pair.pole == pole);
        zeroed || silent(model, channel)
    };
    let superfluous_poles = (0..poles.len())
        .filter(|&index| {
            let mut seen = channels
                .iter()
                .filter(|channel| shows(&poles[index], channel.output))
                .peekable();
            seen.peek().is_some() && seen.all(|channel| cancelled(channel, index))
        })
        .collect();
    Ok(PoleZeroReport {
        poles,
        channels,
        superfluous_poles,
    })
}

/// A diagonal row that does not use the input has nothing to cancel there.
fn silent(model: &ArxModel, channel: &ChannelZeros) -> bool {
    let used = |term: &Term| term.channel == Channel::Input(channel.input);
    matches!(model.structure(), ArxStructure::Diagonal { .. })
        && !model.rows()[channel.output].terms.iter().any(used)
}

fn longest(row: &ArxRow, channel: Channel) -> Option<usize> {
    let own = row.terms.iter().filter(|term| term.channel == channel);
    own.map(|term| term.lag).max()
}

/// The polynomial of a channel in a row, highest power of `z` first, times `z^most`.
fn polynomial(row: &ArxRow, channel: Channel, most: usize) -> Vec<f64> {
    let mut coefficients = vec![0.0; most + 1];
    for term in row.terms.iter().filter(|term| term.channel == channel) {
        coefficients[term.lag] = -term.coefficient;
    }
    coefficients
}

fn diagonal_poles(model: &ArxModel, covariances: &[DMatrix<f64>]) -> Result<Vec<Pole>, IdentError> {
    let mut poles = Vec::new();
    for (output, row) in model.rows().iter().enumerate() {
        let channel = Channel::Output(output);
        let mut coefficients = polynomial(row, channel, longest(row, channel).unwrap_or(0));
        coefficients[0] = 1.0;
        let part = Part {
            model,
            rows: vec![output],
            columns: vec![channel],
        };
        let found = part.with_errors(&roots(&coefficients)?, covariances);
        poles.extend(found.into_iter().map(|root| Pole {
            root,
            output: Some(output),
        }));
    }
    Ok(poles)
}

fn diagonal_zeros(
    model: &ArxModel,
    covariances: &[DMatrix<f64>],
) -> Result<Vec<ChannelZeros>, IdentError> {
    let mut channels = Vec::new();
    for (output, row) in model.rows().iter().enumerate() {
        let order = longest(row, Channel::Output(output)).unwrap_or(0);
        for input in 0..model.inputs().len() {
            let channel = Channel::Input(input);
            let part = Part {
                model,
                rows: vec![output],
                columns: vec![channel],
            };
            let last = longest(row, channel);
            let coefficients = polynomial(row, channel, last.unwrap_or(0));
            let mut zeros = part.with_errors(&roots(&coefficients)?, covariances);
            // z^order P and z^order Q: what Q has to spare are zeros at the origin.
            let spare = last.map_or(0, |last| order.saturating_sub(last));
            zeros.extend((0..spare).map(|_| Root::at_origin()));
            channels.push(ChannelZeros {
                output,
                input,
                zeros,
                cancellations: Vec::new(),
            });
        }
    }
    Ok(channels)
}

fn coupled_poles(model: &ArxModel, covariances: &[DMatrix<f64>]) -> Result<Vec<Pole>, IdentError> {
    let ny = model.outputs().len();
    let part = Part {
        model,
        rows: (0..ny).collect(),
        columns: (0..ny).map(Channel::Output).collect(),
    };
    let found = part.with_errors(&autonomous(model)?.poles()?, covariances);
    Ok(found
        .into_iter()
        .map(|root| Pole { root, output: None })
        .collect())
}

/// The outputs' part of a full or canonical model, without the states that delay inputs only.
fn autonomous(model: &ArxModel) -> Result<StateSpace, IdentError> {
    let indices = match model.structure() {
        ArxStructure::Canonical { indices, .. } => indices.clone(),
        ArxStructure::Diagonal { na, .. } | ArxStructure::Full { na, .. } => {
            vec![*na; model.outputs().len()]
        }
    };
    let rows: Vec<Vec<Term>> = model
        .rows()
        .iter()
        .map(|row| {
            let outputs = |term: &&Term| matches!(term.channel, Channel::Output(_));
            row.terms.iter().filter(outputs).copied().collect()
        })
        .collect();
    let rows: Vec<&[Term]> = rows.iter().map(Vec::as_slice).collect();
    CanonicalForm::from_rows(indices, 0, false, &rows).to_state_space(
        model.sample_time_s(),
        Vec::new(),
        model.outputs().to_vec(),
    )
}

fn coupled_zeros(
    model: &ArxModel,
    covariances: &[DMatrix<f64>],
) -> Result<Vec<ChannelZeros>, IdentError> {
    let ny = model.outputs().len();
    let whole = model.state_space()?;
    let padding = whole.nx() - autonomous(model)?.nx();
    let mut channels = Vec::new();
    for output in 0..ny {
        for input in 0..model.inputs().len() {
            let (near, away): (Vec<Complex<f64>>, Vec<Complex<f64>>) =
                invariant_zeros(&single(&whole, output, input)?)?
                    .into_iter()
                    .partition(|zero| zero.norm() < ORIGIN_RADIUS);
            let mut columns: Vec<Channel> = (0..ny).map(Channel::Output).collect();
            columns[output] = Channel::Input(input);
            let part = Part {
                model,
                rows: (0..ny).collect(),
                columns,
            };
            let mut zeros = part.with_errors(&away, covariances);
            let spare = near.len().saturating_sub(padding);
            zeros.extend((0..spare).map(|_| Root::at_origin()));
            channels.push(ChannelZeros {
                output,
                input,
                zeros,
                cancellations: Vec::new(),
            });
        }
    }
    Ok(channels)
}

/// The channel from one input to one output.
fn single(model: &StateSpace, output: usize, input: usize) -> Result<StateSpace, IdentError> {
    Ok(StateSpace::new(
        [
            model.a().clone(),
            model.b().columns(input, 1).into_owned(),
            model.c().rows(output, 1).into_owned(),
            model.d().view((output, input), (1, 1)).into_owned(),
        ],
        model.sample_time_s(),
        vec![Signal::new("input", "")],
        vec![Signal::new("output", "")],
    )?)
}
