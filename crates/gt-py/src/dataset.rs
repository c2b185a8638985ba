//! `Dataset`: records of inputs and outputs.

use std::sync::Arc;

use gtfdi::core::{Dataset, DimensionError, Signal};
use nalgebra::DMatrix;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PySlice;
use serde::{Deserialize, Serialize};

use crate::array::samples;
use crate::dataset_view::view;
use crate::error::Failure;
use crate::interop::{FRAMES, call};
use crate::pickle::{Pickled, Reduced, reduce};
use crate::trend::PyTrend;

/// A name, or a list of names.
#[derive(FromPyObject, Clone)]
pub enum Names {
    /// One.
    #[pyo3(annotation = "str")]
    One(String),
    /// Several.
    #[pyo3(annotation = "list of str")]
    Many(Vec<String>),
}

impl From<Names> for Vec<String> {
    fn from(names: Names) -> Self {
        match names {
            Names::One(name) => vec![name],
            Names::Many(names) => names,
        }
    }
}

/// A record of inputs and outputs at a constant sample time.
///
/// Time is axis 0. The record owns its samples: arrays are copied once, after a conversion where
/// they are not C-contiguous float64; ``u`` and ``y`` are views of it, which cannot be written to.
///
/// Parameters
/// ----------
/// u : array_like, shape (N, nu) or (N,)
///     Inputs. NaN, or a masked sample, means *no valid sample*.
/// y : array_like, shape (N, ny) or (N,)
///     Outputs.
/// sample_time_s : float
///     Sample time in seconds.
/// inputs, outputs : list of str, optional
///     Tags; ``u1, u2, ...`` and ``y1, y2, ...`` where left out.
/// input_units, output_units : list of str, optional
///     SI units; empty where unknown.
/// start_time_s : float, optional
///     Time of the first sample in seconds.
///
/// Raises
/// ------
/// DimensionError
///     Sizes disagree.
/// DataError
///     A tag stands twice, or the sample time is not positive.
/// ArrayTypeError
///     An array of something else than real numbers.
///
/// Examples
/// --------
/// >>> import numpy as np, gtfdi
/// >>> data = gtfdi.Dataset(np.zeros((10, 1)), np.ones((10, 2)), 0.1, outputs=["p", "t"])
/// >>> len(data), data[2:5].y.shape
/// (10, (3, 2))
#[pyclass(frozen, eq, name = "Dataset", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyDataset {
    pub inner: Arc<Dataset>,
}

impl PyDataset {
    pub fn new(inner: Arc<Dataset>) -> Self {
        Self { inner }
    }
}

