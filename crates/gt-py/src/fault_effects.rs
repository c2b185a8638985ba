//! `fault_effects` and `lag_limit`: what the paper's four faults do to the simulated turbine.

use gtfdi::plant::effects::{MONITORED, Reading};
use gtfdi::plant::{
    EffectSettings, FaultCase, FaultEffects, PlantParameters, Profile, Variant,
    lag_limit as find_limit,
};
use nalgebra::DMatrix;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::array::matrix_out;
use crate::dataset::names;
use crate::error::Failure;
use crate::interrupt::interruptible;

/// What the paper's four faults do to the 28 outputs of the prototype, each there in full from the
/// beginning, in percent of the healthy steady value.
///
/// In two readings: ``raw``, the faulty closed loop against the healthy one, and ``inputs_held``,
/// the faulty plant against a healthy one that gets its valve angle and its demanded fuel. The
/// second is what a residual can show at best, however good its model.
///
/// Parameters
/// ----------
/// map_set : {"paper", "axial"}, default "paper"
///     Compressor map.
/// flow_loss_percent : float, default 5
///     Compressor fouling: share of the mass flow that is lost.
/// drift_percent : float, default 5
///     Thermocouple drift: error of the reading of t3.
/// efficiency_loss_percent : float, default 5
///     Turbine damage: share of the efficiency that is lost.
/// lag_s : float, default 2
///     Fuel actuator: time constant of its lag in seconds.
/// profile : str, default "lively"
///     Excitation: ``steady``, ``gentle``, ``standard``, ``lively`` or ``wide``.
/// window_s, settle_s : float, default 120 and 30
///     Length of the window, and what passes before it, in seconds.
/// substeps : int, default 28
///     Integration steps a sample.
/// seed, run_index : int, default 0
///     Of the excitation.
///
/// Returns
/// -------
/// dict
///     ``cases``; ``outputs`` and their ``units``; ``steady`` (28,), the healthy values; ``raw``
///     and ``inputs_held``, each with the arrays (28, 4) ``static_percent``, once everything has
///     settled, and ``rms_percent``, over the window, and the signature of each,
///     ``static_signature`` and ``rms_signature``; ``delivered_fuel_rms_percent`` (28,), what is
///     left of the fourth case where the healthy plant gets the fuel that was delivered.
///
///     A signature has ``monitored``, the outputs q_c, t3, p7 and m9; ``share`` (4, 4), the size of
///     each effect on them over the largest on the same output; ``strongest_case``, the case, 1 to
///     4, that moves each most; ``most_affected``, the output that each case moves most; and
///     ``is_diagonal``, whether every one is moved most by its own case.
///
/// Raises
/// ------
/// PlantError
///     A setting out of its range, a name that there is not, or a faulty plant without an
///     equilibrium.
///
/// Examples
/// --------
/// >>> effects = gtfdi.fault_effects(window_s=8.0, settle_s=0.0)
/// >>> fouling = effects["raw"]["static_percent"][:, 0]
/// >>> round(float(fouling[effects["outputs"].index("q_c")]), 2)
/// -3.57
/// >>> effects["raw"]["rms_percent"].shape
/// (28, 4)
#[pyfunction]
#[pyo3(signature = (map_set="paper", *, flow_loss_percent=5.0, drift_percent=5.0,
    efficiency_loss_percent=5.0, lag_s=2.0, profile="lively", window_s=120.0, settle_s=30.0,
    substeps=28, seed=0, run_index=0))]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn fault_effects<'py>(
    py: Python<'py>,
    map_set: &str,
    flow_loss_percent: f64,
    drift_percent: f64,
    efficiency_loss_percent: f64,
    lag_s: f64,
    profile: &str,
    window_s: f64,
    settle_s: f64,
    substeps: usize,
    seed: u64,
    run_index: u64,
) -> Result<Bound<'py, PyDict>, Failure> {
    let plant = PlantParameters::for_maps(map_set.parse()?);
    let settings = EffectSettings {
        flow_loss_percent,
        drift_percent,
        efficiency_loss_percent,
        lag_s,
        profile: Profile::named(Variant::Prototype, profile)?,
        window_s,
        settle_s,
        substeps,
        seed,
        run_index,
    };
    let effects = interruptible(py, move |_| Ok(FaultEffects::measure(&plant, &settings)?))?;
    let whole = PyDict::new(py);
    whole.set_item("cases", FaultCase::NAMES)?;
    whole.set_item("outputs", names(&effects.outputs))?;
    let units = effects.outputs.iter().map(|signal| signal.unit.clone());
    whole.set_item("units", units.collect::<Vec<_>>())?;
    whole.set_item("steady", PyArray1::from_slice(py, &effects.steady))?;
    whole.set_item("raw", reading(py, &effects, &effects.raw)?)?;
    whole.set_item("inputs_held", reading(py, &effects, &effects.inputs_held)?)?;
    let delivered = PyArray1::from_slice(py, &effects.delivered_fuel_rms_percent);
    whole.set_item("delivered_fuel_rms_percent", delivered)?;
    Ok(whole)
}

fn reading<'py>(
    py: Python<'py>,
    effects: &FaultEffects,
    reading: &Reading,
) -> PyResult<Bound<'py, PyDict>> {
    let entry = PyDict::new(py);
    for (name, percent) in [
        ("static", &reading.static_percent),
        ("rms", &reading.rms_percent),
    ] {
        entry.set_item(format!("{name}_percent"), matrix_out(py, percent)?)?;
        let signature = signature(py, effects, percent)?;
        entry.set_item(format!("{name}_signature"), signature)?;
    }
    Ok(entry)
}

fn signature<'py>(
    py: Python<'py>,
    effects: &FaultEffects,
    percent: &DMatrix<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let found = effects.signature(percent);
    let entry = PyDict::new(py);
    entry.set_item("monitored", MONITORED)?;
    entry.set_item("share", matrix_out(py, &found.share)?)?;
    entry.set_item("strongest_case", found.strongest_case)?;
    entry.set_item("most_affected", found.most_affected)?;
    entry.set_item("is_diagonal", found.is_diagonal())?;
    Ok(entry)
}

/// The smallest lag of the fuel actuator at which the prototype's speed loop, linearised at design,
/// no longer decays.
///
/// Parameters
/// ----------
/// map_set : {"paper", "axial"}, default "paper"
///     Compressor map.
///
/// Returns
/// -------
/// dict or None
///     ``lag_s`` in seconds and ``frequency_rad_s``, that of the mode that neither decays nor
///     grows; none where all decay up to 1000 s.
///
/// Examples
/// --------
/// >>> limit = gtfdi.lag_limit()
/// >>> limit["lag_s"] > 2.0  # what ``fault_effects`` takes is stable
/// True
#[pyfunction]
#[pyo3(signature = (map_set="paper"))]
pub fn lag_limit<'py>(
    py: Python<'py>,
    map_set: &str,
) -> Result<Option<Bound<'py, PyDict>>, Failure> {
    let plant = PlantParameters::for_maps(map_set.parse()?);
    let Some(found) = py.detach(|| find_limit(&plant))? else {
        return Ok(None);
    };
    let entries = [
        ("lag_s", found.lag_s),
        ("frequency_rad_s", found.frequency_rad_s),
    ];
    Ok(Some(entries.into_py_dict(py)?))
}
