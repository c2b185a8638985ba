//! One-step-ahead prediction, equation error and free run of an ARX model.

use gt_core::Dataset;
use nalgebra::DMatrix;

use crate::regressor::Deviations;
use crate::{ArxModel, Channel, IdentError, Term};

/// A free run has diverged where an output leaves the model's operating point by more than this
/// many times the range that it has in the record.
pub const DIVERGENCE_FACTOR: f64 = 1e6;

/// The outputs of a model that sees only the inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeRun {
    /// Outputs in the record's units (`ny x N`); the first `max_lag` columns are the measured
    /// ones, and an output that diverged is NaN from there on.
    pub y: DMatrix<f64>,
    /// For each output, the sample from which the run is not finite or further than
    /// [`DIVERGENCE_FACTOR`] times the output's range in the record from the operating point.
    /// An output that is driven by a diverged one diverges with it.
    pub diverges_at: Vec<Option<usize>>,
}

/// What stands for another output at lag 0.
#[derive(Clone, Copy, PartialEq)]
enum Contemporaneous {
    Measured,
    Predicted,
}

impl ArxModel {
    /// The outputs predicted one step ahead (`ny x N`, in the record's units); the first
    /// `max_lag` columns are NaN.
    ///
    /// Where a row holds another output at lag 0 (canonical structures with `v_j > v_i`, `j < i`),
    /// that output's own prediction stands in for it, so that no output at time `t` is used.
    ///
    /// # Errors
    /// Another set of channels or sample time than the model's, a sample that is not finite, or
    /// fewer than `max_lag + 1` samples.
    pub fn predict(&self, data: &Dataset) -> Result<DMatrix<f64>, IdentError> {
        let record = self.deviations(data)?;
        let mut predicted = self
            .one_step(&record, Contemporaneous::Predicted)
            .transpose();
        for mut column in predicted.column_iter_mut() {
            column += &self.operating_point().y;
        }
        Ok(predicted)
    }

    /// The equation error `e(t)` of eq. 7 (`ny x N`, in the record's units): the measured output
    /// minus its row with every term measured, lag 0 included; the first `max_lag` columns are
    /// NaN. It equals the prediction error unless a row holds another output at lag 0.
    ///
    /// # Errors
    /// As [`ArxModel::predict`].
    pub fn equation_error(&self, data: &Dataset) -> Result<DMatrix<f64>, IdentError> {
        let record = self.deviations(data)?;
        let explained = self.one_step(&record, Contemporaneous::Measured);
        Ok((record.y - explained).transpose())
    }

    /// The outputs of a free run over the record's inputs, started from its first `max_lag`
    /// measured outputs.
    ///
    /// # Errors
    /// As [`ArxModel::predict`].
    pub fn simulate(&self, data: &Dataset) -> Result<FreeRun, IdentError> {
        let record = self.deviations(data)?;
        let limits: Vec<f64> = record
            .y
            .column_iter()
            .map(|y| divergence_limit(y.iter()))
            .collect();
        let mut y = record.y.clone();
        let mut diverges_at = vec![None; y.ncols()];
        for t in self.max_lag()..y.nrows() {
            for (output, row) in self.rows().iter().enumerate() {
                let value: f64 = if diverges_at[output].is_some() {
                    f64::NAN
                } else {
                    row.terms
                        .iter()
                        .map(|term| contribution(term, &y, &record.u, t))
                        .sum()
                };
                if value.abs() <= limits[output] {
                    y[(t, output)] = value;
                } else {
                    y[(t, output)] = f64::NAN;
                    diverges_at[output].get_or_insert(t);
                }
            }
        }
        let mut y = y.transpose();
        for mut column in y.column_iter_mut() {
            column += &self.operating_point().y;
        }
        y.columns_mut(0, self.max_lag())
            .copy_from(&data.y().columns(0, self.max_lag()));
        Ok(FreeRun { y, diverges_at })
    }

    fn deviations(&self, data: &Dataset) -> Result<Deviations, IdentError> {
        self.check_record(data)?;
        let needed = self.max_lag().saturating_add(1);
        if data.len() < needed {
            let structure = self.structure().to_string();
            return Err(IdentError::TooFewRows {
                structure,
                needed,
                found: data.len(),
            });
        }
        Deviations::new(data, self.operating_point())
    }

    /// The explained part of each output (`N x ny`, deviations), a channel a column.
    fn one_step(&self, record: &Deviations, lag_zero: Contemporaneous) -> DMatrix<f64> {
        let samples = record.y.nrows();
        let rows = self.max_lag()..samples;
        let mut explained = DMatrix::from_element(samples, record.y.ncols(), f64::NAN);
        for (output, row) in self.rows().iter().enumerate() {
            let mut sum = vec![0.0; rows.len()];
            for term in &row.terms {
                let earlier = match term.channel {
                    Channel::Output(other)
                        if term.lag == 0 && lag_zero == Contemporaneous::Predicted =>
                    {
                        Some(other)
                    }
                    _ => None,
                };
                let values = match earlier {
                    Some(other) => {
                        &explained.as_slice()[other * samples + rows.start..(other + 1) * samples]
                    }
                    None => record.lagged(term.regressor(), &rows),
                };
                for (total, value) in sum.iter_mut().zip(values) {
                    *total += term.coefficient * value;
                }
            }
            explained
                .view_mut((rows.start, output), (rows.len(), 1))
                .copy_from_slice(&sum);
        }
        explained
    }
}

/// The value of one term at `t` (`y` and `u` are `N x channels`).
pub(crate) fn contribution(term: &Term, y: &DMatrix<f64>, u: &DMatrix<f64>, t: usize) -> f64 {
    let value = match term.channel {
        Channel::Output(index) => y[(t - term.lag, index)],
        Channel::Input(index) => u[(t - term.lag, index)],
    };
    term.coefficient * value
}

/// The deviation beyond which a free run counts as diverged; 1 stands for the range of an output
/// that neither moves nor leaves the operating point.
pub(crate) fn divergence_limit<'a>(deviations: impl Iterator<Item = &'a f64>) -> f64 {
    let (low, high, most) = deviations.fold(
        (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64),
        |(low, high, most), &x| (low.min(x), high.max(x), most.max(x.abs())),
    );
    let range = if high > low { high - low } else { most };
    DIVERGENCE_FACTOR * if range > 0.0 { range } else { 1.0 }
}
