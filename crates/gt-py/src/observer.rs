//! `observer`: a residual generator for one output.

use gtfdi::core::{OperatingPoint, StateSpace};
use gtfdi::fdi::ResidualGenerator;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::array::{json_text, json_value, pair_out, vector};
use crate::dataset::names;
use crate::error::Failure;
use crate::output_model::PyOutputModel;
use crate::pickle::{Pickled, Reduced, reduce};
use crate::poles::{Poles, python_text};
use crate::record::Given;
use crate::state_space::PyStateSpace;

/// A residual generator; ``gtfdi.observer`` makes one.
#[pyclass(frozen, eq, name = "Observer", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyObserver {
    pub inner: ResidualGenerator,
}

#[pymethods]
impl PyObserver {
    /// The residual of a record, an array (N,), from the initial state zero; the first
    /// ``settle_samples`` of it hold the initial transient. A sample without a valid input or
    /// output gives NaN. C-contiguous float64 arrays are read where they are.
    ///
    /// Examples
    /// --------
    /// >>> gtfdi.observer(model.output_model(0), poles=0.5).residual(u, y).shape
    /// (7500,)
    #[pyo3(signature = (u, y=None))]
    fn residual<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        y: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray1<f64>>, Failure> {
        let residual = Given::new(u, y)?.residuals(u.py(), &self.inner)?;
        // One output: a row, which lies in memory as an array does.
        let values: Vec<f64> = residual.data.into();
        Ok(PyArray1::from_vec(u.py(), values))
    }

    /// The gain K, an array (nx,).
    #[getter]
    fn gain<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.inner.gain().as_slice())
    }

    /// The poles that were asked for, an array (nx,): of float, of complex where one is.
    #[getter]
    fn poles<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        match self.inner.poles() {
            [] => PyArray1::from_vec(py, self.inner.complex_poles()).into_any(),
            real => PyArray1::from_slice(py, real).into_any(),
        }
    }

    /// Samples after which a wrong initial state is forgotten.
    #[getter]
    fn settle_samples(&self) -> usize {
        self.inner.settle_samples()
    }

    /// The model (StateSpace).
    #[getter]
    fn model(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.inner.model().clone(),
        }
    }

    /// The operating point, a dictionary of arrays ``u`` and ``y``.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let point = self.inner.point();
        pair_out(py, &point.u, &point.y)
    }

    /// The observer as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("observer", &self.inner)
    }

    /// An observer from the JSON that ``to_json`` gave; it is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        Self::restored(json_value("observer", text)?)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        let poles = self.inner.complex_poles();
        let poles: Vec<String> = poles.into_iter().map(python_text).collect();
        format!(
            "Observer(output: {}, inputs: {}, poles: [{}])",
            self.inner.outputs()[0].name,
            names(self.inner.inputs()).join(", "),
            poles.join(", ")
        )
    }
}

/// What an observer is made for.
#[derive(FromPyObject)]
pub enum Model<'py> {
    /// A model of one output.
    #[pyo3(annotation = "StateSpace")]
    StateSpace(Bound<'py, PyStateSpace>),
    /// A row of an ARX model, with its operating point.
    #[pyo3(annotation = "OutputModel")]
    Output(Bound<'py, PyOutputModel>),
}

/// Designs the output observer of a model with one output.
///
/// The residual is ``r(t) = (y - y0) - C x - D (u - u0)`` with
/// ``x(t+1) = A x + B (u - u0) + K r`` and the poles of ``A - K C`` as given.
///
/// Parameters
/// ----------
/// model : StateSpace or OutputModel
///     A model of one output.
/// poles : float, or list of float or complex
///     One pole for all states, or one a state, inside the unit circle; complex ones together with
///     their conjugates.
/// point : tuple of array_like, optional
///     Operating point ``(u0, y0)``; that of the OutputModel, or zero.
///
/// Returns
/// -------
/// Observer
///
/// Raises
/// ------
/// DesignError
///     A pole is outside the unit circle or without its conjugate, their number is not that of the
///     states, or the output does not determine the state.
///
/// Examples
/// --------
/// >>> observer = gtfdi.observer(model.output_model("q_c"), poles=0.7)
/// >>> observer.settle_samples
/// 109
/// >>> pairs = [0.8 + 0.1j, 0.8 - 0.1j] * 4
/// >>> gtfdi.observer(model.output_model("q_c"), poles=pairs).poles.dtype
/// dtype('complex128')
#[pyfunction]
#[pyo3(signature = (model, poles, point=None))]
pub fn observer(
    model: Model<'_>,
    poles: Poles,
    point: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
) -> Result<PyObserver, Failure> {
    let (model, point) = model_and_point(model, point)?;
    let poles = poles.of(model.nx());
    Ok(PyObserver {
        inner: ResidualGenerator::observer_complex(model, point, &poles)?,
    })
}

/// A model with its operating point: as given, or its own, or zero.
pub fn model_and_point(
    model: Model<'_>,
    point: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
) -> Result<(StateSpace, OperatingPoint), Failure> {
    let (model, own): (StateSpace, Option<OperatingPoint>) = match model {
        Model::StateSpace(model) => (model.get().inner.clone(), None),
        Model::Output(output) => {
            let output = &output.get().inner;
            (output.model.clone(), Some(output.point.clone()))
        }
    };
    let point = match (point, own) {
        (Some((u, y)), _) => OperatingPoint {
            u: vector(&u, "u0")?,
            y: vector(&y, "y0")?,
        },
        (None, Some(point)) => point,
        (None, None) => OperatingPoint::zero(model.nu(), model.ny()),
    };
    Ok((model, point))
}

impl Pickled for PyObserver {
    type Stored = ResidualGenerator;

    fn stored(&self) -> Result<ResidualGenerator, Failure> {
        Ok(self.inner.clone())
    }

    /// Refuses the generator of a Kalman filter.
    fn restored(inner: ResidualGenerator) -> Result<Self, Failure> {
        if inner.noise().is_some() {
            return Err(Failure::Refusal {
                option: "observer",
                reason: "expected placed poles, found the noise of a Kalman filter".to_owned(),
            });
        }
        Ok(Self { inner })
    }
}
