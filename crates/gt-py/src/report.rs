//! `write_report`: a page about a model, or about what a detector finds in a record.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gt_campaign::report::Document;
use gt_campaign::reports::{
    ModelReport, OrderComparison, Provenance, detection_report, isolation_report, model_report,
};
use gtfdi::core::{Dataset, Signal, Stop as _};
use gtfdi::ident::eiv::EivModel;
use gtfdi::ident::{ArxModel, Start, ValidationOptions, validate_records};
use nalgebra::DMatrix;
use pyo3::prelude::*;

use crate::arx_fit::PyArxFit;
use crate::arx_model::PyArxModel;
use crate::bank::PyBank;
use crate::eiv_model::PyEivModel;
use crate::eiv_order_table::PyEivOrderTable;
use crate::error::Failure;
use crate::interrupt::{Abandoned, interruptible};
use crate::isolator::PyIsolator;
use crate::order_table::PyOrderTable;
use crate::record::Given;

/// What a report is about.
#[derive(FromPyObject)]
pub enum Subject<'py> {
    /// What a bank finds.
    #[pyo3(annotation = "Bank")]
    Bank(Bound<'py, PyBank>),
    /// What an isolator finds.
    #[pyo3(annotation = "Isolator")]
    Isolator(Bound<'py, PyIsolator>),
    /// A model with the covariance of its coefficients.
    #[pyo3(annotation = "ArxFit")]
    Fit(Bound<'py, PyArxFit>),
    /// A model.
    #[pyo3(annotation = "ArxModel")]
    Arx(Bound<'py, PyArxModel>),
    /// A model with the noise on its channels.
    #[pyo3(annotation = "EivModel")]
    Eiv(Bound<'py, PyEivModel>),
}

/// What the orders were compared by.
#[derive(FromPyObject)]
pub enum Orders<'py> {
    /// Least squares.
    #[pyo3(annotation = "OrderTable")]
    Arx(Bound<'py, PyOrderTable>),
    /// Errors in variables.
    #[pyo3(annotation = "EivOrderTable")]
    Eiv(Bound<'py, PyEivOrderTable>),
}

impl Orders<'_> {
    fn comparison(&self) -> OrderComparison {
        match self {
            Self::Arx(table) => OrderComparison::Arx(table.get().inner.clone()),
            Self::Eiv(table) => OrderComparison::Eiv(table.get().inner.clone()),
        }
    }
}

/// Writes a report into a folder: ``index.html``, which needs nothing else and asks for no network,
/// and each of its charts as SVG and CSV below ``figures``.
///
/// Of a model it shows the errors on the record, prediction and free run, tests of the one-step
/// errors, equations, poles, zeros and frequency responses, with their errors where ``subject`` is
/// an ``ArxFit``, and the noise of an ``EivModel``. Of a bank or an isolator it shows what it finds in
/// the record: alarms, promises, residuals and statistics with their limits.
///
/// Parameters
/// ----------
/// folder : path
///     Made where it is missing; files of the same names are replaced.
/// subject : Bank, Isolator, ArxFit, ArxModel or EivModel
///     What the report is about.
/// u, y
///     The record: a Dataset, or arrays with the channels of ``subject``.
/// orders : OrderTable or EivOrderTable, optional
///     The orders that a model's was chosen among: shown as a table and a chart, with the order that
///     its criterion takes.
///
/// Raises
/// ------
/// OptionError
///     ``orders`` for a bank or an isolator.
/// DataError, DesignError, IdentError
///     A record that does not fit.
/// LogError
///     A folder or file that cannot be made or written.
///
/// Examples
/// --------
/// >>> gtfdi.write_report("report", model, run.measured)
/// >>> gtfdi.write_report("found", bank, run.measured)
#[pyfunction]
#[pyo3(signature = (folder, subject, u, y=None, *, orders=None))]
pub fn write_report(
    py: Python<'_>,
    folder: PathBuf,
    subject: Subject<'_>,
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    orders: Option<Orders<'_>>,
) -> Result<(), Failure> {
    let orders = orders.map(|orders| orders.comparison());
    let is_model = !matches!(subject, Subject::Bank(_) | Subject::Isolator(_));
    if orders.is_some() && !is_model {
        return Err(Failure::Option {
            option: "orders",
            expected: "a model that they are of".to_owned(),
            found: "a detector".to_owned(),
        });
    }
    let given = Given::new(u, y)?;
    match &subject {
        Subject::Bank(bank) => {
            let bank = Arc::clone(&bank.get().inner);
            let data = narrowed(given, &bank.inputs(), &bank.outputs(), bank.sample_time_s())?;
            interruptible(py, move |abandoned| {
                let run = bank.run_until(&data, abandoned)?;
                let document = detection_report(&bank, &data, &run, &Provenance::default());
                write(&document, &folder, abandoned)
            })
        }
        Subject::Isolator(isolator) => {
            let isolator = Arc::clone(&isolator.get().inner);
            let (inputs, outputs) = (isolator.inputs(), isolator.outputs());
            let data = narrowed(given, &inputs, &outputs, isolator.sample_time_s())?;
            interruptible(py, move |abandoned| {
                let document =
                    isolation_report(&isolator, &data, &Provenance::default(), abandoned)?;
                write(&document, &folder, abandoned)
            })
        }
        Subject::Fit(fit) => {
            let fit = fit.get();
            let about = About {
                model: fit.model.clone(),
                method: "arx",
                noise: None,
                covariances: Some(fit.covariance.clone()),
                orders,
            };
            about.write(py, given, folder)
        }
        Subject::Arx(model) => {
            let about = About {
                model: model.get().inner.clone(),
                method: "arx",
                noise: None,
                covariances: None,
                orders,
            };
            about.write(py, given, folder)
        }
        Subject::Eiv(model) => {
            let noise = &model.get().inner;
            let about = About {
                model: noise.relation().clone(),
                method: "eiv",
                noise: Some(noise.clone()),
                covariances: None,
                orders,
            };
            about.write(py, given, folder)
        }
    }
}

/// Writes a report, unless nobody waits for it any more.
fn write(document: &Document, folder: &Path, abandoned: &Abandoned) -> Result<(), Failure> {
    abandoned.check()?;
    Ok(document.write(folder)?)
}

/// The record for a detector, which knows its channels by name alone.
fn narrowed(
    given: Given<'_>,
    inputs: &[String],
    outputs: &[String],
    sample_time_s: f64,
) -> Result<Arc<Dataset>, Failure> {
    given.known(
        &Signal::named(inputs),
        &Signal::named(outputs),
        sample_time_s,
    )
}

/// A model with what its kind knows of it.
struct About {
    model: ArxModel,
    method: &'static str,
    noise: Option<EivModel>,
    covariances: Option<Vec<DMatrix<f64>>>,
    orders: Option<OrderComparison>,
}

impl About {
    fn write(self, py: Python<'_>, given: Given<'_>, folder: PathBuf) -> Result<(), Failure> {
        let model = &self.model;
        let data = given.known(model.inputs(), model.outputs(), model.sample_time_s())?;
        // Noise on the first samples would ring through a run that takes them as they are.
        let start = match self.noise {
            Some(_) => Start::Fitted,
            None => Start::Measured,
        };
        interruptible(py, move |abandoned| {
            let options = ValidationOptions {
                start,
                // The page tests them.
                residual_tests: false,
                ..ValidationOptions::default()
            };
            let records: [&Dataset; 1] = [&data];
            let scores = validate_records(&self.model, &records, options)?;
            abandoned.check()?;
            let report = ModelReport {
                model: &self.model,
                method: self.method,
                noise: self.noise.as_ref(),
                covariances: self.covariances.as_deref(),
                train_samples: self.model.rows_used(),
                validation: &records,
                scores: &scores,
                start,
                orders: self.orders.as_ref().map(OrderComparison::shown),
                findings: Vec::new(),
            };
            let document = model_report(&report, &Provenance::default(), abandoned)?;
            write(&document, &folder, abandoned)
        })
    }
}
