//! One factorisation of a window that any structure within its lags is fitted from.

use std::collections::HashMap;

use gt_core::{Dataset, Signal};
use nalgebra::{DMatrix, DVector};

use crate::arx::rank_deficient;
use crate::least_squares::{CONDITION_LIMIT, LeastSquares, condition, scaled_norm};
use crate::record::{Records, Window};
use crate::regressor::check_varies;
use crate::tall::triangle;
use crate::{ArxStructure, Channel, IdentError, Missing, Regressor};

/// Columns up to which a condition is that of a singular value decomposition.
const DECOMPOSED: usize = 64;

/// The triangular factor of the lagged channels of a window, of the outputs at lag 0 and of a
/// column of ones.
pub(crate) struct WindowFactor<'a> {
    records: Records<'a>,
    signals: (&'a [Signal], &'a [Signal]),
    r: DMatrix<f64>,
    columns: HashMap<Regressor, usize>,
    pub rows: usize,
}

/// What a row leaves unexplained, in rotated coordinates.
pub(crate) struct RowFit {
    pub residual: DVector<f64>,
    pub condition: f64,
    /// The condition's error where it is beyond the limit; the residual is then that without the
    /// dependent regressors.
    pub refused: Option<IdentError>,
}

impl<'a> WindowFactor<'a> {
    /// The factor for all of `structures` on the rows from their longest lag on. Regressors that
    /// come first there come first in the factor.
    pub fn new(data: &'a Dataset, structures: &[ArxStructure]) -> Result<Self, IdentError> {
        let (nu, ny) = (data.nu(), data.ny());
        let mut longest = 0;
        let mut columns: HashMap<Regressor, usize> = HashMap::new();
        let mut order: Vec<Regressor> = Vec::new();
        let present = (0..ny).map(|output| Regressor {
            channel: Channel::Output(output),
            lag: 0,
        });
        for structure in structures {
            longest = longest.max(structure.max_lag(nu));
            for output in 0..ny {
                for each in structure.regressors(output, nu, ny)? {
                    let is_present = each.lag == 0 && matches!(each.channel, Channel::Output(_));
                    if !is_present && !columns.contains_key(&each) {
                        columns.insert(each, order.len());
                        order.push(each);
                    }
                }
            }
        }
        for each in present {
            columns.insert(each, order.len());
            order.push(each);
        }
        let mut records = Records::new(&[data], Missing::Refuse)?;
        records.check_vary(data.inputs(), data.outputs(), |input| {
            order
                .iter()
                .any(|each| each.channel == Channel::Input(input))
        })?;
        for (index, signal) in data.outputs().iter().enumerate() {
            check_varies(signal, data.y().row(index).iter().skip(longest).copied())?;
        }
        let point = records.means();
        records.centre_at(&point);
        let window = Window::new(&records, longest, 0);
        Ok(Self {
            r: triangle(&records, &window, &order, true),
            rows: records.rows(longest, 0),
            columns,
            signals: (data.inputs(), data.outputs()),
            records,
        })
    }

    pub fn ny(&self) -> usize {
        self.records.ny()
    }

    fn place(&self, regressors: &[Regressor]) -> Vec<usize> {
        regressors
            .iter()
            .filter_map(|each| self.columns.get(each).copied())
            .collect()
    }

    fn target(&self, output: usize) -> usize {
        self.r.ncols() - 1 - self.ny() + output
    }

    /// Fits one row by itself.
    pub fn fit(&self, output: usize, regressors: &[Regressor]) -> RowFit {
        let design = self.r.select_columns(&self.place(regressors));
        let target = self.r.select_columns(&[self.target(output)]);
        let solution = LeastSquares::new(&design, &target);
        self.finish(output, regressors, &design, solution)
    }

