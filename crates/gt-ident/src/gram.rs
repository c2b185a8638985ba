//! Inner products of all lagged channels.

use nalgebra::DMatrix;

use crate::Regressor;
use crate::kernel::correlate;
use crate::record::{Records, Window};

/// A sum that keeps what its additions round off.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    pub fn add(&mut self, value: f64) {
        let total = self.high + value;
        let other = total - self.high;
        self.low += (self.high - (total - other)) + (value - other);
        self.high = total;
    }

    /// Adds `a b` exactly.
    fn add_product(&mut self, a: f64, b: f64) {
        let product = a * b;
        self.add(product);
        self.low += a.mul_add(b, -product);
    }

    pub fn value(&self) -> f64 {
        self.high + self.low
    }
}

/// The inner products of all channels at lags `0..=longest`, from the products of lag 0 alone:
/// a row of products moves down its diagonal as `t` moves by one, which costs two edge terms a
/// stretch instead of a sum over the record.
///
/// It squares the condition of the regressors and is never the answer by itself.
pub(crate) struct Gram {
    longest: usize,
    width: usize,
    /// Entry `((i, a), (j, b))` at `[(i * width + a, j * width + b)]` for `i <= j`.
    products: DMatrix<f64>,
}

impl Gram {
    /// One pass over the records.
    pub fn new(records: &Records, window: &Window) -> Self {
        let (longest, width) = (window.longest, records.channels());
        let lags = longest + 1;
        let mut first = vec![Sum::default(); width * width * lags];
        let mut block_sums = vec![0.0; lags];
        let used: Vec<usize> = (0..width).filter(|&each| window.uses[each]).collect();
        records.for_each_block(window, |block| {
            for &a in &used {
                let now = block.lagged(a, 0);
                for &b in &used {
                    block_sums.fill(0.0);
                    correlate(now, block.lags(b, 0, longest), &mut block_sums);
                    for (sum, &part) in first[(a * width + b) * lags..].iter_mut().zip(&block_sums)
                    {
                        sum.add(part);
                    }
                }
            }
        });
        let mut edges = vec![Sum::default(); width * width * longest * longest];
        let cell =
            |i: usize, a: usize, j: usize, b: usize| ((i * width + a) * longest + j) * width + b;
        records.for_each_edge(window, |before, last| {
            for i in 0..longest {
                for j in i..longest {
                    for &a in &used {
                        for &b in &used {
                            let sum = &mut edges[cell(i, a, j, b)];
                            sum.add_product(before[i * width + a], before[j * width + b]);
                            sum.add_product(-last[i * width + a], last[j * width + b]);
                        }
                    }
                }
            }
        });
        let mut products = DMatrix::zeros(width * lags, width * lags);
        for distance in 0..lags {
            for a in 0..width {
                for b in 0..width {
                    let mut sum = first[(a * width + b) * lags + distance];
                    products[(a, distance * width + b)] = sum.value();
                    for i in 0..longest - distance {
                        let edge = edges[cell(i, a, i + distance, b)];
                        sum.add(edge.high);
                        sum.add(edge.low);
                        let (row, column) = (i + 1, i + 1 + distance);
                        products[(row * width + a, column * width + b)] = sum.value();
                    }
                }
            }
        }
        Self {
            longest,
            width,
            products,
        }
    }

    /// The inner product of two lagged channels.
    pub fn product(&self, records: &Records, left: Regressor, right: Regressor) -> f64 {
        let (early, late) = if left.lag <= right.lag {
            (left, right)
        } else {
            (right, left)
        };
        let at = |each: Regressor| {
            each.lag.min(self.longest) * self.width + records.position(each.channel)
        };
        self.products[(at(early), at(late))]
    }
}
