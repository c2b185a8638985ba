//! Readings at their own times into samples at one period.

use serde::{Deserialize, Serialize};

use super::ReadingError;
use crate::quality::Quality;

/// The most samples of a record that is made by resampling.
const MOST_SAMPLES: f64 = 5e7;
/// How far a time may lie beside a sample of the record and still be at it, in periods.
const AT: f64 = 1e-6;

/// How readings become samples of one period. Nothing is ever extrapolated: a sample without a
/// reading that may stand for it is missing (NaN).
///
/// The first sample is at the first reading of any tag. Every sample is at the start of its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Resample {
    /// The period in seconds.
    pub step_s: f64,
    /// What stands for a sample.
    pub method: ResampleMethod,
    /// The oldest reading that may be held, or the longest step that may be bridged, in seconds; for
    /// [`ResampleMethod::Hold`] and [`ResampleMethod::Linear`].
    pub hold_at_most_s: Option<f64>,
}

/// What stands for a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ResampleMethod {
    /// The mean of the readings from the sample's time to before the next one's.
    #[default]
    Mean,
    /// The last valid reading at or before the sample's time.
    Hold,
    /// The line between the valid readings around the sample's time.
    Linear,
}

/// What resampling made of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Resampled {
    /// What was asked for.
    #[serde(flatten)]
    pub resample: Resample,
    /// The samples of the whole file.
    pub samples: usize,
    /// What the samples of each tag are.
    pub tags: Vec<ResampledTag>,
}

/// Where the samples of a tag come from; the counts but for `averaged_from` add up to all samples.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ResampledTag {
    /// The tag.
    pub name: String,
    /// Samples that are a reading as it stands.
    pub original: usize,
    /// Samples that are the mean of several readings.
    pub averaged: usize,
    /// The readings in those.
    pub averaged_from: usize,
    /// Samples that are an earlier reading.
    pub held: usize,
    /// Samples between two readings.
    pub interpolated: usize,
    /// Samples that are missing.
    pub missing: usize,
}

impl ResampledTag {
    /// The counts in words.
    pub(super) fn text(&self) -> String {
        let parts = [
            (self.original, "as they stand".to_owned()),
            (
                self.averaged,
                format!("averaged from {}", self.averaged_from),
            ),
            (self.held, "held".to_owned()),
            (self.interpolated, "interpolated".to_owned()),
            (self.missing, "missing".to_owned()),
        ];
        let parts = parts.into_iter().filter(|(count, _)| *count > 0);
        let parts: Vec<String> = parts.map(|(n, text)| format!("{n} {text}")).collect();
        format!("`{}`: {}", self.name, parts.join(", "))
    }
}

