//! `peak_gain` and `robustness`: gains of systems over frequencies.

use gtfdi::core::DimensionError;
use gtfdi::fdi::{FrequencyBand, PeakGain, Robustness, peak_gain as peak};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::state_space::PyStateSpace;

/// The largest gain of a stable system over all frequencies and directions, its H-infinity norm.
///
/// Parameters
/// ----------
/// system : StateSpace
///     The system.
///
/// Returns
/// -------
/// dict
///     ``gain``, which is reached; ``frequency_hz``, where; ``bound``, which is nowhere exceeded,
///     a relative 1e-7 above the gain.
///
/// Raises
/// ------
/// DesignError
///     The system is not stable.
///
/// Examples
/// --------
/// >>> lag = gtfdi.StateSpace([[0.5]], [[1.0]], [[1.0]], [[0.0]], 0.1)
/// >>> found = gtfdi.peak_gain(lag)
/// >>> round(found["gain"], 6), round(found["frequency_hz"], 6)  # 1 / (1 - 0.5), at rest
/// (2.0, 0.0)
#[pyfunction]
pub fn peak_gain<'py>(
    py: Python<'py>,
    system: &PyStateSpace,
) -> Result<Bound<'py, PyDict>, Failure> {
    let system = system.inner.clone();
    let found = interruptible(py, move |_| Ok(peak(&system)?))?;
    Ok(peak_out(py, &found)?)
}

/// How much more a residual feels faults than disturbances.
///
/// Parameters
/// ----------
/// from_disturbance, from_fault : StateSpace
///     Stable systems from disturbances and from faults to the same residuals.
/// band_hz : tuple of float, optional
///     The lowest and the highest frequency of the faults in hertz; 0 and half of the sampling
///     frequency where left out.
///
/// Returns
/// -------
/// dict
///     ``disturbance``: the most that a disturbance is amplified, as of ``peak_gain``; ``fault``:
///     the least that a fault within the band is, in any direction, 0 with more faults than
///     residuals; ``fault_frequency_hz``, where that is; ``ratio``: the second over the first.
///
/// Raises
/// ------
/// DimensionError
///     The systems have not the same number of residuals.
/// DesignError
///     A system is not stable, or the band is empty or reaches beyond half of the sampling
///     frequency.
///
/// Examples
/// --------
/// >>> lag = gtfdi.StateSpace([[0.5]], [[1.0]], [[1.0]], [[0.0]], 0.1)
/// >>> direct = gtfdi.StateSpace([[0.5]], [[0.0]], [[1.0]], [[3.0]], 0.1)
/// >>> round(gtfdi.robustness(lag, direct)["ratio"], 6)
/// 1.5
#[pyfunction]
#[pyo3(signature = (from_disturbance, from_fault, band_hz=None))]
pub fn robustness<'py>(
    py: Python<'py>,
    from_disturbance: &PyStateSpace,
    from_fault: &PyStateSpace,
    band_hz: Option<(f64, f64)>,
) -> Result<Bound<'py, PyDict>, Failure> {
    let (disturbance, fault) = (&from_disturbance.inner, &from_fault.inner);
    DimensionError::check("outputs of from_fault", disturbance.ny(), fault.ny())?;
    let band = band(band_hz, fault.sample_time_s());
    let (disturbance, fault) = (disturbance.clone(), fault.clone());
    let found = interruptible(py, move |_| Ok(Robustness::of(&disturbance, &fault, band)?))?;
    Ok(robustness_out(py, &found)?)
}

/// The band that is given, or all frequencies.
pub fn band(given_hz: Option<(f64, f64)>, sample_time_s: f64) -> FrequencyBand {
    given_hz.map_or_else(
        || FrequencyBand::all(sample_time_s),
        |(low_hz, high_hz)| FrequencyBand { low_hz, high_hz },
    )
}

/// A judgement as a dictionary.
pub fn robustness_out<'py>(py: Python<'py>, found: &Robustness) -> PyResult<Bound<'py, PyDict>> {
    let entries = [
        ("fault", found.fault),
        ("fault_frequency_hz", found.fault_frequency_hz),
        ("ratio", found.ratio),
    ];
    let whole = entries.into_py_dict(py)?;
    whole.set_item("disturbance", peak_out(py, &found.disturbance)?)?;
    Ok(whole)
}

fn peak_out<'py>(py: Python<'py>, found: &PeakGain) -> PyResult<Bound<'py, PyDict>> {
    [
        ("gain", found.gain),
        ("frequency_hz", found.frequency_hz),
        ("bound", found.bound),
    ]
    .into_py_dict(py)
}
