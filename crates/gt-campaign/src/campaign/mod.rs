//! Campaigns: many seeded runs with drawn faults, judged by a bank, a row a run.
//!
//! A [`Spec`] says what is run, [`prepare`] opens its [`Folder`] and makes its bank, and
//! [`Campaign::fill`] runs on all cores what the folder has not. Any run is regenerated alone, bit
//! for bit, by [`Campaign::row`]. Other processes are given a [`Task`], of which each runs some chunks
//! and hands back their [`Part`]s. [`Summary`] says what the rows say.

mod bank_choice;
mod bank_making;
mod cell;
mod check;
mod comparison;
mod draw;
mod fault_plan;
mod fault_summary;
mod figures;
mod folder;
mod interval;
mod isolator_making;
mod judge;
mod lock;
mod manifest;
mod naming;
mod naming_summary;
mod page;
mod roc;
mod row;
mod runner;
mod sensor_noise;
mod size_limit;
mod spec;
mod summary;
mod table;
mod task;

pub use bank_choice::{BankChoice, IsolatorFamily, TestFamily};
pub use cell::{Cell, ColumnKind};
pub use check::Problem;
pub use comparison::{Compared, ComparedFault, Comparison, Difference};
pub use draw::DrawnFault;
pub use fault_plan::{FaultPlan, FaultShape, Sign, SizeRange};
pub use fault_summary::{FaultSummary, FirstAlarmCount, SizeBin, SizeLimitInTime};
pub use folder::{Folder, finished_rows};
pub use interval::{Proportion, Quantile};
pub use judge::{FirstAlarm, Judge, Judgement};
pub use manifest::Manifest;
pub use naming::{NONE_OF_THESE, Naming};
pub use naming_summary::{Confusion, NamingCounts};
pub use roc::RocPoint;
pub use row::{COLUMNS, Column, Row, RunFailure, Status};
pub use runner::{Campaign, prepare, prepare_single};
pub use size_limit::SizeLimit;
pub use spec::{ModelMethod, ModelPlan, PlantPlan, RecordPlan, Spec, TestPlanText};
pub use summary::{FailureCount, Summary};
pub use table::Table;
pub use task::{Part, Task};
