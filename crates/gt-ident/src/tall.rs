//! Householder QR of a regressor matrix that is never formed whole.

use nalgebra::DMatrix;

use crate::Regressor;
use crate::least_squares::triangular_factor;
use crate::record::{Records, Window};

/// The triangular factor of the lagged channels `columns` over the window, and of a last column of
/// ones where `with_ones` is set: blocks of rows are put under the factor so far and factorised
/// with it. Memory is a few times that of `4 p x p` numbers, whatever the length of the records.
pub(crate) fn triangle(
    records: &Records,
    window: &Window,
    columns: &[Regressor],
    with_ones: bool,
) -> DMatrix<f64> {
    let p = columns.len() + usize::from(with_ones);
    let mut window = window.clone();
    // Few columns make panels, many make the factor itself the larger part of each block.
    window.block_rows = window.block_rows.max(4 * p);
    let mut factor = DMatrix::zeros(0, p);
    records.for_each_block(&window, |block| {
        let above = factor.nrows();
        let mut stacked = DMatrix::zeros(above + block.rows(), p);
        stacked.rows_mut(0, above).copy_from(&factor);
        for (index, each) in columns.iter().enumerate() {
            let samples = block.lagged(records.position(each.channel), each.lag);
            let mut column = stacked.column_mut(index);
            column.as_mut_slice()[above..].copy_from_slice(samples);
        }
        if with_ones {
            stacked
                .view_mut((above, p - 1), (block.rows(), 1))
                .fill(1.0);
        }
        factor = triangular_factor(&stacked);
    });
    factor
}
