//! What the values of a tag say.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::DMatrix;
use serde::Serialize;

use crate::Place;

/// Differences beyond so many median absolute deviations are outliers.
const OUTLIER_MADS: f64 = 10.0;
/// A run of one value is frozen from so many times the usual run on.
const FROZEN_RUNS: usize = 10;
/// And from so many samples on.
const FROZEN_SAMPLES: usize = 20;
/// The highest order of excitation that is looked for.
const MOST_ORDER: usize = 20;
/// Relative size of the smallest eigenvalue that counts.
const EXCITATION_TOLERANCE: f64 = 1e-9;

/// A tag and what its values are like.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TagCheck {
    /// The tag.
    pub name: String,
    /// Its unit, where the file tells it.
    pub unit: String,
    /// What it holds.
    pub kind: TagKind,
    /// Finite numbers.
    pub values: usize,
    /// Cells without one, of those that may be missing.
    pub missing: usize,
    /// The words in those; nothing is the empty word.
    pub words: BTreeMap<String, usize>,
    /// The smallest number.
    pub minimum: Option<f64>,
    /// The largest number.
    pub maximum: Option<f64>,
    /// Whether all numbers are the same.
    pub constant: bool,
    /// The longest run of one number.
    pub longest_run: Option<Run>,
    /// The median length of a run of one number.
    pub usual_run: Option<usize>,
    /// Whether the longest run is far longer than is usual for the tag.
    pub frozen: bool,
    /// Share of the numbers that are the smallest.
    pub at_minimum_share: Option<f64>,
    /// Share of the numbers that are the largest.
    pub at_maximum_share: Option<f64>,
    /// The step of which all differences are whole multiples, where there is one.
    pub quantisation_step: Option<f64>,
    /// Numbers that leave their neighbours by more than ten median absolute deviations of the first
    /// difference, and that the next one leaves again.
    pub outliers: Vec<Outlier>,
    /// Order of persistent excitation, 20 at most: how many lags a fit could tell apart, the tag
    /// being an input. None where values are missing throughout.
    pub excitation_order: Option<usize>,
}

/// What a tag holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TagKind {
    /// Numbers, and perhaps words for missing ones.
    Number,
    /// Other texts only.
    Text,
    /// Nothing.
    Empty,
}

/// A run of one number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Run {
    /// The number.
    pub value: f64,
    /// Its samples.
    pub samples: usize,
    /// The line of the first, from 1.
    pub line: Option<u64>,
    /// The row of the first, from 0.
    pub row: Option<usize>,
}

/// A number far off its neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Outlier {
    /// The number.
    pub value: f64,
    /// Its line, from 1.
    pub line: Option<u64>,
    /// Its row, from 0.
    pub row: Option<usize>,
}

fn of_place(place: Place) -> (Option<u64>, Option<usize>) {
    match place {
        Place::Line(line) => (Some(line), None),
        Place::Row(row) | Place::Message(row) => (None, Some(row)),
    }
}

/// Fills in what the numbers of a tag say; NaN stands for none.
pub(super) fn describe(check: &mut TagCheck, values: &[f64], places: &[Place]) {
    let valid: Vec<(f64, Place)> = values.iter().copied().zip(places.iter().copied()).collect();
    let valid: Vec<(f64, Place)> = valid.into_iter().filter(|(v, _)| v.is_finite()).collect();
    check.values = valid.len();
    if valid.is_empty() {
        return;
    }
    let mut sorted: Vec<f64> = valid.iter().map(|(value, _)| *value).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (least, most) = (sorted[0], sorted[sorted.len() - 1]);
    let share = |wanted: f64| {
        let count = sorted
            .iter()
            .filter(|&&value| is_same(value, wanted))
            .count();
        count as f64 / sorted.len() as f64
    };
    check.minimum = Some(least);
    check.maximum = Some(most);
    check.constant = is_same(least, most);
    if !check.constant {
        check.at_minimum_share = Some(share(least));
        check.at_maximum_share = Some(share(most));
        check.quantisation_step = quantisation(&sorted);
        check.outliers = outliers(&valid);
        check.excitation_order = excitation_order(values);
    }
    runs(check, &valid);
}

