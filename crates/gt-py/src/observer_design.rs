//! `optimise_observer`: poles by pairs of records without and with a fault.

use std::sync::Arc;

use gtfdi::core::{Dataset, StateSpace};
use gtfdi::fdi::{
    Criterion, ObserverDesign, PoleSearch, RecordPair, ResidualGenerator, SearchMethod,
};
use nalgebra::Complex;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyType;
use serde::{Deserialize, Serialize};

use crate::array::{json_out, json_text, json_value};
use crate::choice::named;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::observer::{Model, PyObserver, model_and_point};
use crate::pickle::{Pickled, Reduced, reduce};
use crate::poles::python_text;
use crate::record::Given;

const CRITERIA: [(&str, Criterion); 2] = [
    ("fault-energy", Criterion::FaultEnergy),
    ("paper", Criterion::Paper),
];
const METHODS: [(&str, SearchMethod); 2] = [
    ("descent", SearchMethod::Descent),
    ("evolution", SearchMethod::Evolution),
];

/// The observer whose poles tell the faults of some records best, with what speaks for and against
/// it; ``gtfdi.optimise_observer`` makes one.
#[pyclass(frozen, eq, name = "ObserverDesign", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyObserverDesign {
    inner: Design,
}

/// What a search found and the observer that it makes.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Design {
    search: ObserverDesign,
    observer: ResidualGenerator,
}

#[pymethods]
impl PyObserverDesign {
    /// The poles, an array (nx,) of complex.
    #[getter]
    fn poles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Complex<f64>>> {
        PyArray1::from_slice(py, &self.inner.search.poles)
    }

    /// The observer with these poles (Observer).
    #[getter]
    fn observer(&self) -> PyObserver {
        PyObserver {
            inner: self.inner.observer.clone(),
        }
    }

    /// What was minimised: ``"fault-energy"`` or ``"paper"``.
    #[getter]
    fn criterion(&self) -> &'static str {
        let found = CRITERIA
            .iter()
            .find(|(_, criterion)| *criterion == self.inner.search.criterion);
        found.map_or("", |(name, _)| name)
    }

    /// The largest modulus that a pole could have.
    #[getter]
    fn radius(&self) -> f64 {
        self.inner.search.radius
    }

    /// The criterion on the pairs that the poles were chosen by.
    #[getter]
    fn v(&self) -> f64 {
        self.inner.search.v
    }

    /// The criterion on the validation pairs, ``None`` without any.
    #[getter]
    fn v_validation(&self) -> Option<f64> {
        self.inner.search.v_validation
    }

    /// The least criterion that a class of filters reaches on the pairs that the poles were chosen
    /// by, never above ``v``: those of the equation error with any numerator and the poles found and
    /// ``bound_functions`` more at ``bound_pole``.
    #[getter]
    fn bound(&self) -> f64 {
        self.inner.search.bound.value
    }

    /// The criterion of that filter on the validation pairs, ``None`` without any.
    #[getter]
    fn bound_validation(&self) -> Option<f64> {
        self.inner.search.bound.validation
    }

    /// Evaluations of the criterion in all attempts.
    #[getter]
    fn evaluations(&self) -> usize {
        self.inner.search.evaluations
    }

    /// Where the attempt began that found the poles: a dictionary with ``kind`` (``"vertex"``,
    /// ``"inner"``, ``"diagonal"``, ``"random"`` or ``"evolution"``) and its ``index`` or ``pole``.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "start", &self.inner.search.start)
    }

    /// All attempts in their order: dictionaries with ``start``, ``v`` and ``evaluations``.
    #[getter]
    fn attempts<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "attempts", &self.inner.search.attempts)
    }

    /// The design as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("observer design", &self.inner)
    }

    /// A design from the JSON that ``to_json`` gave; its observer is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        Self::restored(json_value("observer design", text)?)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        let poles = self.inner.search.poles.iter();
        let poles: Vec<String> = poles.map(|&pole| python_text(pole)).collect();
        format!(
            "ObserverDesign(output: {}, v: {:?}, poles: [{}])",
            self.inner.observer.outputs()[0].name,
            self.inner.search.v,
            poles.join(", ")
        )
    }
}

/// A record without and one with a fault, of the same run.
type Pair<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// The records of pairs, read for a model.
fn records(pairs: &[Pair<'_>], model: &StateSpace) -> Result<Vec<[Arc<Dataset>; 2]>, Failure> {
    let record = |given: &Bound<'_, PyAny>| {
        Given::new(given, None)?.known(model.inputs(), model.outputs(), model.sample_time_s())
    };
    pairs
        .iter()
        .map(|(healthy, faulty)| Ok([record(healthy)?, record(faulty)?]))
        .collect()
}

fn borrowed(records: &[[Arc<Dataset>; 2]]) -> Vec<RecordPair<'_>> {
    records
        .iter()
        .map(|[healthy, faulty]| RecordPair { healthy, faulty })
        .collect()
}

