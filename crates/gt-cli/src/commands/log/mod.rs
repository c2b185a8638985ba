//! Verbs on logs, one file each.

pub mod export;
pub mod info;
pub mod recover;
pub mod verify;
