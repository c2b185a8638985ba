//! The `gtfdi` command line.
fn main() {}
