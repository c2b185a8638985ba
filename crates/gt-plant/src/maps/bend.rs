//! A bend that keeps continued values in a range.

/// Least room of an efficiency to bend in; twice that is the most by which it passes 1.
const LEAST_ROOM: f64 = 0.005;

/// The identity between two values that bends, with continuous slope, towards a limit beyond each.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bend {
    /// Below this value the curve bends, and how far the limit lies below it.
    lower: [f64; 2],
    /// Above this value the curve bends, and how far the limit lies above it.
    upper: [f64; 2],
}

impl Bend {
    /// For flows: straight from half the smallest to twice the largest, limited at half and twice
    /// that.
    pub(super) fn flow([smallest, largest]: [f64; 2]) -> Self {
        Self {
            upper: [2.0 * largest, 2.0 * largest],
            ..Self::positive(smallest)
        }
    }

    /// For efficiencies: limited at a quarter of the smallest and at 1, or a little above where the
    /// largest leaves no room to bend in.
    pub(super) fn efficiency([smallest, largest]: [f64; 2]) -> Self {
        let room = (0.5 * (1.0 - largest)).max(LEAST_ROOM);
        Self {
            upper: [largest + room, room],
            ..Self::positive(smallest)
        }
    }

    /// For anything above zero: straight down to half the smallest, limited at a quarter.
    pub(super) fn positive(smallest: f64) -> Self {
        Self {
            lower: [0.5 * smallest, 0.25 * smallest],
            upper: [f64::INFINITY, 0.0],
        }
    }

    /// The bent value and the slope of the bend.
    #[inline]
    pub(super) fn apply(&self, value: f64) -> [f64; 2] {
        // Written so that no infinite excess gives a NaN.
        let [start, room] = self.lower;
        if value < start {
            let excess = start - value;
            return [start - room / (1.0 + room / excess), slope(excess / room)];
        }
        let [start, room] = self.upper;
        if value > start {
            let excess = value - start;
            return [start + room / (1.0 + room / excess), slope(excess / room)];
        }
        [value, 1.0]
    }
}

fn slope(excess: f64) -> f64 {
    let root = 1.0 / (1.0 + excess);
    root * root
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn prop_stays_within_its_limits_and_rises(
            smallest in 0.1..0.6f64,
            span in 0.0..0.9f64,
            value in -20.0..20.0f64,
        ) {
            let largest = smallest + span * (1.0 - smallest);
            for (bend, high) in [
                (Bend::flow([smallest, largest]), 4.0 * largest),
                (Bend::efficiency([smallest, largest]), 1.0),
            ] {
                let [bent, slope] = bend.apply(value);
                prop_assert!((0.25 * smallest..=high).contains(&bent));
                prop_assert!((0.0..=1.0).contains(&slope));
                // The second derivative is at most 2 / room, and the room here at least 0.02.
                let [next, _] = bend.apply(value + 1e-6);
                prop_assert!((next - bent - slope * 1e-6).abs() < 1e-10);
                if (smallest..=largest).contains(&value) {
                    prop_assert_eq!([bent, slope], [value, 1.0]);
                }
            }
        }
    }

    #[test]
    fn infinities_are_no_nan() {
        let full = Bend::efficiency([0.8, 1.0]);
        let [most, slope] = full.apply(f64::INFINITY);
        assert!((most - 1.01).abs() < 1e-15 && slope == 0.0);
        assert_eq!(full.apply(f64::NEG_INFINITY), [0.2, 0.0]);
        assert_eq!(Bend::flow([1.0, 2.0]).apply(f64::INFINITY), [8.0, 0.0]);
        assert!(full.apply(f64::NAN)[0].is_nan());
    }
}
