//! Counted alarms on healthy records and what they say about their rate.

use serde::{Deserialize, Serialize};

use crate::FdiError;
use crate::runtime::{ExceedanceRun, Persistence};

/// Probability left out on each side of the interval: 95 % in all.
const TAIL: f64 = 0.025;
/// Beyond this count, `ln k!` by Stirling's series is exact to rounding.
const STIRLING_FROM: usize = 256;

/// Alarms counted on healthy running and the rate they support.
///
/// Deserialisation checks that the rate and its interval follow from the counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct FalseAlarmRate {
    /// Alarm events.
    pub alarms: usize,
    /// Hours of healthy running that were judged.
    pub hours: f64,
    /// `alarms / hours`.
    pub per_hour: f64,
    /// Lower end of the exact 95 % Poisson interval of the rate (Garwood, *Biometrika* 28, 1936).
    pub per_hour_low: f64,
    /// Upper end of the exact 95 % Poisson interval of the rate.
    pub per_hour_high: f64,
}

/// The fields of a [`FalseAlarmRate`] as they come from a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    alarms: usize,
    hours: f64,
    per_hour: f64,
    per_hour_low: f64,
    per_hour_high: f64,
}

impl TryFrom<Unchecked> for FalseAlarmRate {
    type Error = FdiError;

    fn try_from(raw: Unchecked) -> Result<Self, FdiError> {
        let rate = Self::from_counts(raw.alarms, raw.hours)?;
        let pairs = [
            ("per_hour", rate.per_hour, raw.per_hour),
            ("per_hour_low", rate.per_hour_low, raw.per_hour_low),
            ("per_hour_high", rate.per_hour_high, raw.per_hour_high),
        ];
        for (what, expected, found) in pairs {
            // Another machine's logarithms may differ in the last digits.
            if (expected - found).abs() > 1e-9 * expected || found.is_nan() {
                return Err(FdiError::FalseAlarms {
                    what,
                    expected,
                    found,
                });
            }
        }
        Ok(rate)
    }
}

impl FalseAlarmRate {
    /// The rate and its exact interval: the upper end is the rate at which `alarms` or fewer would
    /// be counted with probability 2.5 %, the lower end that at which `alarms` or more would.
    ///
    /// # Errors
    /// [`FdiError::Option`] unless `hours` is positive and finite.
    pub fn from_counts(alarms: usize, hours: f64) -> Result<Self, FdiError> {
        if !(hours.is_finite() && hours > 0.0) {
            let expected = "a positive finite number of hours";
            return Err(FdiError::Option {
                option: "hours",
                expected,
                found: hours,
            });
        }
        let count = alarms as f64;
        let width = 10.0 * (count + 1.0).sqrt();
        let high = bisect(count, count + width, |mean| at_most(alarms, mean) > TAIL);
        let low = if alarms == 0 {
            0.0
        } else {
            bisect((count - width).max(0.0), count, |mean| {
                at_least(alarms, mean) < TAIL
            })
        };
        Ok(Self {
            alarms,
            hours,
            per_hour: count / hours,
            per_hour_low: low / hours,
            per_hour_high: high / hours,
        })
    }
}

/// Alarm events in a series: runs of samples with a modulus above `limit`, as long as `wait` asks
/// for; they last until as many samples in a row are within the limit.
pub fn count_alarms(series: &[f64], limit: f64, wait: Persistence) -> usize {
    let mut run = ExceedanceRun::default();
    series
        .iter()
        .filter(|value| run.update(0.0, value.abs(), limit, wait))
        .count()
}

/// The mean in `low..high` up to which `below` holds, to the last bit.
fn bisect(mut low: f64, mut high: f64, below: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            return middle;
        }
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// `P(X <= count)` for a Poisson `mean` not below `count`: the terms fall from `count` downwards.
fn at_most(count: usize, mean: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for k in (1..=count).rev() {
        term *= k as f64 / mean;
        sum += term;
        if term < f64::EPSILON * sum {
            break;
        }
    }
    probability(count, mean) * sum
}

/// `P(X >= count)` for a Poisson `mean` not above `count`: the terms fall from `count` upwards.
fn at_least(count: usize, mean: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, count as f64);
    while term >= f64::EPSILON * sum {
        k += 1.0;
        term *= mean / k;
        sum += term;
    }
    probability(count, mean) * sum
}

/// `P(X = count)` for a Poisson `mean`.
fn probability(count: usize, mean: f64) -> f64 {
    if count == 0 {
        return (-mean).exp();
    }
    (count as f64 * mean.ln() - mean - ln_factorial(count)).exp()
}

fn ln_factorial(count: usize) -> f64 {
    if count < STIRLING_FROM {
        return (2..=count).map(|k| (k as f64).ln()).sum();
    }
    let k = count as f64;
    let correction = 1.0 / (12.0 * k) - 1.0 / (360.0 * k.powi(3));
    (k + 0.5) * k.ln() - k + 0.5 * std::f64::consts::TAU.ln() + correction
}
