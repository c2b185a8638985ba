//! `ScheduledArx`: local models along a load, still to be fitted.

use std::sync::Arc;

use gtfdi::core::Dataset;
use gtfdi::ident::schedule::{Estimation, ScheduledArx, ScheduledModel};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

use crate::arx_structure::StructureOptions;
use crate::choice::named;
use crate::dataset::Names;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::order::{Numbers, Order};
use crate::pickle::{Reduced, pickle_inner, reduce};
use crate::record::unknown_records;
use crate::scheduled_model::PyScheduledModel;
use crate::warning::warn;

/// ARX models at several values of a scheduling channel (a load, a speed demand), which is one of
/// the inputs; still to be fitted.
///
/// A slow scheduling channel is best left out of the equations (``nb`` of 0 for it): the points'
/// constants hold its effect at rest already.
///
/// Parameters
/// ----------
/// channel : str
///     The scheduling channel.
/// values : list of float
///     The operating points in ascending order, in the channel's unit.
/// order, na, nb, nk, indices, structure
///     As for ``gtfdi.Arx``, the same at every point; with several records ``order`` is a number.
/// width : float, default 1
///     Part of the way between two points over which one hands over to the other: 1 is linear
///     interpolation, 0 a switch half-way.
/// estimation : {"local", "joint"}, default "local"
///     Each point alone on the samples around it, or all at once on the blended equation.
///
/// Examples
/// --------
/// >>> data = run.measured.select(["a_v", "M_f"], ["q_c"])
/// >>> low, high = np.quantile(data.u[:, 1], [0.2, 0.8])
/// >>> model = gtfdi.ScheduledArx("M_f", [low, high], na=1, nb=[1, 0]).fit(data)
/// >>> model.channel, len(model.points)
/// ('M_f', 2)
#[pyclass(frozen, eq, name = "ScheduledArx", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyScheduledArx {
    inner: Wish,
}

/// What is to be fitted.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub struct Wish {
    structure: StructureOptions,
    channel: String,
    values: Vec<f64>,
    width: f64,
    estimation: Estimation,
}

#[pymethods]
impl PyScheduledArx {
    #[new]
    #[pyo3(signature = (channel, values, *, order=None, na=None, nb=None, nk=None, indices=None,
        structure=None, width=1.0, estimation="local"),
        text_signature = "(channel, values, *, order=None, na=None, nb=None, nk=1, indices=None, \
        structure=None, width=1.0, estimation='local')")]
    #[allow(clippy::too_many_arguments)] // Python names them
    fn py_new(
        channel: String,
        values: Vec<f64>,
        order: Option<Order>,
        na: Option<usize>,
        nb: Option<Numbers>,
        nk: Option<Numbers>,
        indices: Option<Vec<usize>>,
        structure: Option<String>,
        width: f64,
        estimation: &str,
    ) -> Result<Self, Failure> {
        let estimations = [("local", Estimation::Local), ("joint", Estimation::Joint)];
        let inner = Wish {
            structure: StructureOptions {
                order,
                na,
                nb,
                nk,
                indices,
                structure,
            },
            channel,
            values,
            width,
            estimation: named("estimation", estimation, &estimations)?,
        };
        Ok(Self { inner })
    }

    /// Fits all points.
    ///
    /// Parameters
    /// ----------
    /// u, y, sample_time_s, inputs, outputs
    ///     As for ``gtfdi.arx``: one record or a list of them.
    ///
    /// Returns
    /// -------
    /// ScheduledModel
    ///
    /// Raises
    /// ------
    /// IdentError
    ///     Values that do not ascend, a point without samples enough, or records that do not
    ///     determine the models.
    /// DataError
    ///     The scheduling channel is no input.
    #[pyo3(signature = (u, y=None, *, sample_time_s=None, inputs=None, outputs=None))]
    fn fit(
        &self,
        u: &Bound<'_, PyAny>,
        y: Option<&Bound<'_, PyAny>>,
        sample_time_s: Option<f64>,
        inputs: Option<Names>,
        outputs: Option<Names>,
    ) -> Result<PyScheduledModel, Failure> {
        let py = u.py();
        let records = unknown_records(u, y, inputs.as_ref(), outputs.as_ref(), sample_time_s)?;
        let wish = self.inner.clone();
        let (inner, warning) = interruptible(py, move |_| wish.fit_records(records))?;
        if let Some(warning) = warning {
            warn(py, &warning)?;
        }
        Ok(PyScheduledModel { inner })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

impl Wish {
    fn fit_records(
        &self,
        records: Vec<Arc<Dataset>>,
    ) -> Result<(ScheduledModel, Option<String>), Failure> {
        let (structure, warning) = self.structure.choose(&records)?;
        let wish = ScheduledArx::new(structure, &self.channel, self.values.clone())
            .width(self.width)
            .estimation(self.estimation);
        let records: Vec<Dataset> = records.into_iter().map(Arc::unwrap_or_clone).collect();
        Ok((wish.fit(&records)?, warning))
    }
}

pickle_inner!(PyScheduledArx, Wish);
