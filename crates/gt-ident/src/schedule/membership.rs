//! How much each point takes part.

/// Points on the axis of the scheduling channel with the width of the hand-over between them.
#[derive(Debug, Clone)]
pub(crate) struct Memberships {
    values: Vec<f64>,
    width: f64,
}

/// The points that take part: `(point, weight)`; the weights sum to 1, and the second is 0 where
/// one point stands alone.
pub(crate) type Pair = [(usize, f64); 2];

impl Memberships {
    /// `values` ascend and are not empty, `width` lies in 0..=1.
    pub fn new(values: Vec<f64>, width: f64) -> Self {
        Self { values, width }
    }

    /// The points at `value`; beyond the ends the last one stands alone.
    pub fn at(&self, value: f64) -> Pair {
        let last = self.values.len() - 1;
        let above = self.values.partition_point(|&point| point <= value);
        if above == 0 {
            return [(0, 1.0), (last.min(1), 0.0)];
        }
        if above > last {
            return [(last, 1.0), (last.saturating_sub(1), 0.0)];
        }
        let (low, high) = (self.values[above - 1], self.values[above]);
        // Half of each first: the difference of two huge numbers would overflow.
        let part = (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low);
        let upper = if self.width > 0.0 {
            (0.5 + (part - 0.5) / self.width).clamp(0.0, 1.0)
        } else {
            f64::from(u8::from(part >= 0.5))
        };
        [(above - 1, 1.0 - upper), (above, upper)]
    }

    /// The weight of one point at `value`.
    pub fn of(&self, point: usize, value: f64) -> f64 {
        let pair = self.at(value);
        let own = pair.iter().filter(|(index, _)| *index == point);
        own.map(|(_, weight)| weight).sum()
    }
}
