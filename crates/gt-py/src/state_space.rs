//! `StateSpace`: a discrete linear model.

use gtfdi::core::StateSpace;
use gtfdi::ident::pole_zero::invariant_zeros;
use nalgebra::{Complex, DVector};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::array::{json_text, json_value, matrix, matrix_out, samples, samples_out, vector};
use crate::dataset::{Names, names, signals};
use crate::error::Failure;
use crate::interop::call;
use crate::pickle::{Reduced, pickle_inner, reduce};

/// The Python module that knows the systems of other packages.
const SYSTEMS: &str = "gtfdi._systems";

/// Most Markov parameters at once: more would ask for more memory than there is.
const MOST_MARKOV_PARAMETERS: usize = 1_000_000;

/// A discrete linear model ``x(t+1) = A x(t) + B u(t)``, ``y(t) = C x(t) + D u(t)``.
///
/// Parameters
/// ----------
/// A, B, C, D : array_like, shapes (nx, nx), (nx, nu), (ny, nx), (ny, nu)
///     The matrices.
/// dt : float
///     Sample time in seconds.
/// inputs, outputs : list of str, optional
///     Tags; ``u1, u2, ...`` and ``y1, y2, ...`` where left out.
///
/// Raises
/// ------
/// DimensionError
///     Sizes disagree.
/// ModelError
///     An entry is not finite, or the sample time is not positive.
///
/// Examples
/// --------
/// >>> model = gtfdi.StateSpace([[0.5]], [[1.0]], [[1.0]], [[0.0]], 0.1)
/// >>> model.simulate([1.0, 0.0, 0.0]).ravel()
/// array([0. , 1. , 0.5])
#[pyclass(frozen, eq, name = "StateSpace", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyStateSpace {
    pub inner: StateSpace,
}

#[pymethods]
impl PyStateSpace {
    #[new]
    #[pyo3(signature = (A, B, C, D, dt, inputs=None, outputs=None))]
    #[allow(non_snake_case)] // the field's notation
    fn py_new(
        A: &Bound<'_, PyAny>,
        B: &Bound<'_, PyAny>,
        C: &Bound<'_, PyAny>,
        D: &Bound<'_, PyAny>,
        dt: f64,
        inputs: Option<Names>,
        outputs: Option<Names>,
    ) -> Result<Self, Failure> {
        let matrices = [
            matrix(A, "A")?,
            matrix(B, "B")?,
            matrix(C, "C")?,
            matrix(D, "D")?,
        ];
        let inputs = signals(inputs, None, 'u', matrices[1].ncols())?;
        let outputs = signals(outputs, None, 'y', matrices[2].nrows())?;
        Ok(Self {
            inner: StateSpace::new(matrices, dt, inputs, outputs)?,
        })
    }