fn runs(check: &mut TagCheck, valid: &[(f64, Place)]) {
    let mut lengths = Vec::new();
    let mut longest: Option<Run> = None;
    let mut start = 0;
    for end in 1..=valid.len() {
        if end < valid.len() && is_same(valid[end].0, valid[start].0) {
            continue;
        }
        let samples = end - start;
        lengths.push(samples);
        if longest.is_none_or(|run| samples > run.samples) {
            let (line, row) = of_place(valid[start].1);
            let value = valid[start].0;
            longest = Some(Run {
                value,
                samples,
                line,
                row,
            });
        }
        start = end;
    }
    lengths.sort_unstable();
    let usual = lengths.get(lengths.len() / 2).copied();
    check.longest_run = longest;
    check.usual_run = usual;
    let limit = FROZEN_SAMPLES.max(FROZEN_RUNS * usual.unwrap_or(1));
    check.frozen = !check.constant && longest.is_some_and(|run| run.samples >= limit);
}

/// The step of sorted numbers: the smallest difference, where all others are multiples of it.
fn quantisation(sorted: &[f64]) -> Option<f64> {
    let steps: Vec<f64> = sorted
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|&step| step > 0.0)
        .collect();
    let least = steps.iter().copied().reduce(f64::min)?;
    let whole = |step: &f64| ((step / least) - (step / least).round()).abs() < 1e-3;
    (steps.len() > 2 && steps.iter().all(whole)).then_some(least)
}

/// Whether a sensor gave the same number again.
#[expect(
    clippy::float_cmp,
    reason = "a frozen value is the same to the last bit"
)]
fn is_same(a: f64, b: f64) -> bool {
    a == b
}

/// The middle one, the upper of two; 0 of none.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

fn outliers(valid: &[(f64, Place)]) -> Vec<Outlier> {
    let steps: Vec<f64> = valid.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    let middle = median(steps.clone());
    let deviations = steps.iter().map(|step| (step - middle).abs());
    let limit = OUTLIER_MADS * median(deviations.collect());
    if limit <= 0.0 {
        return Vec::new();
    }
    let far = |step: f64| (step - middle).abs() > limit;
    let pairs = steps.windows(2).enumerate();
    pairs
        .filter(|(_, pair)| far(pair[0]) && far(pair[1]) && pair[0] * pair[1] < 0.0)
        .map(|(k, _)| {
            let (value, place) = valid[k + 1];
            let (line, row) = of_place(place);
            Outlier { value, line, row }
        })
        .collect()
}

/// The largest number of successive samples, [`MOST_ORDER`] at most, whose sums of products have
/// full rank: the order of persistent excitation of the numbers about their mean.
fn excitation_order(values: &[f64]) -> Option<usize> {
    let valid = values.iter().copied().filter(|value| value.is_finite());
    let (sum, count) = valid.fold((0.0, 0_usize), |(sum, n), value| (sum + value, n + 1));
    let mean = sum / count as f64;
    let mut products = DMatrix::<f64>::zeros(MOST_ORDER, MOST_ORDER);
    let mut windows = 0;
    for run in values.split(|value| !value.is_finite()) {
        let deviations: Vec<f64> = run.iter().map(|value| value - mean).collect();
        windows += add_products(&mut products, &deviations);
    }
    if windows < MOST_ORDER {
        return None;
    }
    products.fill_upper_triangle_with_lower_triangle();
    let has_full_rank = |order: usize| {
        let part = products.view((0, 0), (order, order)).into_owned();
        let values = part.symmetric_eigenvalues();
        values.min() > EXCITATION_TOLERANCE * values.max()
    };
    Some(
        (1..=MOST_ORDER)
            .take_while(|&order| has_full_rank(order))
            .count(),
    )
}

