//! How sure counts are.

use std::fmt;

use serde::Serialize;

/// The normal deviate with 2.5 % above it.
const DEVIATE: f64 = 1.959_963_984_540_054;

/// A proportion with its 95 % interval after Wilson (*Journal of the American Statistical
/// Association* 22, 1927), which keeps within 0 and 1 and says something of no and of all counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Proportion {
    /// How many.
    pub count: u64,
    /// Of how many.
    pub of: u64,
    /// `count / of`; `None` of none.
    pub share: Option<f64>,
    /// Lower end of the interval; 0 of none.
    pub low: f64,
    /// Upper end of the interval; 1 of none.
    pub high: f64,
}

impl Proportion {
    /// `count` of `of`.
    pub fn new(count: u64, of: u64) -> Self {
        if of == 0 {
            return Self {
                count,
                of,
                share: None,
                low: 0.0,
                high: 1.0,
            };
        }
        let n = of as f64;
        let share = count as f64 / n;
        let square = DEVIATE * DEVIATE / n;
        let middle = share + 0.5 * square;
        let half = DEVIATE * (share * (1.0 - share) / n + 0.25 * square / n).sqrt();
        Self {
            count,
            of,
            share: Some(share),
            // At both ends the interval ends there; rounding would miss it.
            low: if count == 0 {
                0.0
            } else {
                (middle - half) / (1.0 + square)
            },
            high: if count == of {
                1.0
            } else {
                (middle + half) / (1.0 + square)
            },
        }
    }

    /// The proportion of `values` that hold.
    pub fn of(values: impl Iterator<Item = bool>) -> Self {
        let (mut count, mut of) = (0, 0);
        for value in values {
            of += 1;
            count += u64::from(value);
        }
        Self::new(count, of)
    }
}

/// A quantile with its 95 % interval, which assumes no distribution: the order statistics whose
/// ranks are the normal approximation of the binomial's. What lies among runs without a value is
/// `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quantile {
    /// The share below it.
    pub share: f64,
    /// The value.
    pub value: Option<f64>,
    /// Lower end of the interval.
    pub low: Option<f64>,
    /// Upper end of the interval.
    pub high: Option<f64>,
}

impl Quantile {
    /// The quantile of `of` values of which the smallest are `sorted`, in order.
    pub fn new(share: f64, sorted: &[f64], of: usize) -> Self {
        let n = of as f64;
        let spread = DEVIATE * (n * share * (1.0 - share)).sqrt();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a rank"
        )]
        let at = |rank: f64| {
            let rank = rank.ceil().max(1.0) as usize;
            (rank <= of)
                .then(|| sorted.get(rank - 1).copied())
                .flatten()
        };
        Self {
            share,
            value: at(n * share),
            low: at((n * share - spread).floor()),
            high: at((n * share + spread).floor() + 1.0),
        }
    }
}

/// In percent with the interval, `93.1 (90.0 .. 95.2)`; a dash of none.
impl fmt::Display for Proportion {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(share) = self.share else {
            return formatter.pad("-");
        };
        let [share, low, high] = [share, self.low, self.high].map(|share| 100.0 * share);
        formatter.pad(&format!("{share:.1} ({low:.1} .. {high:.1})"))
    }
}

/// With its interval, `12.3 (11.0 .. 14.2)`, and dashes for what is not there.
impl fmt::Display for Quantile {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.1}"));
        let [value, low, high] = [self.value, self.low, self.high].map(text);
        formatter.pad(&format!("{value} ({low} .. {high})"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newcombe, *Statistics in Medicine* 17 (1998), table I: Wilson's interval without continuity
    /// correction.
    #[test]
    fn published_wilson_intervals() {
        for (count, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let found = Proportion::new(count, of);
            // Four decimals are printed.
            assert!((found.low - low).abs() < 5e-5, "{found:?}");
            assert!((found.high - high).abs() < 5e-5, "{found:?}");
        }
        let none = Proportion::new(0, 0);
        assert_eq!((none.share, none.low, none.high), (None, 0.0, 1.0));
        assert!(Proportion::new(20, 20).high >= 1.0);
        assert_eq!(none.to_string(), "-");
        assert_eq!(Proportion::new(81, 263).to_string(), "30.8 (25.5 .. 36.6)");
    }

    #[test]
    fn a_quantile_among_runs_without_a_value_is_none() {
        let sorted: Vec<f64> = (1..=60).map(f64::from).collect();
        let median = Quantile::new(0.5, &sorted, 100);
        // Ranks 50 +- 9.8.
        assert_eq!(
            (median.value, median.low, median.high),
            (Some(50.0), Some(40.0), Some(60.0))
        );
        let ninth = Quantile::new(0.9, &sorted, 100);
        assert_eq!((ninth.value, ninth.low, ninth.high), (None, None, None));
        assert_eq!(Quantile::new(0.5, &[], 0).value, None);
        assert_eq!(median.to_string(), "50.0 (40.0 .. 60.0)");
        assert_eq!(ninth.to_string(), "- (- .. -)");
    }
}
