//! The times of samples that come without one.

use serde::{Deserialize, Serialize};

/// Time of the first sample since the time was last given, and the samples since then.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SampleClock {
    since: Option<(f64, usize)>,
}

impl SampleClock {
    /// A clock whose last sample was at `time_s`, if there was one. Where that is a whole number of
    /// sample times, it goes on counting from 0: the same times, bit for bit, as one that did.
    pub fn at(time_s: Option<f64>, sample_time_s: f64) -> Self {
        let since = time_s.map(|time_s| {
            let count = (time_s / sample_time_s).round();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates"
            )]
            let whole = count as usize;
            if (whole as f64 * sample_time_s).to_bits() == time_s.to_bits() {
                (0.0, whole)
            } else {
                (time_s, 0)
            }
        });
        Self { since }
    }

    /// The clock at the next sample: as given, or a sample time after the one before, or 0.
    pub fn next(self, given_s: Option<f64>) -> Self {
        let since = match (given_s, self.since) {
            (Some(t_s), _) => (t_s, 0),
            (None, Some((start_s, count))) => (start_s, count + 1),
            (None, None) => (0.0, 0),
        };
        Self { since: Some(since) }
    }

    /// The time of the last sample in seconds.
    pub fn time_s(self, sample_time_s: f64) -> f64 {
        let (start_s, count) = self.since.unwrap_or((0.0, 0));
        start_s + count as f64 * sample_time_s
    }
}
