//! Where an increasing function crosses zero.

use crate::FdiError;

/// Bisection alone would need no more.
const MAX_EVALUATIONS: usize = 200;
/// Width of the bracket, relative to `1 + x`, at which its middle is the root.
const TOLERANCE: f64 = 1e-13;

/// The root of the increasing `f` in `low..high`, where `f(low) <= 0 <= f(high)`: regula falsi in
/// the Illinois form, with a bisection whenever two evaluations did not halve the bracket or a
/// value is infinite.
pub(super) fn increasing_root(
    (mut low, mut high): (f64, f64),
    mut f: impl FnMut(f64) -> Result<f64, FdiError>,
) -> Result<f64, FdiError> {
    let (mut at_low, mut at_high) = (f(low)?, f(high)?);
    let mut width_before = f64::INFINITY;
    // Which end moved last: the other end's value is halved when the same one moves again.
    let mut moved = 0_i8;
    for evaluation in 0..MAX_EVALUATIONS {
        let width = high - low;
        if at_low >= 0.0 {
            return Ok(low);
        }
        if at_high <= 0.0 || width <= TOLERANCE * (1.0 + high.abs()) {
            return Ok(if at_high <= 0.0 {
                high
            } else {
                f64::midpoint(low, high)
            });
        }
        let secant = low - at_low * width / (at_high - at_low);
        let slow = evaluation % 2 == 0 && width > 0.5 * width_before;
        let x = if slow || !(secant > low && secant < high) {
            f64::midpoint(low, high)
        } else {
            secant
        };
        if evaluation % 2 == 0 {
            width_before = width;
        }
        let value = f(x)?;
        if value < 0.0 {
            (low, at_low) = (x, value);
            if moved == -1 {
                at_high *= 0.5;
            }
            moved = -1;
        } else if value > 0.0 {
            (high, at_high) = (x, value);
            if moved == 1 {
                at_low *= 0.5;
            }
            moved = 1;
        } else {
            return Ok(x);
        }
    }
    Ok(f64::midpoint(low, high))
}