#[pymethods]
impl PyDataset {
    #[new]
    #[pyo3(signature = (u, y, sample_time_s, inputs=None, outputs=None, input_units=None,
        output_units=None, start_time_s=0.0))]
    #[allow(clippy::too_many_arguments)] // Python names them
    fn py_new(
        u: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        sample_time_s: f64,
        inputs: Option<Names>,
        outputs: Option<Names>,
        input_units: Option<Names>,
        output_units: Option<Names>,
        start_time_s: f64,
    ) -> Result<Self, Failure> {
        let (u, y) = (samples(u, "u")?, samples(y, "y")?);
        let inputs = signals(inputs, input_units, 'u', u.nrows())?;
        let outputs = signals(outputs, output_units, 'y', y.nrows())?;
        let data = Dataset::new(inputs, outputs, u, y, sample_time_s)?;
        Ok(Self::new(Arc::new(data.starting_at(start_time_s))))
    }

    /// Inputs, a read-only array (N, nu) on the record's own memory.
    #[getter]
    fn u<'py>(slf: &Bound<'py, Self>) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        view(slf, Dataset::u)
    }

    /// Outputs, a read-only array (N, ny) on the record's own memory.
    #[getter]
    fn y<'py>(slf: &Bound<'py, Self>) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
        view(slf, Dataset::y)
    }

    /// Times of the samples in seconds, an array (N,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(
            py,
            (0..self.inner.len())
                .map(|k| self.inner.time_s(k))
                .collect(),
        )
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

    /// Units of the inputs.
    #[getter]
    fn input_units(&self) -> Vec<String> {
        units(self.inner.inputs())
    }

    /// Units of the outputs.
    #[getter]
    fn output_units(&self) -> Vec<String> {
        units(self.inner.outputs())
    }

    /// Sample time in seconds.
    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.inner.sample_time_s()
    }

    /// Time of the first sample in seconds.
    #[getter]
    fn start_time_s(&self) -> f64 {
        self.inner.start_time_s()
    }

    /// The record with the named channels as inputs and outputs, in the order asked for; a channel
    /// may come from either side.
    ///
    /// Examples
    /// --------
    /// >>> run = gtfdi.simulate(8.0)
    /// >>> run.measured.select(["a_v", "M_f"], ["q_c"]).y.shape
    /// (100, 1)
    fn select(&self, inputs: Names, outputs: Names) -> Result<Self, Failure> {
        let (inputs, outputs): (Vec<String>, Vec<String>) = (inputs.into(), outputs.into());
        Ok(Self::new(Arc::new(self.inner.select(&inputs, &outputs)?)))
    }

    /// The lines in time that fit the channels best; samples that are not finite are left out.
    fn trend(&self) -> PyTrend {
        PyTrend {
            inner: self.inner.trend(),
        }
    }

    /// The record without a trend, of this record or of another one; it keeps its means.
    fn detrended(&self, trend: &PyTrend) -> Result<Self, Failure> {
        Ok(Self::new(Arc::new(self.inner.detrended(&trend.inner)?)))
    }

    /// The record with a trend put back.
    fn retrended(&self, trend: &PyTrend) -> Result<Self, Failure> {
        Ok(Self::new(Arc::new(self.inner.retrended(&trend.inner)?)))
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    fn __getitem__(&self, rows: &Bound<'_, PySlice>) -> Result<Self, Failure> {
        let length = isize::try_from(self.inner.len()).map_err(PyErr::from)?;
        let indices = rows.indices(length)?;
        if indices.step != 1 {
            return Err(Failure::Option {
                option: "step of the slice",
                expected: "1 (the sample time stays)".to_owned(),
                found: indices.step.to_string(),
            });
        }
        let start = usize::try_from(indices.start).map_err(PyErr::from)?;
        let stop = usize::try_from(indices.stop).map_err(PyErr::from)?;
        Ok(Self::new(Arc::new(self.inner.rows(start..stop)?)))
    }

    fn __repr__(&self) -> String {
        format!(
            "Dataset({} samples of {} s, inputs: {}, outputs: {})",
            self.inner.len(),
            self.inner.sample_time_s(),
            self.inputs().join(", "),
            self.outputs().join(", ")
        )
    }

    /// A ``pandas.DataFrame`` with the time in seconds as its index and a column for each channel; units
    /// are in its ``attrs``.
    ///
    /// Needs the package ``pandas`` (``pip install 'gtfdi[pandas]'``).
    ///
    /// Examples
    /// --------
    /// >>> record.to_pandas().index.name
    /// 'time_s'
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call(slf.py(), FRAMES, "to_pandas", (slf,))
    }

    /// A ``polars.DataFrame`` with the column ``time_s`` and those of ``to_pandas``.
    ///
    /// Needs the package ``polars`` (``pip install 'gtfdi[polars]'``).
    ///
    /// Examples
    /// --------
    /// >>> record.to_polars().columns[0]
    /// 'time_s'
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        call(slf.py(), FRAMES, "to_polars", (slf,))
    }

    /// The columns of ``to_polars`` as an Arrow stream, for anything that reads the PyCapsule
    /// interface: ``pyarrow.table``, ``polars.DataFrame``, DuckDB.
    ///
    /// Needs the package ``pyarrow`` (``pip install 'gtfdi[arrow]'``).
    ///
    /// Examples
    /// --------
    /// >>> import pyarrow
    /// >>> pyarrow.table(record).column_names[0]
    /// 'time_s'
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        slf: &Bound<'py, Self>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        call(slf.py(), FRAMES, "arrow_stream", (slf, requested_schema))
    }

    /// The record in a ``pandas.DataFrame``.
    ///
    /// Parameters
    /// ----------
    /// frame : pandas.DataFrame
    ///     A column a channel. NaN means *no valid sample*.
    /// inputs, outputs : str or list of str
    ///     The columns to read.
    /// sample_time_s : float, optional
    ///     Sample time in seconds, where the frame has no times; with times, the one they are to
    ///     have.
    /// time : str, optional
    ///     The column with the times, in seconds or as instants; by default they are those of the
    ///     index, or of a column ``time_s`` beside an index that only counts.
    ///
    /// Returns
    /// -------
    /// Dataset
    ///
    /// Raises
    /// ------
    /// DataError
    ///     There is no such column, or times are not a constant step apart.
    ///
    /// Examples
    /// --------
    /// >>> frame = record.to_pandas()
    /// >>> gtfdi.Dataset.from_pandas(frame, "u", ["a", "b", "c"]) == record
    /// True
    #[staticmethod]
    #[pyo3(signature = (frame, inputs, outputs, sample_time_s=None, time=None))]
    fn from_pandas<'py>(
        frame: &Bound<'py, PyAny>,
        inputs: &Bound<'py, PyAny>,
        outputs: &Bound<'py, PyAny>,
        sample_time_s: Option<f64>,
        time: Option<&str>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let arguments = (frame, inputs, outputs, sample_time_s, time);
        call(frame.py(), FRAMES, "from_pandas", arguments)
    }

    /// The record in a table of ``pyarrow``, ``polars`` or anything else that has
    /// ``__arrow_c_stream__``.
    ///
    /// Needs the package ``pyarrow`` (``pip install 'gtfdi[arrow]'``).
    ///
    /// Parameters
    /// ----------
    /// table : object with __arrow_c_stream__
    ///     A column a channel. Null and NaN mean *no valid sample*.
    /// inputs, outputs, sample_time_s, time
    ///     As for ``from_pandas``; without a sample time, times are in the column ``time_s``.
    ///
    /// Returns
    /// -------
    /// Dataset
    ///
    /// Examples
    /// --------
    /// >>> gtfdi.Dataset.from_arrow(record.to_polars(), "u", ["a", "b", "c"]) == record
    /// True
    #[staticmethod]
    #[pyo3(signature = (table, inputs, outputs, sample_time_s=None, time=None))]
    fn from_arrow<'py>(
        table: &Bound<'py, PyAny>,
        inputs: &Bound<'py, PyAny>,
        outputs: &Bound<'py, PyAny>,
        sample_time_s: Option<f64>,
        time: Option<&str>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let arguments = (table, inputs, outputs, sample_time_s, time);
        call(table.py(), FRAMES, "from_arrow", arguments)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

