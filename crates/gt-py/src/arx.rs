//! `Arx` and `arx`: from records to a model by least squares.

use std::sync::Arc;

use gtfdi::core::Dataset;
use gtfdi::ident::ArxFit;
use pyo3::prelude::*;

use crate::arx_fit::PyArxFit;
use crate::arx_model::PyArxModel;
use crate::arx_options::{CentreOption, FitArguments, FitOptions};
use crate::arx_structure::StructureOptions;
use crate::dataset::Names;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::order::{Numbers, Order};
use crate::pickle::{Pickled, Reduced, reduce};
use crate::record::{borrowed, unknown_records};
use crate::warning::warn;

/// An ARX model that is still to be fitted.
///
/// Parameters
/// ----------
/// order : int, tuple of int or "auto", optional
///     Order n: output lags up to n and input lags up to n; for a canonical structure the sum of
///     the indices. A pair ``(low, high)`` searches by MDL, ``"auto"`` is ``(1, 12)`` as far as the
///     record bears it.
/// na, nb : int, optional
///     Number of output lags and of input lags (one number, or one an input), in place of an order.
/// nk : int or list of int, default 1
///     Smallest input lag; 0 adds a direct term to a canonical structure.
/// indices : list of int, optional
///     Canonical indices, one an output, in place of an order.
/// structure : {"full", "diag", "canonical"}, optional
///     ``full``; ``canonical`` with indices, or with an order and several outputs.
/// first_row : int, default 0
///     Samples before it, in each record, are no rows of the regression.
/// centre : {"means", "zero"} or tuple (u, y), default "means"
///     The operating point that is subtracted: the means of the records, nothing, or a known one.
/// missing : {"refuse", "break"}, default "refuse"
///     What a sample that is NaN means: the record is refused, or it ends there and another begins.
/// ridge : float, default 0
///     Weight of the penalty on the coefficients, each times the norm of its regressor.
/// equation_errors : {"uncorrelated", "correlated"}, default "uncorrelated"
///     Whether the errors of different outputs may be correlated: three-stage least squares then.
/// solver : {"qr", "automatic"}, default "qr"
///     ``automatic`` refines inner products of lags on long records, which is quicker.
///
/// Examples
/// --------
/// >>> gtfdi.Arx(order=2, nk=0).fit(u, y).structure
/// {'full': {'na': 2, 'nb': [3], 'nk': [0]}}
#[pyclass(frozen, eq, name = "Arx", module = "gtfdi")]
#[derive(Clone, PartialEq)]
pub struct PyArx {
    structure: StructureOptions,
    options: FitOptions,
}

impl Pickled for PyArx {
    type Stored = (StructureOptions, FitOptions);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        Ok((self.structure.clone(), self.options.clone()))
    }

    fn restored((structure, options): Self::Stored) -> Result<Self, Failure> {
        Ok(Self { structure, options })
    }
}

