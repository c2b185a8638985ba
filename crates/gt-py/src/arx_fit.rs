//! `ArxFit`: a model with the covariance of its coefficients.

use gtfdi::core::DimensionError;
use gtfdi::ident::{
    ArxFit, ArxModel, SolvedBy, check_covariances, dc_gains, frequency_response,
    parameter_covariance, pole_zero::pole_zero,
};
use nalgebra::DMatrix;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::array::{matrix, matrix_out, vector};
use crate::arx_model::PyArxModel;
use crate::choice::named;
use crate::dataset::names;
use crate::error::Failure;
use crate::frequency_response::{PyFrequencyResponse, gains_out};
use crate::pickle::{Pickled, Reduced, reduce};
use crate::pole_zero::report_out;

/// The solvers by name.
const SOLVERS: [(&str, SolvedBy); 3] = [
    ("qr", SolvedBy::Qr),
    ("refinement", SolvedBy::Refinement),
    ("joint", SolvedBy::Joint),
];

/// A fitted ARX model with what is known of its coefficients' errors; ``Arx.fit_in_full`` makes
/// one.
///
/// The rows are taken as estimated independently of one another, with white equation errors;
/// ``ArxModel.test_residuals`` says whether they are.
///
/// Parameters
/// ----------
/// model : ArxModel
///     The model.
/// covariance : list of array_like, one an output
///     Covariance of the coefficients of each row, in the order of ``model.regression``.
/// solved_by : list of {"qr", "refinement", "joint"}, optional
///     How each row was solved, where that is known.
///
/// Raises
/// ------
/// DimensionError, IdentError
///     Covariances that are not those of the model's rows.
#[pyclass(frozen, eq, name = "ArxFit", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyArxFit {
    pub model: ArxModel,
    pub covariance: Vec<DMatrix<f64>>,
    solved_by: Option<Vec<SolvedBy>>,
}

impl From<ArxFit> for PyArxFit {
    fn from(fit: ArxFit) -> Self {
        Self {
            model: fit.model,
            covariance: fit.covariance,
            solved_by: Some(fit.solved_by),
        }
    }
}

#[pymethods]
impl PyArxFit {
    #[new]
    #[pyo3(signature = (model, covariance, solved_by=None))]
    fn py_new(
        model: &PyArxModel,
        covariance: Vec<Bound<'_, PyAny>>,
        solved_by: Option<Vec<String>>,
    ) -> Result<Self, Failure> {
        let model = model.inner.clone();
        let covariance = covariance
            .iter()
            .enumerate()
            .map(|(index, value)| matrix(value, &format!("covariance {index}")))
            .collect::<Result<Vec<_>, Failure>>()?;
        check_covariances(&model, &covariance)?;
        let solved_by = solved_by
            .map(|names| {
                DimensionError::check("entries of solved_by", model.rows().len(), names.len())?;
                let solvers = names.iter();
                solvers
                    .map(|name| named("solved_by", name, &SOLVERS))
                    .collect::<Result<Vec<_>, Failure>>()
            })
            .transpose()?;
        Ok(Self {
            model,
            covariance,
            solved_by,
        })
    }

    /// A model with the covariance of its coefficients from the record that it was fitted to, for
    /// example one that comes from a file.
    ///
    /// Examples
    /// --------
    /// >>> fit = gtfdi.ArxFit.from_record(model, u, y)
    /// >>> np.allclose(np.sqrt(np.diag(fit.covariance[0])), model.standard_errors[0], rtol=1e-6)
    /// True
    #[classmethod]
    #[pyo3(signature = (model, u, y=None))]
    fn from_record(
        class: &Bound<'_, PyType>,
        model: &PyArxModel,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
    ) -> Result<Self, Failure> {
        let data = model.known(u, y)?;
        let model = model.inner.clone();
        let covariance = class.py().detach(|| parameter_covariance(&model, &data))?;
        Ok(Self {
            model,
            covariance,
            solved_by: None,
        })
    }

    /// The model (ArxModel).
    #[getter]
    pub fn model(&self) -> PyArxModel {
        PyArxModel {
            inner: self.model.clone(),
        }
    }

