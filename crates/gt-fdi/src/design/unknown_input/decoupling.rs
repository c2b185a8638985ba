//! The part of a model that a disturbance does not reach.

use gt_core::{DimensionError, StateSpace};
use nalgebra::{Complex, DMatrix, DVector, SVD, SymmetricEigen};

use super::super::noise::{NoiseCovariance, symmetrised};
use super::super::riccati::MAX_CLOSED_LOOP_RADIUS;
use super::error::UnknownInputError;
use super::fault_model::{FaultModel, UnknownInput, numbered};
use crate::FdiError;

/// The smallest singular value of `C E`, relative to the norm of C, with which disturbances are
/// told from the outputs: below it, fewer than eight digits of the observer would be left.
pub const MIN_DECOUPLING_GAIN: f64 = 1e-8;
/// The smallest singular value of `[z I - A; C]` at an eigenvalue `z` that is not stable, both
/// parts relative to their norm, with which the mode counts as seen.
pub const MIN_DETECTABILITY: f64 = 1e-8;

/// Singular values that count as 0, relative to the largest.
const RANK_TOLERANCE: f64 = 1e-10;
/// Iterations after which singular values are given up.
const ITERATIONS: usize = 10_000;

/// A model without its disturbances: `xi = W' T x (nx - re)`, `xi(t+1) = A_r xi + B_r [u; y]`,
/// `M (S y - S D u) = C_r xi`, with known right sides.
///
/// `S` scales the outputs. What they show of disturbances at once is used up first:
/// `F_d = U Sigma V'` gives `d_1 = V' d` as `Sigma^-1 U' (y - C x - D u)`, which turns A into
/// `A - E V Sigma^-1 U' C`, makes `y` a known input and leaves the outputs across `U`, `C_1 x`, and
/// the disturbances across `V`, `E_2`. Then `H = E_2 (C_1 E_2)^+` and `T = I - H C_1`, `T E_2 = 0`,
/// of which W is an orthonormal basis: `x = W xi + H y_1`.
pub(super) struct Decoupling {
    /// `A_r`, `B_r` and `C_r`, no direct term; inputs are those of the model and then its outputs.
    pub(super) reduced: StateSpace,
    /// `M S (nr x ny)`, from an output to the left side.
    pub(super) outputs: DMatrix<f64>,
    /// `W' T ((nx - re) x nx)`.
    states: DMatrix<f64>,
    /// `W' T (B_y + A H N) S ((nx - re) x ny)`: what an error of the outputs does to `xi`.
    errors: DMatrix<f64>,
}

impl Decoupling {
    /// Checks whether disturbances can be decoupled, and does so.
    pub(super) fn of(model: &FaultModel) -> Result<Self, FdiError> {
        let (plant, disturbance) = (model.model(), model.disturbance());
        let scale = output_scales(plant, &disturbance.output);
        let (c, d) = (&scale * plant.c(), &scale * plant.d());
        let (e, f) = normalised(disturbance, &scale);

        // What the outputs show at once.
        let seen = Factors::of(&f, 0.0)?;
        let shown = &e * seen.inverse();
        let n = complement(&seen.left)?.transpose();
        let a = plant.a() - &shown * &c;
        let c1 = &n * &c;

        // What they show one step later.
        let rest = &e - &e * &seen.right * seen.right.transpose();
        let e2 = Factors::of(&rest, e.norm())?.left;
        let ce = Factors::of(&(&c1 * &e2), 0.0)?;
        let (rank, left) = (e2.ncols(), c1.nrows());
        // C_1 is a part of rows of unit norm or less; its norm is at least that of what it shows.
        let smallest = ce.smallest(rank) / c1.norm().max(f64::MIN_POSITIVE);
        if rank > 0 && smallest < MIN_DECOUPLING_GAIN {
            let limit = MIN_DECOUPLING_GAIN;
            let found = ce.above(limit * c1.norm());
            return Err(UnknownInputError::HiddenDisturbance {
                expected: rank,
                found,
                smallest,
                limit,
            }
            .into());
        }
        if left <= rank {
            return Err(UnknownInputError::NoOutputLeft {
                disturbances: rank + seen.values.len(),
                outputs: plant.ny(),
            }
            .into());
        }
        let inverse = ce.inverse();
        let h = &e2 * &inverse;
        let annihilated = Factors::of(&(inverse * &c1).transpose(), 0.0)?;
        let w = complement(&annihilated.left)?;
        let states = w.transpose() - w.transpose() * &h * &c1;
        let outputs = complement(&ce.left)?.transpose() * &n;

        let errors = &states * (&shown + &a * &h * &n);
        let (nu, ny, order) = (plant.nu(), plant.ny(), w.ncols());
        let mut b = DMatrix::zeros(order, nu + ny);
        b.columns_mut(0, nu)
            .copy_from(&(&states * plant.b() - &errors * d));
        let errors = errors * &scale;
        b.columns_mut(nu, ny).copy_from(&errors);
        let matrices = [
            &states * &a * &w,
            b,
            &outputs * &c * w,
            DMatrix::zeros(outputs.nrows(), nu + ny),
        ];
        let channels = plant.inputs().iter().chain(plant.outputs());
        let residuals = numbered("r", outputs.nrows());
        let ts = plant.sample_time_s();
        let reduced = StateSpace::new(matrices, ts, channels.cloned().collect(), residuals)?;
        check_detectable(&reduced)?;
        Ok(Self {
            reduced,
            outputs: outputs * scale,
            states,
            errors,
        })
    }