#[pymethods]
impl PyArx {
    #[new]
    #[pyo3(signature = (*, order=None, na=None, nb=None, nk=None, indices=None, structure=None,
        first_row=0, centre=None, missing="refuse", ridge=0.0, equation_errors="uncorrelated",
        solver="qr"),
        text_signature = "(*, order=None, na=None, nb=None, nk=1, indices=None, structure=None, \
        first_row=0, centre='means', missing='refuse', ridge=0.0, \
        equation_errors='uncorrelated', solver='qr')")]
    #[allow(clippy::too_many_arguments)] // Python names them
    fn py_new(
        order: Option<Order>,
        na: Option<usize>,
        nb: Option<Numbers>,
        nk: Option<Numbers>,
        indices: Option<Vec<usize>>,
        structure: Option<String>,
        first_row: usize,
        centre: Option<CentreOption<'_>>,
        missing: &str,
        ridge: f64,
        equation_errors: &str,
        solver: &str,
    ) -> Result<Self, Failure> {
        Ok(Self {
            structure: StructureOptions {
                order,
                na,
                nb,
                nk,
                indices,
                structure,
            },
            options: FitOptions::read(&FitArguments {
                first_row,
                centre,
                missing,
                ridge,
                equation_errors,
                solver,
            })?,
        })
    }

    /// Fits by least squares; arguments and errors as for ``gtfdi.arx``.
    #[pyo3(signature = (u, y=None, *, sample_time_s=None, inputs=None, outputs=None))]
    fn fit(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
        sample_time_s: Option<f64>,
        inputs: Option<Names>,
        outputs: Option<Names>,
    ) -> Result<PyArxModel, Failure> {
        let fit = self.fit_in_full(u, y, sample_time_s, inputs, outputs)?;
        Ok(fit.model())
    }

    /// Fits by least squares and keeps the covariance of the coefficients, an ``ArxFit``;
    /// arguments and errors as for ``gtfdi.arx``.
    ///
    /// Examples
    /// --------
    /// >>> fit = gtfdi.Arx(order=2, nk=0).fit_in_full(u, y)
    /// >>> fit.covariance[0].shape, fit.solved_by
    /// ((8, 8), ['qr'])
    #[pyo3(signature = (u, y=None, *, sample_time_s=None, inputs=None, outputs=None))]
    fn fit_in_full(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
        sample_time_s: Option<f64>,
        inputs: Option<Names>,
        outputs: Option<Names>,
    ) -> Result<PyArxFit, Failure> {
        let py = u.py();
        let records = unknown_records(u, y, inputs.as_ref(), outputs.as_ref(), sample_time_s)?;
        let wish = self.clone();
        let (fit, warning) = interruptible(py, move |_| wish.fit_records(&records))?;
        if let Some(warning) = warning {
            warn(py, &warning)?;
        }
        Ok(fit.into())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

impl PyArx {
    fn fit_records(&self, records: &[Arc<Dataset>]) -> Result<(ArxFit, Option<String>), Failure> {
        let (structure, warning) = self.structure.choose(records)?;
        let fit = self
            .options
            .arx(structure)
            .fit_in_full(&borrowed(records))?;
        Ok((fit, warning))
    }
}

/// Identifies an ARX model by least squares.
///
/// The means of the record are removed first and kept as the operating point, unless ``centre`` is
/// another. The lock on the interpreter is released meanwhile.
///
/// Parameters
/// ----------
/// u : array_like, shape (N, nu), Dataset or list
///     Inputs, or a whole record (then without ``y``), or a list of records, each a Dataset or a
///     tuple ``(u, y)``: no regression row reaches from one record into another.
/// y : array_like, shape (N, ny), optional
///     Outputs.
/// order, na, nb, nk, indices, structure
///     As for ``gtfdi.Arx``; with several records ``order`` is a number.
/// first_row, centre, missing, ridge, equation_errors, solver
///     As for ``gtfdi.Arx``.
/// sample_time_s : float, optional
///     Sample time of the arrays, 1 where left out.
/// inputs, outputs : list of str, optional
///     Tags of the arrays' channels; of a Dataset, the channels to use.
///
/// Returns
/// -------
/// ArxModel
///
/// Raises
/// ------
/// IdentError
///     The record does not determine the model; the message says why.
/// OptionError
///     Options exclude each other or are out of range.
/// DimensionError, DataError, ArrayTypeError
///     The record cannot be used.
///
/// Examples
/// --------
/// >>> run = gtfdi.simulate(600.0, seed=1)
/// >>> model = gtfdi.arx(run.measured, order=8, nk=0, inputs=["a_v", "M_f"], outputs=["q_c"])
/// >>> model.validate(run.measured)[0]["fit_prediction_percent"] > 90.0
/// True
#[pyfunction]
#[pyo3(signature = (u, y=None, *, order=None, na=None, nb=None, nk=None, indices=None,
    structure=None, first_row=0, centre=None, missing="refuse", ridge=0.0,
    equation_errors="uncorrelated", solver="qr", sample_time_s=None, inputs=None, outputs=None),
    text_signature = "(u, y=None, *, order=None, na=None, nb=None, nk=1, indices=None, \
    structure=None, first_row=0, centre='means', missing='refuse', ridge=0.0, \
    equation_errors='uncorrelated', solver='qr', sample_time_s=None, inputs=None, outputs=None)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn arx(
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    order: Option<Order>,
    na: Option<usize>,
    nb: Option<Numbers>,
    nk: Option<Numbers>,
    indices: Option<Vec<usize>>,
    structure: Option<String>,
    first_row: usize,
    centre: Option<CentreOption<'_>>,
    missing: &str,
    ridge: f64,
    equation_errors: &str,
    solver: &str,
    sample_time_s: Option<f64>,
    inputs: Option<Names>,
    outputs: Option<Names>,
) -> Result<PyArxModel, Failure> {
    let arx = PyArx::py_new(
        order,
        na,
        nb,
        nk,
        indices,
        structure,
        first_row,
        centre,
        missing,
        ridge,
        equation_errors,
        solver,
    )?;
    arx.fit(u, y, sample_time_s, inputs, outputs)
}
