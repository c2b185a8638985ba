//! How a campaign fails.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::campaign::Problem;

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
    /// A campaign's file, or one that it names, could not be read.
    #[error("{}: cannot read: {source}", path.display())]
    SpecFile {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A campaign's file is no TOML, or has other keys or types.
    #[error("{}: {reason}", path.display())]
    SpecText {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        reason: String,
    },
    /// A value of a campaign's file makes no sense.
    #[error("{}: {problem}", path.display())]
    Spec {
        /// The file.
        path: PathBuf,
        /// The key, what was expected and what was found.
        problem: Problem,
    },
    /// A value that is in no file makes no sense.
    #[error("{0}")]
    Value(Problem),
    /// A folder has files that are none of a campaign's.
    #[error(
        "{}: expected an empty folder or one of this campaign, found `{found}` in it",
        path.display()
    )]
    Foreign {
        /// The folder.
        path: PathBuf,
        /// One of the files.
        found: String,
    },
    /// Another process is at work in a folder.
    #[error("{}: expected a folder that nobody works in, found another process at work", path.display())]
    Busy {
        /// The folder.
        path: PathBuf,
    },
    /// A folder holds another campaign.
    #[error(
        "{}: {key}: expected {expected}, with which the campaign began, found {found};          take another folder for another campaign",
        path.display()
    )]
    Changed {
        /// The folder's own file.
        path: PathBuf,
        /// The first key that differs.
        key: String,
        /// What the campaign began with.
        expected: String,
        /// What is asked for now.
        found: String,
    },
    /// A table of rows could not be read or made.
    #[error("{}: {reason}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// Another process made something else of a chunk than its rows.
    #[error("expected the rows of chunk {chunk} of this campaign, found {found}")]
    Part {
        /// The chunk.
        chunk: u64,
        /// What was handed over.
        found: String,
    },
    /// What another process is to run was made by another version, so its rows could be others.
    #[error(
        "expected a worker with gtfdi {expected}, with which the campaign began, found {found}"
    )]
    Version {
        /// The campaign's version.
        expected: String,
        /// The worker's.
        found: String,
    },
    /// What another process is to run is no task.
    #[error("expected a task of a campaign, found none: {0}")]
    Task(#[from] serde_json::Error),
    /// Whoever watches wanted the work to end.
    #[error("stopped after {done} of {total} runs")]
    Stopped {
        /// Runs whose rows are kept.
        done: u64,
        /// Runs of the campaign.
        total: u64,
    },
    /// A campaign could not go on, and can be resumed.
    #[error(
        "{source}; {done} of {total} runs are kept in {}, and the same command goes on from there",
        folder.display()
    )]
    Unfinished {
        /// The campaign's folder.
        folder: PathBuf,
        /// Runs whose rows are kept.
        done: u64,
        /// Runs of the campaign.
        total: u64,
        /// What went wrong.
        source: Box<CampaignError>,
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
    ($source:ty, $variant:ident $(, $stopped:pat)?) => {
        impl<T> During<T> for Result<T, $source> {
            fn during(self, what: &str) -> Result<T, CampaignError> {
                self.map_err(|source| match source {
                    $($stopped => CampaignError::Stopped { done: 0, total: 0 },)?
                    source => CampaignError::$variant {
                        what: what.to_owned(),
                        source,
                    },
                })
            }
        }
    };
}

during!(
    gtfdi::plant::PlantError,
    Plant,
    gtfdi::plant::PlantError::Stopped(_)
);
during!(gtfdi::core::DataError, Data);
during!(
    gtfdi::ident::IdentError,
    Ident,
    gtfdi::ident::IdentError::Stopped(_)
);
during!(gtfdi::fdi::FdiError, Fdi, gtfdi::fdi::FdiError::Stopped(_));
