//! The bound on the mean delay.

use gt_fdi::design::mean_delay_bound;
use gt_fdi::runtime::Waveform;

use crate::run_length::{DAY, assert_close};

/// The bound for ramps, to the digits of the specification's table.
#[test]
fn regress_bound_for_ramps() {
    for (slope, expected, unit) in [
        (1e-4, 1384.0, 0.5),
        (3e-4, 695.0, 0.5),
        (1e-3, 325.0, 0.5),
        (1e-2, 75.3, 0.05),
        (1e-1, 17.2, 0.05),
    ] {
        let found = mean_delay_bound(Waveform::Ramp, slope, DAY).unwrap();
        assert_close("bound", found, expected, unit);
    }
}

/// A fault that every detector sees at once has a delay of 1; one that is hardly there waits about
/// as long as a false alarm, `1 + sum exp(-m / g) = 1 / (1 - exp(-1 / g))`.
#[test]
fn the_bound_has_its_limits() {
    assert_eq!(mean_delay_bound(Waveform::Step, 100.0, DAY), Ok(1.0));
    let blind = mean_delay_bound(Waveform::Step, 1e-9, 50.0).unwrap();
    // The fault's own effect is below 1e-9 x sqrt(2000 samples).
    let expected = 1.0 / -(-1.0_f64 / 50.0).exp_m1();
    assert_close("ratio", blind / expected, 1.0, 1e-6);
}
