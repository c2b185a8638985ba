//! Where readings come from. Each source runs on a thread of its own, so that a full queue slows it
//! down and nothing else.

pub mod lines;
pub mod message;
pub mod mqtt;
pub mod plant;
pub mod replay;
