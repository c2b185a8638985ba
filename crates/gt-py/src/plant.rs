//! `simulate`, `steady_state` and `units`: the embedded gas turbine.

use std::path::PathBuf;
use std::sync::Arc;

use gt_log::{RunMetadata, write_run};
use gtfdi::core::{Dataset, Signal};
use gtfdi::plant::channels::{HIDDEN_CHANNELS, signals};
use gtfdi::plant::{self, PlantParameters, Run, Scenario, Variant};
use nalgebra::DMatrix;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};

use crate::array::samples_out;
use crate::dataset::{PyDataset, StoredDataset, names};
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::pickle::{Pickled, Reduced, reduce};
use crate::scenario::Arguments;

/// The record of a simulated run; see ``simulate``.
#[pyclass(frozen, name = "Run", module = "gtfdi")]
pub struct PyRun {
    scenario: Scenario,
    truth: Arc<Dataset>,
    measured: Arc<Dataset>,
    hidden_signals: Vec<Signal>,
    hidden: DMatrix<f64>,
    fault_signals: Vec<Signal>,
    fault_magnitudes: DMatrix<f64>,
    warnings: Vec<plant::Warning>,
    ended: Option<plant::PlantError>,
}

#[pymethods]
impl PyRun {
    /// What the plant did: no noise, no sensor fault (Dataset).
    #[getter]
    fn truth(&self) -> PyDataset {
        PyDataset::new(Arc::clone(&self.truth))
    }

    /// What the sensors say (Dataset).
    #[getter]
    fn measured(&self) -> PyDataset {
        PyDataset::new(Arc::clone(&self.measured))
    }

    /// What no sensor measures: efficiencies ``e_c`` and ``e_t``, and the fuel flow ``M_fc`` that
    /// reaches the combustor; an array (N, 3).
    #[getter]
    fn hidden<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.hidden.clone())
    }

    /// Names of the columns of ``hidden``.
    #[getter]
    fn hidden_names(&self) -> Vec<String> {
        names(&self.hidden_signals)
    }

    /// Why the record is shorter than asked for, as text; ``None`` where it is not.
    #[getter]
    fn ended(&self) -> Option<String> {
        self.ended.as_ref().map(ToString::to_string)
    }

    /// Magnitude of each fault at each sample, an array (N, nf).
    #[getter]
    fn faults<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        samples_out(py, self.fault_magnitudes.clone())
    }

    /// Names of the faults (nf).
    #[getter]
    fn fault_names(&self) -> Vec<String> {
        names(&self.fault_signals)
    }

    /// Units of the faults' magnitudes (nf).
    #[getter]
    fn fault_units(&self) -> Vec<String> {
        self.fault_signals
            .iter()
            .map(|signal| signal.unit.clone())
            .collect()
    }

    /// What a reader of the record should know, as text: limits that were met, maps that were left.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.iter().map(ToString::to_string).collect()
    }

    /// The whole scenario as TOML; as a file it is one for ``simulate(scenario=path)``.
    #[getter]
    fn config(&self) -> Result<String, Failure> {
        toml::to_string(&self.scenario).map_err(|cause| Failure::NotToml { cause })
    }

    /// Writes the run as an MCAP log, the same bytes as ``gtfdi simulate`` writes.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The file; it appears only when it is whole.
    ///
    /// Examples
    /// --------
    /// >>> gtfdi.simulate(60.0, seed=3).write("run.mcap")
    fn write(&self, py: Python<'_>, path: PathBuf) -> Result<(), Failure> {
        let metadata = RunMetadata {
            seed: Some(self.scenario.seed),
            run_index: Some(self.scenario.run_index),
            config_toml: self.config()?,
            ..RunMetadata::default()
        };
        let run = Run {
            truth: Dataset::clone(&self.truth),
            measured: Dataset::clone(&self.measured),
            hidden_signals: self.hidden_signals.clone(),
            hidden: self.hidden.clone(),
            fault_signals: self.fault_signals.clone(),
            fault_magnitudes: self.fault_magnitudes.clone(),
            warnings: self.warnings.clone(),
            ended: self.ended.clone(),
        };
        Ok(py.detach(|| write_run(&path, &run, &metadata))?)
    }

    fn __len__(&self) -> usize {
        self.truth.len()
    }

    fn __repr__(&self) -> String {
        let faults = self.fault_names().join(", ");
        format!(
            "Run({}, {} samples of {} s, seed {}, faults: {})",
            self.scenario.variant,
            self.truth.len(),
            self.truth.sample_time_s(),
            self.scenario.seed,
            if faults.is_empty() {
                "none"
            } else {
                faults.as_str()
            }
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<Reduced<'py>, Failure> {
        reduce(py, self)
    }
}

