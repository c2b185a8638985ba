//! How good samples are, and the topic that says so.

use gt_core::{Dataset, Signal};
use serde::{Deserialize, Serialize};

use crate::writer::QualityTopicId;
use crate::{LogError, LogWriter};

/// The topic of the qualities of a plant's samples.
const TOPIC: &str = "/plant/quality";
/// Qualities are repeated this often, so that a reader who starts in the middle finds them.
const PERIOD_S: f64 = 60.0;

/// How good a sample is, as control systems grade them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quality {
    /// As the sensor gave it.
    Good,
    /// Its sensor doubts it.
    Uncertain,
    /// Not valid, or none came.
    Bad,
    /// An older reading.
    Stale,
    /// Made of readings around it.
    Interpolated,
}

impl Quality {
    /// The names in logs, in the order of their numbers.
    pub const NAMES: &[&str] = &["GOOD", "UNCERTAIN", "BAD", "STALE", "INTERPOLATED"];

    /// The number in logs.
    pub fn number(self) -> i32 {
        match self {
            Self::Good => 0,
            Self::Uncertain => 1,
            Self::Bad => 2,
            Self::Stale => 3,
            Self::Interpolated => 4,
        }
    }

    /// The name in logs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "GOOD",
            Self::Uncertain => "UNCERTAIN",
            Self::Bad => "BAD",
            Self::Stale => "STALE",
            Self::Interpolated => "INTERPOLATED",
        }
    }

    /// Whether there is a value that can be used.
    pub fn is_usable(self) -> bool {
        matches!(self, Self::Good | Self::Uncertain | Self::Interpolated)
    }

    /// That of a value of which nothing else is known.
    fn of(value: f64) -> Self {
        if value.is_finite() {
            Self::Good
        } else {
            Self::Bad
        }
    }
}

/// Writes the qualities of a record's samples where they change, and once a minute.
pub(crate) struct QualityLog<'a> {
    /// What is known of the samples of each channel beside their values.
    known: &'a [Vec<Quality>],
    topic: QualityTopicId,
    last: Vec<Quality>,
    repeat: usize,
}

impl<'a> QualityLog<'a> {
    /// Adds the topic `/plant/quality` with a field for every input and output of `data`.
    pub(crate) fn new(
        log: &mut LogWriter,
        data: &Dataset,
        asset: &str,
        known: &'a [Vec<Quality>],
    ) -> Result<Self, LogError> {
        let signals = data.inputs().iter().chain(data.outputs());
        let signals: Vec<Signal> = signals
            .map(|own| Signal::new(own.name.as_str(), ""))
            .collect();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
        let repeat = ((PERIOD_S / data.sample_time_s()) as usize).max(1);
        Ok(Self {
            known,
            topic: log.add_quality_topic(TOPIC, &signals, data.sample_time_s(), asset)?,
            last: Vec::new(),
            repeat,
        })
    }

    /// Writes the qualities of sample `k`, if it is time.
    pub(crate) fn write(
        &mut self,
        log: &mut LogWriter,
        data: &Dataset,
        k: usize,
        time_ns: u64,
    ) -> Result<(), LogError> {
        let (inputs, outputs) = (data.u().column(k), data.y().column(k));
        let values = inputs.iter().chain(outputs.iter());
        let known = |channel: usize| self.known.get(channel).and_then(|own| own.get(k)).copied();
        let own = values.enumerate().map(|(channel, value)| {
            let of_value = Quality::of(*value);
            let known = known(channel).filter(|_| of_value == Quality::Good);
            known.unwrap_or(of_value)
        });
        let own: Vec<Quality> = own.collect();
        if own == self.last && !k.is_multiple_of(self.repeat) {
            return Ok(());
        }
        self.last = own;
        log.write_quality(self.topic, time_ns, &self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::Quality;

    #[test]
    fn names_and_numbers_belong_together() {
        let all = [
            Quality::Good,
            Quality::Uncertain,
            Quality::Bad,
            Quality::Stale,
            Quality::Interpolated,
        ];
        for (number, (quality, name)) in all.iter().zip(Quality::NAMES).enumerate() {
            assert_eq!(usize::try_from(quality.number()), Ok(number));
            assert_eq!(quality.name(), *name);
        }
    }
}
