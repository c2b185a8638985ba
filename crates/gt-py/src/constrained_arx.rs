//! `ConstrainedArx` and `ConstrainedFit`: least squares with stable poles and known gains.

use std::collections::BTreeMap;
use std::sync::Arc;

use gtfdi::core::Dataset;
use gtfdi::ident::constrained::{ConstrainedArx, ConstrainedFit, DcGain, MAX_RADIUS};
use pyo3::prelude::*;

use crate::array::json_out;
use crate::arx_model::PyArxModel;
use crate::arx_structure::StructureOptions;
use crate::choice::named;
use crate::dataset::Names;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::order::{Numbers, Order};
use crate::pickle::{Pickled, Reduced, pickle_inner, reduce};
use crate::record::Given;
use crate::warning::warn;

/// What may be known of a gain.
#[derive(FromPyObject)]
pub enum Gain {
    /// Its value.
    #[pyo3(annotation = "float")]
    Equal(f64),
    /// Its lower and upper limit.
    #[pyo3(annotation = "tuple of two float")]
    Between((f64, f64)),
    /// `positive` or `negative`.
    #[pyo3(annotation = "str")]
    Sign(String),
}

impl Gain {
    fn read(&self) -> Result<DcGain, Failure> {
        let signs = [
            ("positive", DcGain::Positive),
            ("negative", DcGain::Negative),
        ];
        match self {
            Self::Equal(value) => Ok(DcGain::Equal(*value)),
            Self::Between((lower, upper)) => Ok(DcGain::Between(*lower, *upper)),
            Self::Sign(name) => named("dc_gains", name, &signs),
        }
    }
}

/// What is known of gains, by output and input.
type Gains = BTreeMap<(String, String), Gain>;

/// A diagonal ARX model (own-output lags only) that is to be fitted with stable poles and known
/// gains at rest, by quadratic programmes.
///
/// Parameters
/// ----------
/// order, na, nb, nk
///     As for ``gtfdi.Arx`` with the structure ``diag``.
/// max_radius : float, default 0.999
///     Largest modulus of a pole, above 0 and at most 1.
/// dc_gains : dict, optional
///     What is known of gains at rest, by ``(output, input)``: ``"positive"``, ``"negative"``, a
///     value, or a tuple of limits, in units of the output per unit of the input.
///
/// Raises
/// ------
/// OptionError
///     A gain is none of these.
///
/// Examples
/// --------
/// >>> wish = gtfdi.ConstrainedArx(order=2, dc_gains={("q_c", "M_f"): "positive"})
/// >>> fit = wish.fit(run.measured, inputs=["a_v", "M_f"], outputs="q_c")
/// >>> fit.rows[0]["cost_ratio"] >= 1.0, fit.rows[0]["radius"] <= 0.999
/// (True, True)
#[pyclass(frozen, eq, name = "ConstrainedArx", module = "gtfdi")]
#[derive(Clone, PartialEq)]
pub struct PyConstrainedArx {
    structure: StructureOptions,
    max_radius: f64,
    gains: Vec<(String, String, DcGain)>,
}

impl Pickled for PyConstrainedArx {
    type Stored = (StructureOptions, f64, Vec<(String, String, DcGain)>);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        Ok((self.structure.clone(), self.max_radius, self.gains.clone()))
    }

    fn restored((structure, max_radius, gains): Self::Stored) -> Result<Self, Failure> {
        Ok(Self {
            structure,
            max_radius,
            gains,
        })
    }
}

#[pymethods]
impl PyConstrainedArx {
    #[new]
    #[pyo3(signature = (*, order=None, na=None, nb=None, nk=None, max_radius=MAX_RADIUS,
        dc_gains=None),
        text_signature = "(*, order=None, na=None, nb=None, nk=1, max_radius=0.999, \
        dc_gains=None)")]
    fn py_new(
        order: Option<Order>,
        na: Option<usize>,
        nb: Option<Numbers>,
        nk: Option<Numbers>,
        max_radius: f64,
        dc_gains: Option<Gains>,
    ) -> Result<Self, Failure> {
        let gains = dc_gains.unwrap_or_default().into_iter();
        Ok(Self {
            structure: StructureOptions {
                order,
                na,
                nb,
                nk,
                indices: None,
                structure: Some("diag".to_owned()),
            },
            max_radius,
            gains: gains
                .map(|((output, input), gain)| Ok((output, input, gain.read()?)))
                .collect::<Result<_, Failure>>()?,
        })
    }

    /// Fits each row by least squares under the constraints.
    ///
    /// Parameters
    /// ----------
    /// u, y, sample_time_s, inputs, outputs
    ///     As for ``gtfdi.arx``, of one record.
    ///
    /// Returns
    /// -------
    /// ConstrainedFit
    ///
    /// Raises
    /// ------
    /// IdentError
    ///     A radius or a gain is out of its range, or the record does not determine the model.
    /// DataError
    ///     A gain is that of a channel that the record does not have.
    #[pyo3(signature = (u, y=None, *, sample_time_s=None, inputs=None, outputs=None))]
    fn fit(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
        sample_time_s: Option<f64>,
        inputs: Option<Names>,
        outputs: Option<Names>,
    ) -> Result<PyConstrainedFit, Failure> {
        let py = u.py();
        let data = Given::new(u, y)?.unknown(inputs, outputs, sample_time_s)?;
        let wish = self.clone();
        let (inner, warning) = interruptible(py, move |_| wish.fit_record(data))?;
        if let Some(warning) = warning {
            warn(py, &warning)?;
        }
        Ok(PyConstrainedFit { inner })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

impl PyConstrainedArx {
    fn fit_record(&self, data: Arc<Dataset>) -> Result<(ConstrainedFit, Option<String>), Failure> {
        let records = [data];
        let (structure, warning) = self.structure.choose(&records)?;
        let mut wish = ConstrainedArx::new(structure).max_radius(self.max_radius);
        for (output, input, gain) in &self.gains {
            wish = wish.dc_gain(output, input, *gain);
        }
        Ok((wish.fit(&records[0])?, warning))
    }
}

/// A constrained fit with its account; ``ConstrainedArx.fit`` makes one.
#[pyclass(frozen, eq, name = "ConstrainedFit", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyConstrainedFit {
    inner: ConstrainedFit,
}

#[pymethods]
impl PyConstrainedFit {
    /// The model (ArxModel), without standard errors.
    #[getter]
    fn model(&self) -> PyArxModel {
        PyArxModel {
            inner: self.inner.model.clone(),
        }
    }

    /// What the constraints cost each output: dictionaries with ``output``, ``cost_ratio`` (sum of
    /// squares over that of least squares, ``None`` where that is zero), ``reflected_cost_ratio``
    /// (the same after reflecting the unstable poles; ``None`` where there are none),
    /// ``least_squares_radius``, ``radius`` (the largest modulus of a pole), ``active`` (the
    /// constraints that bind, ``{"stability": {"angle_rad"}}`` or ``{"dc_gain": {"input"}}``) and
    /// ``iterations``.
    #[getter]
    fn rows<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json_out(py, "constrained fit", &self.inner.rows)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

pickle_inner!(PyConstrainedFit, ConstrainedFit);
