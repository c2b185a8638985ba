//! How well a model explains a record.

use std::ops::Range;

use gt_core::{Dataset, Signal};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::regressor::check_varies;
use crate::{
    ArxModel, IdentError, RecordOrigin, ResidualOptions, ResidualVerdict, Start, test_residuals,
};

/// The errors of a model on a record, one step ahead and in free run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Validation {
    /// The samples that count: all but the first `max_lag` of each record, as if they were one.
    pub rows: Range<usize>,
    /// One entry per output.
    pub outputs: Vec<OutputFit>,
    /// Whether the errors one step ahead are white and independent of past inputs, on the longest
    /// record. Taken for another record than that of the fit while it is that one, or a part of it,
    /// the tests are cautious: they reject too seldom. `None` where no test was asked for, the
    /// record is too short for one or its errors are rounding only.
    pub residuals: Option<ResidualVerdict>,
}

/// The errors of one output. `prediction` is one step ahead, `simulation` is the free run from the
/// [`Start`] that was asked for, `None` where that diverges.
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
    /// Time at which the free run diverges, in seconds; the earliest of several records.
    pub diverges_at_s: Option<f64>,
}

/// What the records of a validation are, and where their free runs start.
///
/// | Name | Default | Purpose |
/// |---|---|---|
/// | `origin` | `Fresh` | what a single record is to the model; one of several is taken as fresh |
/// | `start` | `Measured` | where free runs start; `Fitted` for records that are noisy, above all for the relation of an errors-in-variables model |
/// | `residual_tests` | yes | whether the one-step errors are tested: most of the time of a validation |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ValidationOptions {
    /// What the record is to the model.
    pub origin: RecordOrigin,
    /// Where a free run starts.
    pub start: Start,
    /// Whether the one-step errors are tested.
    pub residual_tests: bool,
}

impl Default for ValidationOptions {
    fn default() -> Self {
        Self {
            origin: RecordOrigin::Fresh,
            start: Start::Measured,
            residual_tests: true,
        }
    }
}

/// The errors of `model` on `data`, a record other than that of the fit; the free run starts from
/// the first `max_lag` measured outputs.
///
/// # Errors
/// As [`validate_records`].
pub fn validate(model: &ArxModel, data: &Dataset) -> Result<Validation, IdentError> {
    validate_records(model, &[data], ValidationOptions::default())
}

/// The errors of `model` on several records without gaps (see [`crate::unbroken`]) as on one: no
/// prediction reaches from one into another, and each free run has a start of its own. Records of at
/// most `max_lag` samples do not count.
///
/// # Errors
/// [`IdentError::NoRecords`]; as [`ArxModel::predict`]; [`IdentError::TooFewRows`] where no record
/// has `max_lag + 2` samples; [`IdentError::ConstantChannel`] for an output that does not vary over
/// the samples that count.
pub fn validate_records(
    model: &ArxModel,
    records: &[&Dataset],
    options: ValidationOptions,
) -> Result<Validation, IdentError> {
    for data in records {
        model.check_record(data)?;
    }
    let longest = records.iter().max_by_key(|data| data.len());
    let longest = *longest.ok_or(IdentError::NoRecords)?;
    let lag = model.max_lag();
    let needed = lag.saturating_add(2);
    if longest.len() < needed {
        let structure = model.structure().to_string();
        return Err(IdentError::TooFewRows {
            structure,
            needed,
            found: longest.len(),
        });
    }
    let mut samples: Vec<Samples> = model.outputs().iter().map(|_| Samples::default()).collect();
    for data in records.iter().filter(|data| data.len() > lag) {
        let predicted = model.predict(data)?;
        let free_run = model.simulate_from(data, options.start)?;
        for (index, samples) in samples.iter_mut().enumerate() {
            let over = |matrix: &DMatrix<f64>| -> Vec<f64> {
                matrix.row(index).iter().skip(lag).copied().collect()
            };
            samples.measured.extend(over(data.y()));
            samples.predicted.extend(over(&predicted));
            samples.simulated.extend(over(&free_run.y));
            let diverges_at_s = free_run.diverges_at[index].map(|sample| data.time_s(sample));
            samples.diverges_at_s = [samples.diverges_at_s, diverges_at_s]
                .into_iter()
                .flatten()
                .reduce(f64::min);
        }
    }
    let count = samples.first().map_or(0, |samples| samples.measured.len());
    let outputs = model.outputs().iter().zip(&samples);
    let outputs = outputs
        .map(|(signal, samples)| samples.fit(signal))
        .collect::<Result<_, _>>()?;
    let origin = if records.len() == 1 {
        options.origin
    } else {
        RecordOrigin::Fresh
    };
    let residuals = if options.residual_tests {
        residual_verdict(model, longest, longest.len() - lag, origin)?
    } else {
        None
    };
    Ok(Validation {
        residuals,
        rows: lag..lag + count,
        outputs,
    })
}

/// The samples of one output that count, of all records.
#[derive(Default)]
struct Samples {
    measured: Vec<f64>,
    predicted: Vec<f64>,
    simulated: Vec<f64>,
    diverges_at_s: Option<f64>,
}

impl Samples {
    fn fit(&self, signal: &Signal) -> Result<OutputFit, IdentError> {
        check_varies(signal, self.measured.iter().copied())?;
        let prediction = Errors::new(&self.measured, &self.predicted);
        let simulation = match self.diverges_at_s {
            Some(_) => None,
            None => Some(Errors::new(&self.measured, &self.simulated)),
        };
        Ok(OutputFit {
            name: signal.name.clone(),
            fit_prediction_percent: prediction.fit_percent,
            fit_simulation_percent: simulation.as_ref().map(|errors| errors.fit_percent),
            ppcre_prediction_percent: prediction.ppcre_percent,
            ppcre_simulation_percent: simulation.as_ref().map(|errors| errors.ppcre_percent),
            sse_prediction: prediction.sse,
            sse_simulation: simulation.as_ref().map(|errors| errors.sse),
            diverges_at_s: self.diverges_at_s,
        })
    }
}

/// The verdict of the tests at the default options for so many rows.
fn residual_verdict(
    model: &ArxModel,
    data: &Dataset,
    rows: usize,
    origin: RecordOrigin,
) -> Result<Option<ResidualVerdict>, IdentError> {
    let options = ResidualOptions {
        origin,
        ..ResidualOptions::for_residuals(rows)
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
