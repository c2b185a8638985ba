//! Least squares by refinement: the inner products of the lagged channels precondition, the
//! residuals of the record itself decide.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::Regressor;
use crate::gram::{Gram, Sum};
use crate::kernel::{combine, correlate};
use crate::least_squares::{LeastSquares, condition};
use crate::record::{Records, Taps, Window, taps};

/// Beyond this condition all is left to the QR factorisation: coefficients would still agree with
/// it to 1e-9, but conditions and standard errors, which come from the Gram matrix, no longer to a
/// few per cent.
const REFINED_CONDITION: f64 = 6e7;
/// From here on the Gram matrix has lost so many digits that the weakest direction is measured.
const PROBED_CONDITION: f64 = 1e5;
/// What the last correction may leave of the coefficients' error, relative to them: its size times
/// the rate at which corrections have shrunk. Channels by themselves may keep ten times that: one
/// that explains little has coefficients that are small beside the others' and matter as much.
const LEFT_OVER: f64 = 3e-12;
/// Corrections that no longer shrink are the rounding of the normal residuals, which the QR
/// factorisation has as well; above this size it is the safer of the two.
const FLOOR: f64 = 3e-11;
/// Corrections up to this size may be the last.
const LAST_CORRECTION: f64 = 1e-6;
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
    let mut x = space.up(&start)?;

    let runs = taps(records, regressors);
    let chosen: Vec<usize> = targets
        .iter()
        .map(|t| records.position(t.channel))
        .collect();
    let pass = |x: &DMatrix<f64>, probe: bool| Pass::new(records, window, &runs, &chosen, x, probe);
    let mut memory = Memory::default();
    let mut measured = None;

    let mut now = if first_condition > PROBED_CONDITION {
        let direction = space.weakest()?;
        let mut with_probe = x.clone().insert_column(k, 0.0);
        with_probe.set_column(k, &space.unscaled(&direction));
        let mut both = pass(&with_probe, true);
        both.squares.pop();
        let image = -space.down(&both.sums.columns(k, 1).into_owned())?;
        let image = image.column(0).into_owned();
        let direction = &space.root * direction;
        memory.learn(direction.clone(), image.clone());
        measured = Some((direction, image));
        both.sums = both.sums.columns(0, k).into_owned();
        both
    } else {
        pass(&x, false)
    };
    let mut s = space.down(&now.sums)?;
    // Before a second correction shows the rate, that of rounding in the Gram matrix.
    let mut rate = (p as f64) * f64::EPSILON * first_condition * first_condition;
    let mut previous = f64::INFINITY;
    for _ in 0..PASSES {
        let mut step = DMatrix::zeros(p, k);
        for (index, column) in s.column_iter().enumerate() {
            step.set_column(index, &memory.step(&column.into_owned()));
        }
        let change = space.up(&step)?;
        x += &change;
        let worst =
            (0..k)
                .map(|j| space.relative(&change, &x, j, &runs))
                .fold(0.0, |most: f64, value| {
                    // A maximum that keeps NaN.
                    if value <= most { most } else { value }
                });
        if previous.is_finite() {
            rate = worst / previous;
        }
        // What the correction takes off the sum of squares; where it is most of it, the sum that
        // is left has to be measured.
        let gains: Vec<f64> = (0..k).map(|j| s.column(j).dot(&step.column(j))).collect();
        let squares = gains.iter().zip(&now.squares);
        let known = squares.clone().all(|(gain, square)| *gain < 0.1 * square);
        let settled = worst <= LAST_CORRECTION && worst * rate <= LEFT_OVER && known;
        let floor = worst <= FLOOR && (rate > 0.5 || worst <= LEFT_OVER);
        if settled || floor {
            let factor = corrected(&space.root, measured)?;
            let condition = condition(&factor);
            let squares = squares
                .map(|(gain, square)| if known { square - gain } else { *square })
                .collect();
            return (condition <= REFINED_CONDITION).then(|| LeastSquares {
                coefficients: x,
                squares,
                rotated: DMatrix::zeros(0, 0),
                condition,
                factor,
                scales: space.scales.as_slice().to_vec(),
            });
        }
        if worst.is_nan() || worst >= 0.5 * previous {
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

    /// The size of a change of column `j` beside the whole, in units in which the regressors have
    /// norm 1, and a tenth of that within the worst channel.
    fn relative(&self, change: &DMatrix<f64>, x: &DMatrix<f64>, j: usize, runs: &[Taps]) -> f64 {
        let (mut all, mut worst) = ((0.0, 0.0), 0.0_f64);
        for run in runs {
            let square = |matrix: &DMatrix<f64>| -> f64 {
                let values = run.at.iter().map(|&at| matrix[(at, j)] * self.scales[at]);
                values.map(|value| value * value).sum()
            };
            let own = (square(change), square(x));
            all = (all.0 + own.0, all.1 + own.1);
            if own.0 > 0.0 {
                worst = worst.max(own.0 / own.1);
            }
        }
        if all.0 > 0.0 {
            (all.0 / all.1).sqrt().max(0.1 * worst.sqrt())
        } else {
            all.0
        }
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
}

/// The Cholesky factor of `R' M R` with `M d = image` for the measured direction and the identity
/// beside it. Only that direction counts here: the images of steps hold the rounding of two normal
/// residuals, which a step corrects later and a condition would keep.
fn corrected(
    root: &DMatrix<f64>,
    measured: Option<(DVector<f64>, DVector<f64>)>,
) -> Option<DMatrix<f64>> {
    let Some((direction, image)) = measured else {
        return Some(root.clone());
    };
    let norm = direction.norm();
    let (q, w) = (direction / norm, image / norm);
    let mixed = &w * q.transpose();
    let kept = 1.0 + q.dot(&w);
    let mut m = &mixed + mixed.transpose() - &q * q.transpose() * kept;
    m += DMatrix::identity(root.nrows(), root.nrows());
    Some(Cholesky::new(m)?.l().transpose() * root)
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
