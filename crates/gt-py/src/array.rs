//! NumPy arrays in and out.
//!
//! Time is axis 0: an array `(N, channels)` in C order has the bytes of a `channels x N` matrix in
//! column-major order, so that nothing is transposed on the way. The matrices of a model (A, B, C,
//! D) are ordinary two-dimensional arrays and are.

use gtfdi::core::DimensionError;
use nalgebra::{DMatrix, DVector};
use numpy::{
    Element, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use serde::Serialize;

use crate::error::Failure;

/// A C-contiguous array of doubles: the argument itself where it is one, else a converted copy.
/// The masked samples of a masked array become NaN, *no valid sample*.
fn doubles<'py>(
    value: &Bound<'py, PyAny>,
    what: &str,
) -> Result<PyReadonlyArrayDyn<'py, f64>, Failure> {
    let py = value.py();
    let numpy = py.import("numpy")?;
    let subclass = !value.is_exact_instance(&numpy.getattr("ndarray")?);
    if !subclass
        && let Ok(array) = value.cast::<PyArrayDyn<f64>>()
        && array.is_c_contiguous()
    {
        return array
            .try_readonly()
            .map_err(|error| PyErr::from(error).into());
    }
    let not_numbers = |found: String| Failure::NotNumbers {
        what: what.to_owned(),
        found,
    };
    let masked = subclass && value.is_instance(&numpy.getattr("ma")?.getattr("MaskedArray")?)?;
    let array = if masked {
        value.clone()
    } else {
        numpy
            .call_method1("asarray", (value,))
            .map_err(|error| not_numbers(error.value(py).to_string()))?
    };
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if !["f", "i", "u", "b"].contains(&kind.as_str()) {
        return Err(not_numbers(format!("dtype {dtype}")));
    }
    let array = if masked {
        array
            .call_method1("astype", ("float64",))?
            .call_method1("filled", (f64::NAN,))?
    } else {
        array
    };
    let options = [("dtype", "float64"), ("order", "C")].into_py_dict(py)?;
    let array = numpy.call_method("asarray", (array,), Some(&options))?;
    let array = array.cast_into::<PyArrayDyn<f64>>().map_err(PyErr::from)?;
    array
        .try_readonly()
        .map_err(|error| PyErr::from(error).into())
}

fn slice<'a>(array: &'a PyReadonlyArrayDyn<'_, f64>, what: &str) -> Result<&'a [f64], Failure> {
    array.as_slice().map_err(|error| Failure::NotNumbers {
        what: what.to_owned(),
        found: error.to_string(),
    })
}

/// Samples `(N, channels)`, or `(N,)` for one channel: the memory of the argument itself where that
/// is a C-contiguous array of doubles.
pub struct Samples<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
    what: &'static str,
    count: usize,
    channels: usize,
}

impl<'py> Samples<'py> {
    /// Reads an argument.
    pub fn new(value: &Bound<'py, PyAny>, what: &'static str) -> Result<Self, Failure> {
        let array = doubles(value, what)?;
        let (count, channels) = match *array.shape() {
            [count] => (count, 1),
            [count, channels] => (count, channels),
            _ => {
                let found = array.ndim();
                DimensionError::check(
                    &format!("dimensions of {what} (samples, channels)"),
                    2,
                    found,
                )?;
                (0, 0)
            }
        };
        Ok(Self {
            array,
            what,
            count,
            channels,
        })
    }

    /// Number of samples N.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The samples one after the other.
    pub fn values(&self) -> Result<&[f64], Failure> {
        slice(&self.array, self.what)
    }
}

/// Samples of many streams `(N, channels, streams)`, where they are like [`Samples`].
pub struct Block<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
    what: &'static str,
    shape: [usize; 3],
}

impl<'py> Block<'py> {
    /// Reads an argument.
    pub fn new(value: &Bound<'py, PyAny>, what: &'static str) -> Result<Self, Failure> {
        let array = doubles(value, what)?;
        let axes = format!("dimensions of {what} (samples, channels, streams)");
        DimensionError::check(&axes, 3, array.ndim())?;
        let shape = array.shape();
        let shape = [shape[0], shape[1], shape[2]];
        Ok(Self { array, what, shape })
    }

