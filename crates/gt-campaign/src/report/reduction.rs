//! Long curves made short without losing a peak.

/// Which samples of a curve are drawn so that it looks the same in `buckets` columns: all of a short
/// one, and of a long one the least and the greatest value of every bucket, in their order. A bucket
/// without a finite value gives one sample, so that a gap stays a gap.
pub(super) fn extremes(values: &[f64], buckets: usize) -> Vec<usize> {
    let count = values.len();
    if count <= 2 * buckets {
        return (0..count).collect();
    }
    let mut kept = Vec::with_capacity(2 * buckets);
    for bucket in 0..buckets {
        let (start, end) = (bucket * count / buckets, (bucket + 1) * count / buckets);
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let finite = || (start..end).filter(|index| values[*index].is_finite());
        match (finite().min_by(by_value), finite().max_by(by_value)) {
            (Some(low), Some(high)) if low != high => {
                kept.extend([low.min(high), low.max(high)]);
            }
            (Some(only), _) => kept.push(only),
            _ => kept.push(start),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_peak_survives() {
        let mut values = vec![0.0; 50_000];
        values[31_234] = 7.0;
        let kept = extremes(&values, 600);
        assert!(
            kept.contains(&31_234),
            "the peak at sample 31234 is dropped"
        );
        assert!(kept.len() <= 1200 && kept.is_sorted());
    }

    #[test]
    fn short_curves_are_whole_and_gaps_stay() {
        assert_eq!(extremes(&[f64::NAN; 4], 2), [0, 1, 2, 3]);
        assert!(extremes(&[], 2).is_empty());
        let mut values = vec![1.0; 90];
        values[30..60].fill(f64::NAN);
        let kept = extremes(&values, 3);
        assert_eq!(kept.iter().filter(|k| values[**k].is_nan()).count(), 1);
    }
}
