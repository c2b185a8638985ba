//! `simulate`: the embedded gas turbine.

use std::path::PathBuf;
use std::sync::Arc;

use gt_log::{RunMetadata, write_run};
use gtfdi::core::{Dataset, Signal};
use gtfdi::plant::{self, Fault, Profile, Run, Scenario};
use nalgebra::DMatrix;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use serde::Deserialize;

use crate::array::samples_out;
use crate::dataset::{PyDataset, names};
use crate::error::Failure;

/// The record of a simulated run; see ``simulate``.
#[pyclass(frozen, name = "Run", module = "gtfdi")]
pub struct PyRun {
    scenario: Scenario,
    truth: Arc<Dataset>,
    measured: Arc<Dataset>,
    fault_signals: Vec<Signal>,
    fault_magnitudes: DMatrix<f64>,
    warnings: Vec<plant::Warning>,
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

    /// What a reader of the record should know, as text.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.iter().map(ToString::to_string).collect()
    }

    /// The whole scenario as TOML.
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
            data_sha256: None,
        };
        let run = Run {
            truth: Dataset::clone(&self.truth),
            measured: Dataset::clone(&self.measured),
            fault_signals: self.fault_signals.clone(),
            fault_magnitudes: self.fault_magnitudes.clone(),
            warnings: self.warnings.clone(),
        };
        Ok(py.detach(|| write_run(&path, &run, &metadata))?)
    }

    fn __len__(&self) -> usize {
        self.truth.len()
    }

    fn __repr__(&self) -> String {
        let faults = self.fault_names().join(", ");
        format!(
            "Run({} samples of {} s, seed {}, faults: {})",
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
}

/// Simulates the gas turbine: 5 inputs, 28 outputs, a sample every 0.08 s.
///
/// One seed and run index give the same arrays everywhere, and the defaults are those of the
/// command line. The lock on the interpreter is released meanwhile.
///
/// Parameters
/// ----------
/// seconds : float
///     Length of the record.
/// seed, run_index : int
///     Seed of excitation and noise; index of the run under that seed.
/// profile : {"steady", "gentle", "standard", "lively", "wide"}
///     Excitation.
/// noise : {"none", "low", "table8"}
///     Sensor noise.
/// map_set : {"paper", "axial"}
///     Compressor map.
/// faults : sequence of dict
///     Faults with the keys of the fault files: ``case`` and ``onset_s``, then
///     ``rate_percent_per_h`` and ``limit_percent``, or for ``fuel_actuator_lag``
///     ``rate_s_per_h`` and ``limit_s``.
/// substeps : int
///     Integration steps a sample.
///
/// Returns
/// -------
/// Run
///
/// Raises
/// ------
/// PlantError
///     The scenario makes no sense, or the plant leaves the range where the model means something.
///
/// Examples
/// --------
/// >>> fouling = {"case": "compressor_fouling", "onset_s": 15.0, "rate_percent_per_h": 5.0}
/// >>> run = gtfdi.simulate(60.0, seed=3, faults=[fouling])
/// >>> run.measured.y.shape, run.fault_names
/// ((750, 28), ['compressor_fouling'])
#[pyfunction]
#[pyo3(signature = (seconds=60.0, *, seed=1, run_index=0, profile="standard", noise="low",
    map_set="paper", faults=Vec::new(), substeps=40), text_signature = "(seconds=60.0, *, seed=1, \
    run_index=0, profile='standard', noise='low', map_set='paper', faults=(), substeps=40)")]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn simulate(
    py: Python<'_>,
    seconds: f64,
    seed: u64,
    run_index: u64,
    profile: &str,
    noise: &str,
    map_set: &str,
    faults: Vec<Bound<'_, PyDict>>,
    substeps: usize,
) -> Result<PyRun, Failure> {
    let faults = faults
        .iter()
        .enumerate()
        .map(|(index, fault)| read_fault(index, fault))
        .collect::<Result<Vec<Fault>, Failure>>()?;
    let scenario = Scenario {
        map_set: map_set.parse()?,
        duration_s: seconds,
        substeps,
        profile: Profile::named(profile)?,
        noise: noise.parse()?,
        faults,
        seed,
        run_index,
    };
    let run = py.detach(|| plant::simulate(&scenario))?;
    Ok(PyRun {
        scenario,
        truth: Arc::new(run.truth),
        measured: Arc::new(run.measured),
        fault_signals: run.fault_signals,
        fault_magnitudes: run.fault_magnitudes,
        warnings: run.warnings,
    })
}

/// A dictionary as a fault; `None` stands for a key that is left out.
fn read_fault(index: usize, fault: &Bound<'_, PyDict>) -> Result<Fault, Failure> {
    let mut table = toml::Table::new();
    for (key, value) in fault {
        if value.is_none() {
            continue;
        }
        let value = match value.cast::<PyString>() {
            Ok(text) => toml::Value::String(text.extract()?),
            Err(_) => toml::Value::Float(value.extract()?),
        };
        table.insert(key.extract()?, value);
    }
    Fault::deserialize(table).map_err(|cause| Failure::Fault { index, cause })
}
