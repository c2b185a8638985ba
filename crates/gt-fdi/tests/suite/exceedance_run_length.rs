//! Average run lengths of limits and of samples in a row beyond them.

use gt_fdi::design::ExceedanceRunLength;
use gt_fdi::runtime::Sides;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::run_length::assert_close;

/// One-sided 3 sigma: 1 / Q(3) = 740.8 samples; two-sided 370.4 (Shewhart's chart).
#[test]
fn published_three_sigma() {
    for (sides, expected) in [(Sides::Upper, 740.8), (Sides::Both, 370.4)] {
        let limit = ExceedanceRunLength::new(3.0, 1, sides).unwrap();
        assert_close("limit", limit.samples(0.0).unwrap(), expected, 0.05);
    }
}

/// Samples in a row by the chain of run lengths 0, 1, ..., n - 1, solved as equations.
#[test]
fn samples_in_a_row_by_first_steps() {
    let normal = Normal::standard();
    for (limit, shift) in [(1.0, 0.0), (0.2, 1.5), (2.0, -0.7)] {
        for n in 1..=5 {
            let above = 1.0 - normal.cdf(limit - shift);
            let below = normal.cdf(-limit - shift);
            for (sides, p) in [
                (Sides::Upper, above),
                (Sides::Lower, below),
                (Sides::Both, above + below),
            ] {
                let q = DMatrix::from_fn(n, n, |row, column| {
                    if column == 0 {
                        1.0 - p
                    } else if column == row + 1 {
                        p
                    } else {
                        0.0
                    }
                });
                let ones = DVector::from_element(n, 1.0);
                let equations = DMatrix::identity(n, n) - q;
                let expected = equations.lu().solve(&ones).unwrap()[0];
                let rule = ExceedanceRunLength::new(limit, n, sides).unwrap();
                let found = rule.samples(shift).unwrap();
                // The equations' condition is the run length, here up to 1e12.
                let tolerance = 1e-10_f64.max(1e-15 * expected);
                assert_close("ratio", found / expected, 1.0, tolerance);
            }
        }
    }
}

#[test]
fn limits_give_the_run_length_asked_for() {
    for sides in [Sides::Upper, Sides::Both] {
        for consecutive in [1, 2, 5, 30] {
            let limit = ExceedanceRunLength::limit_for(consecutive, sides, 1e12).unwrap();
            let rule = ExceedanceRunLength::new(limit, consecutive, sides).unwrap();
            // The root's tolerance of 1e-13 times the slope of the logarithm, up to 8 n.
            let tolerance = 1e-9;
            assert_close("ratio", rule.samples(0.0).unwrap() / 1e12, 1.0, tolerance);
        }
    }
}