/// A run as it is kept in a pickle.
#[derive(Serialize, Deserialize)]
pub struct StoredRun {
    scenario: Scenario,
    truth: StoredDataset,
    measured: StoredDataset,
    hidden_signals: Vec<Signal>,
    hidden: DMatrix<f64>,
    fault_signals: Vec<Signal>,
    fault_magnitudes: DMatrix<f64>,
    warnings: Vec<plant::Warning>,
    ended: bool,
}

impl Pickled for PyRun {
    type Stored = StoredRun;

    fn stored(&self) -> Result<StoredRun, Failure> {
        Ok(StoredRun {
            scenario: self.scenario.clone(),
            truth: StoredDataset::from(&*self.truth),
            measured: StoredDataset::from(&*self.measured),
            hidden_signals: self.hidden_signals.clone(),
            hidden: self.hidden.clone(),
            fault_signals: self.fault_signals.clone(),
            fault_magnitudes: self.fault_magnitudes.clone(),
            warnings: self.warnings.clone(),
            ended: self.ended.is_some(),
        })
    }

    /// Why a run ended early has no stored form; such a run, which is short, is simulated again for
    /// it.
    fn restored(stored: StoredRun) -> Result<Self, Failure> {
        let ended = if stored.ended {
            plant::simulate(&stored.scenario)?.ended
        } else {
            None
        };
        Ok(Self {
            scenario: stored.scenario,
            truth: Arc::new(stored.truth.dataset()?),
            measured: Arc::new(stored.measured.dataset()?),
            hidden_signals: stored.hidden_signals,
            hidden: stored.hidden,
            fault_signals: stored.fault_signals,
            fault_magnitudes: stored.fault_magnitudes,
            warnings: stored.warnings,
            ended,
        })
    }
}

/// Simulates the gas turbine, a sample every 0.08 s.
///
/// The prototype has 6 inputs and 28 outputs, the machine in cogeneration 7 and 31; see ``units``.
/// One seed and run index give the same arrays everywhere, and the defaults are those of the
/// command line. The lock on the interpreter is released meanwhile.
///
/// Parameters
/// ----------
/// seconds : float, default 60
///     Length of the record.
/// scenario : dict or path_like, optional
///     Everything that determines a run: a dictionary with the keys of a scenario file
///     (``variant``, ``map_set``, ``maps``, ``duration_s``, ``substeps``, ``profile``,
///     ``boundary``, ``disturbance``, ``noise``, ``faults``, ``seed``, ``run_index``), or the path
///     of one. The other arguments replace its fields, their defaults do not; what it leaves out is
///     that of a healthy run of 600 s of the prototype, without noise, with seed 0.
/// variant : {"prototype", "cogeneration"}, default "prototype"
///     The machine with speed governor and pressurising valve, or on the electric mains with guide
///     vanes.
/// seed, run_index : int, default 1 and 0
///     Seed of excitation, noise and random faults; index of the run under that seed.
/// profile : str, default "standard"
///     Excitation: ``steady``, ``gentle``, ``standard``, ``lively`` or ``wide``; in cogeneration
///     ``steady``, ``standard``, ``load_reduction_igv`` or ``load_reduction_fuel``.
/// noise : {"none", "low", "table8", "table8_variance", "tables4_5"} or dict, default "low"
///     Sensor noise: a level, or a dictionary with ``level`` and ``channels``, where
///     ``channels`` maps names to dictionaries of ``deviation`` (in the channel's unit) or
///     ``share`` (of the healthy signal's deviation), ``pole`` and ``resolution``.
/// map_set : {"paper", "axial"}, default "paper"
///     Compressor map.
/// faults : sequence of dict, default ()
///     Faults with the keys of the fault files: ``case``, or ``sensor`` or ``actuator`` with a
///     ``mode``; ``onset_s`` and ``end_s``; and one of the dictionaries ``step``, ``ramp``,
///     ``exponential`` and ``intermittent``. A case also takes ``rate_percent_per_h`` and
///     ``limit_percent`` (``rate_s_per_h`` and ``limit_s`` for ``fuel_actuator_lag``).
/// substeps : int, default 28
///     Integration steps a sample.
///
/// Returns
/// -------
/// Run
///     Shorter than asked for where the plant left the range in which the model means something;
///     its ``ended`` then says which quantity did.
///
/// Raises
/// ------
/// PlantError
///     The scenario makes no sense, or its plant does not even rest within that range.
///
/// Examples
/// --------
/// >>> fouling = {"case": "compressor_fouling", "onset_s": 15.0, "rate_percent_per_h": 5.0}
/// >>> run = gtfdi.simulate(60.0, seed=3, faults=[fouling])
/// >>> run.measured.y.shape, run.fault_names
/// ((750, 28), ['compressor_fouling'])
///
/// A colder day in cogeneration, a degree an hour:
///
/// >>> day = {"boundary": {"temperature_k": {"offset": -10.0, "rate_per_h": -1.0}}, "seed": 3}
/// >>> run = gtfdi.simulate(8.0, scenario=day, variant="cogeneration")
/// >>> run.measured.u.shape, run.hidden_names
/// ((100, 7), ['e_c', 'e_t', 'M_fc'])
#[pyfunction]
#[pyo3(signature = (seconds=None, *, scenario=None, variant=None, seed=None, run_index=None,
    profile=None, noise=None, map_set=None, faults=None, substeps=None))]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn simulate<'py>(
    py: Python<'py>,
    seconds: Option<f64>,
    scenario: Option<Bound<'py, PyAny>>,
    variant: Option<&'py str>,
    seed: Option<u64>,
    run_index: Option<u64>,
    profile: Option<&'py str>,
    noise: Option<Bound<'py, PyAny>>,
    map_set: Option<&'py str>,
    faults: Option<Vec<Bound<'py, PyDict>>>,
    substeps: Option<usize>,
) -> Result<PyRun, Failure> {
    let arguments = Arguments {
        seconds,
        scenario,
        variant,
        seed,
        run_index,
        profile,
        noise,
        map_set,
        faults,
        substeps,
    };
    let scenario = arguments.scenario()?;
    let (scenario, run) = interruptible(py, move |abandoned| {
        let run = plant::simulate_until(&scenario.parameters(), &scenario, abandoned)?;
        Ok((scenario, run))
    })?;
    if let (0, Some(reason)) = (run.truth.len(), &run.ended) {
        // A plant that rests where it may not is no run that ended.
        return Err(reason.clone().into());
    }
    Ok(PyRun {
        scenario,
        truth: Arc::new(run.truth),
        measured: Arc::new(run.measured),
        hidden_signals: run.hidden_signals,
        hidden: run.hidden,
        fault_signals: run.fault_signals,
        fault_magnitudes: run.fault_magnitudes,
        warnings: run.warnings,
        ended: run.ended,
    })
}

