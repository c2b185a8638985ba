//! What goes wrong on the way between Python and the rooms, and which exception says so.

use std::path::PathBuf;

use gt_campaign::CampaignError;
use gt_log::LogError;
use gtfdi::core::{DataError, DimensionError, ModelError, Stopped};
use gtfdi::fdi::{FdiError, FleetError, ResumeError, StatisticError, StepError};
use gtfdi::ident::IdentError;
use gtfdi::plant::PlantError;
use pyo3::prelude::*;
use pyo3::types::PyType;
use thiserror::Error;

/// The Python module of the exception classes, which have two bases each and so are Python.
const EXCEPTIONS: &str = "gtfdi.errors";

/// Why a call from Python is refused.
#[derive(Debug, Error)]
pub enum Failure {
    /// Sizes disagree.
    #[error(transparent)]
    Dimension(#[from] DimensionError),
    /// A record cannot be built or used.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A state-space model cannot be built or used.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A model cannot be identified, realised or applied.
    #[error(transparent)]
    Ident(#[from] IdentError),
    /// A design cannot be made or used.
    #[error(transparent)]
    Fdi(#[from] FdiError),
    /// The online detector refused a sample.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The online detector refused a saved state.
    #[error(transparent)]
    Resume(#[from] ResumeError),
    /// A streaming statistic cannot be made or used.
    #[error(transparent)]
    Statistic(#[from] StatisticError),
    /// A fleet refused samples.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// A scenario cannot be simulated.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// A file cannot be read or written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A file cannot be read as it was asked to be; Python's keywords are named.
    #[error("{text}")]
    Reading {
        /// Which file, what was expected and what was found.
        text: String,
    },
    /// A fault of a scenario has other keys or values than its case.
    #[error("faults, entry {index}: {cause}")]
    Fault {
        /// 0-based position in the list.
        index: usize,
        /// What the keys should be.
        cause: toml::de::Error,
    },
    /// A fault's description has other keys or values than there are.
    #[error("faults, entry {index}: {cause}")]
    Description {
        /// 0-based position in the list.
        index: usize,
        /// What is wrong.
        cause: String,
    },
    /// The effect of a fault cannot be used or learned.
    #[error("fault `{name}`: {source}")]
    Effect {
        /// The fault.
        name: String,
        /// Why not.
        source: FdiError,
    },
    /// A model has no generator for all its outputs.
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    /// The noise of a scenario has other keys or values than there are.
    #[error("noise: {cause}")]
    Noise {
        /// What the keys should be.
        cause: toml::de::Error,
    },
    /// A scenario has other keys or values than there are.
    #[error("scenario: {cause}")]
    Scenario {
        /// What the keys should be.
        cause: toml::de::Error,
    },
    /// A file is no scenario.
    #[error("{}: {}", path.display(), cause.to_string().trim_end())]
    ScenarioFile {
        /// The file.
        path: PathBuf,
        /// What it should hold.
        cause: toml::de::Error,
    },
    /// A file cannot be read.
    #[error("{}: {cause}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: std::io::Error,
    },
    /// A scenario has no TOML form.
    #[error("scenario: expected a TOML form, found none: {cause}")]
    NotToml {
        /// What is in the way.
        cause: toml::ser::Error,
    },
    /// A value has no JSON form.
    #[error("{what}: expected a JSON form, found none: {cause}")]
    Json {
        /// What was to be written or read.
        what: &'static str,
        /// What is in the way.
        cause: serde_json::Error,
    },
    /// A model file without what the class is about.
    #[error("{place}: expected an errors-in-variables model (kind eiv or frisch), found kind arx")]
    NoNoise {
        /// The file, or what was read.
        place: String,
    },
    /// An array of something else than real numbers.
    #[error("{what}: expected an array of real numbers, found {found}")]
    NotNumbers {
        /// Which argument.
        what: String,
        /// Its dtype, or why NumPy makes no array of it.
        found: String,
    },
    /// An option out of its range, or options that exclude each other.
    #[error("option {option}: expected {expected}, found {found}")]
    Option {
        /// The option's name.
        option: &'static str,
        /// What is accepted.
        expected: String,
        /// What was given.
        found: String,
    },
    /// An option that does not fit the others or is out of its range.
    #[error("option `{option}`: {reason}")]
    Refusal {
        /// The option's name.
        option: &'static str,
        /// What was expected and what was found.
        reason: String,
    },
    /// A pickle is of another version, or its bytes are broken.
    #[error("pickle of {name}: expected {expected}, found {found}")]
    Pickle {
        /// The class.
        name: String,
        /// What this version reads.
        expected: String,
        /// What the pickle holds.
        found: String,
    },
    /// The caller has gone.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// No thread for long work can be had.
    #[error("expected a thread for long work, found none: {cause}")]
    Thread {
        /// What the system says.
        cause: std::io::Error,
    },
    /// Long work came to no end: a defect of this package.
    #[error("expected a result of long work, found a thread that died: please report it")]
    Died,
    /// Python itself objects.
    #[error(transparent)]
    Python(#[from] PyErr),
}

impl Failure {
    /// The name of the exception class, and the sizes where it is about sizes.
    fn class(&self) -> (&'static str, Option<&DimensionError>) {
        match self {
            Self::Dimension(sizes)
            | Self::Data(DataError::Dimension(sizes))
            | Self::Model(ModelError::Dimension(sizes))
            | Self::Ident(
                IdentError::Dimension(sizes)
                | IdentError::Data(DataError::Dimension(sizes))
                | IdentError::Model(ModelError::Dimension(sizes)),
            )
            | Self::Fdi(
                FdiError::Dimension(sizes)
                | FdiError::Data(DataError::Dimension(sizes))
                | FdiError::Model(ModelError::Dimension(sizes)),
            ) => ("DimensionError", Some(sizes)),
            Self::Data(_) | Self::Ident(IdentError::Data(_)) | Self::Fdi(FdiError::Data(_)) => {
                ("DataError", None)
            }
            Self::Model(_) | Self::Ident(IdentError::Model(_)) | Self::Fdi(FdiError::Model(_)) => {
                ("ModelError", None)
            }
            Self::Ident(_) => ("IdentError", None),
            Self::Step(_) | Self::Resume(_) | Self::Fleet(_) | Self::Fdi(FdiError::Step(_)) => {
                ("StepError", None)
            }
            Self::Campaign(CampaignError::Folder { .. } | CampaignError::Log(_)) => {
                ("LogError", None)
            }
            Self::Fdi(_) | Self::Statistic(_) | Self::Effect { .. } | Self::Campaign(_) => {
                ("DesignError", None)
            }
            Self::Plant(_)
            | Self::Fault { .. }
            | Self::Noise { .. }
            | Self::Scenario { .. }
            | Self::ScenarioFile { .. }
            | Self::NotToml { .. } => ("PlantError", None),
            Self::Log(_)
            | Self::Reading { .. }
            | Self::Json { .. }
            | Self::Unreadable { .. }
            | Self::NoNoise { .. } => ("LogError", None),
            Self::NotNumbers { .. } => ("ArrayTypeError", None),
            Self::Option { .. } | Self::Refusal { .. } | Self::Description { .. } => {
                ("OptionError", None)
            }
            Self::Pickle { .. } => ("PickleError", None),
            Self::Stopped(_) | Self::Thread { .. } | Self::Died | Self::Python(_) => {
                ("GtfdiError", None)
            }
        }
    }

    fn raise(&self, py: Python<'_>) -> PyResult<PyErr> {
        let (name, sizes) = self.class();
        let class = py
            .import(EXCEPTIONS)?
            .getattr(name)?
            .cast_into::<PyType>()?;
        let error = PyErr::from_type(class, self.to_string());
        if let Some(sizes) = sizes {
            let value = error.value(py);
            value.setattr("what", &sizes.what)?;
            value.setattr("expected", sizes.expected)?;
            value.setattr("found", sizes.found)?;
        }
        Ok(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Python(error) => error,
            failure => Python::attach(|py| failure.raise(py).unwrap_or_else(|error| error)),
        }
    }
}
