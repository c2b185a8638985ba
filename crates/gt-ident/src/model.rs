//! The fitted ARX model.

use gt_core::{Dataset, DimensionError, OperatingPoint, Signal};
use serde::{Deserialize, Serialize};

use crate::{ArxStructure, Channel, IdentError, Regressor};

/// One term of a row: `coefficient * channel(t - lag)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// The channel.
    pub channel: Channel,
    /// The lag in samples.
    pub lag: usize,
    /// The coefficient, in units of the output per unit of the channel.
    pub coefficient: f64,
}

impl Term {
    pub(crate) fn new(regressor: Regressor, coefficient: f64) -> Self {
        Self {
            channel: regressor.channel,
            lag: regressor.lag,
            coefficient,
        }
    }

    /// The lagged channel.
    pub fn regressor(&self) -> Regressor {
        Regressor {
            channel: self.channel,
            lag: self.lag,
        }
    }
}

/// The equation of one output, in deviations from the operating point:
/// `y_i(t) = sum of coefficient * channel(t - lag) + e_i(t)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArxRow {
    /// The terms: outputs before inputs, recent lags first, channels in order within a lag.
    pub terms: Vec<Term>,
    /// Mean square of the equation error over the regression rows (residual sum of squares / T).
    pub residual_variance: f64,
}

/// A fitted ARX model.
///
/// It works on the units of the record it was fitted to; the means of that record are its
/// operating point. Deserialisation checks what the fit guarantees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Fitted", into = "Fitted")]
pub struct ArxModel {
    fitted: Fitted,
    max_lag: usize,
}

/// The fields of an [`ArxModel`] as they stand in a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Fitted {
    pub inputs: Vec<Signal>,
    pub outputs: Vec<Signal>,
    pub sample_time_s: f64,
    pub operating_point: OperatingPoint,
    pub structure: ArxStructure,
    pub rows: Vec<ArxRow>,
    pub rows_used: usize,
    pub condition: Vec<f64>,
    /// One list a row, as long as its terms; files of older versions have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_errors: Option<Vec<Vec<f64>>>,
}

impl TryFrom<Fitted> for ArxModel {
    type Error = IdentError;

    fn try_from(fitted: Fitted) -> Result<Self, IdentError> {
        Self::new(fitted)
    }
}

impl From<ArxModel> for Fitted {
    fn from(model: ArxModel) -> Self {
        model.fitted
    }
}

impl ArxModel {
    pub(crate) fn new(fitted: Fitted) -> Result<Self, IdentError> {
        let (nu, ny) = (fitted.inputs.len(), fitted.outputs.len());
        // The record's own check covers names and sample time.
        Dataset::new(
            fitted.inputs.clone(),
            fitted.outputs.clone(),
            nalgebra::DMatrix::zeros(nu, 0),
            nalgebra::DMatrix::zeros(ny, 0),
            fitted.sample_time_s,
        )?;
        fitted.structure.validate(nu, ny)?;
        DimensionError::check(
            "operating point, inputs",
            nu,
            fitted.operating_point.u.len(),
        )?;
        DimensionError::check(
            "operating point, outputs",
            ny,
            fitted.operating_point.y.len(),
        )?;
        DimensionError::check("rows (outputs)", ny, fitted.rows.len())?;
        DimensionError::check("conditions (outputs)", ny, fitted.condition.len())?;
        for (index, row) in fitted.rows.iter().enumerate() {
            check_row(&fitted.structure, index, row, nu, ny)?;
        }
        let point = fitted
            .operating_point
            .u
            .iter()
            .chain(fitted.operating_point.y.iter());
        if let Some(&found) = point.into_iter().find(|value| !value.is_finite()) {
            let what = "operating point".to_owned();
            return Err(IdentError::ModelValue {
                what,
                expected: "a finite number",
                found,
            });
        }
        if let Some(&found) = fitted
            .condition
            .iter()
            .find(|value| !(1.0..).contains(*value))
        {
            let what = "condition".to_owned();
            return Err(IdentError::ModelValue {
                what,
                expected: "a number of at least 1",
                found,
            });
        }
        if let Some(lists) = &fitted.standard_errors {
            check_standard_errors(lists, &fitted.rows)?;
        }
        let max_lag = fitted.structure.max_lag(nu);
        Ok(Self { fitted, max_lag })
    }

    /// The same model with other coefficients and standard errors, functions of the output and the
    /// regressor; its residual variances are those of the equation error on `data`. A standard
    /// error that is not finite leaves the model without any.
    pub(crate) fn with_coefficients(
        &self,
        data: &Dataset,
        coefficient: impl Fn(usize, Regressor) -> f64,
        standard_error: Option<impl Fn(usize, Regressor) -> f64>,
    ) -> Result<Self, IdentError> {
        let mut fitted = self.fitted.clone();
        let rows = fitted.rows.iter().enumerate();
        fitted.standard_errors = standard_error
            .map(|of| {
                let list = |(output, row): (usize, &ArxRow)| {
                    let terms = row.terms.iter();
                    terms.map(|term| of(output, term.regressor())).collect()
                };
                rows.map(list).collect::<Vec<Vec<f64>>>()
            })
            .filter(|lists| lists.iter().flatten().all(|error| error.is_finite()));
        for (output, row) in fitted.rows.iter_mut().enumerate() {
            for term in &mut row.terms {
                term.coefficient = coefficient(output, term.regressor());
            }
        }
        let error = Self::new(fitted.clone())?.equation_error(data)?;
        for (output, row) in fitted.rows.iter_mut().enumerate() {
            let counted = error.row(output).into_iter().skip(self.max_lag);
            let rows = error.ncols() - self.max_lag;
            row.residual_variance = counted.map(|e| e * e).sum::<f64>() / rows as f64;
        }
        Self::new(fitted)
    }

