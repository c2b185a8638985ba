//! Campaigns: many seeded runs with drawn faults, judged by a bank, a row a run.
//!
//! A [`Spec`] says what is run, [`prepare`] opens its [`Folder`] and makes its bank, and
//! [`Campaign::fill`] runs on all cores what the folder has not. Any run is regenerated alone, bit
//! for bit, by [`Campaign::row`]. [`Summary`] says what the rows say.

mod bank_choice;
mod bank_making;
mod cell;
mod check;
mod draw;
mod fault_plan;
mod figures;
mod folder;
mod interval;
mod judge;
mod lock;
mod manifest;
mod page;
mod row;
mod runner;
mod sensor_noise;
mod spec;
mod summary;
mod table;

pub use bank_choice::{BankChoice, TestFamily};
pub use cell::{Cell, ColumnKind};
pub use check::Problem;
pub use draw::DrawnFault;
pub use fault_plan::{FaultPlan, FaultShape, Sign, SizeRange};
pub use folder::{Folder, finished_rows};
pub use interval::{Proportion, Quantile};
pub use judge::{FirstAlarm, Judge, Judgement};
pub use manifest::Manifest;
pub use row::{COLUMNS, Column, Row, RunFailure, Status};
pub use runner::{Campaign, prepare, prepare_single};
pub use spec::{ModelMethod, ModelPlan, PlantPlan, RecordPlan, Spec, TestPlanText};
pub use summary::{
    Confusion, FailureCount, FaultSummary, FirstAlarmCount, RocPoint, SizeBin, Summary,
};
pub use table::Table;
