//! How a campaign fails.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// A campaign that could not be carried out or written.
#[derive(Debug, Error)]
pub enum CampaignError {
    /// The plant could not be trimmed or simulated.
    #[error("{what}: {source}")]
    Plant {
        /// The run.
        what: String,
        /// The plant's error.
        source: gtfdi::plant::PlantError,
    },
    /// A record does not have what was asked of it.
    #[error("{what}: {source}")]
    Data {
        /// The record.
        what: String,
        /// The error of the data.
        source: gtfdi::core::DataError,
    },
    /// A model could not be identified, realised or validated.
    #[error("{what}: {source}")]
    Ident {
        /// The model.
        what: String,
        /// The identification's error.
        source: gtfdi::ident::IdentError,
    },
    /// A residual generator, a threshold or a signature could not be computed.
    #[error("{what}: {source}")]
    Fdi {
        /// What was being designed or run.
        what: String,
        /// The error of the design.
        source: gtfdi::fdi::FdiError,
    },
    /// A log or another file could not be written.
    #[error(transparent)]
    Log(#[from] gt_log::LogError),
    /// A folder could not be made.
    #[error("{}: cannot make the folder: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A scenario could not be written down.
    #[error("scenario: {0}")]
    Toml(#[from] toml::ser::Error),
}

/// Names what was being done when a step of a campaign failed.
pub(crate) trait During<T> {
    /// Attaches `what` to the error.
    fn during(self, what: &str) -> Result<T, CampaignError>;
}

macro_rules! during {
    ($source:ty, $variant:ident) => {
        impl<T> During<T> for Result<T, $source> {
            fn during(self, what: &str) -> Result<T, CampaignError> {
                self.map_err(|source| CampaignError::$variant {
                    what: what.to_owned(),
                    source,
                })
            }
        }
    };
}

during!(gtfdi::plant::PlantError, Plant);
during!(gtfdi::core::DataError, Data);
during!(gtfdi::ident::IdentError, Ident);
during!(gtfdi::fdi::FdiError, Fdi);
