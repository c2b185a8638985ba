//! Time stamps and the sample time they imply.

use std::path::Path;

use gtfdi::ident::Missing;

use crate::{LogError, Place, TimeGap};

/// The time of sample 0 of every simulated log, 2006-01-18T00:00:00Z, in nanoseconds since 1970.
pub const EPOCH_NS: u64 = 1_137_542_400_000_000_000;

/// How far a step in time may lie from the median step, relative to it.
pub const UNIFORM_TOLERANCE: f64 = 1e-3;

/// The time of sample `k` of a simulated log in nanoseconds since 1970: [`EPOCH_NS`] and `k` whole
/// periods. A period that is a whole number of nanoseconds (0.08 s) is multiplied as an integer;
/// any other (1/3 s) is rounded once, after the multiplication.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast saturates, and a negative or NaN period has no better answer than 0"
)]
pub fn sample_time_ns(k: usize, sample_time_s: f64) -> u64 {
    let period_ns = sample_time_s * 1e9;
    let whole_ns = period_ns.round();
    // The product above is off by one rounding at most.
    let elapsed_ns = if (period_ns - whole_ns).abs() <= period_ns.abs() * f64::EPSILON {
        (whole_ns as u64).saturating_mul(k as u64)
    } else {
        (k as f64 * period_ns).round() as u64
    };
    EPOCH_NS.saturating_add(elapsed_ns)
}

/// The times of a record's rows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Clock {
    /// Seconds since an unknown instant.
    Seconds(Vec<f64>),
    /// Nanoseconds since 1970.
    Nanoseconds(Vec<i128>),
}

impl Clock {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Seconds(times) => times.len(),
            Self::Nanoseconds(times) => times.len(),
        }
    }

    /// Refuses times that go backwards; they may stand still.
    pub(crate) fn check_order(
        &self,
        path: &Path,
        place: impl Fn(usize) -> Place,
    ) -> Result<(), LogError> {
        match (1..self.len()).find(|&k| self.between_s(k - 1, k) < 0.0) {
            None => Ok(()),
            Some(k) => Err(LogError::TimeNotIncreasing {
                path: path.to_owned(),
                place: place(k),
                previous_s: self.shown_s(k - 1),
                found_s: self.shown_s(k),
            }),
        }
    }

    /// The earliest time of several clocks of one kind, as a clock of one time.
    pub(crate) fn earliest<'a>(clocks: impl Iterator<Item = &'a Self>) -> Option<Self> {
        clocks.fold(None, |earliest, clock| match (earliest, clock) {
            (None, Self::Seconds(times)) => {
                let first = times.iter().copied().reduce(f64::min)?;
                Some(Self::Seconds(vec![first]))
            }
            (None, Self::Nanoseconds(times)) => {
                let first = times.iter().copied().min()?;
                Some(Self::Nanoseconds(vec![first]))
            }
            (Some(Self::Seconds(first)), Self::Seconds(times)) => {
                let first = first.iter().chain(times).copied().reduce(f64::min)?;
                Some(Self::Seconds(vec![first]))
            }
            (Some(Self::Nanoseconds(first)), Self::Nanoseconds(times)) => {
                let first = first.iter().chain(times).copied().min()?;
                Some(Self::Nanoseconds(vec![first]))
            }
            (earliest, _) => earliest,
        })
    }

    /// All times in seconds since the first time of another clock of the same kind.
    pub(crate) fn since(&self, origin: &Self) -> Vec<f64> {
        match (self, origin) {
            (Self::Seconds(times), Self::Seconds(origin)) => {
                let origin = origin.first().copied().unwrap_or(0.0);
                times.iter().map(|time| time - origin).collect()
            }
            (Self::Nanoseconds(times), Self::Nanoseconds(origin)) => {
                let origin = origin.first().copied().unwrap_or(0);
                times
                    .iter()
                    .map(|time| (time - origin) as f64 / 1e9)
                    .collect()
            }
            _ => Vec::new(),
        }
    }

    /// Seconds from row `a` to row `b`.
    fn between_s(&self, a: usize, b: usize) -> f64 {
        match self {
            Self::Seconds(times) => times[b] - times[a],
            // Exact below 2^53 ns (104 days), and then to 1 in 2^53.
            Self::Nanoseconds(times) => (times[b] - times[a]) as f64 / 1e9,
        }
    }

    /// The time of row `k`: as it stands for seconds, since row 0 otherwise.
    fn shown_s(&self, k: usize) -> f64 {
        match self {
            Self::Seconds(times) => times[k],
            Self::Nanoseconds(_) => self.between_s(0, k),
        }
    }

    /// The sample time of strictly increasing, uniform times, and the gaps in them.
    ///
    /// Uniform means: every step within [`UNIFORM_TOLERANCE`] of the median step, or longer with
    /// [`Missing::Break`]: a gap. The result is the mean of the other steps to 12 significant digits,
    /// which takes away what adding 0.08 a thousand times put into the last ones.
    pub(crate) fn uniform(
        &self,
        path: &Path,
        missing: Missing,
        place: impl Fn(usize) -> Place,
    ) -> Result<Uniform, LogError> {
        let count = self.len();
        if count < 2 {
            return Err(LogError::TooFewTimes {
                path: path.to_owned(),
                found: count,
            });
        }
        let steps: Vec<f64> = (1..count).map(|k| self.between_s(k - 1, k)).collect();
        if let Some(k) = steps.iter().position(|&step| step <= 0.0) {
            return Err(LogError::TimeNotIncreasing {
                path: path.to_owned(),
                place: place(k + 1),
                previous_s: self.shown_s(k),
                found_s: self.shown_s(k + 1),
            });
        }
        let mut sorted = steps.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let median_s = sorted[sorted.len() / 2];
        let limit_s = UNIFORM_TOLERANCE * median_s;
        let mut gaps = Vec::new();
        let mut in_gaps_s = 0.0;
        for (k, &step) in steps.iter().enumerate() {
            if (step - median_s).abs() <= limit_s {
                continue;
            }
            if missing == Missing::Refuse || step < median_s {
                return Err(LogError::TimeNotUniform {
                    path: path.to_owned(),
                    place: place(k + 1),
                    expected_s: median_s,
                    found_s: step,
                    tolerance: UNIFORM_TOLERANCE,
                });
            }
            in_gaps_s += step;
            gaps.push(TimeGap {
                sample: k + 1,
                since_first_s: self.between_s(0, k + 1),
            });
        }
        // The median step is no gap, so that there is at least one other.
        let regular = (count - 1 - gaps.len()) as f64;
        let mean_s = (self.between_s(0, count - 1) - in_gaps_s) / regular;
        Ok(Uniform {
            sample_time_s: format!("{mean_s:.11e}").parse().unwrap_or(mean_s),
            gaps,
        })
    }
}

