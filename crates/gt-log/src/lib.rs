//! Files in and out: MCAP logs, CSV records, model files.
//!
//! - [`LogWriter`] writes MCAP with Protobuf messages of named `optional double` fields, whose
//!   descriptor is made at run time from the tags (package `gtfdi.v1`). The same content gives the
//!   same bytes, whatever the path, the clock and the number of threads.
//! - [`read_dataset`] reads `.csv`, `.parquet` and `.mcap` into a [`gt_core::Dataset`], the logs of
//!   strangers too (Protobuf of any descriptor, JSON); [`Reading`] says what a file does not say of
//!   itself; [`columns`] lists what there is to select; [`check`] says what is in a table and all that
//!   is wrong with it.
//! - [`info`] says what a log holds, [`verify`] whether it is sound, and [`recover`] writes what is
//!   sound in one that is not.
//! - [`write_run`], [`write_verdicts`] and [`write_diagnoses`] are the logs of a simulated run
//!   (`/plant/measured`, `/plant/truth`, `/plant/faults`), of a bank's verdicts and of an isolator's;
//!   each says what its topics hold.
//! - [`RotatingLog`] writes file after file, each whole by itself, and removes the oldest;
//!   [`recover_parts`] makes whole what it had to leave when its process died; [`export`] makes
//!   tables of topics.
//! - [`read_json`] and [`write_json`] are model and bank files; [`ModelFile`] and
//!   [`DetectorFile`] are what is in one.
//!
//! Every file appears under its name only when it is whole: it is written as `NAME.part` and
//! renamed. No bytes, however broken, make a reader panic.

mod atomic;
mod build_info;
mod check;
mod chunk;
mod detector_file;
mod diagnosis_log;
mod error;
mod export;
mod fields;
mod import;
mod info;
mod judge;
mod model_document;
mod model_file;
mod model_log;
mod plant_log;
mod quality;
mod raw;
mod reader;
mod records;
mod recover;
mod remark_log;
mod rotating_log;
mod schema;
mod source;
mod table;
mod time;
mod verdict_log;
mod verify;
mod writer;

pub use atomic::write_atomically;
pub use build_info::{BuildInfo, build_info};
pub use check::{
    Comparison, Confidence, Damage, DamageKind, DataCheck, Gap, NotCompared, Outlier, Reason, Run,
    Suggestion, TagCheck, TagKind, TimeCheck, check,
};
pub use detector_file::DetectorFile;
pub use diagnosis_log::write_diagnoses;
pub use error::{CellProblem, LogError, Place};
pub use export::{ExportOptions, ExportTime, Exported, ExportedColumn, export};
pub use import::{
    DEFAULT_TOPIC, Decimal, Imported, Layout, Reading, ReadingError, Resample, ResampleMethod,
    Resampled, ResampledTag, Selection, TagMap, TimeGap, Warning, columns, read_dataset,
};
pub use info::{AttachmentInfo, ChunkInfo, LogInfo, MetadataInfo, TopicInfo, info};
pub use model_document::{ModelFile, ModelKind, ModelNoise};
pub use model_file::{read_json, write_json};
pub use model_log::LoggedModel;
pub use plant_log::write_run;
pub use quality::Quality;
pub use reader::{JsonMessage, read_attachment, read_json_messages};
pub use recover::{Loss, LossKind, PartRecovery, RecoveredTopic, Recovery, recover, recover_parts};
pub use rotating_log::{JsonTopicHead, LogHead, RotatingLog, RotationOptions, TopicHead};
pub use source::sha256_hex;
pub use time::{EPOCH_NS, UNIFORM_TOLERANCE, sample_time_ns};
pub use verdict_log::write_verdicts;
pub use verify::{Problem, ProblemKind, Severity, Verification, verify};
pub use writer::{JsonTopicId, LogCompression, LogWriter, QualityTopicId, RunMetadata, TopicId};