/// Adds the products of the samples of each window of [`MOST_ORDER`] successive ones, `products[(i, j)]`
/// those of its i-th and j-th for `j <= i`; says how many windows there are.
///
/// A sample that stands in every place of some window has the same products in all of them, so that
/// they are summed once for each lag; what the first and the last windows have besides is added.
fn add_products(products: &mut DMatrix<f64>, values: &[f64]) -> usize {
    let Some(last) = values.len().checked_sub(MOST_ORDER) else {
        return 0;
    };
    let sum = |samples: Range<usize>, lag: usize| -> f64 {
        let pairs = samples.map(|sample| values[sample] * values[sample - lag]);
        pairs.sum()
    };
    // In the order of the window, which the lags fall by.
    let mut in_every_place = [0.0; MOST_ORDER];
    let everywhere = MOST_ORDER - 1..last + 1;
    for window in values[..everywhere.end.max(MOST_ORDER)].windows(MOST_ORDER) {
        let newest = window[MOST_ORDER - 1];
        for (sum, value) in in_every_place.iter_mut().zip(window) {
            *sum += newest * value;
        }
    }
    for row in 0..MOST_ORDER {
        for column in 0..=row {
            let lag = row - column;
            products[(row, column)] += if everywhere.is_empty() {
                sum(row..last + row + 1, lag)
            } else {
                let before = sum(row..everywhere.start, lag);
                let after = sum(everywhere.end..everywhere.end + row, lag);
                before + in_every_place[MOST_ORDER - 1 - lag] + after
            };
        }
    }
    last + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sines(count: i32, samples: i32) -> Vec<f64> {
        let sample = |k: i32| {
            let terms = (1..=count).map(|n| (0.3 * f64::from(n * k)).sin());
            terms.sum::<f64>()
        };
        (0..samples).map(sample).collect()
    }

    /// A sum of n sines is exciting of order 2 n (Soderstrom and Stoica, System Identification,
    /// example 5.11), and what is left of its mean adds one.
    #[test]
    fn published_order_of_excitation_of_sines() {
        for count in [1, 2, 3] {
            let found = excitation_order(&sines(count, 400)).unwrap();
            let order = 2 * usize::try_from(count).unwrap();
            assert!(
                (order..=order + 1).contains(&found),
                "{count} sines: {found}"
            );
        }
        assert_eq!(excitation_order(&[1.0; 60]), Some(0));
        assert_eq!(excitation_order(&[1.0; 10]), None);
    }

    /// Against each window by itself, on runs that have a sample in every place and on shorter ones.
    #[test]
    fn products_of_runs_are_those_of_their_windows() {
        for len in [5, 20, 21, 30, 38, 39, 40, 200] {
            let values: Vec<f64> = (0..len).map(|k| (1.7 * f64::from(k * k)).sin()).collect();
            let mut found = DMatrix::zeros(MOST_ORDER, MOST_ORDER);
            let windows = add_products(&mut found, &values);
            assert_eq!(windows, values.windows(MOST_ORDER).count());
            for row in 0..MOST_ORDER {
                for column in 0..=row {
                    let products = values.windows(MOST_ORDER).map(|w| w[row] * w[column]);
                    let expected: f64 = products.sum();
                    // Sums of up to 200 terms of 1 in another order.
                    let error = (found[(row, column)] - expected).abs();
                    assert!(error < 1e-12, "{len}: {row}, {column}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn steps_and_spikes_are_found() {
        let numbers = [0.0, 0.5, 1.5, 1.0, 4.0];
        let mut sorted = numbers.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        assert_eq!(quantisation(&sorted), Some(0.5));
        assert_eq!(quantisation(&[0.0, 0.5, 1.1, 1.7]), None);
        let mut values = sines(2, 200);
        values[77] += 50.0;
        values.iter_mut().skip(150).for_each(|value| *value += 50.0);
        let valid: Vec<(f64, Place)> = values.iter().copied().zip((0..).map(Place::Row)).collect();
        let found: Vec<Option<usize>> = outliers(&valid).iter().map(|o| o.row).collect();
        assert_eq!(found, [Some(77)], "a step is no spike");
    }
}
