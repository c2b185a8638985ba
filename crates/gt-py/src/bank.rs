//! `design`, `Bank` and `Detection`: observers with thresholds over whole records.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use gt_campaign::paper;
use gt_log::{read_json, write_json};
use gtfdi::core::{Dataset, Signal, index_of};
use gtfdi::fdi::{
    Bank, BankRun, Detector, FalseAlarmSummary, OutputDetector, ResidualGenerator, ThresholdRule,
};
use gtfdi::ident::ArxModel;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyType;
use serde::Serialize;

use crate::array::{json_out, json_text, json_value, samples_out};
use crate::arx_model::PyArxModel;
use crate::detector::PyDetector;
use crate::eiv_model::PyEivModel;
use crate::error::Failure;
use crate::observer::Poles;
use crate::record::Given;

/// The bank's name, part of its topics in a log; that of the command line.
const BANK_NAME: &str = "observers";

/// A bank of output observers with fixed thresholds; ``gtfdi.design`` makes one.
#[pyclass(frozen, eq, name = "Bank", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyBank {
    inner: Bank,
}

/// What `Bank.detectors` says of each.
#[derive(Serialize)]
struct DetectorReport<'a> {
    output: &'a str,
    poles: &'a [f64],
    limit: f64,
    consecutive: usize,
    settle_samples: usize,
    false_alarms: FalseAlarmSummary,
}

#[pymethods]
impl PyBank {
    /// The bank's name.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// Tags of all inputs that a generator reads.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.inner.inputs()
    }

    /// Tags of the outputs, in the order of the detectors.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.inner.outputs()
    }

    /// Sample time in seconds.
    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.inner.sample_time_s()
    }

    /// A dictionary for each detector: ``output``, ``poles``, ``limit``, ``consecutive``,
    /// ``settle_samples`` and ``false_alarms``, which were counted when the limit was set.
    #[getter]
    fn detectors<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        let report = |detector: &OutputDetector| {
            json_out(
                py,
                "detector",
                &DetectorReport {
                    output: detector.name(),
                    poles: detector.generator.poles(),
                    limit: detector.threshold.limit,
                    consecutive: detector.threshold.consecutive,
                    settle_samples: detector.generator.settle_samples(),
                    false_alarms: detector.false_alarms,
                },
            )
        };
        let reports: Vec<Bound<'py, PyAny>> = self
            .inner
            .detectors()
            .iter()
            .map(report)
            .collect::<Result<_, Failure>>()?;
        Ok(reports.into_pyobject(py)?)
    }

    /// Runs the bank over a record: a Dataset, or arrays ``u`` and ``y`` with the channels of
    /// ``inputs`` and ``outputs``.
    ///
    /// Examples
    /// --------
    /// >>> bank.detect(run.measured).alarms
    /// []
    #[pyo3(signature = (u, y=None))]
    fn detect(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<PyDetection, Failure> {
        // A Dataset goes to the bank as it is, which finds its channels by name.
        let data = match Given::new(u, y)? {
            Given::Record(data) => data,
            arrays @ Given::Arrays(..) => arrays.known(
                &Signal::named(&self.inner.inputs()),
                &Signal::named(&self.inner.outputs()),
                self.inner.sample_time_s(),
            )?,
        };
        let inner = u.py().detach(|| self.inner.run(&data))?;
        Ok(PyDetection { inner })
    }

    /// The online detector of the bank, with every generator in its initial state (Detector).
    fn detector(&self) -> PyDetector {
        PyDetector::new(Detector::new(&self.inner))
    }

    /// Writes a bank file, as ``gtfdi design --out`` does.
    fn save(&self, py: Python<'_>, path: PathBuf) -> Result<(), Failure> {
        Ok(py.detach(|| write_json(&path, &self.inner))?)
    }

    /// Reads a bank file; it is checked.
    #[classmethod]
    fn load(class: &Bound<'_, PyType>, path: PathBuf) -> Result<Self, Failure> {
        let inner: Bank = class.py().detach(|| read_json(&path))?;
        Ok(Self { inner })
    }

    /// The bank as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("bank", &self.inner)
    }

    /// A bank from the JSON that ``to_json`` gave; it is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        let inner = json_value("bank", text)?;
        Ok(Self { inner })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        Ok((
            slf.get_type().getattr("from_json")?,
            (slf.get().to_json()?,),
        ))
    }

    fn __repr__(&self) -> String {
        format!(
            "Bank({}, inputs: {}, outputs: {}, sample time {} s)",
            self.inner.name,
            self.inner.inputs().join(", "),
            self.inner.outputs().join(", "),
            self.inner.sample_time_s()
        )
    }
}

/// What a bank says of a record.
#[pyclass(frozen, name = "Detection", module = "gtfdi")]
pub struct PyDetection {
    inner: BankRun,
}

#[pymethods]
impl PyDetection {
    /// Times of the samples in seconds, an array (N,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.time_s)
    }

    /// Tags of the outputs, the columns of ``residuals``.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.inner.outputs.clone()
    }

    /// Residuals, an array (N, nd), settling included; NaN where a sample is missing.
    #[getter]
    fn residuals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.inner.residuals.clone())
    }

    /// The alarms in order of time: dictionaries with ``time_s``, ``first_exceedance_s``,
    /// ``end_s`` (``None`` while it lasts), ``tag``, ``residual`` and ``threshold``.
    #[getter]
    fn alarms<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "alarms", &self.inner.alarms)
    }

    /// For each detector the share of its judged samples above the limit, an array (nd,).
    #[getter]
    fn share_above_limit<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.share_above_limit)
    }

    fn __repr__(&self) -> String {
        format!(
            "Detection({} samples, outputs: {}, {} alarms)",
            self.inner.time_s.len(),
            self.inner.outputs.join(", "),
            self.inner.alarms.len()
        )
    }
}

