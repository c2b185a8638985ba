//! `design_isolator`, `Isolator` and `Isolation`: which fault, since when, how large.

use std::path::PathBuf;
use std::sync::Arc;

use gt_campaign::{FaultDescription, IsolatorPlan, PairRecords, joint_kalman_generator};
use gt_log::{RunMetadata, read_json, write_diagnoses, write_json};
use gtfdi::core::Dataset;
use gtfdi::fdi::{IsolationMonitor, Isolator};
use gtfdi::ident::ArxModel;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::array::{json_form, json_out, json_text, json_value, vector};
use crate::bank::{Model, Placement, check_poles, generators, is_kalman, known_records};
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::isolation_monitor::PyIsolationMonitor;
use crate::pickle::{Pickled, Reduced, pickle_inner, reduce};
use crate::record::Given;

/// Residual generators, hypotheses about faults, and limits for a false-alarm rate of all of them
/// together; ``gtfdi.design_isolator`` makes one.
#[pyclass(frozen, eq, name = "Isolator", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyIsolator {
    pub inner: Arc<Isolator>,
}

impl PyIsolator {
    /// A record as it is given.
    fn data(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<Arc<Dataset>, Failure> {
        Given::new(u, y)?.by_name(
            &self.inner.inputs(),
            &self.inner.outputs(),
            self.inner.sample_time_s(),
        )
    }
}

#[pymethods]
impl PyIsolator {
    /// The isolator's name.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// Tags of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.inner.inputs()
    }

    /// Tags of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.inner.outputs()
    }

    /// Sample time in seconds.
    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.inner.sample_time_s()
    }

    /// Samples before anything is judged.
    #[getter]
    fn settle_samples(&self) -> usize {
        self.inner.settle_samples()
    }

    /// The hypotheses: dictionaries with ``name``, ``unit``, ``both_signs`` and ``effect``, which is
    /// what one unit of the fault changes, as it was given or learned.
    #[getter]
    fn hypotheses<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "hypotheses", self.inner.hypotheses())
    }

    /// Names of the statistics: of the hypotheses, then ``"any direction"``.
    #[getter]
    fn statistics(&self) -> Vec<&str> {
        self.inner.statistic_names()
    }

    /// The limit of each statistic, an array.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.inner.limits())
    }

    /// What the healthy records promise of each limit: dictionaries with ``asked_hours``, ``hours``,
    /// ``hours_low``, ``hours_high``, ``peaks``, ``healthy_hours`` and ``healthy_hours_needed``.
    #[getter]
    fn mean_times<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "mean times", self.inner.mean_times())
    }

    /// Runs over a record: a Dataset, or arrays ``u`` and ``y`` with the channels of ``inputs`` and
    /// ``outputs``.
    ///
    /// Examples
    /// --------
    /// >>> isolator.detect(record).alarms
    /// []
    #[pyo3(signature = (u, y=None))]
    fn detect(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<PyIsolation, Failure> {
        let data = self.data(u, y)?;
        let isolator = Arc::clone(&self.inner);
        let run = interruptible(u.py(), move |abandoned| {
            Ok(isolator.run_until(&data, abandoned, |_| {})?)
        })?;
        let alarms = run.alarms.iter();
        let inner = Judgement {
            judged: run.judged,
            alarms: alarms
                .map(|alarm| json_form("alarms", &self.inner.named_alarm(alarm)))
                .collect::<Result<_, Failure>>()?,
            peaks: run.peaks,
        };
        Ok(PyIsolation { inner })
    }

    /// Runs over a record, as ``detect``, and writes statistics, limits, alarms and diagnoses as an
    /// MCAP log, as ``gtfdi detect --out`` does. The isolator is attached.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The log; it appears only when it is whole.
    /// u, y
    ///     The record.
    ///
    /// Examples
    /// --------
    /// >>> from gtfdi import log
    /// >>> isolator.write_diagnoses("diagnoses.mcap", record)
    /// >>> log.verify("diagnoses.mcap")["problems"]
    /// []
    #[pyo3(signature = (path, u, y=None))]
    fn write_diagnoses(
        &self,
        path: PathBuf,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<(), Failure> {
        let data = self.data(u, y)?;
        let isolator = Arc::clone(&self.inner);
        interruptible(u.py(), move |_| {
            let metadata = RunMetadata::default();
            Ok(write_diagnoses(&path, &isolator, &data, &metadata)?)
        })
    }

    /// What watches samples as they come (IsolationMonitor), in its initial state.
    fn monitor(&self) -> Result<PyIsolationMonitor, Failure> {
        let monitor = IsolationMonitor::new(&self.inner)?;
        Ok(PyIsolationMonitor::new(Arc::clone(&self.inner), monitor))
    }

    /// Writes a file, as ``gtfdi design --faults --out`` does.
    fn save(&self, py: Python<'_>, path: PathBuf) -> Result<(), Failure> {
        Ok(py.detach(|| write_json(&path, &*self.inner))?)
    }

    /// Reads an isolator's file; it is checked.
    #[classmethod]
    fn load(class: &Bound<'_, PyType>, path: PathBuf) -> Result<Self, Failure> {
        let inner: Isolator = class.py().detach(|| read_json(&path))?;
        Ok(Self {
            inner: Arc::new(inner),
        })
    }

    /// The isolator as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("isolator", &*self.inner)
    }

    /// An isolator from the JSON that ``to_json`` gave; it is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        let inner: Isolator = json_value("isolator", text)?;
        Ok(Self {
            inner: Arc::new(inner),
        })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "Isolator({}, statistics: {}, sample time {} s)",
            self.inner.name,
            self.inner.statistic_names().join(", "),
            self.inner.sample_time_s()
        )
    }
}

