//! `OutputErrorRefinement` and `Refined`: a model refined on the error of its free run.

use gtfdi::ident::output_error::{InitialOutputs, OutputErrorRefinement, Refined};
use pyo3::prelude::*;

use crate::array::json_out;
use crate::arx_model::PyArxModel;
use crate::choice::named;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::pickle::{Reduced, pickle_inner, reduce};

/// The refinement of a diagonal ARX model on the error of its free run, which a second record must
/// confirm.
///
/// Parameters
/// ----------
/// initial : {"estimated", "measured"}, default "estimated"
///     What the run over the training record starts from.
/// max_radius : float, default 0.9999
///     Largest modulus of a pole, above 0 and below 1.
/// max_iterations : int, default 60
///     Most steps for a row.
///
/// Examples
/// --------
/// >>> start = gtfdi.arx(u, y, order=2, structure="diag", inputs=["a_v", "M_f"], outputs="q_c")
/// >>> train, hold_out = (u[:4000], y[:4000]), (u[4000:], y[4000:])
/// >>> refined = gtfdi.OutputErrorRefinement(max_iterations=5).refine(start, train, hold_out)
/// >>> refined.outputs[0]["train_after"] <= refined.outputs[0]["train_before"]
/// True
#[pyclass(frozen, eq, name = "OutputErrorRefinement", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyOutputErrorRefinement {
    inner: OutputErrorRefinement,
}

#[pymethods]
impl PyOutputErrorRefinement {
    #[new]
    #[pyo3(signature = (*, initial="estimated", max_radius=0.9999, max_iterations=60))]
    fn py_new(initial: &str, max_radius: f64, max_iterations: usize) -> Result<Self, Failure> {
        let outputs = [
            ("estimated", InitialOutputs::Estimated),
            ("measured", InitialOutputs::Measured),
        ];
        let inner = OutputErrorRefinement::new()
            .initial(named("initial", initial, &outputs)?)
            .max_radius(max_radius)
            .max_iterations(max_iterations);
        Ok(Self { inner })
    }

    /// Refines each row on ``train`` and keeps it where its free run over ``hold_out`` is better
    /// than the start's.
    ///
    /// Parameters
    /// ----------
    /// model : ArxModel
    ///     The start, of diagonal structure and stable.
    /// train, hold_out : Dataset or tuple (u, y)
    ///     The records.
    ///
    /// Returns
    /// -------
    /// Refined
    ///
    /// Raises
    /// ------
    /// IdentError
    ///     A model of another structure or with poles outside ``max_radius``, or a record that does
    ///     not fit the model.
    fn refine(
        &self,
        py: Python<'_>,
        model: &PyArxModel,
        train: &Bound<'_, PyAny>,
        hold_out: &Bound<'_, PyAny>,
    ) -> Result<PyRefined, Failure> {
        let (train, hold_out) = (model.known(train, None)?, model.known(hold_out, None)?);
        let (wish, start) = (self.inner, model.inner.clone());
        let inner = interruptible(py, move |_| Ok(wish.refine(&start, &train, &hold_out)?))?;
        Ok(PyRefined { inner })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

/// A refined model and what came of each row; ``OutputErrorRefinement.refine`` makes one.
#[pyclass(frozen, eq, name = "Refined", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyRefined {
    inner: Refined,
}

#[pymethods]
impl PyRefined {
    /// The model (ArxModel): accepted rows are new, refused ones as they were.
    #[getter]
    fn model(&self) -> PyArxModel {
        PyArxModel {
            inner: self.inner.model.clone(),
        }
    }

    /// For each output a dictionary with ``output``, ``accepted``, the root mean squares
    /// ``train_before``, ``train_after``, ``hold_out_before`` and ``hold_out_after`` of the free
    /// run's error (``None`` where it diverges), ``radius`` (the largest modulus of a pole of the
    /// refined row) and ``iterations``.
    #[getter]
    fn outputs<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "refinement", &self.inner.outputs)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

pickle_inner!(PyRefined, Refined);

pickle_inner!(PyOutputErrorRefinement, OutputErrorRefinement);