    /// Numbers of samples, channels and streams.
    pub fn shape(&self) -> [usize; 3] {
        self.shape
    }

    /// The samples one after the other, the streams of a channel side by side.
    pub fn values(&self) -> Result<&[f64], Failure> {
        slice(&self.array, self.what)
    }
}

/// Samples as a `channels x N` matrix.
pub fn samples(value: &Bound<'_, PyAny>, what: &'static str) -> Result<DMatrix<f64>, Failure> {
    let samples = Samples::new(value, what)?;
    let (channels, count) = (samples.channels(), samples.count());
    Ok(DMatrix::from_column_slice(
        channels,
        count,
        samples.values()?,
    ))
}

/// A matrix `(rows, columns)` as it is.
pub fn matrix(value: &Bound<'_, PyAny>, what: &str) -> Result<DMatrix<f64>, Failure> {
    let array = doubles(value, what)?;
    DimensionError::check(&format!("dimensions of {what}"), 2, array.ndim())?;
    let shape = array.shape();
    Ok(DMatrix::from_row_slice(
        shape[0],
        shape[1],
        slice(&array, what)?,
    ))
}

/// A vector `(n,)`.
pub fn vector(value: &Bound<'_, PyAny>, what: &str) -> Result<DVector<f64>, Failure> {
    let array = doubles(value, what)?;
    DimensionError::check(&format!("dimensions of {what}"), 1, array.ndim())?;
    Ok(DVector::from_column_slice(slice(&array, what)?))
}

/// A `channels x N` matrix as an array `(N, channels)`; its memory moves to NumPy.
pub fn samples_out(py: Python<'_>, matrix: DMatrix<f64>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let shape = [matrix.ncols(), matrix.nrows()];
    let values: Vec<f64> = matrix.data.into();
    PyArray1::from_vec(py, values).reshape(shape)
}

/// A matrix as an array `(rows, columns)`.
pub fn matrix_out<'py>(
    py: Python<'py>,
    matrix: &DMatrix<f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    samples_out(py, matrix.transpose())
}

/// Rows of equal length, one a sample, as an array `(N, columns)`.
pub fn table_out<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
    columns: usize,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    PyArray1::from_vec(py, values).reshape([rows, columns])
}

/// What a value's JSON form is in Python: dictionaries, lists, numbers, text, `None`.
pub fn json_out<'py, T: Serialize + ?Sized>(
    py: Python<'py>,
    what: &'static str,
    value: &T,
) -> Result<Bound<'py, PyAny>, Failure> {
    let text = json_text(what, value)?;
    Ok(py.import("json")?.call_method1("loads", (text,))?)
}

/// The value that a JSON text holds, checked; `what` names it in the error.
pub fn json_value<T: serde::de::DeserializeOwned>(
    what: &'static str,
    text: &str,
) -> Result<T, Failure> {
    serde_json::from_str(text).map_err(|cause| Failure::Json { what, cause })
}

/// The JSON form of a value, as a tree.
pub fn json_form<T: Serialize + ?Sized>(
    what: &'static str,
    value: &T,
) -> Result<serde_json::Value, Failure> {
    serde_json::to_value(value).map_err(|cause| Failure::Json { what, cause })
}

/// The JSON form of a value, as text.
pub fn json_text<T: Serialize + ?Sized>(what: &'static str, value: &T) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(|cause| Failure::Json { what, cause })
}

/// Two vectors as a dictionary of arrays `u` and `y`.
pub fn pair_out<'py>(
    py: Python<'py>,
    u: &DVector<f64>,
    y: &DVector<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let array = |values: &DVector<f64>| PyArray1::from_slice(py, values.as_slice());
    [("u", array(u)), ("y", array(y))].into_py_dict(py)
}