    /// The residual of a solution, of one without the dependent regressors where there are any.
    fn finish(
        &self,
        output: usize,
        regressors: &[Regressor],
        design: &DMatrix<f64>,
        mut solution: LeastSquares,
    ) -> RowFit {
        let condition = solution.condition;
        let target = self.r.select_columns(&[self.target(output)]);
        let (mut kept, mut left) = (regressors.to_vec(), design.clone());
        let mut refused = None;
        while !solution.full_rank() && !kept.is_empty() {
            refused.get_or_insert_with(|| {
                rank_deficient(&self.records, self.signals, output, &kept, &solution)
            });
            // What a dependent column explains, the others explain as well.
            let mut dependent = solution.dependent();
            if dependent.is_empty() {
                dependent.push(solution.weakest());
            }
            let stay: Vec<usize> = (0..kept.len())
                .filter(|index| !dependent.contains(index))
                .collect();
            kept = stay.iter().map(|&index| kept[index]).collect();
            left = left.select_columns(&stay);
            solution = LeastSquares::new(&left, &target);
        }
        let residual = target.column(0) - &left * solution.coefficients.column(0);
        RowFit {
            residual,
            condition,
            refused,
        }
    }

    /// Fits an output with each of the sets of `steps`, one set within the next where they share a
    /// factorisation: the coefficients of each set are then those of a leading block.
    pub fn fit_steps(&self, output: usize, steps: &[Vec<Regressor>]) -> Vec<RowFit> {
        let mut chains: Vec<Chain> = Vec::new();
        for (step, set) in steps.iter().enumerate() {
            let holds = |chain: &&mut Chain| chain.order.iter().all(|each| set.contains(each));
            if let Some(chain) = chains.iter_mut().find(holds) {
                chain.extend(step, set);
            } else {
                let mut chain = Chain::default();
                chain.extend(step, set);
                chains.push(chain);
            }
        }
        let mut fits: Vec<Option<RowFit>> = steps.iter().map(|_| None).collect();
        for chain in chains {
            for (step, fit) in self.fit_chain(output, &chain) {
                fits[step] = Some(fit);
            }
        }
        fits.into_iter().flatten().collect()
    }

    fn fit_chain(&self, output: usize, chain: &Chain) -> Vec<(usize, RowFit)> {
        let p = chain.order.len();
        let mut chosen = self.place(&chain.order);
        chosen.push(self.target(output));
        let joint = LeastSquares::from_triangle(
            &crate::least_squares::triangular_factor(&self.r.select_columns(&chosen)),
            p,
            0.0,
        );
        let design = self.r.select_columns(&chosen[..p]);
        let target = self.r.column(self.target(output)).into_owned();
        let mut extremes = Extremes::default();
        let mut fits = Vec::with_capacity(chain.lengths.len());
        for &(step, length) in &chain.lengths {
            let block = joint.factor.view((0, 0), (length, length));
            let condition = if length <= DECOMPOSED {
                condition(&block.into_owned())
            } else {
                extremes.condition(&joint.factor, length)
            };
            if condition > CONDITION_LIMIT {
                // Rare: by itself, which finds what is dependent.
                fits.push((step, self.fit(output, &chain.order[..length])));
                continue;
            }
            let mut theta = joint.rotated.rows(0, length).into_owned();
            block.solve_upper_triangular_mut(&mut theta);
            for (value, scale) in theta.iter_mut().zip(&joint.scales) {
                *value /= scale;
            }
            let residual = &target - design.columns(0, length) * theta.column(0);
            fits.push((
                step,
                RowFit {
                    residual,
                    condition,
                    refused: None,
                },
            ));
        }
        fits
    }

