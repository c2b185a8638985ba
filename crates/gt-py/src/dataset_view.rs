//! NumPy's view of the samples of a `Dataset`.
#![expect(
    unsafe_code,
    reason = "a copy at every access of `u` is 48 MB of a record of 1e6 x 6; test_arrays.py covers it"
)]

use gtfdi::core::Dataset;
use nalgebra::DMatrix;
use numpy::PyArray2;
use numpy::ndarray::ArrayView2;
use pyo3::prelude::*;

use crate::dataset::PyDataset;
use crate::error::Failure;

/// The samples that `of` picks from a record, as a read-only array (N, channels) on the record's own
/// memory.
pub fn view<'py>(
    record: &Bound<'py, PyDataset>,
    of: impl Fn(&Dataset) -> &DMatrix<f64>,
) -> Result<Bound<'py, PyArray2<f64>>, Failure> {
    let samples = of(&record.get().inner);
    let shape = (samples.ncols(), samples.nrows());
    let view =
        ArrayView2::from_shape(shape, samples.as_slice()).map_err(|cause| Failure::NotNumbers {
            what: "samples of a Dataset".to_owned(),
            found: cause.to_string(),
        })?;
    // SAFETY: the array holds a reference to `record`, a frozen object that never gives up or
    // changes the record behind its `Arc`, so the samples stay where they are as long as the array
    // lives; and nobody can write to them through the array, which does not own them.
    let array = unsafe { PyArray2::borrow_from_array(&view, record.clone().into_any()) };
    // Not by a borrow of the array: that of another thread that reads would be in its way.
    array.getattr("flags")?.setattr("writeable", false)?;
    Ok(array)
}
