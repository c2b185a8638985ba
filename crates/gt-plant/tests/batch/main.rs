//! Many runs at once against each run alone.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "the helpers stand outside the test functions"
)]

mod alike;
mod company;
mod kernels;
mod scenarios;

use gt_plant::Run;

/// Every number and every word of two records is the same.
fn assert_same(found: &Run, expected: &Run, what: &str) {
    let numbers = |run: &Run| -> Vec<u64> {
        let (truth, measured) = (&run.truth, &run.measured);
        [truth.u(), truth.y(), measured.u(), measured.y()]
            .into_iter()
            .chain([&run.hidden, &run.fault_magnitudes])
            .flat_map(|matrix| matrix.iter().map(|value| value.to_bits()))
            .collect()
    };
    assert!(numbers(found) == numbers(expected), "{what}: other numbers");
    assert_eq!(found.truth.len(), expected.truth.len(), "{what}");
    assert_eq!(found.truth.outputs(), expected.truth.outputs(), "{what}");
    assert_eq!(found.hidden_signals, expected.hidden_signals, "{what}");
    assert_eq!(found.fault_signals, expected.fault_signals, "{what}");
    assert_eq!(found.warnings, expected.warnings, "{what}");
    assert_eq!(
        format!("{:?}", found.ended),
        format!("{:?}", expected.ended),
        "{what}"
    );
}
