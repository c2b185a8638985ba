//! Keeps flow monotone over the pressure ratio between the lines as on them.

use super::grid::{Corner, mix};

/// Limits the slopes over speed of `corners` and adds the mixed derivatives. The corners stand line
/// by line at `shares` on each of `speeds`, and the lines are monotone; afterwards the bicubic
/// interpolant is monotone over the share at every speed.
///
/// At a fixed speed between two lines the derivative by share is a sum of one part from each, and
/// the part of a line with derivative `y'` and derivative `D'` of its slope over speed keeps the
/// sign of `y'` where `|k D'| <= 3 |y'|`, with `k` the step of speed (the weights of slope and
/// value stand as `k t / (1 + 2t)`). That holds in an interval of shares when both `3 y + k D` and
/// `3 y - k D` lie in Fritsch and Carlson's box. With `R` the smaller, over both ends, of
/// `3 |quotient of y| - |y'|`, it is enough that `|quotient of D| <= 3/4 R / k` and that
/// `|D'| <= 3/4 R / k` at both ends, for then `|3 k (quotient of D)| + |k D'| <= 3 R`.
pub(super) fn keep(speeds: &[f64], shares: &[f64], corners: &mut [Corner]) {
    let last = shares.len() - 1;
    for (line, corners) in corners.chunks_exact_mut(shares.len()).enumerate() {
        let fast = (line + 1).min(speeds.len() - 1);
        let step = speeds[line.max(1)] - speeds[line.max(1) - 1];
        let step = step.max(speeds[fast] - speeds[fast - 1]);
        let rooms: Vec<f64> = (0..last)
            .map(|i| {
                let quotient = (corners[i + 1][0] - corners[i][0]) / (shares[i + 1] - shares[i]);
                let slope = corners[i][1].abs().max(corners[i + 1][1].abs());
                // Where a line of another node list cuts off the flat end of a cubic, none is left.
                (3.0 * quotient.abs() - slope).max(0.0) * 0.75 / step
            })
            .collect();
        // Cuts what one node moves more than the last, then centres what that left on one side.
        let mut unlimited = corners[0][2];
        let (mut shift, mut total) = (0.0, 0.0);
        for node in 1..=last {
            let rise = corners[node][2] - unlimited;
            unlimited = corners[node][2];
            let most = rooms[node - 1] * (shares[node] - shares[node - 1]);
            shift += rise.max(-most).min(most) - rise;
            total += shift;
            corners[node][2] += shift;
        }
        let centre = total / shares.len() as f64;
        for corner in corners.iter_mut() {
            corner[2] -= centre;
        }
        mix(shares, corners);
        for (node, corner) in corners.iter_mut().enumerate() {
            let room = rooms[node.max(1) - 1].min(rooms[node.min(last - 1)]);
            let most = room.min(3.0 * corner[1].abs() / step);
            corner[3] = corner[3].max(-most).min(most);
        }
    }
}
