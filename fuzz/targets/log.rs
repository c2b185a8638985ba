//! MCAP logs: read, described, verified and recovered. What is recovered must have the form of a log.

#![no_main]

use gt_log::{
    Problem, ProblemKind, Selection, Severity, columns, info, read_dataset, recover, verify,
};
use gtfdi_fuzz::{folder, with_file};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let selection = Selection {
        inputs: vec!["a_v".to_owned()],
        outputs: vec!["M_f".to_owned()],
        ..Selection::default()
    };
    with_file("log.mcap", data, |path| {
        let _ = info(path);
        let _ = columns(path, None);
        let _ = read_dataset(path, &selection);
        let _ = verify(path);
        let out = folder().join("recovered.mcap");
        let _ = std::fs::remove_file(&out);
        if recover(path, &out).is_ok() {
            let found = verify(&out).expect("a recovered log that can be read");
            // What was changed in the source is written as it stands where no checksum tells: definitions,
            // and messages of a chunk whose end is lost.
            let mut own = found.problems.iter();
            let is_known = |problem: &Problem| {
                matches!(problem.kind, ProblemKind::Definition | ProblemKind::Message)
            };
            assert!(
                own.all(|problem| problem.severity == Severity::Remark || is_known(problem)),
                "{:?}",
                found.problems
            );
        }
    });
});