    /// What signals that enter the plant add to `xi(t+1)` and to the left side: `W' T E - (...) F`
    /// and `M S F`.
    pub(super) fn of_input(&self, input: &UnknownInput) -> UnknownInput {
        UnknownInput {
            state: &self.states * &input.state - &self.errors * &input.output,
            output: &self.outputs * &input.output,
        }
    }

    /// The noise of the plant as that of the reduced model.
    pub(super) fn noise(&self, noise: &NoiseCovariance) -> Result<NoiseCovariance, FdiError> {
        self.noise_through(noise, &self.errors, &self.outputs)
    }

    /// As [`Decoupling::noise`], where errors of the outputs enter the state by `-G ((nx - re) x ny)`
    /// and the left side by `M (nr x ny)`.
    pub(super) fn noise_through(
        &self,
        noise: &NoiseCovariance,
        g: &DMatrix<f64>,
        m: &DMatrix<f64>,
    ) -> Result<NoiseCovariance, FdiError> {
        let (nx, ny) = (self.states.ncols(), self.outputs.ncols());
        DimensionError::check("rows of Q (states)", nx, noise.q().nrows())?;
        DimensionError::check("rows of R (outputs)", ny, noise.r().nrows())?;
        let t = &self.states;
        let (q, r, s) = (noise.q(), noise.r(), noise.s());
        let cross = t * s * g.transpose();
        let state = t * q * t.transpose() + g * r * g.transpose() - &cross - cross.transpose();
        let output = m * r * m.transpose();
        NoiseCovariance::new(
            &symmetrised(&state),
            &symmetrised(&output),
            &(t * s * m.transpose() - g * r * m.transpose()),
        )
    }
}

/// One over the norm of each row of `[C F]`, so that the units of the outputs do not matter.
pub(super) fn output_scales(model: &StateSpace, f: &DMatrix<f64>) -> DMatrix<f64> {
    let scales = DVector::from_fn(model.ny(), |row, _| {
        let norm = model.c().row(row).norm().hypot(f.row(row).norm());
        if norm > 0.0 { 1.0 / norm } else { 1.0 }
    });
    DMatrix::from_diagonal(&scales)
}

/// E and the scaled F with columns of one size, so that the units of disturbances do not matter.
fn normalised(input: &UnknownInput, scale: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let scaled = UnknownInput {
        state: input.state.clone(),
        output: scale * &input.output,
    };
    let mut joint = scaled.joint();
    for mut column in joint.column_iter_mut() {
        let norm = column.norm();
        if norm > 0.0 {
            column /= norm;
        }
    }
    let nx = input.state.nrows();
    let output = joint.rows(nx, joint.nrows() - nx).into_owned();
    (joint.rows(0, nx).into_owned(), output)
}

/// A matrix as `left diag(values) right'` without its zero singular values.
struct Factors {
    left: DMatrix<f64>,
    values: Vec<f64>,
    right: DMatrix<f64>,
}

