//! CSV exports, read in every way that there is an option for, and checked for damage.

#![no_main]

use gt_log::{
    Decimal, Layout, Reading, Resample, ResampleMethod, Selection, check, columns, read_dataset,
};
use gtfdi_fuzz::{Bytes, with_file};
use libfuzzer_sys::fuzz_target;

/// The first bytes choose the options, the rest is the file.
fn selection(bytes: &mut Bytes) -> Selection {
    let how = bytes.byte();
    let mut reading = Reading::default();
    if how & 1 != 0 {
        reading.layout = Some(Layout::Long);
    }
    if how & 2 != 0 {
        reading.decimal = Some(Decimal::Comma);
    }
    if how & 4 != 0 {
        reading.time_zone = Some("Europe/Rome".to_owned());
    }
    if how & 8 != 0 {
        reading.time_format = Some("%d.%m.%Y %H:%M:%S".to_owned());
    }
    if how & 16 != 0 {
        let method = match bytes.byte() % 3 {
            0 => ResampleMethod::Mean,
            1 => ResampleMethod::Linear,
            _ => ResampleMethod::Hold,
        };
        reading.resample = Some(Resample {
            step_s: f64::from(bytes.byte()).max(0.5) / 4.0,
            method,
            hold_at_most_s: (method != ResampleMethod::Mean).then(|| f64::from(bytes.byte())),
        });
    }
    if how & 32 != 0 {
        reading.encoding = Some("utf-16le".to_owned());
    }
    Selection {
        inputs: vec!["a_v".to_owned()],
        outputs: vec!["M_f".to_owned()],
        reading,
        ..Selection::default()
    }
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let selection = selection(&mut bytes);
    with_file("table.csv", bytes.0, |path| {
        let _ = columns(path, None);
        let _ = read_dataset(path, &selection);
        let _ = check(path, &selection);
    });
});
