//! What the times of a file say.

use std::path::Path;

use serde::Serialize;

use super::{Damage, DamageKind};
use crate::time::Clock;
use crate::{LogError, Place, UNIFORM_TOLERANCE};

/// The times of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeCheck {
    /// The time column.
    pub column: String,
    /// Times that could be read.
    pub count: usize,
    /// From the first to the last of them in seconds.
    pub span_s: f64,
    /// The median step, where there are two times.
    pub period_s: Option<f64>,
    /// The share of steps that are not within a thousandth of the period.
    pub off_period_share: f64,
    /// Steps longer than the period.
    pub gaps: usize,
    /// The longest of them.
    pub longest_gap: Option<Gap>,
    /// Times that repeat the one before.
    pub duplicates: usize,
    /// Times before the one before.
    pub backwards: usize,
    /// A sample time that the times have or come near to, in seconds.
    pub suggested_sample_time_s: Option<f64>,
}

/// A step in time that is longer than the others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gap {
    /// Its length in seconds.
    pub seconds: f64,
    /// The line after it, from 1.
    pub line: Option<u64>,
    /// The row after it, from 0.
    pub row: Option<usize>,
}

impl TimeCheck {
    /// The times of samples of one period.
    pub(super) fn of_samples(column: String, count: usize, period_s: f64) -> Self {
        Self {
            column,
            count,
            span_s: count.saturating_sub(1) as f64 * period_s,
            period_s: Some(period_s),
            off_period_share: 0.0,
            gaps: 0,
            longest_gap: None,
            duplicates: 0,
            backwards: 0,
            suggested_sample_time_s: Some(period_s),
        }
    }
}

/// Examines times; `tag` is the tag whose times they are.
pub(super) fn times(
    path: &Path,
    column: &str,
    tag: Option<&str>,
    clock: &Clock,
    places: &[Place],
    damages: &mut Vec<Damage>,
) -> TimeCheck {
    let since = clock.since(clock);
    let steps: Vec<f64> = since.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut forward: Vec<f64> = steps.iter().copied().filter(|&step| step > 0.0).collect();
    forward.sort_unstable_by(f64::total_cmp);
    let period_s = forward.get(forward.len() / 2).copied();
    let mut check = TimeCheck {
        column: column.to_owned(),
        count: since.len(),
        span_s: since.last().copied().unwrap_or(0.0),
        period_s,
        off_period_share: 0.0,
        gaps: 0,
        longest_gap: None,
        duplicates: 0,
        backwards: 0,
        suggested_sample_time_s: period_s.map(rounded),
    };
    let limit_s = UNIFORM_TOLERANCE * period_s.unwrap_or(0.0);
    let mut off = 0;
    for (k, &step) in steps.iter().enumerate() {
        if period_s.is_some_and(|period_s| (step - period_s).abs() <= limit_s) {
            continue;
        }
        off += 1;
        let place = places[k + 1];
        let kind = if step == 0.0 {
            check.duplicates += 1;
            DamageKind::Duplicate
        } else if step < 0.0 {
            check.backwards += 1;
            DamageKind::Backward
        } else if step > period_s.unwrap_or(0.0) {
            check.gaps += 1;
            if check
                .longest_gap
                .is_none_or(|longest| step > longest.seconds)
            {
                check.longest_gap = Some(gap(step, place));
            }
            DamageKind::Gap
        } else {
            DamageKind::Step
        };
        let error = if step <= 0.0 {
            LogError::TimeNotIncreasing {
                path: path.to_owned(),
                place,
                previous_s: since[k],
                found_s: since[k + 1],
            }
        } else {
            LogError::TimeNotUniform {
                path: path.to_owned(),
                place,
                expected_s: period_s.unwrap_or(0.0),
                found_s: step,
                tolerance: UNIFORM_TOLERANCE,
            }
        };
        let mended_by = match kind {
            DamageKind::Gap => Some("--missing"),
            DamageKind::Step | DamageKind::Duplicate => Some("--resample"),
            _ => None,
        };
        damages.push(Damage::at(
            kind,
            place,
            tag.or(Some(column)),
            &error,
            mended_by,
        ));
    }
    if !steps.is_empty() {
        check.off_period_share = f64::from(off) / steps.len() as f64;
    }
    check
}

fn gap(seconds: f64, place: Place) -> Gap {
    let (line, row) = match place {
        Place::Line(line) => (Some(line), None),
        Place::Row(row) | Place::Message(row) => (None, Some(row)),
    };
    Gap { seconds, line, row }
}

/// A period to three significant digits.
fn rounded(period_s: f64) -> f64 {
    format!("{period_s:.2e}").parse().unwrap_or(period_s)
}
