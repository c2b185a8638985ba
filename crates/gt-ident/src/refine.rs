//! Least squares by refinement: the inner products of the lagged channels precondition, the
//! residuals of the record itself decide.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::Regressor;
use crate::gram::{Gram, Sum};
use crate::kernel::{combine, correlate};
use crate::least_squares::{LeastSquares, condition};
use crate::record::{Records, Taps, Window, taps};

/// Beyond this condition the coefficients are left to the QR factorisation: their error against it
/// would grow from 1e-10 to above 1e-8.
pub(crate) const REFINED_CONDITION: f64 = 3e8;
/// From here on the Gram matrix has lost so many digits that the weakest direction is measured.
const PROBED_CONDITION: f64 = 1e6;
/// The relative size of the last correction of the coefficients; what is left after it is smaller
/// again.
const LAST_CORRECTION: f64 = 1e-11;
/// Passes over the record.
const PASSES: usize = 12;

/// The solution for `targets` (positions of channels) at the QR factorisation's accuracy, or
/// nothing where that cannot be had: the QR factorisation is then due.
///
/// With `R` the Cholesky factor of the Gram matrix, each pass over the record computes the true
/// normal residual `s = R^-T Phi' (y - Phi x)`. The matrix `M = R^-T Phi' Phi R^-1` would be the
/// identity without rounding; what passes have shown of it (`M d = s_before - s_after` for a step
/// `d`) is used in the next step, which makes the iteration a conjugate-gradient method with full
/// memory (and, unlike its short recurrences, one whose every residual is a measured one).
pub(crate) fn solve(
    records: &Records,
    window: &Window,
    gram: &Gram,
    regressors: &[Regressor],
    targets: &[Regressor],
) -> Option<LeastSquares> {
    let (p, k) = (regressors.len(), targets.len());
    let product = |a: Regressor, b: Regressor| gram.product(records, a, b);
    let scales: Vec<f64> = regressors.iter().map(|&a| product(a, a).sqrt()).collect();
    if !scales.iter().all(|scale| scale.is_normal()) {
        return None;
    }
    let scaled = DMatrix::from_fn(p, p, |i, j| {
        product(regressors[i], regressors[j]) / (scales[i] * scales[j])
    });
    let root = Cholesky::new(scaled)?.l().transpose();
    let first_condition = condition(&root);
    if first_condition > REFINED_CONDITION {
        return None;
    }
    let space = Space {
        root,
        scales: DVector::from_vec(scales),
    };
    let sums = DMatrix::from_fn(p, k, |i, j| product(regressors[i], targets[j]));
    let start = space.down(&sums)?;
    let reference: Vec<f64> = start.column_iter().map(|column| column.norm()).collect();
    let mut x = space.up(&start)?;

    let runs = taps(records, regressors);
    let chosen: Vec<usize> = targets
        .iter()
        .map(|t| records.position(t.channel))
        .collect();
    let pass = |x: &DMatrix<f64>, probe: bool| Pass::new(records, window, &runs, &chosen, x, probe);
    let mut memory = Memory::default();
    let mut smallest_square = f64::INFINITY;

    let mut now = if first_condition > PROBED_CONDITION {
        let direction = space.weakest()?;
        let mut with_probe = x.clone().insert_column(k, 0.0);
        with_probe.set_column(k, &space.unscaled(&direction));
        let mut both = pass(&with_probe, true);
        smallest_square = both.squares.pop()?;
        let image = -space.down(&both.sums.columns(k, 1).into_owned())?;
        memory.learn(&space.root * direction, image.column(0).into_owned());
        both.sums = both.sums.columns(0, k).into_owned();
        both
    } else {
        pass(&x, false)
    };
    let mut s = space.down(&now.sums)?;
    let mut previous = f64::INFINITY;
    for _ in 0..PASSES {
        let mut step = DMatrix::zeros(p, k);
        for (index, column) in s.column_iter().enumerate() {
            step.set_column(index, &memory.step(&column.into_owned()));
        }
        let change = space.up(&step)?;
        x += &change;
        let relative = (0..k).map(|j| space.size(&change, j) / space.size(&x, j));
        // A target that nothing explains has coefficients that are rounding alone.
        let noise = (0..k).map(|j| s.column(j).norm() / reference[j].max(f64::MIN_POSITIVE));
        let worst = relative
            .zip(noise)
            .map(|(change, noise)| if noise < 1e-15 { 0.0 } else { change })
            .fold(0.0, f64::max);
        if worst <= LAST_CORRECTION {
            let factor = memory.corrected(&space.root)?;
            let measured = condition(&factor);
            // The measured direction bounds the smallest singular value from above.
            let bound = largest_singular_value(&factor) / smallest_square.sqrt();
            let condition = measured.max(bound);
            return (condition <= REFINED_CONDITION).then(|| LeastSquares {
                coefficients: x,
                squares: now.squares,
                rotated: DMatrix::zeros(0, 0),
                condition,
                factor,
                scales: space.scales.as_slice().to_vec(),
            });
        }
        // Written so that NaN ends it too.
        if !(worst < 0.5 * previous) {
            return None;
        }
        previous = worst;
        now = pass(&x, false);
        let after = space.down(&now.sums)?;
        for index in 0..k {
            let image = s.column(index) - after.column(index);
            memory.learn(step.column(index).into_owned(), image);
        }
        s = after;
    }
    None
}