/// Searches the poles of the output observer of a model with one output that tell a fault best
/// from what is there without it.
///
/// What is minimised is the sum of squares of the healthy residuals over that of all that the fault
/// adds to them; with ``criterion="paper"`` over that of the faulty residual, of one pair. It falls
/// as ``radius`` approaches one, up to filters that ring for as long as the record: judge the poles
/// by ``v_validation``.
///
/// Parameters
/// ----------
/// model : StateSpace or OutputModel
///     A model of one output.
/// pairs : list of tuple (healthy, faulty)
///     Pairs of records of the same run without and with a fault, of the same length, as
///     ``gtfdi.simulate`` gives with one seed; each a Dataset or a tuple (u, y).
/// validation : list of tuple (healthy, faulty), optional
///     Pairs that have no part in the choice.
/// criterion : str, optional
///     ``"fault-energy"`` or ``"paper"``.
/// method : str, optional
///     ``"descent"``: by sequential quadratic programming from many starts; ``"evolution"``.
/// radius : float, optional
///     Largest modulus of a pole.
/// skip_samples : int, optional
///     Samples at the start of each record that do not count, while the observer forgets its
///     initial state.
/// diagonal_starts, random_starts : int, optional
///     Descents with all poles at one real place, and from places drawn, besides those from the
///     corners of what the radius allows.
/// seed : int, optional
///     Of the draws and of the evolution.
/// bound_pole, bound_functions : float and int, optional
///     The class of filters of the bound: the pole of its Laguerre functions and their number.
/// point : tuple of array_like, optional
///     Operating point ``(u0, y0)``; that of the OutputModel, or zero.
///
/// Returns
/// -------
/// ObserverDesign
///
/// Raises
/// ------
/// DesignError
///     The records of a pair differ in length, are too short, have samples that are not finite or
///     are the same, or an option is out of its range.
///
/// Examples
/// --------
/// >>> drift = {"case": "thermocouple_drift", "onset_s": 10.0, "rate_percent_per_h": 50.0}
/// >>> healthy, faulty = (
/// ...     gtfdi.simulate(40.0, seed=7, faults=faults).measured for faults in ([], [drift])
/// ... )
/// >>> t3 = gtfdi.arx(healthy, order=1, inputs=["a_v", "M_f"], outputs="t3").output_model(0)
/// >>> design = gtfdi.optimise_observer(t3, [(healthy, faulty)], radius=0.9)
/// >>> design.bound <= design.v
/// True
/// >>> bool(np.abs(design.poles).max() <= 0.9 + 1e-12)
/// True
#[pyfunction]
#[pyo3(signature = (model, pairs, validation=Vec::new(), *, criterion="fault-energy",
    method="descent", radius=0.97, skip_samples=0, diagonal_starts=9, random_starts=20, seed=0,
    bound_pole=0.9, bound_functions=8, point=None),
    text_signature = "(model, pairs, validation=(), *, criterion='fault-energy', \
    method='descent', radius=0.97, skip_samples=0, diagonal_starts=9, random_starts=20, seed=0, \
    bound_pole=0.9, bound_functions=8, point=None)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn optimise_observer(
    py: Python<'_>,
    model: Model<'_>,
    pairs: Vec<Pair<'_>>,
    validation: Vec<Pair<'_>>,
    criterion: &str,
    method: &str,
    radius: f64,
    skip_samples: usize,
    diagonal_starts: usize,
    random_starts: usize,
    seed: u64,
    bound_pole: f64,
    bound_functions: usize,
    point: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
) -> Result<PyObserverDesign, Failure> {
    let search = PoleSearch {
        criterion: named("criterion", criterion, &CRITERIA)?,
        method: named("method", method, &METHODS)?,
        radius,
        diagonal_starts,
        random_starts,
        seed,
        skip_samples,
        bound_pole,
        bound_functions,
    };
    let (model, point) = model_and_point(model, point)?;
    let (training, validation) = (records(&pairs, &model)?, records(&validation, &model)?);
    interruptible(py, move |_| {
        let (training, validation) = (borrowed(&training), borrowed(&validation));
        let search = search.design(&model, &point, &training, &validation)?;
        let observer = search.generator(model, point)?;
        let inner = Design { search, observer };
        Ok(PyObserverDesign { inner })
    })
}

impl Pickled for PyObserverDesign {
    type Stored = Design;

    fn stored(&self) -> Result<Design, Failure> {
        Ok(self.inner.clone())
    }

    /// Refuses a design whose observer has other poles than its search found.
    fn restored(inner: Design) -> Result<Self, Failure> {
        if inner.observer.complex_poles() == inner.search.poles {
            return Ok(Self { inner });
        }
        Err(Failure::Refusal {
            option: "poles",
            reason: "expected those of the observer, found others".to_owned(),
        })
    }
}
