//! How well a model explains a record.

use std::ops::Range;

use gt_core::Dataset;
use serde::Serialize;

use crate::regressor::check_varies;
use crate::{ArxModel, IdentError, ResidualOptions, ResidualVerdict, Start, test_residuals};

/// The errors of a model on a record, one step ahead and in free run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Validation {
    /// The samples that count: all but the first `max_lag`.
    pub rows: Range<usize>,
    /// One entry per output.
    pub outputs: Vec<OutputFit>,
    /// Whether the errors one step ahead are white and independent of past inputs, for a record
    /// other than that of the fit (on that one the tests are cautious: they reject too seldom).
    /// `None` where the record is too short for a test or its errors are rounding only.
    pub residuals: Option<ResidualVerdict>,
}

/// The errors of one output. `prediction` is one step ahead, `simulation` is the free run, `None` where
/// that diverges.
///
/// With `e = y - yhat` over the rows that count: fit `= 100 (1 - |e| / |y - mean y|)`,
/// PPCRE `= 100 std(e) / std(y)`, SSE `= mean(e^2) / var(y)`; population moments.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutputFit {
    /// The output's name.
    pub name: String,
    /// Fit one step ahead, per cent; 100 is perfect, 0 is no better than the mean.
    pub fit_prediction_percent: f64,
    /// Fit of the free run, per cent.
    pub fit_simulation_percent: Option<f64>,
    /// Reconstruction error one step ahead, per cent (footnote 2 of the paper).
    pub ppcre_prediction_percent: f64,
    /// Reconstruction error of the free run, per cent.
    pub ppcre_simulation_percent: Option<f64>,
    /// Mean square error one step ahead over the output's variance.
    pub sse_prediction: f64,
    /// Mean square error of the free run over the output's variance.
    pub sse_simulation: Option<f64>,
    /// Time at which the free run diverges, in seconds.
    pub diverges_at_s: Option<f64>,
}

/// Residuals that the verdict takes for each lag of its correlations.
const SAMPLES_PER_LAG: usize = 5;

/// The errors of `model` on `data`; the free run starts from the first `max_lag` measured outputs.
///
/// # Errors
/// As [`validate_from`].
pub fn validate(model: &ArxModel, data: &Dataset) -> Result<Validation, IdentError> {
    validate_from(model, data, Start::Measured)
}

/// The errors of `model` on `data`, with the free run from the given start: [`Start::Fitted`] for a
/// record that is noisy, above all for the relation of an errors-in-variables model.
///
/// # Errors
/// As [`ArxModel::predict`]; [`IdentError::TooFewRows`] below `max_lag + 2` samples;
/// [`IdentError::ConstantChannel`] for an output that does not vary over the rows that count.
pub fn validate_from(
    model: &ArxModel,
    data: &Dataset,
    start: Start,
) -> Result<Validation, IdentError> {
    model.check_record(data)?;
    let needed = model.max_lag().saturating_add(2);
    if data.len() < needed {
        let structure = model.structure().to_string();
        return Err(IdentError::TooFewRows {
            structure,
            needed,
            found: data.len(),
        });
    }
    let predicted = model.predict(data)?;
    let free_run = model.simulate_from(data, start)?;
    let rows = model.max_lag()..data.len();
    let mut outputs = Vec::with_capacity(data.ny());
    for (index, signal) in data.outputs().iter().enumerate() {
        let over = |matrix: &nalgebra::DMatrix<f64>| -> Vec<f64> {
            matrix.row(index).iter().skip(rows.start).copied().collect()
        };
        let y = over(data.y());
        check_varies(signal, y.iter().copied())?;
        let prediction = Errors::new(&y, &over(&predicted));
        let diverges_at = free_run.diverges_at[index];
        let simulation = match diverges_at {
            Some(_) => None,
            None => Some(Errors::new(&y, &over(&free_run.y))),
        };
        outputs.push(OutputFit {
            name: signal.name.clone(),
            fit_prediction_percent: prediction.fit_percent,
            fit_simulation_percent: simulation.as_ref().map(|errors| errors.fit_percent),
            ppcre_prediction_percent: prediction.ppcre_percent,
            ppcre_simulation_percent: simulation.as_ref().map(|errors| errors.ppcre_percent),
            sse_prediction: prediction.sse,
            sse_simulation: simulation.as_ref().map(|errors| errors.sse),
            diverges_at_s: diverges_at.map(|sample| data.time_s(sample)),
        });
    }
    Ok(Validation {
        residuals: residual_verdict(model, data, rows.len())?,
        rows,
        outputs,
    })
}

/// The verdict of the tests at their default options, over fewer lags where the record is short:
/// their laws hold for correlations over many samples.
fn residual_verdict(
    model: &ArxModel,
    data: &Dataset,
    rows: usize,
) -> Result<Option<ResidualVerdict>, IdentError> {
    let defaults = ResidualOptions::default();
    let options = ResidualOptions {
        lags: defaults.lags.min(rows / SAMPLES_PER_LAG),
        ..defaults
    };
    match test_residuals(model, data, &options) {
        Ok(report) => Ok(Some(report.verdict())),
        Err(
            IdentError::TooFewRows { .. }
            | IdentError::ResidualLags { .. }
            | IdentError::NoResidual { .. },
        ) => Ok(None),
        Err(error) => Err(error),
    }
}

struct Errors {
    fit_percent: f64,
    ppcre_percent: f64,
    sse: f64,
}

impl Errors {
    fn new(y: &[f64], estimate: &[f64]) -> Self {
        let error: Vec<f64> = y
            .iter()
            .zip(estimate)
            .map(|(y, estimate)| y - estimate)
            .collect();
        let mean_square = error.iter().map(|e| e * e).sum::<f64>() / error.len() as f64;
        let y_variance = variance(y);
        let sse = mean_square / y_variance;
        Self {
            fit_percent: 100.0 * (1.0 - sse.sqrt()),
            ppcre_percent: 100.0 * (variance(&error) / y_variance).sqrt(),
            sse,
        }
    }
}

/// The population variance.
fn variance(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    values
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / count
}
