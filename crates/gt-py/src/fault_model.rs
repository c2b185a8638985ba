//! `FaultModel`: a model with disturbances and faults that are unknown but for where they enter.

use gtfdi::core::{OperatingPoint, StateSpace};
use gtfdi::fdi::{FaultModel, UnknownInput};
use nalgebra::DMatrix;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{matrix, matrix_out, pair_out};
use crate::dataset::names;
use crate::error::Failure;
use crate::observer::{Model, model_and_point};
use crate::pickle::{Pickled, Reduced, reduce};
use crate::state_space::PyStateSpace;

/// A model with disturbances d and faults f of which nothing is known but where they enter:
/// ``x(t+1) = A x + B u + E_d d + E_f f``, ``y(t) = C x + D u + F_d d + F_f f``.
///
/// Parameters
/// ----------
/// model : StateSpace or OutputModel
///     The model from u to y.
/// E_d, F_d : array_like, shapes (nx, nd) and (ny, nd), optional
///     What a unit of each disturbance adds to the next state and to the outputs. One of them left
///     out is zero; without both there is no disturbance.
/// E_f, F_f : array_like, shapes (nx, nf) and (ny, nf), optional
///     The same of the faults.
/// point : tuple of array_like, optional
///     Operating point ``(u0, y0)``; that of the OutputModel, or zero.
///
/// Raises
/// ------
/// DimensionError
///     Sizes disagree.
/// DesignError
///     An entry is not finite.
///
/// Examples
/// --------
/// Two tanks in a row; nobody measures what leaks out of the second one.
///
/// >>> tanks = gtfdi.StateSpace(
/// ...     [[0.9, 0.0], [0.1, 0.9]], [[1.0], [0.0]], np.eye(2), np.zeros((2, 1)), 1.0
/// ... )
/// >>> leak, sensor = [[0.0], [1.0]], [[1.0], [0.0]]
/// >>> gtfdi.FaultModel(tanks, E_d=leak, F_f=sensor)
/// FaultModel(2 states, outputs: y1, y2, 1 disturbances, 1 faults)
#[pyclass(frozen, eq, name = "FaultModel", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyFaultModel {
    pub inner: FaultModel,
    pub point: OperatingPoint,
}

#[pymethods]
impl PyFaultModel {
    #[new]
    #[pyo3(signature = (model, *, E_d=None, F_d=None, E_f=None, F_f=None, point=None))]
    #[allow(non_snake_case)] // the field's notation
    fn py_new(
        model: Model<'_>,
        E_d: Option<&Bound<'_, PyAny>>,
        F_d: Option<&Bound<'_, PyAny>>,
        E_f: Option<&Bound<'_, PyAny>>,
        F_f: Option<&Bound<'_, PyAny>>,
        point: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
    ) -> Result<Self, Failure> {
        let (model, point) = model_and_point(model, point)?;
        let disturbance = entering(&model, (E_d, "E_d"), (F_d, "F_d"))?;
        let fault = entering(&model, (E_f, "E_f"), (F_f, "F_f"))?;
        let inner = FaultModel::new(model, disturbance, fault)?;
        Ok(Self { inner, point })
    }

    /// The model from u to y (StateSpace).
    #[getter]
    fn model(&self) -> PyStateSpace {
        PyStateSpace {
            inner: self.inner.model().clone(),
        }
    }

    /// What disturbances add to the next state, an array (nx, nd).
    #[getter(E_d)]
    fn state_disturbance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, &self.inner.disturbance().state)
    }

    /// What disturbances add to the outputs, an array (ny, nd).
    #[getter(F_d)]
    fn output_disturbance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, &self.inner.disturbance().output)
    }

    /// What faults add to the next state, an array (nx, nf).
    #[getter(E_f)]
    fn state_fault<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, &self.inner.fault().state)
    }

    /// What faults add to the outputs, an array (ny, nf).
    #[getter(F_f)]
    fn output_fault<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, &self.inner.fault().output)
    }

    /// The operating point, a dictionary of arrays ``u`` and ``y``.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        pair_out(py, &self.point.u, &self.point.y)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        let model = self.inner.model();
        format!(
            "FaultModel({} states, outputs: {}, {} disturbances, {} faults)",
            model.nx(),
            names(model.outputs()).join(", "),
            self.inner.disturbance().count(),
            self.inner.fault().count()
        )
    }
}

impl Pickled for PyFaultModel {
    /// The model, `[E_d, F_d, E_f, F_f]`, and the operating point.
    type Stored = (StateSpace, [DMatrix<f64>; 4], OperatingPoint);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        let (d, f) = (self.inner.disturbance(), self.inner.fault());
        let matrices = [&d.state, &d.output, &f.state, &f.output].map(Clone::clone);
        Ok((self.inner.model().clone(), matrices, self.point.clone()))
    }

    fn restored((model, matrices, point): Self::Stored) -> Result<Self, Failure> {
        let [state, output, state_fault, output_fault] = matrices;
        let disturbance = UnknownInput { state, output };
        let fault = UnknownInput {
            state: state_fault,
            output: output_fault,
        };
        let inner = FaultModel::new(model, disturbance, fault)?;
        Ok(Self { inner, point })
    }
}

/// A matrix that may be left out, with its name.
type Given<'a, 'py> = (Option<&'a Bound<'py, PyAny>>, &'static str);

/// Where signals enter a model: as given, or not at all.
fn entering(
    model: &StateSpace,
    (state, state_name): Given<'_, '_>,
    (output, output_name): Given<'_, '_>,
) -> Result<UnknownInput, Failure> {
    let state = state.map(|given| matrix(given, state_name)).transpose()?;
    let output = output.map(|given| matrix(given, output_name)).transpose()?;
    let (nx, ny) = (model.nx(), model.ny());
    Ok(match (state, output) {
        (Some(state), Some(output)) => UnknownInput { state, output },
        (Some(state), None) => UnknownInput::of_state(state, ny),
        (None, Some(output)) => UnknownInput::of_output(nx, output),
        (None, None) => UnknownInput::of_state(DMatrix::zeros(nx, 0), ny),
    })
}
