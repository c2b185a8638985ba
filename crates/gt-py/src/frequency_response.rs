//! `FrequencyResponse`: responses and gains with their standard errors.

use gtfdi::ident::{ArxModel, Estimate, FrequencyPoint};
use nalgebra::{Complex, DMatrix, Scalar};
use numpy::{Element, PyArray1, PyArray2, PyArray3, PyArray4, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::matrix_out;
use crate::dataset::names;
use crate::error::Failure;
use crate::pickle::{Pickled, Reduced, reduce};

/// A frequency response with standard errors; ``ArxFit.frequency_response`` makes one.
#[pyclass(frozen, name = "FrequencyResponse", module = "gtfdi")]
pub struct PyFrequencyResponse {
    inputs: Vec<String>,
    outputs: Vec<String>,
    points: Vec<FrequencyPoint>,
}

impl Pickled for PyFrequencyResponse {
    type Stored = (Vec<String>, Vec<String>, Vec<FrequencyPoint>);

    fn stored(&self) -> Result<Self::Stored, Failure> {
        let points = self.points.clone();
        Ok((self.inputs.clone(), self.outputs.clone(), points))
    }

    fn restored((inputs, outputs, points): Self::Stored) -> Result<Self, Failure> {
        Ok(Self {
            inputs,
            outputs,
            points,
        })
    }
}

impl PyFrequencyResponse {
    pub fn new(model: &ArxModel, points: Vec<FrequencyPoint>) -> Self {
        Self {
            inputs: names(model.inputs()),
            outputs: names(model.outputs()),
            points,
        }
    }

    /// A matrix (ny, nu) of each frequency below each other.
    fn stacked<'py, T: Element + Scalar>(
        &self,
        py: Python<'py>,
        of: impl Fn(&FrequencyPoint) -> &DMatrix<T>,
    ) -> PyResult<Bound<'py, PyArray3<T>>> {
        let values: Vec<T> = self
            .points
            .iter()
            .flat_map(|point| of(point).transpose().as_slice().to_vec())
            .collect();
        let shape = [self.points.len(), self.outputs.len(), self.inputs.len()];
        PyArray1::from_vec(py, values).reshape(shape)
    }

    /// The intervals of an estimate of each channel at each frequency, NaN where it has none.
    fn bands<'py>(
        &self,
        py: Python<'py>,
        confidence: f64,
        of: impl Fn(&FrequencyPoint, usize, usize) -> Option<Estimate>,
    ) -> Result<Bound<'py, PyArray4<f64>>, Failure> {
        check_confidence(confidence)?;
        let (ny, nu) = (self.outputs.len(), self.inputs.len());
        let mut values = Vec::with_capacity(2 * ny * nu * self.points.len());
        for point in &self.points {
            for output in 0..ny {
                for input in 0..nu {
                    values.extend(interval(of(point, output, input), confidence));
                }
            }
        }
        let shape = [self.points.len(), ny, nu, 2];
        Ok(PyArray1::from_vec(py, values).reshape(shape)?)
    }
}

#[pymethods]
impl PyFrequencyResponse {
    /// Tags of the inputs.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.inputs.clone()
    }

    /// Tags of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.outputs.clone()
    }

    /// The frequencies in Hz, an array (nf,).
    #[getter]
    fn frequency_hz<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let frequencies = self.points.iter().map(|point| point.frequency_hz);
        PyArray1::from_vec(py, frequencies.collect())
    }

    /// The response, a complex array (nf, ny, nu), in outputs' units per inputs' units.
    #[getter]
    fn response<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<Complex<f64>>>> {
        self.stacked(py, |point| &point.response)
    }

    /// Standard error of the magnitude, an array (nf, ny, nu).
    #[getter]
    fn magnitude_error<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        self.stacked(py, |point| &point.magnitude_error)
    }

    /// Standard error of the phase in radians, an array (nf, ny, nu); infinite where the response
    /// is zero.
    #[getter]
    fn phase_error_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        self.stacked(py, |point| &point.phase_error_rad)
    }

    /// Limits between which the magnitude is with the probability ``confidence``, to first order;
    /// an array (nf, ny, nu, 2), low and high.
    #[pyo3(signature = (confidence=0.95))]
    fn magnitude_band<'py>(
        &self,
        py: Python<'py>,
        confidence: f64,
    ) -> Result<Bound<'py, PyArray4<f64>>, Failure> {
        self.bands(py, confidence, FrequencyPoint::magnitude)
    }

    /// Limits between which the phase in radians is with the probability ``confidence``, to first
    /// order; an array (nf, ny, nu, 2), NaN where the response is zero.
    #[pyo3(signature = (confidence=0.95))]
    fn phase_band_rad<'py>(
        &self,
        py: Python<'py>,
        confidence: f64,
    ) -> Result<Bound<'py, PyArray4<f64>>, Failure> {
        self.bands(py, confidence, FrequencyPoint::phase_rad)
    }

    fn __repr__(&self) -> String {
        format!(
            "FrequencyResponse({} frequencies, inputs: {}, outputs: {})",
            self.points.len(),
            self.inputs.join(", "),
            self.outputs.join(", ")
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

/// Low and high, NaN where the estimate has no interval.
fn interval(estimate: Option<Estimate>, confidence: f64) -> [f64; 2] {
    let found = estimate.and_then(|estimate| estimate.interval(confidence));
    found.unwrap_or([f64::NAN; 2])
}

fn check_confidence(confidence: f64) -> Result<(), Failure> {
    if confidence > 0.0 && confidence < 1.0 {
        return Ok(());
    }
    Err(Failure::Option {
        option: "confidence",
        expected: "a number above 0 and below 1".to_owned(),
        found: confidence.to_string(),
    })
}

/// Gains (a list an output) as a dictionary of arrays.
pub fn gains_out<'py>(
    py: Python<'py>,
    gains: &[Vec<Estimate>],
    confidence: f64,
) -> Result<Bound<'py, PyDict>, Failure> {
    check_confidence(confidence)?;
    let inputs = gains.first().map_or(0, Vec::len);
    let table = |of: &dyn Fn(&Estimate) -> f64| -> PyResult<Bound<'py, PyArray2<f64>>> {
        let values = DMatrix::from_fn(gains.len(), inputs, |output, input| {
            of(&gains[output][input])
        });
        matrix_out(py, &values)
    };
    let report = PyDict::new(py);
    report.set_item("value", table(&|gain| gain.value)?)?;
    let error = |gain: &Estimate| gain.standard_error.unwrap_or(f64::NAN);
    report.set_item("standard_error", table(&error)?)?;
    for (side, name) in ["low", "high"].into_iter().enumerate() {
        let limit = |gain: &Estimate| interval(Some(*gain), confidence)[side];
        report.set_item(name, table(&limit)?)?;
    }
    Ok(report)
}
