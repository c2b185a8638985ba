//! Poles and zeros as dictionaries.

use gtfdi::ident::pole_zero::{ChannelZeros, PoleZeroReport, Root};
use gtfdi::ident::{ArxModel, Estimate};
use nalgebra::DMatrix;
use pyo3::prelude::*;
use pyo3::types::{PyComplex, PyDict};

use crate::array::matrix_out;

/// The report, with channels by name.
pub fn report_out<'py>(
    py: Python<'py>,
    model: &ArxModel,
    report: &PoleZeroReport,
) -> PyResult<Bound<'py, PyDict>> {
    let poles = report.poles.iter().map(|pole| {
        let entry = root_out(py, &pole.root, model.sample_time_s())?;
        let output = pole
            .output
            .map(|index| model.outputs()[index].name.as_str());
        entry.set_item("output", output)?;
        Ok(entry)
    });
    let channels = report.channels.iter();
    let channels = channels.map(|channel| channel_out(py, model, channel));
    let whole = PyDict::new(py);
    whole.set_item("poles", poles.collect::<PyResult<Vec<_>>>()?)?;
    whole.set_item("channels", channels.collect::<PyResult<Vec<_>>>()?)?;
    whole.set_item("superfluous_poles", report.superfluous_poles.clone())?;
    Ok(whole)
}

fn channel_out<'py>(
    py: Python<'py>,
    model: &ArxModel,
    channel: &ChannelZeros,
) -> PyResult<Bound<'py, PyDict>> {
    let zeros = channel.zeros.iter();
    let zeros = zeros.map(|zero| root_out(py, zero, model.sample_time_s()));
    let cancellations = channel.cancellations.iter().map(|pair| {
        let entry = PyDict::new(py);
        entry.set_item("pole", pair.pole)?;
        entry.set_item("zero", pair.zero)?;
        entry.set_item("distance", pair.distance)?;
        entry.set_item("standard_errors", pair.standard_errors)?;
        Ok(entry)
    });
    let whole = PyDict::new(py);
    whole.set_item("output", &model.outputs()[channel.output].name)?;
    whole.set_item("input", &model.inputs()[channel.input].name)?;
    whole.set_item("zeros", zeros.collect::<PyResult<Vec<_>>>()?)?;
    whole.set_item(
        "cancellations",
        cancellations.collect::<PyResult<Vec<_>>>()?,
    )?;
    Ok(whole)
}

fn root_out<'py>(py: Python<'py>, root: &Root, sample_time_s: f64) -> PyResult<Bound<'py, PyDict>> {
    let estimates = [
        ("magnitude", Some(root.magnitude())),
        ("time_constant_s", root.time_constant_s(sample_time_s)),
        ("damping", root.damping()),
        (
            "natural_frequency_hz",
            root.natural_frequency_hz(sample_time_s),
        ),
    ];
    let covariance = root.covariance.map(|covariance| {
        let matrix = DMatrix::from_column_slice(2, 2, covariance.as_slice());
        matrix_out(py, &matrix)
    });
    let value = PyComplex::from_doubles(py, root.value.re, root.value.im);
    let entry = PyDict::new(py);
    entry.set_item("value", value)?;
    entry.set_item("covariance", covariance.transpose()?)?;
    entry.set_item("standard_error", root.standard_error())?;
    for (name, estimate) in estimates {
        let estimate = estimate.map(|estimate| estimate_out(py, estimate));
        entry.set_item(name, estimate.transpose()?)?;
    }
    Ok(entry)
}

fn estimate_out(py: Python<'_>, estimate: Estimate) -> PyResult<Bound<'_, PyDict>> {
    let entry = PyDict::new(py);
    entry.set_item("value", estimate.value)?;
    entry.set_item("standard_error", estimate.standard_error)?;
    Ok(entry)
}
