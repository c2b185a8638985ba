//! What every message of a log passes: the writer of its file, and the encoding of its numbers.
//!
//! | what is wanted | begin with |
//! |---|---|
//! | a file of messages | [`FileWriter`] |
//! | messages of doubles, by field number | [`Layout`], [`Decoder`] |
//!
//! This is a crate by itself because it is compiled for speed, and `gt-log`, which says what logs
//! mean and is many times as long, for size.

mod file_writer;
mod message;

pub use file_writer::FileWriter;
pub use message::{Decoder, Layout};
