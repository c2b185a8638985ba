//! Pairs of records between the samples that either of them misses.

use std::ops::Range;
use std::path::Path;

use gtfdi::core::Dataset;

use crate::failure::Failure;

/// The pieces of a pair of records, of the same samples of both. Those of fewer samples than
/// `shortest` are left out where there are longer ones. Records of different lengths are no pair, and
/// stay whole for whoever refuses them.
///
/// # Errors
/// No sample that both records have.
pub fn pieces(
    path: &Path,
    healthy: &Dataset,
    (faulty_path, faulty): (&Path, &Dataset),
    shortest: usize,
) -> Result<Vec<(Dataset, Dataset)>, Failure> {
    if healthy.len() != faulty.len() {
        return Ok(vec![(healthy.clone(), faulty.clone())]);
    }
    let rows = |path: &Path, data: &Dataset, piece: &Range<usize>| {
        let part = data.rows(piece.clone());
        part.map_err(|error| Failure::in_file(path, error))
    };
    let found = kept(&[healthy, faulty], shortest);
    if found.is_empty() {
        let text = format!(
            "expected samples that {} has too, found none",
            path.display()
        );
        return Err(Failure::in_file(faulty_path, text));
    }
    let pair = |piece: &Range<usize>| {
        Ok((
            rows(path, healthy, piece)?,
            rows(faulty_path, faulty, piece)?,
        ))
    };
    found.iter().map(pair).collect()
}

/// Where no record misses a sample, stretches of `shortest` or more, or else all there are.
pub fn kept(records: &[&Dataset], shortest: usize) -> Vec<Range<usize>> {
    let all = common(records);
    let is_long = |piece: &&Range<usize>| piece.len() >= shortest;
    let long: Vec<Range<usize>> = all.iter().filter(is_long).cloned().collect();
    if long.is_empty() { all } else { long }
}

/// Where no record misses a sample.
fn common(records: &[&Dataset]) -> Vec<Range<usize>> {
    let len = records.iter().map(|data| data.len()).min().unwrap_or(0);
    let is_whole = |sample: usize| {
        records.iter().all(|data| {
            let (u, y) = (data.u().column(sample), data.y().column(sample));
            !u.iter().chain(y.iter()).any(|value| value.is_nan())
        })
    };
    let mut pieces = Vec::new();
    let mut start = 0;
    for sample in 0..=len {
        if sample < len && is_whole(sample) {
            continue;
        }
        if start < sample {
            pieces.push(start..sample);
        }
        start = sample + 1;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use gtfdi::core::Signal;
    use nalgebra::DMatrix;

    use super::*;

    fn record(len: usize, missing: &[usize]) -> Dataset {
        let value = |_, sample: usize| {
            if missing.contains(&sample) {
                f64::NAN
            } else {
                sample as f64
            }
        };
        let y = DMatrix::from_fn(1, len, value);
        let u = DMatrix::zeros(0, len);
        Dataset::new(vec![], vec![Signal::new("y", "")], u, y, 1.0).expect("a record")
    }

    #[test]
    fn pairs_are_split_where_either_record_misses_a_sample() {
        let (left, right) = (record(20, &[0, 7]), record(20, &[8, 19]));
        assert_eq!(kept(&[&left, &right], 1), [1..7, 9..19]);
        assert_eq!(kept(&[&left, &right], 8), vec![9..19]);
        // Where all are too short, whoever wants longer ones says so.
        assert_eq!(kept(&[&left, &right], 11), [1..7, 9..19]);
        let path = Path::new("h.csv");
        let pairs = pieces(path, &left, (Path::new("f.csv"), &right), 1).expect("pieces");
        let starts: Vec<(f64, f64)> = pairs.iter().map(|(a, b)| (a.y()[0], b.y()[0])).collect();
        assert_eq!(starts, [(1.0, 1.0), (9.0, 9.0)]);
        let none = record(20, &(0..20).collect::<Vec<_>>());
        let Err(Failure::Input(error)) = pieces(path, &none, (Path::new("f.csv"), &right), 1)
        else {
            panic!("no sample of both");
        };
        assert_eq!(
            error.to_string(),
            "f.csv: expected samples that h.csv has too, found none"
        );
        // No pair, and refused as such elsewhere.
        let odd = pieces(path, &record(5, &[]), (path, &right), 1).expect("whole");
        assert_eq!(odd[0].0.len(), 5);
    }
}