impl Resample {
    /// Refuses what no file could be resampled by.
    pub(super) fn check(&self) -> Result<(), ReadingError> {
        let positive = |option: &'static str, found: f64| {
            if found.is_finite() && found > 0.0 {
                return Ok(());
            }
            Err(ReadingError::NotPositive { option, found })
        };
        positive("resample", self.step_s)?;
        match (self.method, self.hold_at_most_s) {
            (ResampleMethod::Mean, Some(found)) => Err(ReadingError::HoldWithMean { found }),
            (ResampleMethod::Mean, None) => Ok(()),
            (_, None) => Err(ReadingError::HoldMissing),
            (_, Some(longest)) => positive("hold-at-most", longest),
        }
    }

    /// How many samples last this long.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the range is checked first"
    )]
    pub(super) fn samples(&self, duration_s: f64) -> Result<usize, ReadingError> {
        let count = (duration_s / self.step_s + AT).floor() + 1.0;
        if (1.0..=MOST_SAMPLES).contains(&count) {
            return Ok(count as usize);
        }
        Err(ReadingError::TooManySamples {
            found: count,
            most: MOST_SAMPLES,
        })
    }

    /// The samples of a tag from its readings at times that never decrease, in seconds since the
    /// first sample, each with how good it is; a reading that is NaN is none.
    pub(super) fn samples_of(
        &self,
        name: &str,
        count: usize,
        times_s: &[f64],
        values: &[f64],
    ) -> (Vec<(f64, Quality)>, ResampledTag) {
        let valid = times_s.iter().copied().zip(values.iter().copied());
        let valid: Vec<(f64, f64)> = valid.filter(|(_, value)| !value.is_nan()).collect();
        let mut report = ResampledTag {
            name: name.to_owned(),
            ..ResampledTag::default()
        };
        let samples = match self.method {
            ResampleMethod::Mean => self.means(count, &valid, &mut report),
            ResampleMethod::Hold | ResampleMethod::Linear => {
                self.between(count, &valid, &mut report)
            }
        };
        (samples, report)
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cast saturates, and what lies beyond the samples is left out"
    )]
    fn means(
        &self,
        count: usize,
        valid: &[(f64, f64)],
        report: &mut ResampledTag,
    ) -> Vec<(f64, Quality)> {
        let mut sums = vec![(0.0, 0_usize); count];
        for &(time_s, value) in valid {
            let index = (time_s / self.step_s + AT).floor() as usize;
            if let Some((sum, readings)) = sums.get_mut(index) {
                *sum += value;
                *readings += 1;
            }
        }
        let mean = |(sum, readings): (f64, usize)| {
            match readings {
                0 => report.missing += 1,
                1 => report.original += 1,
                several => {
                    report.averaged += 1;
                    report.averaged_from += several;
                }
            }
            if readings == 0 {
                (f64::NAN, Quality::Bad)
            } else {
                (sum / readings as f64, Quality::Good)
            }
        };
        sums.into_iter().map(mean).collect()
    }

    fn between(
        &self,
        count: usize,
        valid: &[(f64, f64)],
        report: &mut ResampledTag,
    ) -> Vec<(f64, Quality)> {
        let longest_s = self.hold_at_most_s.unwrap_or(0.0) + AT * self.step_s;
        let mut next = 0;
        let sample = |k: usize| {
            let time_s = k as f64 * self.step_s;
            while valid
                .get(next)
                .is_some_and(|&(t, _)| t <= time_s + AT * self.step_s)
            {
                next += 1;
            }
            let before = next.checked_sub(1).and_then(|index| valid.get(index));
            let Some(&(before_s, value)) = before else {
                report.missing += 1;
                return (f64::NAN, Quality::Bad);
            };
            let age_s = time_s - before_s;
            if age_s <= AT * self.step_s {
                report.original += 1;
                return (value, Quality::Good);
            }
            match (self.method, valid.get(next)) {
                (ResampleMethod::Linear, Some(&(after_s, after)))
                    if after_s - before_s <= longest_s =>
                {
                    report.interpolated += 1;
                    let share = age_s / (after_s - before_s);
                    let line = value * (1.0 - share) + after * share;
                    (line, Quality::Interpolated)
                }
                (ResampleMethod::Hold, _) if age_s <= longest_s => {
                    report.held += 1;
                    (value, Quality::Stale)
                }
                _ => {
                    report.missing += 1;
                    (f64::NAN, Quality::Bad)
                }
            }
        };
        (0..count).map(sample).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn by(method: ResampleMethod, step_s: f64, hold_at_most_s: Option<f64>) -> Resample {
        Resample {
            step_s,
            method,
            hold_at_most_s,
        }
    }

    fn run(resample: Resample, readings: &[(f64, f64)]) -> (Vec<f64>, ResampledTag) {
        let (times, values): (Vec<f64>, Vec<f64>) = readings.iter().copied().unzip();
        let count = resample.samples(times[times.len() - 1]).unwrap();
        let (samples, report) = resample.samples_of("y", count, &times, &values);
        (
            samples.into_iter().map(|(value, _)| value).collect(),
            report,
        )
    }

    fn shown(values: &[f64]) -> Vec<String> {
        values.iter().map(ToString::to_string).collect()
    }

    const READINGS: [(f64, f64); 6] = [
        (0.0, 1.0),
        (0.5, 3.0),
        (1.5, 4.0),
        (2.0, f64::NAN),
        (5.25, 10.0),
        (5.75, 12.0),
    ];

    #[test]
    fn means_are_those_of_the_interval() {
        let (values, report) = run(by(ResampleMethod::Mean, 1.0, None), &READINGS);
        assert_eq!(shown(&values), ["2", "4", "NaN", "NaN", "NaN", "11"]);
        assert_eq!(
            report.text(),
            "`y`: 1 as they stand, 2 averaged from 4, 3 missing"
        );
    }

    #[test]
    fn readings_are_held_no_longer_than_allowed() {
        let (values, report) = run(by(ResampleMethod::Hold, 1.0, Some(1.5)), &READINGS);
        assert_eq!(shown(&values), ["1", "3", "4", "4", "NaN", "NaN"]);
        assert_eq!(report.text(), "`y`: 1 as they stand, 3 held, 2 missing");
    }

    #[test]
    fn lines_bridge_no_longer_step_than_allowed() {
        let (values, report) = run(by(ResampleMethod::Linear, 1.0, Some(1.0)), &READINGS);
        assert_eq!(shown(&values), ["1", "3.5", "NaN", "NaN", "NaN", "NaN"]);
        assert_eq!(
            report.text(),
            "`y`: 1 as they stand, 1 interpolated, 4 missing"
        );
        let (values, _) = run(by(ResampleMethod::Linear, 1.0, Some(3.75)), &READINGS);
        assert_eq!(shown(&values[..5]), ["1", "3.5", "4.8", "6.4", "8"]);
        assert!((values[5] - 9.6).abs() < 1e-14);
    }

    /// A reading is good, one that is held is stale, one on a line interpolated, none bad.
    #[test]
    fn samples_say_how_good_they_are() {
        use Quality::{Bad, Good, Interpolated, Stale};
        let qualities = |method, hold_at_most_s| -> Vec<Quality> {
            let (times, values): (Vec<f64>, Vec<f64>) = READINGS.iter().copied().unzip();
            let (samples, _) = by(method, 1.0, hold_at_most_s).samples_of("y", 6, &times, &values);
            samples.into_iter().map(|(_, quality)| quality).collect()
        };
        let mean = qualities(ResampleMethod::Mean, None);
        assert_eq!(mean, [Good, Good, Bad, Bad, Bad, Good]);
        let hold = qualities(ResampleMethod::Hold, Some(1.5));
        assert_eq!(hold, [Good, Stale, Stale, Stale, Bad, Bad]);
        let linear = qualities(ResampleMethod::Linear, Some(1.0));
        assert_eq!(linear, [Good, Interpolated, Bad, Bad, Bad, Bad]);
    }

    #[test]
    fn what_no_file_could_follow_is_refused() {
        let text = |resample: Resample| resample.check().unwrap_err().to_string();
        assert_eq!(
            text(by(ResampleMethod::Mean, 0.0, None)),
            "--resample: expected a positive, finite number of seconds, found 0"
        );
        assert_eq!(
            text(by(ResampleMethod::Hold, 1.0, Some(f64::NAN))),
            "--hold-at-most: expected a positive, finite number of seconds, found NaN"
        );
        assert_eq!(
            text(by(ResampleMethod::Linear, 1.0, None)),
            "--hold-at-most: required with --resample-method hold and linear, for example \
             --hold-at-most 60"
        );
        assert_eq!(
            text(by(ResampleMethod::Mean, 1.0, Some(2.0))),
            "--hold-at-most: expected with --resample-method hold or linear, found 2 with mean"
        );
        let error = by(ResampleMethod::Mean, 1e-9, None)
            .samples(1e6)
            .unwrap_err();
        assert_eq!(
            error.to_string(),
            "--resample: expected at most 50000000 samples, found 1000000000000001; give a longer \
             step, or look for a wrong time"
        );
    }

    proptest! {
        /// At the period of the readings every method gives the readings, and the counts add up.
        #[test]
        fn prop_resampling_at_the_own_period_changes_nothing(
            values in prop::collection::vec(
                prop_oneof![4 => -1e6..1e6_f64, 1 => Just(f64::NAN)], 1..50),
            step_s in 1e-3..1e3_f64,
        ) {
            let times: Vec<f64> = (0..values.len()).map(|k| k as f64 * step_s).collect();
            for method in [ResampleMethod::Mean, ResampleMethod::Hold, ResampleMethod::Linear] {
                let hold = (method != ResampleMethod::Mean).then_some(step_s / 2.0);
                let resample = by(method, step_s, hold);
                let count = resample.samples(times[times.len() - 1]).unwrap();
                let (found, report) = resample.samples_of("y", count, &times, &values);
                let found: Vec<f64> = found.into_iter().map(|(value, _)| value).collect();
                prop_assert_eq!(shown(&found), shown(&values));
                let valid = values.iter().filter(|value| !value.is_nan()).count();
                prop_assert_eq!(report.original, valid);
                prop_assert_eq!(report.missing, values.len() - valid);
            }
        }

        /// No sample leaves the range of the readings, and the counts are of all samples.
        #[test]
        fn prop_no_sample_is_extrapolated(
            steps in prop::collection::vec((0.0..5.0_f64, -10.0..10.0_f64), 1..40),
            step_s in 0.1..7.0_f64,
            hold_s in 0.1..9.0_f64,
        ) {
            let mut time_s = -steps[0].0;
            let readings: Vec<(f64, f64)> = steps.iter().map(|&(step, value)| {
                time_s += step;
                (time_s, value)
            }).collect();
            let least = readings.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
            let most = readings.iter().map(|r| r.1).fold(f64::NEG_INFINITY, f64::max);
            for method in [ResampleMethod::Mean, ResampleMethod::Hold, ResampleMethod::Linear] {
                let hold = (method != ResampleMethod::Mean).then_some(hold_s);
                let (values, report) = run(by(method, step_s, hold), &readings);
                let total = report.original + report.averaged + report.held
                    + report.interpolated + report.missing;
                prop_assert_eq!(total, values.len());
                let missing = values.iter().filter(|value| value.is_nan()).count();
                prop_assert_eq!(report.missing, missing);
                for value in values.into_iter().filter(|value| !value.is_nan()) {
                    prop_assert!(value >= least - 1e-9 && value <= most + 1e-9);
                }
            }
        }
    }
}
