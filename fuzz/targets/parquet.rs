//! Parquet files.

#![no_main]

use gt_log::{Selection, check, columns, read_dataset};
use gtfdi_fuzz::with_file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let selection = Selection {
        inputs: vec!["a_v".to_owned()],
        outputs: vec!["M_f".to_owned()],
        ..Selection::default()
    };
    with_file("table.parquet", data, |path| {
        let _ = columns(path, None);
        let _ = read_dataset(path, &selection);
        let _ = check(path, &selection);
    });
});
