//! The free run of one row and its gradient.

use nalgebra::DMatrix;

use crate::regressor::Deviations;
use crate::{Channel, Regressor, Term};

/// The record as one row sees it, in deviations. Parameters: the `na` own-output coefficients, the
/// inputs' coefficients, then, where they are estimated, the outputs before the window, the latest
/// first.
pub(crate) struct RowRun {
    na: usize,
    /// A column per input coefficient over the window.
    inputs: Vec<Vec<f64>>,
    /// Measured outputs before the window, the latest first.
    before: Vec<f64>,
    /// Measured outputs in the window.
    measured: Vec<f64>,
    estimates_initial: bool,
}

impl RowRun {
    /// The row of `output` over the samples from `first` on.
    pub fn new(
        record: &Deviations,
        output: usize,
        terms: &[Term],
        first: usize,
        estimates_initial: bool,
    ) -> Self {
        let window = first..record.y.nrows();
        let own = Regressor {
            channel: Channel::Output(output),
            lag: 0,
        };
        let na = terms
            .iter()
            .filter(|term| term.channel == own.channel)
            .count();
        Self {
            na,
            inputs: terms[na..]
                .iter()
                .map(|term| record.lagged(term.regressor(), &window).to_vec())
                .collect(),
            before: (1..=na)
                .map(|lag| record.y[(first - lag, output)])
                .collect(),
            measured: record.lagged(own, &window).to_vec(),
            estimates_initial,
        }
    }

    /// The parameters of a row with the measured outputs as the initial ones.
    pub fn start(&self, terms: &[Term]) -> Vec<f64> {
        let mut parameters: Vec<f64> = terms.iter().map(|term| term.coefficient).collect();
        if self.estimates_initial {
            parameters.extend(&self.before);
        }
        parameters
    }

    /// Number of coefficients of the row.
    pub fn coefficients(&self) -> usize {
        self.na + self.inputs.len()
    }

    /// Own-output coefficients among the parameters.
    pub fn own_lags<'a>(&self, parameters: &'a [f64]) -> &'a [f64] {
        &parameters[..self.na]
    }

    fn initial<'a>(&'a self, parameters: &'a [f64]) -> &'a [f64] {
        if self.estimates_initial {
            &parameters[self.coefficients()..]
        } else {
            &self.before
        }
    }

    /// The free run over the window.
    pub fn outputs(&self, parameters: &[f64]) -> Vec<f64> {
        let beta = &parameters[self.na..self.coefficients()];
        let mut forced = vec![0.0; self.measured.len()];
        for (column, beta) in self.inputs.iter().zip(beta) {
            for (sum, value) in forced.iter_mut().zip(column) {
                *sum += beta * value;
            }
        }
        filtered(
            self.own_lags(parameters),
            self.initial(parameters),
            forced.into_iter(),
        )
    }

    /// Measured minus free run.
    pub fn errors(&self, parameters: &[f64]) -> Vec<f64> {
        let run = self.outputs(parameters);
        self.measured
            .iter()
            .zip(run)
            .map(|(y, run)| y - run)
            .collect()
    }

    /// The derivative of the free run (`window x parameters`): every column is a signal filtered
    /// by `1 / A`, namely the run itself at lag k, an input at its lag, or an initial output.
    pub fn gradient(&self, parameters: &[f64]) -> DMatrix<f64> {
        let (own, initial) = (self.own_lags(parameters), self.initial(parameters));
        let run = self.outputs(parameters);
        let rest = vec![0.0; self.na];
        let mut gradient = DMatrix::zeros(run.len(), parameters.len());
        for lag in 1..=self.na {
            let earlier = initial[..lag].iter().rev().chain(&run).copied();
            let column = filtered(own, &rest, earlier.take(run.len()));
            gradient.column_mut(lag - 1).copy_from_slice(&column);
        }
        for (index, input) in self.inputs.iter().enumerate() {
            let column = filtered(own, &rest, input.iter().copied());
            gradient
                .column_mut(self.na + index)
                .copy_from_slice(&column);
        }
        if self.estimates_initial {
            for lag in 0..self.na {
                let mut unit = rest.clone();
                unit[lag] = 1.0;
                let column = filtered(own, &unit, std::iter::repeat_n(0.0, run.len()));
                gradient
                    .column_mut(self.coefficients() + lag)
                    .copy_from_slice(&column);
            }
        }
        gradient
    }
}

/// `out(t) = source(t) + sum of own_k out(t - k)`, with `before` as the outputs before the first
/// sample, the latest first.
fn filtered(own: &[f64], before: &[f64], source: impl Iterator<Item = f64>) -> Vec<f64> {
    let n = own.len();
    let mut out: Vec<f64> = before.iter().rev().copied().collect();
    out.reserve(source.size_hint().0);
    for value in source {
        let past = out[out.len() - n..].iter().rev();
        let sum: f64 = own.iter().zip(past).map(|(own, past)| own * past).sum();
        out.push(value + sum);
    }
    out.split_off(n)
}
