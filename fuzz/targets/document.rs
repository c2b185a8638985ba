//! Models, banks and isolators in JSON. Whatever is taken for a detector can be stepped.

#![no_main]

use gt_log::{DetectorFile, ModelFile, read_json};
use gt_serve::pipeline::Watch;
use gtfdi_fuzz::with_file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    with_file("document.json", data, |path| {
        let _ = read_json::<ModelFile>(path);
        let Ok(file) = DetectorFile::read(path) else {
            return;
        };
        let Ok(mut watch) = Watch::new(&file) else {
            return;
        };
        let (u, y) = (
            vec![1.0; watch.inputs().len()],
            vec![1.0; watch.outputs().len()],
        );
        for k in 0..3 {
            let _ = watch.step(f64::from(k) * watch.sample_time_s(), &u, &y);
        }
    });
});
