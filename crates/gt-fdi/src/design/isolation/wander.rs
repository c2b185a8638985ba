//! How healthy residuals wander.

use gt_core::Dataset;
use nalgebra::{DMatrix, DVector};

use super::calibrate::{SAMPLES_A_SCAN, run};
use super::isolator::Fields;
use crate::FdiError;

/// The identity by rows.
pub(super) fn identity(size: usize) -> Vec<Vec<f64>> {
    by_rows(&DMatrix::identity(size, size))
}

fn by_rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let rows = matrix.row_iter();
    rows.map(|row| row.iter().copied().collect()).collect()
}

/// By the memory's level the covariance of the normalised sums of healthy residuals, by rows, and
/// of each hypothesis the variance of its normalised agreement where it is driven. White residuals
/// have the identity and 1; no direction counts as quieter than that.
pub(super) type Wander = (Vec<Vec<Vec<f64>>>, Vec<Vec<f64>>);

pub(super) fn wander(fields: &Fields, healthy: &[Dataset]) -> Result<Wander, FdiError> {
    // Of both signs: the square of either half is the same.
    let mut symmetric = fields.clone();
    for hypothesis in &mut symmetric.hypotheses {
        hypothesis.both_signs = true;
    }
    let (size, count) = (fields.scale.len(), fields.hypotheses.len());
    let levels = fields.core()?.levels();
    let mut covariances = vec![(DMatrix::<f64>::zeros(size, size), 0_usize); levels];
    let mut squares = vec![vec![(0.0, 0_usize); levels]; count];
    let mut samples = 0_usize;
    run(&symmetric, healthy, |core| {
        samples += 1;
        // Sums overlap so much that one in many tells as much as all.
        if samples.is_multiple_of(8 * SAMPLES_A_SCAN) {
            core.normalised(|level, place, values| {
                if place < count {
                    let (sum, number) = &mut squares[place][level];
                    *sum += values[0] * values[0];
                    *number += 1;
                } else {
                    let (sum, number) = &mut covariances[level];
                    let values = DVector::from_column_slice(values);
                    sum.ger(1.0, &values, &values, 1.0);
                    *number += 1;
                }
            });
        }
    })?;
    let mut last = DMatrix::identity(size, size);
    let wander = covariances.into_iter().map(|(sum, number)| {
        if number > size {
            let mut parts = (sum / number as f64).symmetric_eigen();
            parts.eigenvalues.apply(|value| *value = value.max(1.0));
            last = parts.recompose();
        }
        by_rows(&last)
    });
    let wander = wander.collect();
    let driven = squares.into_iter().map(|levels| {
        let mut last = 1.0_f64;
        let own = levels.into_iter().map(|(sum, number)| {
            if number > 0 {
                last = (sum / number as f64).max(1.0);
            }
            last
        });
        own.collect()
    });
    Ok((wander, driven.collect()))
}
