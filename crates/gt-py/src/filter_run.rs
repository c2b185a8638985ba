//! `FilterRun`: what a Kalman filter made of a record.

use std::sync::Arc;

use gtfdi::core::{Dataset, OperatingPoint, StateSpace, stored_matrix};
use gtfdi::fdi::{FdiError, FilterRun, KalmanFilter};
use nalgebra::{DMatrix, DVector};
use numpy::PyArray2;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

use crate::array::{samples_out, vector};
use crate::error::Failure;
use crate::pickle::{Pickled, Reduced, reduce};
use crate::record::Given;

/// Innovations and states of every sample of a record; ``KalmanFilter.run`` makes one.
#[pyclass(frozen, eq, name = "FilterRun", module = "gtfdi")]
#[derive(PartialEq)]
pub struct PyFilterRun {
    pub inner: FilterRun,
}

#[pymethods]
impl PyFilterRun {
    /// What the samples before did not tell of the outputs, an array (N, ny) in their units.
    #[getter]
    fn innovations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.inner.innovations.clone())
    }

    /// The innovations whitened by the lower Cholesky factor of their covariance, an array (N, ny):
    /// unit covariance, no unit.
    #[getter]
    fn normalised<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.inner.normalised.clone())
    }

    /// States from the samples before, an array (N, nx), in deviations from the operating point.
    #[getter]
    fn predicted<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.inner.predicted.clone())
    }

    /// States from the samples before and the sample itself, an array (N, nx).
    #[getter]
    fn filtered<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.inner.filtered.clone())
    }

    fn __len__(&self) -> usize {
        self.inner.innovations.ncols()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }

    fn __repr__(&self) -> String {
        format!(
            "FilterRun({} samples, {} outputs, {} states)",
            self.inner.innovations.ncols(),
            self.inner.innovations.nrows(),
            self.inner.predicted.nrows()
        )
    }
}

/// The matrices of a run.
#[derive(Serialize, Deserialize)]
pub struct Stored {
    #[serde(deserialize_with = "stored_matrix")]
    innovations: DMatrix<f64>,
    #[serde(deserialize_with = "stored_matrix")]
    normalised: DMatrix<f64>,
    #[serde(deserialize_with = "stored_matrix")]
    predicted: DMatrix<f64>,
    #[serde(deserialize_with = "stored_matrix")]
    filtered: DMatrix<f64>,
}

impl Pickled for PyFilterRun {
    type Stored = Stored;

    fn stored(&self) -> Result<Stored, Failure> {
        let FilterRun {
            innovations,
            normalised,
            predicted,
            filtered,
        } = self.inner.clone();
        Ok(Stored {
            innovations,
            normalised,
            predicted,
            filtered,
        })
    }

    fn restored(stored: Stored) -> Result<Self, Failure> {
        let inner = FilterRun {
            innovations: stored.innovations,
            normalised: stored.normalised,
            predicted: stored.predicted,
            filtered: stored.filtered,
        };
        Ok(Self { inner })
    }
}

/// Filters a record as it is given, from a state or from rest; the record with it.
pub fn filter_run(
    filter: &KalmanFilter,
    point: &OperatingPoint,
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    x0: Option<&Bound<'_, PyAny>>,
) -> Result<(Arc<Dataset>, FilterRun), Failure> {
    let model = filter.model();
    let data = record_of(model, u, y)?;
    let x0 = match x0 {
        Some(x0) => vector(x0, "x0")?,
        None => DVector::zeros(model.nx()),
    };
    let run = u.py().detach(|| {
        let deviations = data.relative_to(point)?;
        filter.run(&x0, deviations.u(), deviations.y())
    })?;
    Ok((data, run))
}

/// Relative difference up to which two sample times count as one, as everywhere in detection.
const SAMPLE_TIME_TOLERANCE: f64 = 1e-6;

/// A record as it is given, for a filter of a model.
pub fn record_of(
    model: &StateSpace,
    u: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
) -> Result<Arc<Dataset>, Failure> {
    let expected_s = model.sample_time_s();
    let given = Given::new(u, y)?;
    let data = given.known(model.inputs(), model.outputs(), expected_s)?;
    let found_s = data.sample_time_s();
    if (found_s / expected_s - 1.0).abs() > SAMPLE_TIME_TOLERANCE {
        let what = "the record".to_owned();
        return Err(FdiError::SampleTime {
            what,
            expected_s,
            found_s,
        }
        .into());
    }
    Ok(data)
}