fn largest_singular_value(factor: &DMatrix<f64>) -> f64 {
    (factor.transpose() * factor)
        .symmetric_eigenvalues()
        .max()
        .max(0.0)
        .sqrt()
}

/// The change between coefficients and the coordinates in which the Gram matrix is the identity.
struct Space {
    root: DMatrix<f64>,
    scales: DVector<f64>,
}

impl Space {
    /// `R^-T D^-1 sums`.
    fn down(&self, sums: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let mut scaled = sums.clone();
        for mut column in scaled.column_iter_mut() {
            column.component_div_assign(&self.scales);
        }
        self.root.tr_solve_upper_triangular(&scaled)
    }

    /// `D^-1 R^-1 z`.
    fn up(&self, z: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let mut x = self.root.solve_upper_triangular(z)?;
        for mut column in x.column_iter_mut() {
            column.component_div_assign(&self.scales);
        }
        Some(x)
    }

    fn unscaled(&self, direction: &DVector<f64>) -> DVector<f64> {
        direction.component_div(&self.scales)
    }

    /// The norm of column `j` in units in which the regressors have norm 1.
    fn size(&self, x: &DMatrix<f64>, j: usize) -> f64 {
        x.column(j).component_mul(&self.scales).norm()
    }

    /// The right singular vector of the smallest singular value, by inverse iteration: three
    /// rounds leave of the others what the cube of the ratio of squares does.
    fn weakest(&self) -> Option<DVector<f64>> {
        let p = self.root.ncols();
        let mut v = DVector::from_element(p, 1.0 / (p as f64).sqrt());
        for _ in 0..3 {
            let half = self.root.tr_solve_upper_triangular(&v)?;
            v = self.root.solve_upper_triangular(&half)?;
            let norm = v.norm();
            if !norm.is_normal() {
                return None;
            }
            v /= norm;
        }
        Some(v)
    }
}

/// What passes have shown of `M`: directions and their images, the images orthonormal.
#[derive(Default)]
struct Memory {
    directions: Vec<DVector<f64>>,
    images: Vec<DVector<f64>>,
}

impl Memory {
    fn learn(&mut self, mut direction: DVector<f64>, mut image: DVector<f64>) {
        let size = image.norm();
        // Twice is enough for orthogonality.
        for _ in 0..2 {
            for (known, shown) in self.directions.iter().zip(&self.images) {
                let part = shown.dot(&image);
                image.axpy(-part, shown, 1.0);
                direction.axpy(-part, known, 1.0);
            }
        }
        let norm = image.norm();
        if norm > 1e-6 * size && norm.is_normal() {
            self.directions.push(direction / norm);
            self.images.push(image / norm);
        }
    }