    /// State matrix, an array (nx, nx).
    #[getter(A)]
    fn a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.a())
    }

    /// Input matrix, an array (nx, nu).
    #[getter(B)]
    fn b<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.b())
    }

    /// Output matrix, an array (ny, nx).
    #[getter(C)]
    fn c<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.c())
    }

    /// Direct term, an array (ny, nu).
    #[getter(D)]
    fn d<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix_out(py, self.inner.d())
    }

    /// Sample time in seconds.
    #[getter]
    fn dt(&self) -> f64 {
        self.inner.sample_time_s()
    }

    /// Tags of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        names(self.inner.inputs())
    }

    /// Tags of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        names(self.inner.outputs())
    }

    /// The eigenvalues of A, a complex array (nx,).
    fn poles<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray1<Complex<f64>>>, Failure> {
        Ok(PyArray1::from_vec(py, self.inner.poles()?))
    }

    /// The finite invariant zeros, a complex array: those z at which ``[A - z I, B; C, D]`` loses
    /// rank, the transmission zeros together with the modes that cannot be reached or seen.
    ///
    /// Examples
    /// --------
    /// >>> model = gtfdi.StateSpace([[0.5]], [[1.0]], [[1.0]], [[1.0]], 0.1)
    /// >>> model.zeros().real.round(9)  # (z + 0.5) / (z - 0.5)
    /// array([-0.5])
    fn zeros<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray1<Complex<f64>>>, Failure> {
        Ok(PyArray1::from_vec(py, invariant_zeros(&self.inner)?))
    }

    /// The outputs (N, ny) that the inputs ``u`` (N, nu) produce from the state ``x0`` (nx,), which
    /// is zero where left out.
    #[pyo3(signature = (u, x0=None))]
    fn simulate<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        x0: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        let py = u.py();
        let u = samples(u, "u")?;
        let x0 = match x0 {
            Some(x0) => vector(x0, "x0")?,
            None => DVector::zeros(self.inner.nx()),
        };
        let y = py.detach(|| self.inner.simulate(&x0, &u))?;
        Ok(samples_out(py, y)?)
    }

    /// The first ``n`` Markov parameters ``D, C B, C A B, ...``, an array (n, ny, nu); ``n`` is at
    /// most a million.
    fn markov_parameters<'py>(
        &self,
        py: Python<'py>,
        n: usize,
    ) -> Result<Bound<'py, PyArray3<f64>>, Failure> {
        if n > MOST_MARKOV_PARAMETERS {
            return Err(Failure::Option {
                option: "n",
                expected: format!("at most {MOST_MARKOV_PARAMETERS}"),
                found: n.to_string(),
            });
        }
        let parameters = py.detach(|| self.inner.markov_parameters(n));
        let values: Vec<f64> = parameters
            .iter()
            .flat_map(|each| each.transpose().as_slice().to_vec())
            .collect();
        Ok(PyArray1::from_vec(py, values).reshape([n, self.inner.ny(), self.inner.nu()])?)
    }

    /// The model as JSON.
    fn to_json(&self) -> Result<String, Failure> {
        json_text("state-space model", &self.inner)
    }

    /// A model from the JSON that ``to_json`` gave; it is checked.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, text: &str) -> Result<Self, Failure> {
        let inner = json_value("state-space model", text)?;
        Ok(Self { inner })
    }

    /// The model as a ``control.StateSpace`` with the same matrices, sample time and names.
    ///
    /// Needs the package ``control`` (``pip install 'gtfdi[control]'``).
    ///
    /// Examples
    /// --------
    /// >>> system = model.state_space().to_control()
    /// >>> system.dt, system.nstates
    /// (0.08, 8)
    fn to_control<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call(slf.py(), SYSTEMS, "to_control", (slf,))
    }

    /// The model of a system of the package ``control`` in discrete time.
    ///
    /// Raises
    /// ------
    /// ModelError
    ///     Continuous time, or a sample time that is not given.
    ///
    /// Examples
    /// --------
    /// >>> import control
    /// >>> first = gtfdi.StateSpace.from_control(control.tf([1.0], [1.0, -0.5], 0.1))
    /// >>> first.poles().real, first.dt
    /// (array([0.5]), 0.1)
    #[classmethod]
    fn from_control<'py>(
        class: &Bound<'py, PyType>,
        system: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        call(class.py(), SYSTEMS, "from_control", (system,))
    }

    /// The model as a ``scipy.signal.dlti`` in state space.
    ///
    /// Needs the package ``scipy`` (``pip install 'gtfdi[scipy]'``).
    ///
    /// Examples
    /// --------
    /// >>> model.state_space().to_scipy().dt
    /// 0.08
    fn to_scipy<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call(slf.py(), SYSTEMS, "to_scipy", (slf,))
    }

    /// The model of a ``scipy.signal.dlti`` of any form, which has no names of its own.
    ///
    /// Raises
    /// ------
    /// ModelError
    ///     Continuous time, or a sample time that is not given.
    ///
    /// Examples
    /// --------
    /// >>> from scipy import signal
    /// >>> system = signal.dlti([1.0], [1.0, -0.5], dt=0.1)
    /// >>> gtfdi.StateSpace.from_scipy(system, outputs="level").outputs
    /// ['level']
    #[classmethod]
    #[pyo3(signature = (system, inputs=None, outputs=None))]
    fn from_scipy<'py>(
        class: &Bound<'py, PyType>,
        system: &Bound<'py, PyAny>,
        inputs: Option<&Bound<'py, PyAny>>,
        outputs: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        call(class.py(), SYSTEMS, "from_scipy", (system, inputs, outputs))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "StateSpace({} states, inputs: {}, outputs: {}, dt {} s)",
            self.inner.nx(),
            self.inputs().join(", "),
            self.outputs().join(", "),
            self.inner.sample_time_s()
        )
    }
}

pickle_inner!(PyStateSpace, StateSpace);
