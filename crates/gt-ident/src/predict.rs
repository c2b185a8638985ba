//! One-step-ahead prediction and equation error of an ARX model.

use gt_core::Dataset;
use nalgebra::DMatrix;

use crate::regressor::Deviations;
use crate::{ArxModel, Channel, IdentError};

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

    /// The record as deviations, checked and long enough.
    pub(crate) fn deviations(&self, data: &Dataset) -> Result<Deviations, IdentError> {
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
