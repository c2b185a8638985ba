//! Which tags lead the others: whose past explains what the pasts of all others leave open.
//!
//! Every tag is regressed on the past of all tags (an ARX equation with all of them as regressors).
//! A tag leads another as far as the other's equation gets worse without it; the excess of the
//! test's F over chance, as a share of what is left of the other (Granger 1969, Econometrica 37).

use nalgebra::{Cholesky, DMatrix};
use serde::Serialize;

/// The lags of every tag.
const LAGS: usize = 2;
/// The most tags that are compared: the work grows with their third power.
const MOST_TAGS: usize = 128;
/// The most samples that are looked at.
const MOST_SAMPLES: usize = 4000;
/// Rows that each unknown needs.
const ROWS_PER_UNKNOWN: usize = 2;
/// What is added to the diagonal of the normalised moments: tags that are sums of others stay
/// harmless.
const RIDGE: f64 = 1e-8;
/// Lags times F from which one link is beyond chance (5e-5 for two lags).
const BEYOND_CHANCE: f64 = 20.0;
/// Correlation from which two tags move as one.
const ONE: f64 = 0.999;

/// What was compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Comparison {
    /// The tags.
    pub tags: usize,
    /// The samples, those from the first on at which all of them have values.
    pub samples: usize,
    /// The lags of each tag.
    pub lags: usize,
}

/// Why tags were not compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, thiserror::Error)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum NotCompared {
    /// Nothing to compare with.
    #[error("expected two tags or more that move, found {found}")]
    FewTags {
        /// The tags that move.
        found: usize,
    },
    /// More tags than are compared.
    #[error("expected at most {most} tags, found {found}; name some with --inputs and --outputs")]
    ManyTags {
        /// The most.
        most: usize,
        /// The tags there are.
        found: usize,
    },
    /// Samples at which all tags have values are too few.
    #[error("expected {expected} samples at which all tags have values, found {found}")]
    FewSamples {
        /// Those needed.
        expected: usize,
        /// Those there are.
        found: usize,
    },
    /// Tags at times of their own.
    #[error("expected all tags at the same times; give --resample")]
    OwnTimes,
}

/// How a tag stands to the others.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lead {
    /// What it explains of the others.
    pub(super) leads: f64,
    /// What the others explain of it.
    pub(super) follows: f64,
    /// The tag that it explains best, where that is beyond chance.
    pub(super) led: Option<usize>,
    /// The tag that explains it best, where that is beyond chance.
    pub(super) leader: Option<usize>,
    /// A tag that moves as one with it.
    pub(super) twin: Option<usize>,
}

impl Lead {
    /// What it explains as a share of what it explains and what explains it.
    pub(super) fn share(&self) -> f64 {
        self.leads / (self.leads + self.follows + 1e-3)
    }
}

/// Compares tags of as many samples each; NaN is a missing one.
pub(super) fn compare(series: &[&[f64]]) -> Result<(Comparison, Vec<Lead>), NotCompared> {
    let tags = series.len();
    if tags < 2 {
        return Err(NotCompared::FewTags { found: tags });
    }
    if tags > MOST_TAGS {
        let (most, found) = (MOST_TAGS, tags);
        return Err(NotCompared::ManyTags { most, found });
    }
    let len = series.iter().map(|values| values.len()).min().unwrap_or(0);
    let is_whole = |sample: usize| series.iter().all(|values| values[sample].is_finite());
    let mut past = 0;
    let mut rows = Vec::new();
    for sample in 0..len {
        past = if is_whole(sample) { past + 1 } else { 0 };
        if past > LAGS && rows.len() < MOST_SAMPLES {
            rows.push(sample);
        }
    }
    let unknowns = LAGS * tags;
    let expected = ROWS_PER_UNKNOWN * unknowns + 30;
    if rows.len() < expected {
        let found = rows.len();
        return Err(NotCompared::FewSamples { expected, found });
    }
    let regressors = normalised(&rows, unknowns, |row, column| {
        series[column / LAGS][row - 1 - column % LAGS]
    });
    let targets = normalised(&rows, tags, |row, column| series[column][row]);
    let comparison = Comparison {
        tags,
        samples: rows.len(),
        lags: LAGS,
    };
    let links = links(&regressors, &targets).ok_or(NotCompared::FewSamples {
        expected,
        found: rows.len(),
    })?;
    let twins = targets.tr_mul(&targets);
    let leads = (0..tags).map(|tag| lead(tag, &links, &twins, rows.len()));
    Ok((comparison, leads.collect()))
}

/// A matrix of samples x columns, every column without its mean and of unit length.
fn normalised(rows: &[usize], columns: usize, value: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    let mut matrix = DMatrix::from_fn(rows.len(), columns, |row, column| value(rows[row], column));
    for mut column in matrix.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
        let norm = column.norm();
        if norm > 0.0 {
            column /= norm;
        }
    }
    matrix
}

