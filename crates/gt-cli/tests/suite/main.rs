//! The binary from outside: what it prints, writes and returns.

#![allow(clippy::expect_used, clippy::unwrap_used, clippy::panic)] // a failed step is a failed test

mod bad_file;
mod bad_option;
mod bad_record;
mod config;
mod identify;
mod order;
mod output_file;
mod place;
mod public_road;
mod road;
mod signal;
mod simulate;
mod stream;
