//! Rising nodes, the interval in which a coordinate lies and the cubic Hermite weights in it.

/// Farthest coordinate that is told apart; keeps products of two coordinates finite.
pub(super) const FARTHEST: f64 = 1e6;
/// Buckets of the search for each interval: nearly every one then lies in one interval.
const BUCKETS: usize = 4;

/// At least two rising nodes.
#[derive(Debug)]
pub(super) struct Axis {
    nodes: Vec<f64>,
    /// Inverse steps, rounded up.
    inverse: Vec<f64>,
    /// The interval in which each of as many equal parts of the range begins.
    buckets: Vec<usize>,
    buckets_per_unit: f64,
}

impl Axis {
    pub(super) fn new(nodes: Vec<f64>) -> Self {
        let [first, last] = ends(&nodes);
        let count = BUCKETS * (nodes.len() - 1);
        let width = (last - first) / count as f64;
        let inner = &nodes[1..nodes.len() - 1];
        let buckets = (0..count)
            .map(|bucket| {
                let start = first + width * bucket as f64;
                inner.partition_point(|node| *node <= start)
            })
            .collect();
        let steps = nodes.windows(2).map(|pair| pair[1] - pair[0]);
        Self {
            inverse: steps
                .map(|h| (1.0 / h) * (1.0 + 2.0 * f64::EPSILON))
                .collect(),
            nodes,
            buckets,
            buckets_per_unit: 1.0 / width,
        }
    }

    pub(super) fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// First and last node.
    pub(super) fn range(&self) -> [f64; 2] {
        ends(&self.nodes)
    }

    /// The interval, its left node at or below `coordinate`, which lies within the nodes.
    #[inline]
    fn interval(&self, coordinate: f64) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a NaN or what rounds below zero is the first bucket"
        )]
        let bucket = ((coordinate - self.nodes[0]) * self.buckets_per_unit) as usize;
        let mut interval = self.buckets[bucket.min(self.buckets.len() - 1)];
        while interval > 0 && coordinate < self.nodes[interval] {
            interval -= 1;
        }
        while interval + 2 < self.nodes.len() && self.nodes[interval + 1] <= coordinate {
            interval += 1;
        }
        interval
    }

    /// The interval in which `coordinate` lies, or the nearest.
    #[inline]
    pub(super) fn find(&self, coordinate: f64) -> Cell {
        let [first, last] = self.range();
        let held = coordinate.clamp(first, last);
        let index = self.interval(held);
        let left = self.nodes[index];
        let h = self.nodes[index + 1] - left;
        // The inverse is rounded up so that the last node is met exactly.
        let t = ((held - left) * self.inverse[index]).min(1.0);
        let u = 1.0 - t;
        let rise = t * t * (3.0 - 2.0 * t);
        let steep = 6.0 * t * u * self.inverse[index];
        Cell {
            index,
            value: [1.0 - rise, h * t * u * u, rise, -h * t * t * u],
            slope: [-steep, u * (1.0 - 3.0 * t), steep, t * (3.0 * t - 2.0)],
            beyond: coordinate.clamp(-FARTHEST, FARTHEST) - held,
        }
    }
}

fn ends(nodes: &[f64]) -> [f64; 2] {
    [nodes[0], nodes[nodes.len() - 1]]
}

/// Where a coordinate lies among nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// The left node of the interval.
    pub(super) index: usize,
    /// Weights of `[value, slope]` at the left and `[value, slope]` at the right node.
    value: [f64; 4],
    /// The same for the derivative.
    slope: [f64; 4],
    /// How far the coordinate lies outside all nodes; the weights are those of the last node.
    pub(super) beyond: f64,
}

impl Cell {
    /// The interpolants through several quantities at once and their derivatives; at the nearest
    /// node where the coordinate lies outside. Each end is `[values, slopes]`.
    #[inline]
    pub(super) fn blend<const N: usize>(
        &self,
        left: &[[f64; N]; 2],
        right: &[[f64; N]; 2],
    ) -> [[f64; N]; 2] {
        [
            weigh(&self.value, left, right),
            weigh(&self.slope, left, right),
        ]
    }
}

#[inline]
fn weigh<const N: usize>(
    weights: &[f64; 4],
    left: &[[f64; N]; 2],
    right: &[[f64; N]; 2],
) -> [f64; N] {
    let mut sum = [0.0; N];
    for (i, sum) in sum.iter_mut().enumerate() {
        *sum = (weights[0] * left[0][i] + weights[1] * left[1][i])
            + (weights[2] * right[0][i] + weights[3] * right[1][i]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Also where the nodes crowd in a few buckets, where they are the edges of buckets, and
        /// next to either.
        #[test]
        fn prop_interval_is_that_of_a_binary_search(
            steps in prop_oneof![
                proptest::collection::vec(prop_oneof![1e-8..1e-7f64, 0.1..1.0f64], 1..20),
                (1..20usize, 0.01..0.1f64).prop_map(|(count, step)| vec![step; count]),
            ],
            share in 0.0..1.0f64,
        ) {
            let mut nodes = vec![0.3];
            for (i, step) in steps.iter().enumerate() {
                nodes.push(nodes[i] + step);
            }
            let axis = Axis::new(nodes.clone());
            let [first, last] = axis.range();
            let edges = (0..axis.buckets.len()).map(|i| first + i as f64 / axis.buckets_per_unit);
            let mut points: Vec<f64> = nodes.iter().copied().chain(edges).collect();
            points.push(first + share * (last - first));
            for point in points {
                for point in [point.next_down(), point, point.next_up()] {
                    let held = point.clamp(first, last);
                    let inner = &nodes[1..nodes.len() - 1];
                    let expected = inner.partition_point(|node| *node <= held);
                    prop_assert_eq!(axis.interval(held), expected);
                }
            }
        }
    }
}