/// Lags times F of the test that a tag (row) is of no use for another (column).
fn links(regressors: &DMatrix<f64>, targets: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (samples, unknowns) = regressors.shape();
    let tags = targets.ncols();
    let mut moments = regressors.tr_mul(regressors);
    for k in 0..unknowns {
        moments[(k, k)] += RIDGE;
    }
    let inverse = Cholesky::new(moments)?.inverse();
    let coefficients = &inverse * regressors.tr_mul(targets);
    let left = targets - regressors * &coefficients;
    let freedom = (samples - unknowns - 1) as f64;
    let mut links = DMatrix::zeros(tags, tags);
    for from in 0..tags {
        let own = inverse.view((from * LAGS, from * LAGS), (LAGS, LAGS));
        let weight = own.clone_owned().try_inverse()?;
        for to in (0..tags).filter(|&to| to != from) {
            let part = coefficients.view((from * LAGS, to), (LAGS, 1));
            let variance = left.column(to).norm_squared() / freedom;
            let gain = (part.transpose() * &weight * part)[(0, 0)];
            links[(from, to)] = gain / variance.max(f64::MIN_POSITIVE);
        }
    }
    Some(links)
}

fn lead(tag: usize, links: &DMatrix<f64>, twins: &DMatrix<f64>, samples: usize) -> Lead {
    let tags = links.nrows();
    let freedom = (samples - LAGS * tags - 1) as f64;
    let gain = |link: f64| ((link - LAGS as f64).max(0.0) / freedom).ln_1p();
    let others = || (0..tags).filter(|&other| other != tag);
    let best = |link: &dyn Fn(usize) -> f64| {
        others()
            .max_by(|&a, &b| link(a).total_cmp(&link(b)))
            .filter(|&other| link(other) > BEYOND_CHANCE)
    };
    Lead {
        leads: others().map(|other| gain(links[(tag, other)])).sum(),
        follows: others().map(|other| gain(links[(other, tag)])).sum(),
        led: best(&|other| links[(tag, other)]),
        leader: best(&|other| links[(other, tag)]),
        twin: others().find(|&other| twins[(tag, other)].abs() > ONE),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between -1 and 1 by a linear congruence (Knuth, MMIX).
    fn noise(seed: u64, len: usize) -> Vec<f64> {
        let mut state = seed;
        let next = |_| {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            f64::from(u32::try_from(state >> 32).unwrap()) / f64::from(u32::MAX) * 2.0 - 1.0
        };
        (0..len).map(next).collect()
    }

    /// `u` drives `y`, `y` drives `z`; `w` stands alone.
    #[test]
    fn a_chain_is_told_from_its_end_and_from_strangers() {
        let (u, e, w) = (noise(1, 1000), noise(2, 1000), noise(3, 1000));
        let (mut y, mut z) = (vec![0.0; 1000], vec![0.0; 1000]);
        for k in 1..1000 {
            y[k] = 0.7 * y[k - 1] + u[k - 1] + 0.2 * e[k];
            z[k] = 0.5 * z[k - 1] + 0.5 * y[k - 1] + 0.3 * e[999 - k];
        }
        let (done, leads) = compare(&[&u, &y, &z, &w]).unwrap();
        assert_eq!((done.tags, done.samples, done.lags), (4, 998, 2));
        assert!(leads[0].share() > 0.97, "{:?}", leads[0]);
        assert_eq!((leads[0].led, leads[0].leader), (Some(1), None));
        assert_eq!((leads[1].led, leads[1].leader), (Some(2), Some(0)));
        assert!(leads[2].share() < 0.05, "{:?}", leads[2]);
        assert_eq!((leads[2].led, leads[2].leader), (None, Some(1)));
        assert_eq!((leads[3].led, leads[3].leader), (None, None));
        assert!(leads.iter().all(|lead| lead.twin.is_none()));
    }

    #[test]
    fn twins_gaps_and_too_little_data_are_seen() {
        let (u, e) = (noise(1, 300), noise(2, 300));
        let mut twin: Vec<f64> = u.iter().map(|value| 3.0 - 2.0 * value).collect();
        twin[100] = f64::NAN;
        let (done, leads) = compare(&[&u, &twin, &e]).unwrap();
        // The two first samples have no past, and three need the missing one.
        assert_eq!(done.samples, 300 - 2 - 3);
        assert_eq!(leads[0].twin, Some(1));
        assert_eq!(leads[1].twin, Some(0));
        assert_eq!(leads[2].twin, None);
        let text = |series: &[&[f64]]| compare(series).unwrap_err().to_string();
        assert_eq!(
            text(&[&u[..30], &e[..30]]),
            "expected 38 samples at which all tags have values, found 28"
        );
        assert_eq!(text(&[&u]), "expected two tags or more that move, found 1");
        let many = vec![u.as_slice(); 129];
        assert_eq!(
            text(&many),
            "expected at most 128 tags, found 129; name some with --inputs and --outputs"
        );
    }
}
