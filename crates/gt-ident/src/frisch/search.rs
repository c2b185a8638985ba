//! Where on a simplex of noise shares a criterion is least.

use nalgebra::DVector;

use super::brent::{Minimum, brent};
use super::nelder_mead::{Limits, nelder_mead};

/// Points of the grid on a segment, ends included.
const SEGMENT_POINTS: usize = 41;
/// The finest division of an edge of a simplex, and the points at which a coarser one is taken.
const EDGE_PARTS: usize = 6;
const GRID_POINTS: usize = 60;
/// Grid points that a local search starts from.
const STARTS: usize = 2;
/// A share below it is taken as zero: a search in square roots stops within about 1e-9 of zero.
pub(crate) const ZERO_SHARE: f64 = 1e-9;

/// The shares (at least zero, sum 1) of `channels` channels where `f` is least, and its value.
///
/// `f` may be infinite. Two channels: a grid and Brent's method around its best points; more: a
/// grid on the simplex and Nelder-Mead on square roots of the shares, so that a face is a place
/// like any other. `None` where `f` is infinite on the whole grid.
pub(crate) fn least_shares(channels: usize, f: impl Fn(&[f64]) -> f64) -> Option<(Vec<f64>, f64)> {
    if channels <= 1 {
        let value = f(&[1.0]);
        return value.is_finite().then(|| (vec![1.0], value));
    }
    if channels == 2 {
        return segment(f);
    }
    let mut best: Option<(Vec<f64>, f64)> = None;
    for (start, value) in best_of_grid(channels, &f) {
        let found = from_start(&start, value, &f);
        if best.as_ref().is_none_or(|(_, least)| found.1 < *least) {
            best = Some(found);
        }
    }
    best
}

/// The best points of the simplex grid, best first; only those of finite value.
pub(crate) fn best_of_grid(channels: usize, f: impl Fn(&[f64]) -> f64) -> Vec<(Vec<f64>, f64)> {
    let mut points: Vec<(Vec<f64>, f64)> = simplex_grid(channels)
        .into_iter()
        .map(|shares| {
            let value = f(&shares);
            (shares, value)
        })
        .filter(|(_, value)| value.is_finite())
        .collect();
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    points.truncate(STARTS);
    points
}

/// The limits of a local search in square roots of shares, for `dimension` variables.
pub(crate) fn limits(dimension: usize) -> Limits {
    Limits {
        step: 0.2,
        tolerance: 1e-9,
        evaluations: 250 * dimension.max(1),
    }
}

fn segment(f: impl Fn(&[f64]) -> f64) -> Option<(Vec<f64>, f64)> {
    let at = |share: f64| f(&[1.0 - share, share]);
    let last = SEGMENT_POINTS - 1;
    let mut grid: Vec<Minimum> = (0..=last)
        .map(|index| {
            let share = index as f64 / last as f64;
            Minimum {
                at: share,
                value: at(share),
            }
        })
        .collect();
    let spacing = 1.0 / last as f64;
    grid.retain(|point| point.value.is_finite());
    grid.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut best = *grid.first()?;
    for point in grid.iter().take(STARTS) {
        let ends = ((point.at - spacing).max(0.0), (point.at + spacing).min(1.0));
        let found = brent(at, ends, 1e-12, 100);
        if found.value < best.value {
            best = found;
        }
    }
    Some((vec![1.0 - best.at, best.at], best.value))
}

fn from_start(start: &[f64], value: f64, f: &impl Fn(&[f64]) -> f64) -> (Vec<f64>, f64) {
    // The largest share is the unit of the others: its face is far from the start.
    let unit = (0..start.len())
        .max_by(|&a, &b| start[a].total_cmp(&start[b]))
        .unwrap_or(0);
    let shares = |x: &DVector<f64>| -> Vec<f64> {
        let total = 1.0 + x.norm_squared();
        let mut shares: Vec<f64> = x.iter().map(|root| root * root / total).collect();
        shares.insert(unit, 1.0 / total);
        for share in &mut shares {
            if *share < ZERO_SHARE {
                *share = 0.0;
            }
        }
        shares
    };
    let mut roots: Vec<f64> = start
        .iter()
        .map(|share| (share / start[unit]).sqrt())
        .collect();
    roots.remove(unit);
    let roots = DVector::from_vec(roots);
    let limits = limits(roots.len());
    let (x, least) = nelder_mead(|x| f(&shares(x)), &roots, limits);
    if least <= value {
        (shares(&x), least)
    } else {
        (start.to_vec(), value)
    }
}

/// All shares that are multiples of one part of an edge.
fn simplex_grid(channels: usize) -> Vec<Vec<f64>> {
    let parts = (2..=EDGE_PARTS)
        .rev()
        .find(|&parts| compositions(parts, channels) <= GRID_POINTS)
        .unwrap_or(2);
    let mut grid = vec![vec![]];
    for channel in 0..channels {
        let mut longer = Vec::new();
        for point in grid {
            let left = parts - point.iter().sum::<usize>();
            let least = if channel + 1 == channels { left } else { 0 };
            for count in least..=left {
                let mut next = point.clone();
                next.push(count);
                longer.push(next);
            }
        }
        grid = longer;
    }
    grid.into_iter()
        .map(|point| {
            let share = |count: usize| count as f64 / parts as f64;
            point.into_iter().map(share).collect()
        })
        .collect()
}

/// `(parts + channels - 1)` over `parts`.
fn compositions(parts: usize, channels: usize) -> usize {
    (1..=parts).fold(1_usize, |count, k| {
        count.saturating_mul(channels - 1 + k) / k
    })
}

#[cfg(test)]
mod tests {
    use super::{compositions, least_shares, simplex_grid};

    /// The grid holds every composition once and its points are shares.
    #[test]
    fn the_grid_is_the_simplex() {
        for (channels, count) in [(2, 7), (3, 28), (4, 56), (6, 56), (12, 78)] {
            let grid = simplex_grid(channels);
            assert_eq!(grid.len(), count);
            for point in &grid {
                assert!((point.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            }
        }
        assert_eq!(compositions(6, 3), 28);
    }

    /// Minima inside, on faces and at corners, for two to five channels.
    #[test]
    fn minima_inside_and_on_faces() {
        for target in [
            vec![0.9, 0.1],
            vec![0.993, 0.007],
            vec![1.0, 0.0],
            vec![0.0, 1.0],
            vec![0.7, 0.2, 0.1],
            vec![0.8, 0.0, 0.2],
            vec![0.0, 0.4, 0.6],
            vec![0.0, 1.0, 0.0],
            vec![0.5, 0.1, 0.2, 0.2],
            vec![0.6, 0.0, 0.3, 0.0, 0.1],
        ] {
            let distance = |shares: &[f64]| -> f64 {
                let pairs = shares.iter().zip(&target);
                pairs.map(|(a, b)| (a - b).powi(2)).sum()
            };
            let (found, value) = least_shares(target.len(), distance).unwrap();
            assert!(value < 1e-14, "{target:?}: {found:?}");
            for (share, wanted) in found.iter().zip(&target) {
                assert!(*wanted > 0.0 || *share < 1e-8, "{target:?}: {found:?}");
            }
        }
        assert!(least_shares(3, |_| f64::INFINITY).is_none());
        assert_eq!(least_shares(1, |_| 2.0), Some((vec![1.0], 2.0)));
    }
}