impl Factors {
    /// Singular values below [`RANK_TOLERANCE`] of `scale`, or of the largest where that is
    /// larger, count as zero.
    fn of(matrix: &DMatrix<f64>, scale: f64) -> Result<Self, UnknownInputError> {
        let (rows, columns) = matrix.shape();
        let empty = || Self {
            left: DMatrix::zeros(rows, 0),
            values: Vec::new(),
            right: DMatrix::zeros(columns, 0),
        };
        if matrix.is_empty() {
            return Ok(empty());
        }
        let svd = SVD::try_new(matrix.clone(), true, true, f64::EPSILON, ITERATIONS);
        let Some((svd, (u, v_t))) = svd.and_then(|mut svd| {
            let bases = svd.u.take().zip(svd.v_t.take())?;
            Some((svd, bases))
        }) else {
            let iterations = ITERATIONS;
            return Err(UnknownInputError::NoConvergence { iterations });
        };
        let values = svd.singular_values;
        let limit = RANK_TOLERANCE * values.max().max(scale);
        let kept: Vec<usize> = (0..values.len())
            .filter(|&index| values[index] > limit)
            .collect();
        Ok(Self {
            left: u.select_columns(&kept),
            values: kept.iter().map(|&index| values[index]).collect(),
            right: v_t.select_rows(&kept).transpose(),
        })
    }

    /// The pseudoinverse, `right diag(1 / values) left'`.
    fn inverse(&self) -> DMatrix<f64> {
        let weights = self.values.iter().map(|value| 1.0 / value);
        let weights = DVector::from_iterator(self.values.len(), weights);
        &self.right * DMatrix::from_diagonal(&weights) * self.left.transpose()
    }

    /// The smallest of `count` singular values, 0 where some were taken for zero.
    fn smallest(&self, count: usize) -> f64 {
        if self.values.len() < count {
            0.0
        } else {
            self.values.iter().copied().fold(f64::INFINITY, f64::min)
        }
    }

    /// Number of singular values not below a limit.
    fn above(&self, limit: f64) -> usize {
        self.values.iter().filter(|value| **value >= limit).count()
    }
}

/// An orthonormal basis of what is orthogonal to an orthonormal basis.
fn complement(basis: &DMatrix<f64>) -> Result<DMatrix<f64>, UnknownInputError> {
    let size = basis.nrows();
    let projector = DMatrix::identity(size, size) - basis * basis.transpose();
    if projector.is_empty() || basis.ncols() == 0 {
        return Ok(projector);
    }
    let eigen = SymmetricEigen::try_new(symmetrised(&projector), f64::EPSILON, ITERATIONS).ok_or(
        UnknownInputError::NoConvergence {
            iterations: ITERATIONS,
        },
    )?;
    let kept: Vec<usize> = (0..size)
        .filter(|&index| eigen.eigenvalues[index] > 0.5)
        .collect();
    Ok(eigen.eigenvectors.select_columns(&kept))
}

/// Refuses a mode that is neither stable nor seen (Popov, Belevitch and Hautus).
fn check_detectable(model: &StateSpace) -> Result<(), FdiError> {
    let complex = |matrix: &DMatrix<f64>| {
        let norm = matrix.norm();
        let scale = if norm > 0.0 { 1.0 / norm } else { 1.0 };
        (matrix.map(|value| Complex::new(value * scale, 0.0)), scale)
    };
    let ((a, scale), (c, _)) = (complex(model.a()), complex(model.c()));
    let (nx, ny) = (model.nx(), model.ny());
    for pole in model.poles()? {
        if pole.norm() <= MAX_CLOSED_LOOP_RADIUS {
            continue;
        }
        let mut pencil = DMatrix::zeros(nx + ny, nx);
        pencil.rows_mut(0, nx).copy_from(&-&a);
        pencil.rows_mut(nx, ny).copy_from(&c);
        for state in 0..nx {
            pencil[(state, state)] += pole * scale;
        }
        let smallest = SVD::try_new(pencil, false, false, f64::EPSILON, ITERATIONS)
            .map_or(f64::NAN, |svd| svd.singular_values.min());
        // NaN is refused too.
        if !matches!(
            smallest.partial_cmp(&MIN_DETECTABILITY),
            Some(core::cmp::Ordering::Greater)
        ) {
            return Err(UnknownInputError::UnstableZero {
                modulus: pole.norm(),
                angle_rad: pole.arg().abs(),
                smallest,
                limit: MIN_DETECTABILITY,
            }
            .into());
        }
    }
    Ok(())
}