    /// The criteria's ingredients for a whole model: its rows' residuals in rotated coordinates.
    pub fn spread(&self, rows: &[&RowFit]) -> Spread {
        let t = self.rows as f64;
        let ones = self.r.column(self.r.ncols() - 1);
        // Inner products in rotated coordinates are those over the window: with the ones, sums.
        let variance =
            |column: &DVector<f64>| column.norm_squared() / t - (column.dot(&ones) / t).powi(2);
        let mut relative = 0.0;
        let mut residual_variance = Vec::with_capacity(rows.len());
        let mut residuals = DMatrix::zeros(self.r.nrows(), rows.len());
        let mut ln_units = 0.0;
        for (output, row) in rows.iter().enumerate() {
            let target = self.r.column(self.target(output)).into_owned();
            relative += variance(&row.residual) / variance(&target);
            let unit = self.records.scale(Channel::Output(output));
            ln_units += 2.0 * unit.ln();
            residual_variance.push(row.residual.norm_squared() / t / unit / unit);
            residuals.set_column(output, &row.residual);
        }
        let triangle = crate::least_squares::triangular_factor(&residuals);
        let squares = triangle.diagonal();
        Spread {
            residual_variance,
            ln_det: squares
                .iter()
                .map(|value| 2.0 * value.abs().ln() - t.ln())
                .sum::<f64>()
                - ln_units,
            relative_variance: relative / rows.len() as f64,
            condition: rows.iter().map(|row| row.condition).fold(1.0, f64::max),
        }
    }
}

/// The residuals of a model over a window.
pub(crate) struct Spread {
    /// Residual sum of squares over T, one per output, in squared units of the output.
    pub residual_variance: Vec<f64>,
    /// `ln det (E E' / T)`.
    pub ln_det: f64,
    /// Variance of the residuals over that of the outputs, the mean of theirs.
    pub relative_variance: f64,
    /// The largest condition.
    pub condition: f64,
}

/// Regressor sets that grow.
#[derive(Default)]
struct Chain {
    order: Vec<Regressor>,
    /// Position of the set, and how many of `order` it has.
    lengths: Vec<(usize, usize)>,
}

impl Chain {
    fn extend(&mut self, step: usize, set: &[Regressor]) {
        for each in set {
            if !self.order.contains(each) {
                self.order.push(*each);
            }
        }
        self.lengths.push((step, self.order.len()));
    }
}

/// Estimates of the extreme singular vectors of growing leading blocks.
#[derive(Default)]
struct Extremes {
    largest: Vec<f64>,
    smallest: Vec<f64>,
}

impl Extremes {
    /// The condition of the leading block of an upper triangular matrix of unit columns, by power
    /// and inverse iterations that start from the vectors of the block before: from below, and to
    /// a few per cent.
    fn condition(&mut self, factor: &DMatrix<f64>, length: usize) -> f64 {
        let block = factor.view((0, 0), (length, length));
        let rounds = if self.largest.is_empty() { 12 } else { 3 };
        self.largest.resize(length, 1.0 / (length as f64).sqrt());
        self.smallest.resize(length, 1.0 / (length as f64).sqrt());
        let mut high = DVector::from_vec(std::mem::take(&mut self.largest));
        let mut low = DVector::from_vec(std::mem::take(&mut self.smallest));
        let (mut most, mut least) = (1.0, 0.0);
        for _ in 0..rounds {
            let norm = scaled_norm(high.iter().copied());
            high /= norm;
            let image = block * &high;
            most = image.norm();
            high = block.tr_mul(&image);
            let norm = scaled_norm(low.iter().copied());
            low /= norm;
            if !block.tr_solve_upper_triangular_mut(&mut low) {
                return f64::INFINITY;
            }
            // |R^-T v| is at most the inverse of the smallest singular value.
            least = 1.0 / scaled_norm(low.iter().copied());
            block.solve_upper_triangular_mut(&mut low);
        }
        let finite = |vector: &DVector<f64>| vector.iter().all(|value| value.is_finite());
        if !finite(&low) || !finite(&high) || least <= 0.0 {
            return f64::INFINITY;
        }
        (self.largest, self.smallest) = (high.as_slice().to_vec(), low.as_slice().to_vec());
        most / least
    }
}
