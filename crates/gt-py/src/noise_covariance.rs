//! `NoiseCovariance`: the noise that filters are designed for.

use gtfdi::core::{OperatingPoint, StateSpace};
use gtfdi::fdi::NoiseCovariance;
use nalgebra::DMatrix;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::array::{matrix, matrix_out, vector};
use crate::error::Failure;
use crate::observer::{Model, model_and_point};
use crate::pickle::{Reduced, pickle_inner, reduce};

/// The white noise of ``x(t+1) = A x + B u + w``, ``y(t) = C x + D u + v``: the covariances
/// ``Q`` of w, ``R`` of v and ``S`` of w with v.
///
/// Parameters
/// ----------
/// Q : array_like, shape (nx, nx)
///     In the products of the states' units.
/// R : array_like, shape (ny, ny)
///     In the products of the outputs' units.
/// S : array_like, shape (nx, ny), optional
///     Zero where left out.
///
/// Raises
/// ------
/// DimensionError
///     Sizes disagree.
/// DesignError
///     An entry is not finite, or ``[Q S; S' R]`` is not symmetric or not positive semidefinite.
///
/// Examples
/// --------
/// >>> noise = gtfdi.NoiseCovariance(Q=[[0.1]], R=[[0.01]])
/// >>> noise.S
/// array([[0.]])
#[pyclass(frozen, eq, name = "NoiseCovariance", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyNoiseCovariance {
    pub inner: NoiseCovariance,
}

#[pymethods]
impl PyNoiseCovariance {
    #[new]
    #[pyo3(signature = (Q, R, S=None))]
    #[allow(non_snake_case)] // the field's notation
    fn py_new(
        Q: &Bound<'_, PyAny>,
        R: &Bound<'_, PyAny>,
        S: Option<&Bound<'_, PyAny>>,
    ) -> Result<Self, Failure> {
        let (q, r) = (matrix(Q, "Q")?, matrix(R, "R")?);
        let s = match S {
            Some(s) => matrix(s, "S")?,
            None => DMatrix::zeros(q.nrows(), r.nrows()),
        };
        let inner = NoiseCovariance::new(&q, &r, &s)?;
        Ok(Self { inner })
    }

    /// The noise of a model whose measured inputs and outputs have white noise: ``Q = B Su B'``,
    /// ``R = Sy + D Su D'``, ``S = B Su D'``.
    ///
    /// Parameters
    /// ----------
    /// model : StateSpace or OutputModel
    ///     The model.
    /// input_variances, output_variances : array_like, shapes (nu,) and (ny,)
    ///     The diagonals of ``Su`` and ``Sy``, in squared units of the channels.
    ///
    /// Raises
    /// ------
    /// DesignError
    ///     A variance is negative or not finite.
    ///
    /// Examples
    /// --------
    /// >>> tank = gtfdi.StateSpace([[0.9]], [[0.1]], [[1.0]], [[0.0]], 1.0)
    /// >>> noise = gtfdi.NoiseCovariance.errors_in_variables(tank, [4.0], [0.25])
    /// >>> noise.Q, noise.R
    /// (array([[0.04]]), array([[0.25]]))
    #[classmethod]
    fn errors_in_variables(
        _class: &Bound<'_, PyType>,
        model: Model<'_>,
        input_variances: &Bound<'_, PyAny>,
        output_variances: &Bound<'_, PyAny>,
    ) -> Result<Self, Failure> {
        let (model, _): (StateSpace, OperatingPoint) = model_and_point(model, None)?;
        let inner = of_channels(&model, input_variances, output_variances)?;
        Ok(Self { inner })
    }

    /// The covariance of the states' noise, an array (nx, nx).
    #[getter(Q)]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.q())
    }

    /// The covariance of the outputs' noise, an array (ny, ny).
    #[getter(R)]
    fn r<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.r())
    }

    /// The covariance between the two, an array (nx, ny).
    #[getter(S)]
    fn s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.s())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "NoiseCovariance({} states, {} outputs)",
            self.inner.q().nrows(),
            self.inner.r().nrows()
        )
    }
}

pickle_inner!(PyNoiseCovariance, NoiseCovariance);

/// The noise of a model by the variances of its channels.
pub fn of_channels(
    model: &StateSpace,
    input_variances: &Bound<'_, PyAny>,
    output_variances: &Bound<'_, PyAny>,
) -> Result<NoiseCovariance, Failure> {
    let inputs = vector(input_variances, "input_variances")?;
    let outputs = vector(output_variances, "output_variances")?;
    let noise = NoiseCovariance::errors_in_variables(model, inputs.as_slice(), outputs.as_slice())?;
    Ok(noise)
}