/// Names and units of `count` channels.
pub fn signals(
    names: Option<Names>,
    units: Option<Names>,
    prefix: char,
    count: usize,
) -> Result<Vec<Signal>, Failure> {
    let names = match names {
        Some(names) => names.into(),
        None => (1..=count)
            .map(|index| format!("{prefix}{index}"))
            .collect::<Vec<String>>(),
    };
    let Some(units) = units else {
        return Ok(Signal::named(&names));
    };
    let units: Vec<String> = units.into();
    DimensionError::check(
        &format!("units of the channels of {prefix}"),
        names.len(),
        units.len(),
    )?;
    Ok(names
        .into_iter()
        .zip(units)
        .map(|(name, unit)| Signal::new(name, unit))
        .collect())
}

/// The names of signals.
pub fn names(signals: &[Signal]) -> Vec<String> {
    signals.iter().map(|signal| signal.name.clone()).collect()
}

fn units(signals: &[Signal]) -> Vec<String> {
    signals.iter().map(|signal| signal.unit.clone()).collect()
}

/// A record as it is kept in a pickle.
#[derive(Serialize, Deserialize)]
pub struct StoredDataset {
    inputs: Vec<Signal>,
    outputs: Vec<Signal>,
    u: DMatrix<f64>,
    y: DMatrix<f64>,
    sample_time_s: f64,
    start_time_s: f64,
}

impl From<&Dataset> for StoredDataset {
    fn from(data: &Dataset) -> Self {
        Self {
            inputs: data.inputs().to_vec(),
            outputs: data.outputs().to_vec(),
            u: data.u().clone(),
            y: data.y().clone(),
            sample_time_s: data.sample_time_s(),
            start_time_s: data.start_time_s(),
        }
    }
}

impl StoredDataset {
    /// The record, checked.
    pub fn dataset(self) -> Result<Dataset, Failure> {
        let (inputs, outputs) = (self.inputs, self.outputs);
        let data = Dataset::new(inputs, outputs, self.u, self.y, self.sample_time_s)?;
        Ok(data.starting_at(self.start_time_s))
    }
}

impl Pickled for PyDataset {
    type Stored = StoredDataset;

    fn stored(&self) -> Result<StoredDataset, Failure> {
        Ok(StoredDataset::from(&*self.inner))
    }

    fn restored(stored: StoredDataset) -> Result<Self, Failure> {
        Ok(Self::new(Arc::new(stored.dataset()?)))
    }
}