/// What an isolator says of a record.
#[pyclass(frozen, name = "Isolation", module = "gtfdi")]
pub struct PyIsolation {
    inner: Judgement,
}

/// Alarms, in the form that Python shows them, and what stands beside them.
#[derive(Clone, Serialize, Deserialize)]
pub struct Judgement {
    judged: usize,
    peaks: Vec<f64>,
    alarms: Vec<Value>,
}

pickle_inner!(PyIsolation, Judgement);

impl Pickled for PyIsolator {
    type Stored = Isolator;

    fn stored(&self) -> Result<Isolator, Failure> {
        Ok(Isolator::clone(&self.inner))
    }

    fn restored(inner: Isolator) -> Result<Self, Failure> {
        let inner = Arc::new(inner);
        Ok(Self { inner })
    }
}

#[pymethods]
impl PyIsolation {
    /// The alarms in order of time: dictionaries with ``time_s``, ``end_s`` (``None`` while it
    /// lasts), ``tag`` (the statistic that led), ``statistic``, ``threshold``, ``named_s``,
    /// ``finding`` (``"undecided"``, ``"named"``, ``"both"`` or ``"none_of_these"``), ``fault``,
    /// ``unit``, ``probability``, ``onset_s``, ``magnitude``, ``diagnosed_s``, ``hypotheses`` (all of
    /// them, with intervals), ``none_of_these`` and ``pair``.
    #[getter]
    fn alarms<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "alarms", &self.inner.alarms)
    }

    /// Samples that were judged.
    #[getter]
    fn judged(&self) -> usize {
        self.inner.judged
    }

    /// The largest ratio of a statistic to its limit in each second of the record, an array.
    #[getter]
    fn peaks<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.peaks)
    }

    fn __repr__(&self) -> String {
        let faults: Vec<&str> = self
            .inner
            .alarms
            .iter()
            .map(|alarm| alarm["fault"].as_str().unwrap_or("no name"))
            .collect();
        format!(
            "Isolation({} samples judged, alarms: [{}])",
            self.inner.judged,
            faults.join(", ")
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

/// A fault's description from its dictionary, with the records of its pairs.
fn described(
    model: &ArxModel,
    index: usize,
    fault: &Bound<'_, PyDict>,
) -> Result<(FaultDescription, Vec<PairRecords>), Failure> {
    let refuse = |cause: String| Failure::Description { index, cause };
    let py = fault.py();
    let words = fault.copy()?;
    let pairs = words.get_item("pairs")?;
    if pairs.is_some() {
        words.del_item("pairs")?;
    }
    let text: String = py
        .import("json")?
        .call_method1("dumps", (&words,))?
        .extract()?;
    let description: FaultDescription =
        serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?;
    if !description.pairs.is_empty() {
        return Err(refuse(
            "expected records under `pairs`, found `pair`".to_owned(),
        ));
    }
    let mut records = Vec::new();
    let pairs = pairs.into_iter().filter(|pairs| !pairs.is_none());
    for pair in pairs
        .map(|pairs| pairs.try_iter())
        .collect::<PyResult<Vec<_>>>()?
        .into_iter()
        .flatten()
    {
        let (healthy, faulty, sizes): (Bound<'_, PyAny>, Bound<'_, PyAny>, Bound<'_, PyAny>) =
            pair?.extract()?;
        let mut both = known_records(model, &[healthy, faulty])?.into_iter();
        let (Some(healthy), Some(faulty)) = (both.next(), both.next()) else {
            continue;
        };
        records.push(PairRecords {
            healthy,
            faulty,
            sizes: vector(&sizes, "sizes")?.as_slice().to_vec(),
        });
    }
    description
        .check(!records.is_empty())
        .map_err(|error| refuse(error.to_string()))?;
    Ok((description, records))
}

/// Designs an isolator: what tells faults apart, with the size and onset of each, from a model,
/// hypotheses and healthy records.
///
/// For each hypothesis the statistic is the likelihood ratio of a fault that grows evenly since an
/// unknown onset; one more is for a change in any direction. Each gets the same part of the false
/// alarms.
///
/// Parameters
/// ----------
/// model : ArxModel or EivModel
///     The model; of an errors-in-variables model its relation and noise.
/// healthy : list of Dataset, or of tuples (u, y)
///     Healthy records that the model was not identified from, several hours in all.
/// faults : list of dict
///     For each fault ``name``, ``unit``, ``both_signs`` (may its size be negative?) and either
///     ``changes`` (by tag, what one unit of it changes in an output at held inputs; one entry of 1
///     is a sensor), ``actuator`` (the input whose actuator lags its demand, with ``nominal_s``,
///     about the smallest lag to be found), or ``pairs``: tuples ``(healthy, faulty, sizes)`` of two
///     records of the same run and the fault's size at each sample, from which what the fault does
///     is learned; with ``actuator`` the gain of its lag.
/// generator : str, optional
///     ``"kalman"``: one Kalman filter of all outputs for the noise of an errors-in-variables model;
///     of an ARX model its one-step errors. ``"observer"``: output observers with the given poles.
/// poles : float, list of float or complex, or dict, optional
///     Of observers, as for ``design``.
/// arl0_h : float, optional
///     Mean time between false alarms of all statistics together, in hours.
/// confidence : float, optional
///     The probability from which on a fault is named.
/// longest_s : float, optional
///     How far back onsets are looked for, in seconds.
/// limiter : float, optional
///     Robust standard deviations beyond which a burst of a residual is cut; 4 where left out, 2.5
///     where model errors at movements rule.
/// half_width : int, optional
///     Samples on either side for the rate of an actuator's demand; 6 with noise, else 1.
///
/// Returns
/// -------
/// Isolator
///
/// Raises
/// ------
/// OptionError
///     A fault's description says nothing, or two things.
/// DesignError
///     A tag or an option is out of range, a fault does not show, or the healthy records are too
///     few for the promise.
///
/// Examples
/// --------
/// >>> faults = [
/// ...     {"name": "torque meter", "unit": "N m", "both_signs": True, "changes": {"q_c": 1.0}},
/// ...     {"name": "fuel valve", "actuator": "M_f", "nominal_s": 0.4},
/// ... ]
/// >>> gtfdi.design_isolator(model, [run.measured], faults, arl0_h=0.0)
/// Traceback (most recent call last):
///     ...
/// gtfdi.errors.DesignError: option `arl0_hours`: expected a positive finite number, found 0
#[pyfunction]
#[pyo3(signature = (model, healthy, faults, *, generator="kalman", poles=None, arl0_h=24.0,
    confidence=0.99, longest_s=600.0, limiter=None, half_width=None))]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn design_isolator(
    py: Python<'_>,
    model: Model<'_>,
    healthy: Vec<Bound<'_, PyAny>>,
    faults: Vec<Bound<'_, PyDict>>,
    generator: &str,
    poles: Option<Placement>,
    arl0_h: f64,
    confidence: f64,
    longest_s: f64,
    limiter: Option<f64>,
    half_width: Option<usize>,
) -> Result<PyIsolator, Failure> {
    let kalman = is_kalman(generator)?;
    let (noise, model) = (model.noise().cloned(), model.equations().clone());
    check_poles(&model, kalman, poles.as_ref())?;
    let healthy = known_records(&model, &healthy)?;
    let faults = faults
        .iter()
        .enumerate()
        .map(|(index, fault)| described(&model, index, fault))
        .collect::<Result<Vec<_>, Failure>>()?;
    let plan = IsolatorPlan {
        arl0_hours: arl0_h,
        confidence,
        longest_s,
        limiter,
        half_width,
    };
    let inner = interruptible(py, move |_| {
        let noise = noise.as_ref();
        let generators = match (kalman, noise) {
            (true, Some(noise)) => vec![joint_kalman_generator(noise)?],
            _ => generators(&model, noise, kalman, poles.as_ref())?,
        };
        let name = if kalman { "filters" } else { "observers" };
        plan.design(name, generators, noise, &faults, &healthy)
            .map_err(|(fault, source)| match fault {
                Some(name) => Failure::Effect { name, source },
                None => source.into(),
            })
    })?;
    Ok(PyIsolator {
        inner: Arc::new(inner),
    })
}