/// The healthy equilibrium at design: the prototype's is that of the paper's Table 3.
///
/// Parameters
/// ----------
/// variant : {"prototype", "cogeneration"}
///     The machine.
/// map_set : {"paper", "axial"}
///     Compressor map.
///
/// Returns
/// -------
/// dict
///     The value of every output, and the efficiencies ``e_c`` and ``e_t``, by name: 30 of the
///     prototype, 33 in cogeneration. Their units are those of ``units``.
///
/// Examples
/// --------
/// >>> rest, units = gtfdi.steady_state(), gtfdi.units()
/// >>> f"p7 = {rest['p7']:.0f} {units['p7']}, e_c = {rest['e_c']:.3f}"
/// 'p7 = 206409 Pa, e_c = 0.878'
#[pyfunction]
#[pyo3(signature = (variant="prototype", map_set="paper"))]
pub fn steady_state<'py>(
    py: Python<'py>,
    variant: &str,
    map_set: &str,
) -> Result<Bound<'py, PyDict>, Failure> {
    let parameters = PlantParameters::new(variant.parse()?, map_set.parse()?);
    let steady = plant::steady_state(&parameters)?;
    let values = PyDict::new(py);
    for (signal, value) in steady.variables() {
        values.set_item(signal.name, value)?;
    }
    Ok(values)
}

/// The unit of every channel, by name: inputs, outputs, and what no sensor measures.
///
/// Parameters
/// ----------
/// variant : {"prototype", "cogeneration"}
///     The machine.
///
/// Returns
/// -------
/// dict
///     Texts such as ``"kg/s"``; empty for an efficiency.
///
/// Examples
/// --------
/// >>> gtfdi.units("cogeneration")["IGV"]
/// 'deg'
#[pyfunction]
#[pyo3(signature = (variant="prototype"))]
pub fn units<'py>(py: Python<'py>, variant: &str) -> Result<Bound<'py, PyDict>, Failure> {
    let variant: Variant = variant.parse()?;
    let channels = [
        variant.input_channels(),
        variant.output_channels(),
        &HIDDEN_CHANNELS,
    ];
    let units = PyDict::new(py);
    for signal in signals(channels.into_iter().flatten()) {
        units.set_item(signal.name, signal.unit)?;
    }
    Ok(units)
}