    /// The same model with other equations of the same structure; the standard errors, which were
    /// those of the fit, are gone.
    pub(crate) fn with_rows(&self, rows: Vec<ArxRow>) -> Result<Self, IdentError> {
        Self::new(Fitted {
            rows,
            standard_errors: None,
            ..self.fitted.clone()
        })
    }

    /// The input signals (nu).
    pub fn inputs(&self) -> &[Signal] {
        &self.fitted.inputs
    }

    /// The output signals (ny).
    pub fn outputs(&self) -> &[Signal] {
        &self.fitted.outputs
    }

    /// Sample time in seconds.
    pub fn sample_time_s(&self) -> f64 {
        self.fitted.sample_time_s
    }

    /// The operating point of the fit: the means of the training records unless the fit was asked
    /// for another.
    pub fn operating_point(&self) -> &OperatingPoint {
        &self.fitted.operating_point
    }

    /// The structure.
    pub fn structure(&self) -> &ArxStructure {
        &self.fitted.structure
    }

    /// The equations, one per output.
    pub fn rows(&self) -> &[ArxRow] {
        &self.fitted.rows
    }

    /// The longest lag in samples.
    pub fn max_lag(&self) -> usize {
        self.max_lag
    }

    /// Number of samples in the regression.
    pub fn rows_used(&self) -> usize {
        self.fitted.rows_used
    }

    /// Condition of the column-scaled regressor matrix, one per output: the ratio of its extreme
    /// singular values, from the triangular factor.
    pub fn condition(&self) -> &[f64] {
        &self.fitted.condition
    }

    /// Standard errors of the coefficients, a list a row in the order of its terms and their units:
    /// the roots of the diagonal of `s^2 (Phi' Phi)^-1` with `s^2 = RSS / (T - d)` for `T` rows and
    /// `d` coefficients in the row. They hold for white equation errors; with a ridge they are the
    /// spread only, not the bias. None for a model from a file that has none.
    pub fn standard_errors(&self) -> Option<&[Vec<f64>]> {
        self.fitted.standard_errors.as_deref()
    }

    /// Refuses a record with other channels, units or sample time than the model's.
    pub(crate) fn check_record(&self, data: &Dataset) -> Result<(), IdentError> {
        DimensionError::check("inputs of the record", self.inputs().len(), data.nu())?;
        DimensionError::check("outputs of the record", self.outputs().len(), data.ny())?;
        check_signals("input", self.inputs(), data.inputs())?;
        check_signals("output", self.outputs(), data.outputs())?;
        let (expected, found) = (self.sample_time_s(), data.sample_time_s());
        // Sample times often come from differences of time stamps.
        if (expected - found).abs() > 1e-6 * expected {
            return Err(IdentError::SampleTime { expected, found });
        }
        Ok(())
    }
}

fn check_standard_errors(lists: &[Vec<f64>], rows: &[ArxRow]) -> Result<(), IdentError> {
    DimensionError::check("standard errors (outputs)", rows.len(), lists.len())?;
    for (index, (list, row)) in lists.iter().zip(rows).enumerate() {
        let what = format!("standard errors of row {index}");
        DimensionError::check(&what, row.terms.len(), list.len())?;
        if let Some(&found) = list
            .iter()
            .find(|value| !(0.0..f64::INFINITY).contains(*value))
        {
            return Err(IdentError::ModelValue {
                what,
                expected: "finite numbers of at least 0",
                found,
            });
        }
    }
    Ok(())
}

/// Refuses signals with other names than expected, or with another unit where both are known.
pub(crate) fn check_signals(
    side: &'static str,
    expected: &[Signal],
    found: &[Signal],
) -> Result<(), IdentError> {
    for (position, (model, record)) in expected.iter().zip(found).enumerate() {
        if model.name != record.name {
            let (expected, found) = (model.name.clone(), record.name.clone());
            return Err(IdentError::ChannelName {
                side,
                position,
                expected,
                found,
            });
        }
        let known = !model.unit.is_empty() && !record.unit.is_empty();
        if known && model.unit != record.unit {
            return Err(IdentError::ChannelUnit {
                channel: model.name.clone(),
                expected: model.unit.clone(),
                found: record.unit.clone(),
            });
        }
    }
    Ok(())
}

fn check_row(
    structure: &ArxStructure,
    index: usize,
    row: &ArxRow,
    nu: usize,
    ny: usize,
) -> Result<(), IdentError> {
    let count = structure.row_parameters(index, nu, ny);
    DimensionError::check(&format!("terms of row {index}"), count, row.terms.len())?;
    let regressors = structure.regressors(index, nu, ny)?;
    for (position, (term, expected)) in row.terms.iter().zip(&regressors).enumerate() {
        if term.regressor() != *expected {
            return Err(IdentError::TermMismatch {
                row: index,
                term: position,
                expected: expected.to_string(),
                found: term.regressor().to_string(),
            });
        }
        if !term.coefficient.is_finite() {
            return Err(IdentError::ModelValue {
                what: format!("row {index}, term {position}, coefficient"),
                expected: "a finite number",
                found: term.coefficient,
            });
        }
    }
    if !(0.0..f64::INFINITY).contains(&row.residual_variance) {
        return Err(IdentError::ModelValue {
            what: format!("row {index}, residual variance"),
            expected: "a finite number of at least 0",
            found: row.residual_variance,
        });
    }
    Ok(())
}