    /// `M^-1 s` as far as is known, `s` elsewhere.
    fn step(&self, s: &DVector<f64>) -> DVector<f64> {
        let mut rest = s.clone();
        let mut step = DVector::zeros(s.len());
        for (direction, image) in self.directions.iter().zip(&self.images) {
            let part = image.dot(s);
            rest.axpy(-part, image, 1.0);
            step.axpy(part, direction, 1.0);
        }
        step + rest
    }

    /// The Cholesky factor of `R' M R`, `M` the identity where it is not known.
    fn corrected(&self, root: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let p = root.ncols();
        let (mut basis, mut shown): (Vec<DVector<f64>>, Vec<DVector<f64>>) = (vec![], vec![]);
        for (direction, image) in self.directions.iter().zip(&self.images) {
            let (mut q, mut w) = (direction.clone(), image.clone());
            let size = q.norm();
            for _ in 0..2 {
                for (known, seen) in basis.iter().zip(&shown) {
                    let part = known.dot(&q);
                    q.axpy(-part, known, 1.0);
                    w.axpy(-part, seen, 1.0);
                }
            }
            let norm = q.norm();
            if norm > 1e-6 * size {
                basis.push(q / norm);
                shown.push(w / norm);
            }
        }
        let mut m = DMatrix::identity(p, p);
        if !basis.is_empty() {
            let (q, w) = (DMatrix::from_columns(&basis), DMatrix::from_columns(&shown));
            let inner = q.tr_mul(&w);
            let inner = (&inner + inner.transpose()) * 0.5;
            let mixed = &w * q.transpose();
            m += &mixed + mixed.transpose() - &q * inner * q.transpose() - &q * q.transpose();
        }
        let correction = Cholesky::new(m)?.l().transpose();
        Some(correction * root)
    }
}

/// One pass over the record: the normal residuals and the residual sums of squares.
struct Pass {
    sums: DMatrix<f64>,
    squares: Vec<f64>,
}

impl Pass {
    /// `Phi' (y - Phi x)` and `|y - Phi x|^2` for each column of `x`; with `probe` the last column
    /// has no target.
    fn new(
        records: &Records,
        window: &Window,
        runs: &[Taps],
        targets: &[usize],
        x: &DMatrix<f64>,
        probe: bool,
    ) -> Self {
        let (p, k) = x.shape();
        let mut sums = vec![Sum::default(); p * k];
        let mut squares = vec![Sum::default(); k];
        let longest = runs.iter().map(|run| run.at.len()).max().unwrap_or(0);
        let (mut error, mut part) = (Vec::new(), vec![0.0; longest]);
        let negated: Vec<Vec<Vec<f64>>> = (0..k)
            .map(|j| {
                let run = |run: &Taps| run.at.iter().map(|&at| -x[(at, j)]).collect();
                runs.iter().map(run).collect()
            })
            .collect();
        records.for_each_block(window, |block| {
            for j in 0..k {
                error.clear();
                if probe && j + 1 == k {
                    error.resize(block.rows(), 0.0);
                } else {
                    error.extend_from_slice(block.lagged(targets[j], 0));
                }
                for (run, coefficients) in runs.iter().zip(&negated[j]) {
                    let high = run.low + run.at.len() - 1;
                    let samples = block.lags(run.position, run.low, high);
                    combine(coefficients, samples, &mut error);
                }
                let mut square = [0.0];
                correlate(&error, &error, &mut square);
                squares[j].add(square[0]);
                for run in runs {
                    let high = run.low + run.at.len() - 1;
                    let part = &mut part[..run.at.len()];
                    part.fill(0.0);
                    correlate(&error, block.lags(run.position, run.low, high), part);
                    for (&at, &value) in run.at.iter().zip(part.iter()) {
                        sums[j * p + at].add(value);
                    }
                }
            }
        });
        let sums = sums.iter().map(Sum::value);
        Self {
            sums: DMatrix::from_iterator(p, k, sums),
            squares: squares.iter().map(Sum::value).collect(),
        }
    }
}