/// What a bank is designed for.
#[derive(FromPyObject)]
pub enum Model<'py> {
    /// A model of measured channels.
    #[pyo3(annotation = "ArxModel")]
    Arx(Bound<'py, PyArxModel>),
    /// A relation between noise-free channels.
    #[pyo3(annotation = "EivModel")]
    Eiv(Bound<'py, PyEivModel>),
}

impl Model<'_> {
    fn equations(&self) -> &ArxModel {
        match self {
            Self::Arx(model) => &model.get().inner,
            Self::Eiv(model) => model.get().inner.relation(),
        }
    }
}

/// The poles of all observers, or by tag.
#[derive(FromPyObject)]
pub enum Placement {
    /// For every output.
    #[pyo3(annotation = "float or list of float")]
    Common(Poles),
    /// By tag; outputs that are not named keep the default.
    #[pyo3(annotation = "dict")]
    ByTag(HashMap<String, Poles>),
}

fn rule(
    exceedance: Option<f64>,
    margin: Option<f64>,
    arl0_h: Option<f64>,
    consecutive: Option<usize>,
) -> Result<ThresholdRule, Failure> {
    let given = |default: usize| consecutive.unwrap_or(default);
    match (exceedance, margin, arl0_h) {
        (Some(share), None, None) => Ok(ThresholdRule::Exceedance {
            share,
            consecutive: given(6),
        }),
        (None, None, None) => Ok(ThresholdRule::Margin {
            factor: ThresholdRule::DEFAULT_MARGIN,
            consecutive: given(1),
        }),
        (None, Some(factor), None) => Ok(ThresholdRule::Margin {
            factor,
            consecutive: given(1),
        }),
        (None, None, Some(hours)) => Ok(ThresholdRule::MeanTimeBetweenFalseAlarms {
            hours,
            consecutive: given(1),
        }),
        _ => Err(Failure::Option {
            option: "exceedance",
            expected: "one of exceedance, margin and arl0_h".to_owned(),
            found: "several".to_owned(),
        }),
    }
}

/// Designs a bank: an output observer for each output of a model, with a limit set on healthy
/// records and its false alarms counted by cross-validation.
///
/// Parameters
/// ----------
/// model : ArxModel or EivModel
///     The model; of an errors-in-variables model its relation.
/// healthy : list of Dataset, or of tuples (u, y)
///     Healthy records; tuples have the model's channels and sample time.
/// poles : float, list of float or dict, optional
///     One pole for all states, one a state, or either by tag. By default the paper's 0.7, 0.3,
///     0.4, 0.4 for q_c, t3, p7, m9 and 0.5 for any other tag.
/// exceedance : float, optional
///     Limit by the share of healthy samples above it.
/// margin : float, optional
///     Limit as a multiple of the largest healthy residual; 1.2 where no rule is given.
/// arl0_h : float, optional
///     Limit by the mean time between false alarms in hours.
/// consecutive : int, optional
///     Samples in a row above the limit that make an alarm; 6 with ``exceedance``, else 1.
///
/// Returns
/// -------
/// Bank
///
/// Raises
/// ------
/// DesignError
///     A pole or an option is out of its range, or the healthy records are too short.
///
/// Examples
/// --------
/// >>> healthy = [gtfdi.simulate(60.0, seed=seed).measured for seed in (2, 3)]
/// >>> gtfdi.design(model, healthy, poles={"q_c": 0.7}, margin=1.2).save("bank.json")
#[pyfunction]
#[pyo3(signature = (model, healthy, *, poles=None, exceedance=None, margin=None, arl0_h=None,
    consecutive=None), text_signature = "(model, healthy, *, poles=None, exceedance=None, \
    margin=None, arl0_h=None, consecutive=None)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn design(
    py: Python<'_>,
    model: Model<'_>,
    healthy: Vec<Bound<'_, PyAny>>,
    poles: Option<Placement>,
    exceedance: Option<f64>,
    margin: Option<f64>,
    arl0_h: Option<f64>,
    consecutive: Option<usize>,
) -> Result<PyBank, Failure> {
    let rule = rule(exceedance, margin, arl0_h, consecutive)?;
    let model = model.equations();
    if let Some(Placement::ByTag(by_tag)) = &poles {
        for tag in by_tag.keys() {
            index_of(model.outputs(), tag)?;
        }
    }
    let healthy: Vec<Dataset> = healthy
        .iter()
        .map(|record| {
            let given = Given::new(record, None)?;
            let data = given.known(model.inputs(), model.outputs(), model.sample_time_s())?;
            Ok(Arc::unwrap_or_clone(data))
        })
        .collect::<Result<_, Failure>>()?;
    let inner = py.detach(|| -> Result<Bank, Failure> {
        let mut detectors = Vec::with_capacity(model.outputs().len());
        for (index, output) in model.outputs().iter().enumerate() {
            let part = model.output_model(index)?;
            let nx = part.model.nx();
            let places = match &poles {
                Some(Placement::Common(poles)) => Some(poles),
                Some(Placement::ByTag(by_tag)) => by_tag.get(&output.name),
                None => None,
            };
            let places = places.map_or_else(
                || vec![paper::default_pole(&output.name); nx],
                |poles| poles.of(nx),
            );
            let generator = ResidualGenerator::observer(part.model, part.point, &places)?;
            detectors.push(OutputDetector::calibrate(generator, &healthy, rule)?);
        }
        Ok(Bank::new(BANK_NAME, detectors)?)
    })?;
    Ok(PyBank { inner })
}
