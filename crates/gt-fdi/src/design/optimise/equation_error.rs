//! The equation error of a model's ARX form, from which every observer's residual follows.

use gt_core::{Dataset, DimensionError, OperatingPoint, StateSpace};
use nalgebra::{DMatrix, DVector};

use super::super::channels::Channels;
use super::super::observer::{Canonical, check_single_output};
use super::error::SearchError;
use super::record_pair::RecordPair;
use crate::FdiError;

/// `eps = A(z^-1) (y - y0) - sum_j B_j(z^-1) (u_j - u0_j)` from rest, for a model with one output:
/// the residual of every observer of the model is `eps / P(z^-1)`.
pub(super) struct EquationError<'a> {
    model: &'a StateSpace,
    point: &'a OperatingPoint,
    /// Coefficients of `A`, that of `z^-l` at index `l` (nx + 1).
    a: Vec<f64>,
    /// Those of `B_j` in row `j` (nu x nx + 1).
    b: DMatrix<f64>,
}

/// Deviations from the operating point: inputs (nu x N) and output (N).
struct Deviations {
    u: DMatrix<f64>,
    y: DVector<f64>,
}

/// Where a record comes from, for errors.
#[derive(Clone, Copy)]
struct Source {
    set: &'static str,
    pair: usize,
    record: &'static str,
}

/// The equation errors of a pair.
pub(super) struct PairErrors {
    pub(super) healthy: Vec<f64>,
    pub(super) faulty: Vec<f64>,
    /// That of the differences of the two records' signals.
    pub(super) difference: Vec<f64>,
}

impl<'a> EquationError<'a> {
    pub(super) fn of(model: &'a StateSpace, point: &'a OperatingPoint) -> Result<Self, FdiError> {
        check_single_output(model)?;
        DimensionError::check("inputs of the operating point", model.nu(), point.u.len())?;
        DimensionError::check("outputs of the operating point", model.ny(), point.y.len())?;
        let nx = model.nx();
        if nx == 0 {
            let output = model.outputs()[0].name.clone();
            return Err(SearchError::NoStates { output }.into());
        }
        let a: Vec<f64> = Canonical::of(model)?.polynomial.into_iter().rev().collect();
        let markov = model.markov_parameters(nx + 1);
        let b = DMatrix::from_fn(model.nu(), nx + 1, |j, k| {
            (0..=k).map(|i| a[i] * markov[k - i][(0, j)]).sum()
        });
        Ok(Self { model, point, a, b })
    }

    /// The errors of a pair of records, which are found by name.
    pub(super) fn pair(
        &self,
        set: &'static str,
        pair: usize,
        records: RecordPair,
    ) -> Result<PairErrors, FdiError> {
        let (expected, found) = (records.healthy.len(), records.faulty.len());
        if expected != found {
            return Err(SearchError::Length {
                set,
                pair,
                expected,
                found,
            }
            .into());
        }
        let source = |record| Source { set, pair, record };
        let healthy = self.deviations(records.healthy, source("healthy"))?;
        let faulty = self.deviations(records.faulty, source("faulty"))?;
        let difference = Deviations {
            u: &faulty.u - &healthy.u,
            y: &faulty.y - &healthy.y,
        };
        Ok(PairErrors {
            healthy: self.apply(&healthy),
            faulty: self.apply(&faulty),
            difference: self.apply(&difference),
        })
    }

    fn deviations(&self, data: &Dataset, source: Source) -> Result<Deviations, FdiError> {
        let (nu, len) = (self.model.nu(), data.len());
        let inputs: Vec<&str> = self
            .model
            .inputs()
            .iter()
            .map(|s| s.name.as_str())
            .collect();
        let output = self.model.outputs()[0].name.as_str();
        let mut channels = Channels::of(data, self.model.sample_time_s(), &inputs, &[output])?;
        let mut found = Deviations {
            u: DMatrix::zeros(nu, len),
            y: DVector::zeros(len),
        };
        for sample in 0..len {
            let (u, y) = channels.at(sample);
            let mut named = inputs.iter().zip(u).chain([(&output, &y[0])]);
            if let Some((signal, &found)) = named.find(|(_, value)| !value.is_finite()) {
                return Err(SearchError::NotFinite {
                    set: source.set,
                    pair: source.pair,
                    record: source.record,
                    signal: (*signal).to_owned(),
                    sample,
                    found,
                }
                .into());
            }
            for (j, value) in u.iter().enumerate() {
                found.u[(j, sample)] = value - self.point.u[j];
            }
            found.y[sample] = y[0] - self.point.y[0];
        }
        Ok(found)
    }

    fn apply(&self, deviations: &Deviations) -> Vec<f64> {
        let Deviations { u, y } = deviations;
        let error = |t: usize| {
            let lags = (self.a.len() - 1).min(t);
            let terms = (0..=lags).map(|k| {
                let of_inputs = self.b.column(k).dot(&u.column(t - k));
                self.a[k] * y[t - k] - of_inputs
            });
            terms.sum()
        };
        (0..y.len()).map(error).collect()
    }
}