/// What times say of the sampling.
#[derive(Debug, PartialEq)]
pub(crate) struct Uniform {
    pub sample_time_s: f64,
    pub gaps: Vec<TimeGap>,
}

impl Uniform {
    /// A sample time that makes the times of no interest.
    pub(crate) fn given(sample_time_s: f64) -> Self {
        Self {
            sample_time_s,
            gaps: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn epoch_is_the_day_it_says() {
        let instant: jiff::Timestamp = "2006-01-18T00:00:00Z".parse().unwrap();
        assert_eq!(instant.as_nanosecond(), i128::from(EPOCH_NS));
    }

    #[test]
    fn samples_of_eighty_milliseconds_are_exact() {
        for k in [0, 1, 3, 12_345, 10_000_000] {
            assert_eq!(sample_time_ns(k, 0.08), EPOCH_NS + 80_000_000 * k as u64);
        }
    }

    #[test]
    fn other_periods_are_rounded_once() {
        assert_eq!(sample_time_ns(3, 1.0 / 3.0), EPOCH_NS + 1_000_000_000);
        assert_eq!(sample_time_ns(1, 1.0 / 3.0), EPOCH_NS + 333_333_333);
        assert_eq!(sample_time_ns(2, f64::NAN), EPOCH_NS);
        assert_eq!(sample_time_ns(2, -1.0), EPOCH_NS);
        assert_eq!(sample_time_ns(2, f64::INFINITY), u64::MAX);
    }

    #[test]
    fn summed_steps_give_the_period_itself() {
        let mut time_s = 0.0;
        let times = std::iter::repeat_with(|| {
            time_s += 0.08;
            time_s
        });
        let clock = Clock::Seconds(times.take(5000).collect());
        let found = clock
            .uniform(Path::new("x"), Missing::Refuse, Place::Message)
            .unwrap();
        assert_eq!(found.sample_time_s.to_bits(), 0.08_f64.to_bits());
    }

    #[test]
    fn the_tolerance_is_a_thousandth_of_the_period() {
        let with_step = |step: f64| Clock::Seconds(vec![0.0, 1.0, 2.0, 3.0, 3.0 + step]);
        let path = Path::new("x");
        let uniform = |step, missing| with_step(step).uniform(path, missing, Place::Message);
        assert!(uniform(1.0009, Missing::Refuse).is_ok());
        assert!(matches!(
            uniform(1.0011, Missing::Refuse),
            Err(LogError::TimeNotUniform {
                place: Place::Message(4),
                expected_s: 1.0,
                ..
            })
        ));
        // A longer step may be a gap, a shorter one never.
        let gap = TimeGap {
            sample: 4,
            since_first_s: 6.5,
        };
        let expected = Uniform {
            sample_time_s: 1.0,
            gaps: vec![gap],
        };
        assert_eq!(uniform(3.5, Missing::Break).unwrap(), expected);
        assert!(uniform(0.5, Missing::Break).is_err());
    }
}
