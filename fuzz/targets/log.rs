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
        if let Ok(recovery) = recover(path, &out) {
            let found = verify(&out).expect("a recovered log that can be read");
            // Only what a checksum vouches for is written though it does not decode.
            let count = |kind| {
                let own = found.problems.iter().filter(|own| own.kind == kind);
                own.count() as u64
            };
            if found.more_problems == 0 {
                let written = (recovery.undecoded_channels, recovery.undecoded_messages);
                let undecoded = (count(ProblemKind::Definition), count(ProblemKind::Message));
                assert_eq!(undecoded, written, "{:?}", found.problems);
            }
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
