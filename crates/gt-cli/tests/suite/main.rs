//! The binary from outside: what it prints, writes and returns.

#![allow(clippy::expect_used, clippy::unwrap_used, clippy::panic)] // a failed step is a failed test

mod bad_campaign;
mod bad_file;
mod bad_option;
mod bad_record;
mod bad_scenario;
mod campaign;
mod config;
mod config_file;
mod constraint;
mod document;
mod errors_in_variables;
mod export;
mod fit_option;
mod identify;
mod isolation_road;
mod json_schema;
mod log_export;
mod log_recover;
mod log_verify;
mod maps;
mod model_check;
mod model_show;
mod optimise_road;
mod order;
mod output_file;
mod place;
mod public_road;
mod records;
mod report_page;
mod road;
mod scenario;
mod serve;
mod serve_faults;
mod serve_kills;
mod serve_mqtt;
mod serve_tls;
mod serving;
mod shell;
mod signal;
mod simulate;
mod statistics_road;
mod stream;
mod unknown_road;
mod walk_through;
