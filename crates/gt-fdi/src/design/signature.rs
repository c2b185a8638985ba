//! Which residual answers to which fault.

use std::ops::Range;

use gt_core::DimensionError;
use serde::{Deserialize, Serialize};

use super::calibration::check_finite;
use crate::FdiError;

/// What is taken of a residual before its size is measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Feature {
    /// The mean over the trailing window: the paper's monitored moving average.
    MovingMean {
        /// Length of the window in seconds, above 0.
        window_s: f64,
    },
    /// The series minus its mean over the trailing window.
    HighPass {
        /// Length of the window in seconds, above 0.
        window_s: f64,
    },
    /// The series itself.
    Plain,
}

impl Feature {
    /// Refuses a window that is not a positive finite time.
    ///
    /// # Errors
    /// [`FdiError::Option`].
    pub fn validate(&self) -> Result<(), FdiError> {
        match *self {
            Self::MovingMean { window_s } | Self::HighPass { window_s }
                if !(window_s.is_finite() && window_s > 0.0) =>
            {
                let expected = "a positive finite number of seconds";
                Err(FdiError::Option {
                    option: "window_s",
                    expected,
                    found: window_s,
                })
            }
            _ => Ok(()),
        }
    }
}

/// The feature of a series sampled every `sample_time_s` seconds, sample by sample.
///
/// A window has `window_s / sample_time_s` samples, rounded, at least one; at the start of the
/// series it holds those there are. Samples that are not finite are left out of a mean.
pub fn feature(series: &[f64], sample_time_s: f64, feature: Feature) -> Vec<f64> {
    match feature {
        Feature::Plain => series.to_vec(),
        Feature::MovingMean { window_s } => {
            moving_mean(series, window_samples(window_s, sample_time_s))
        }
        Feature::HighPass { window_s } => {
            let means = moving_mean(series, window_samples(window_s, sample_time_s));
            series
                .iter()
                .zip(means)
                .map(|(value, mean)| value - mean)
                .collect()
        }
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates; NaN becomes 1
fn window_samples(window_s: f64, sample_time_s: f64) -> usize {
    ((window_s / sample_time_s).round() as usize).max(1)
}

/// Means over the `window` samples up to each sample; NaN where none of them is finite.
fn moving_mean(series: &[f64], window: usize) -> Vec<f64> {
    let finite = |values: &[f64]| {
        let valid = values.iter().filter(|value| value.is_finite());
        valid.fold((0.0, 0_usize), |(sum, count), value| {
            (sum + value, count + 1)
        })
    };
    let (mut sum, mut count) = (0.0, 0_usize);
    let mut means = Vec::with_capacity(series.len());
    for (index, value) in series.iter().enumerate() {
        if index % window == 0 {
            // Summed afresh once a window, so that rounding cannot pile up.
            (sum, count) = finite(&series[(index + 1).saturating_sub(window)..=index]);
        } else {
            if value.is_finite() {
                (sum, count) = (sum + value, count + 1);
            }
            if let Some(gone) = index.checked_sub(window)
                && series[gone].is_finite()
            {
                (sum, count) = (sum - series[gone], count - 1);
            }
        }
        means.push(sum / count as f64);
    }
    means
}

/// The signature matrix: rows are faults, columns are residuals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignatureMatrix {
    /// Names of the faults.
    pub rows: Vec<String>,
    /// Names of the residuals.
    pub columns: Vec<String>,
    /// `raw` with each column divided by its largest entry; a column of zeros stays so.
    pub matrix: Vec<Vec<f64>>,
    /// Root mean square, over the window, of the difference that the fault makes to the residual's
    /// feature, in the residual's unit.
    pub raw: Vec<Vec<f64>>,
    /// The definition in words, with the window and the features.
    pub definition: String,
}

/// `S_ij = rms over the window of feature_j(faulty_i) - feature_j(healthy)`, then each column
/// divided by its largest entry.
///
/// `faulty` holds for each fault its name and one residual a column, `healthy` one residual a
/// column under the same operation and noise; `columns` names the residuals and their features;
/// `window` is a range of samples.
///
/// # Errors
/// [`FdiError`] when numbers of columns or samples differ, the window does not fit, a feature's
/// window or the sample time is not positive, a sample that counts is not finite, or there is no
/// healthy residual.
pub fn signature(
    faulty: &[(&str, &[Vec<f64>])],
    healthy: &[Vec<f64>],
    columns: &[(&str, Feature)],
    sample_time_s: f64,
    window: Range<usize>,
) -> Result<SignatureMatrix, FdiError> {
    let kinds: Vec<Feature> = columns.iter().map(|(_, kind)| *kind).collect();
    let len = check_window(healthy, &kinds, sample_time_s, &window)?;
    let reference = features("healthy", healthy, columns, sample_time_s, len)?;
    let mut raw = Vec::with_capacity(faulty.len());
    for (fault, residuals) in faulty {
        let with_fault = features(fault, residuals, columns, sample_time_s, len)?;
        let pairs = with_fault.iter().zip(&reference);
        raw.push(
            pairs
                .map(|(f, h)| rms_difference(&f[window.clone()], &h[window.clone()]))
                .collect(),
        );
    }
    Ok(SignatureMatrix {
        rows: faulty.iter().map(|(name, _)| (*name).to_owned()).collect(),
        columns: columns.iter().map(|(name, _)| (*name).to_owned()).collect(),
        matrix: normalise_columns(&raw, columns.len()),
        raw,
        definition: define(columns, sample_time_s, &window),
    })
}

/// Checks what does not depend on the runs; gives the number of samples.
pub(super) fn check_window(
    healthy: &[Vec<f64>],
    features: &[Feature],
    sample_time_s: f64,
    window: &Range<usize>,
) -> Result<usize, FdiError> {
    if !(sample_time_s.is_finite() && sample_time_s > 0.0) {
        let expected = "a positive finite number of seconds";
        return Err(FdiError::Option {
            option: "sample_time_s",
            expected,
            found: sample_time_s,
        });
    }
    features.iter().try_for_each(Feature::validate)?;
    let len = healthy.first().ok_or(FdiError::NoHealthyData)?.len();
    if window.start >= window.end || window.end > len {
        return Err(FdiError::Window {
            start: window.start,
            end: window.end,
            len,
        });
    }
    Ok(len)
}

/// The features of one run's residuals, checked.
fn features(
    run: &str,
    residuals: &[Vec<f64>],
    columns: &[(&str, Feature)],
    sample_time_s: f64,
    len: usize,
) -> Result<Vec<Vec<f64>>, FdiError> {
    DimensionError::check(
        &format!("residuals of `{run}`"),
        columns.len(),
        residuals.len(),
    )?;
    let mut all = Vec::with_capacity(columns.len());
    for (residual, (column, kind)) in residuals.iter().zip(columns) {
        let what = format!("residual `{column}` of `{run}`");
        DimensionError::check(&format!("samples of {what}"), len, residual.len())?;
        check_finite(&what, residual)?;
        all.push(feature(residual, sample_time_s, *kind));
    }
    Ok(all)
}

fn rms_difference(left: &[f64], right: &[f64]) -> f64 {
    let squares: f64 = left
        .iter()
        .zip(right)
        .map(|(left, right)| (left - right).powi(2))
        .sum();
    (squares / left.len() as f64).sqrt()
}

fn normalise_columns(raw: &[Vec<f64>], columns: usize) -> Vec<Vec<f64>> {
    let largest: Vec<f64> = (0..columns)
        .map(|j| raw.iter().map(|row| row[j]).fold(0.0, f64::max))
        .collect();
    let scaled =
        |(value, largest): (&f64, &f64)| if *largest > 0.0 { value / largest } else { 0.0 };
    raw.iter()
        .map(|row| row.iter().zip(&largest).map(scaled).collect())
        .collect()
}

fn define(columns: &[(&str, Feature)], sample_time_s: f64, window: &Range<usize>) -> String {
    let words = columns.iter().map(|(name, feature)| match feature {
        Feature::Plain => format!("{name}: plain"),
        Feature::MovingMean { window_s } => format!("{name}: moving mean of {window_s} s"),
        Feature::HighPass { window_s } => format!("{name}: minus the moving mean of {window_s} s"),
    });
    format!(
        "S_ij = rms of feature_j(fault i) - feature_j(healthy) over samples {}..{} at {} s, each \
         column divided by its largest entry; features: {}",
        window.start,
        window.end,
        sample_time_s,
        words.collect::<Vec<_>>().join(", ")
    )
}

impl SignatureMatrix {
    /// Whether there are as many residuals as faults and each residual peaks, alone, at the fault
    /// of its own position.
    pub fn is_diagonal(&self) -> bool {
        // Entries by `get`: a matrix from a file may be ragged.
        let entry = |i: usize, j: usize| self.matrix.get(i).and_then(|row| row.get(j)).copied();
        let peaks = |j: usize| {
            let mut others = (0..self.rows.len()).filter(|i| *i != j);
            entry(j, j) > Some(0.0) && others.all(|i| entry(i, j) < entry(j, j))
        };
        self.rows.len() == self.columns.len() && (0..self.columns.len()).all(peaks)
    }

    /// Where the entries are above `cut`: the fault lights the residual.
    pub fn binary(&self, cut: f64) -> Vec<Vec<bool>> {
        self.matrix
            .iter()
            .map(|row| row.iter().map(|&value| value > cut).collect())
            .collect()
    }

    /// Whether every fault lights a residual and no two faults light the same ones: weakly
    /// isolating residuals (Gertler, *Fault Detection and Diagnosis in Engineering Systems*, 1998).
    pub fn is_weakly_isolable(&self, cut: f64) -> bool {
        let rows = self.binary(cut);
        all_lit(&rows) && pairs(&rows).all(|(left, right)| left != right)
    }

    /// Whether every fault lights a residual and no fault lights all those of another: even with
    /// some residuals still dark, no fault is taken for another (strongly isolating residuals).
    pub fn is_strongly_isolable(&self, cut: f64) -> bool {
        let rows = self.binary(cut);
        let covers = |left: &[bool], right: &[bool]| left.iter().zip(right).all(|(l, r)| *l || !*r);
        all_lit(&rows) && pairs(&rows).all(|(left, right)| !covers(left, right))
    }
}

fn all_lit(rows: &[Vec<bool>]) -> bool {
    rows.iter().all(|row| row.contains(&true))
}

/// All ordered pairs of different rows.
fn pairs(rows: &[Vec<bool>]) -> impl Iterator<Item = (&[bool], &[bool])> {
    let with_index = move |i: usize| (0..rows.len()).filter(move |j| *j != i);
    (0..rows.len()).flat_map(move |i| with_index(i).map(move |j| (&rows[i][..], &rows[j][..])))
}