    /// Covariance of the coefficients of each output's row, arrays (terms, terms) in the order of
    /// ``model.regression``.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        let rows = self.covariance.iter();
        rows.map(|covariance| matrix_out(py, covariance)).collect()
    }

    /// For each output how its row was solved, ``qr``, ``refinement`` or ``joint``; ``None`` where
    /// that is not known.
    #[getter]
    fn solved_by(&self) -> Option<Vec<&'static str>> {
        let name = |solver: &SolvedBy| match solver {
            SolvedBy::Qr => "qr",
            SolvedBy::Refinement => "refinement",
            SolvedBy::Joint => "joint",
        };
        Some(self.solved_by.as_ref()?.iter().map(name).collect())
    }

    /// The response at frequencies from 0 to half the sampling rate with its standard errors, a
    /// ``FrequencyResponse``.
    ///
    /// Parameters
    /// ----------
    /// frequencies_hz : array_like, shape (nf,)
    ///     The frequencies.
    ///
    /// Examples
    /// --------
    /// >>> fit = gtfdi.ArxFit.from_record(model, u, y)
    /// >>> response = fit.frequency_response([0.0, 0.1, 1.0])
    /// >>> response.response.shape, response.magnitude_band(0.95).shape
    /// ((3, 1, 2), (3, 1, 2, 2))
    fn frequency_response(
        &self,
        frequencies_hz: &Bound<'_, PyAny>,
    ) -> Result<PyFrequencyResponse, Failure> {
        let frequencies = vector(frequencies_hz, "frequencies_hz")?;
        let points = frequencies_hz
            .py()
            .detach(|| frequency_response(&self.model, &self.covariance, frequencies.as_slice()))?;
        Ok(PyFrequencyResponse::new(&self.model, points))
    }

    /// The gains at rest: a dictionary of arrays (ny, nu) ``value``, ``standard_error``, and
    /// ``low`` and ``high``, between which the gain is with the probability ``confidence``.
    #[pyo3(signature = (confidence=0.95))]
    fn dc_gains<'py>(
        &self,
        py: Python<'py>,
        confidence: f64,
    ) -> Result<Bound<'py, PyDict>, Failure> {
        let gains = dc_gains(&self.model, &self.covariance)?;
        gains_out(py, &gains, confidence)
    }

    /// The poles and zeros with their standard errors, a dictionary.
    ///
    /// ``poles`` are dictionaries with ``value`` (complex), ``covariance`` (of the real and the
    /// imaginary part, ``None`` where the root is not resolved from another one),
    /// ``standard_error``, ``magnitude``, ``time_constant_s``, ``damping`` and
    /// ``natural_frequency_hz`` (each ``None`` or a dictionary with ``value`` and
    /// ``standard_error``) and ``output``, the output that the pole belongs to in a diagonal
    /// structure, else ``None``. ``channels`` holds ``output``, ``input``, ``zeros`` (like poles)
    /// and ``cancellations``, zeros that are not told from a pole. ``superfluous_poles`` are the
    /// indices of poles that a zero cancels in every channel where they could show.
    ///
    /// Examples
    /// --------
    /// >>> report = gtfdi.ArxFit.from_record(model, u, y).pole_zero()
    /// >>> len(report["poles"]), [channel["input"] for channel in report["channels"]]
    /// (8, ['a_v', 'M_f'])
    fn pole_zero<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>, Failure> {
        let report = py.detach(|| pole_zero(&self.model, &self.covariance))?;
        Ok(report_out(py, &self.model, &report)?)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "ArxFit({}, inputs: {}, outputs: {})",
            self.model.structure(),
            names(self.model.inputs()).join(", "),
            names(self.model.outputs()).join(", ")
        )
    }
}

impl Pickled for PyArxFit {
    type Stored = (ArxModel, Vec<DMatrix<f64>>, Option<Vec<SolvedBy>>);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        let solved_by = self.solved_by.clone();
        Ok((self.model.clone(), self.covariance.clone(), solved_by))
    }

    fn restored((model, covariance, solved_by): Self::Stored) -> Result<Self, Failure> {
        check_covariances(&model, &covariance)?;
        Ok(Self {
            model,
            covariance,
            solved_by,
        })
    }
}
