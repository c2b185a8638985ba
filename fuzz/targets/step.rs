//! The online detectors, stepped through any times and numbers: no panic, and a state that is taken
//! up again gives the same verdicts.

#![no_main]

use std::sync::LazyLock;

use gt_log::DetectorFile;
use gt_serve::pipeline::Watch;
use gtfdi_fuzz::{Bytes, with_file};
use libfuzzer_sys::fuzz_target;

static TURBINE: LazyLock<DetectorFile> = LazyLock::new(|| {
    let asset = include_bytes!("../../crates/gt-serve/assets/turbine_detector.json");
    with_file("turbine.json", asset, DetectorFile::read).expect("the turbine's detector")
});

static BANK: LazyLock<DetectorFile> = LazyLock::new(|| {
    let bank = include_bytes!("../seeds/document/bank30.json");
    with_file("bank.json", bank, DetectorFile::read).expect("a bank")
});

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let file = if bytes.byte() & 1 == 0 {
        &*TURBINE
    } else {
        &*BANK
    };
    let mut watch = Watch::new(file).expect("a detector that is stepped");
    let mut twin: Option<Watch> = None;
    let (nu, ny) = (watch.inputs().len(), watch.outputs().len());
    let mut k = 0_u32;
    while !bytes.is_empty() {
        match bytes.byte() {
            0 => {
                watch.reset();
                twin = None;
                continue;
            }
            1 => {
                let mut other = Watch::new(file).expect("a detector that is stepped");
                // What it holds now may have no end of numbers: then it is refused.
                if other.resume(&watch.state(), &watch.up()).is_ok() {
                    twin = Some(other);
                }
                continue;
            }
            _ => {}
        }
        // Mostly on the grid, for otherwise all is refused.
        let time_s = if bytes.byte() < 16 {
            bytes.number()
        } else {
            k += 1;
            f64::from(k) * watch.sample_time_s()
        };
        // Wrong counts now and then.
        let more = usize::from(bytes.byte() == 0);
        let u: Vec<f64> = (0..nu + more).map(|_| bytes.number()).collect();
        let y: Vec<f64> = (0..ny).map(|_| bytes.number()).collect();
        let one = watch.step(time_s, &u, &y).map(<[_]>::len);
        if let Some(twin) = &mut twin {
            let other = twin.step(time_s, &u, &y).map(<[_]>::len);
            assert_eq!(one.is_ok(), other.is_ok());
            // A sample that is refused leaves what was there, which the twin has not had.
            if one.is_ok() {
                assert_eq!(bits(watch.residuals()), bits(twin.residuals()));
                assert_eq!(bits(watch.statistics()), bits(twin.statistics()));
            }
        }
    }
});
