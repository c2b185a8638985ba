//! The discrete algebraic Riccati equation of a steady filter.

use gt_core::DimensionError;
use nalgebra::{Cholesky, DMatrix};

use super::doubling::doubling;
use super::filter_error::FilterError;
use super::gains::{ClosedLoop, Process};
use super::noise::{check_finite, check_symmetric, symmetrised};
use super::settling::spectral_radius;
use super::small_square::{SmallSquare, congruence};
use crate::FdiError;

/// The largest spectral radius of `A - K C` at which a solution counts as stabilising: slower than
/// a thousand million samples is not told from never.
pub const MAX_CLOSED_LOOP_RADIUS: f64 = 1.0 - 1e-9;
/// The largest relative residual of the equation that is accepted. Where the outputs hardly show a
/// growing mode, so that `P` is more than some 1e8 times the noise, rounding alone may exceed it:
/// then nothing is said of `P`.
pub const MAX_RICCATI_RESIDUAL: f64 = 1e-8;
/// Doublings after which the equation is given up; `2^40` steps of the recursion.
pub const MAX_DOUBLINGS: usize = 40;

/// Newton steps at most, as long as they lessen the residual; one does but for the worst equations.
const NEWTON_STEPS: usize = 3;
/// Newton steps at most where the residual is still above [`REFINED_RESIDUAL`]. From a gain that
/// stabilises they converge, quadratically unless an eigenvalue tends to the unit circle, where each
/// halves its distance: too few steps for that to pass.
const MOST_NEWTON_STEPS: usize = 12;
/// The relative residual that is rounding, which no Newton step lessens.
const ROUNDING_RESIDUAL: f64 = 4.0 * f64::EPSILON;
/// The relative residual at which no further Newton steps are made.
const REFINED_RESIDUAL: f64 = 1e-12;
/// What is added to Q, relative to its norm, for a gain to begin with where the doubling fails.
const REGULARISATION: f64 = 0.01;

/// The smallest pivot of R, relative to its diagonal, with which the cross term is taken out of the
/// equation as it stands; below it the equation is shifted first.
const SMALLEST_PIVOT: f64 = 1e-6;

/// The stabilising solution of a discrete algebraic Riccati equation.
#[derive(Debug, Clone, PartialEq)]
pub struct Riccati {
    /// `P (nx x nx)`, symmetric.
    pub p: DMatrix<f64>,
    /// Frobenius norm of what the equation's two sides are apart, relative to the largest of those
    /// of `P`, `A P A'` and `Q`: where an output shows the noise, `P` may be no more than rounding.
    pub relative_residual: f64,
    /// Largest modulus of the eigenvalues of `A - K C`, `K = (A P C' + S)(C P C' + R)^-1`.
    pub spectral_radius: f64,
    /// Doublings spent.
    pub iterations: usize,
}

impl Riccati {
    /// Solves `P = A P A' - (A P C' + S)(C P C' + R)^-1 (A P C' + S)' + Q` for the `P (nx x nx)`
    /// that puts the eigenvalues of `A - K C` inside the unit circle.
    ///
    /// Shapes: `A (nx x nx)`, `C (ny x nx)`, `Q (nx x nx)`, `R (ny x ny)`, `S (nx x ny)`. The
    /// equation of a regulator, `X = A'XA - (A'XB + S)(B'XB + R)^-1 (A'XB + S)' + Q`, is that of
    /// `A'` and `B'`. `Q` and `R` are symmetric, and need be definite in no sense as long as
    /// `C P C' + R` is positive definite; `A` may be singular.
    ///
    /// The cross term goes into `A - S R^-1 C` and `Q - S R^-1 S'`. For a singular `R` the unknown
    /// is `P - w I` first, which has the same equation with `R + w C C'`, `S + w A C'` and
    /// `Q + w (A A' - I)`. Then structured doubling (E. K.-W. Chu, H.-Y. Fan, W.-W. Lin,
    /// C.-S. Wang, Int. J. Control 77, 2004) and Newton's steps on the equation as it was given.
    ///
    /// # Errors
    /// [`FdiError::Dimension`] for sizes that disagree; [`FilterError::NotFinite`],
    /// [`FilterError::NotSymmetric`]; [`FilterError::SingularInnovation`] when `C P C' + R` is not
    /// positive definite; [`FilterError::NoSteadySolution`] when the doubling does not converge,
    /// the residual stays above [`MAX_RICCATI_RESIDUAL`] or the closed loop's spectral radius above
    /// [`MAX_CLOSED_LOOP_RADIUS`], for example of a pair that is not detectable.
    pub fn solve(
        a: &DMatrix<f64>,
        c: &DMatrix<f64>,
        q: &DMatrix<f64>,
        r: &DMatrix<f64>,
        s: &DMatrix<f64>,
    ) -> Result<Self, FdiError> {
        let (nx, ny) = (a.nrows(), c.nrows());
        DimensionError::check("columns of A", nx, a.ncols())?;
        DimensionError::check("columns of C", nx, c.ncols())?;
        DimensionError::check("rows of Q", nx, q.nrows())?;
        DimensionError::check("rows of R", ny, r.nrows())?;
        DimensionError::check("rows of S", nx, s.nrows())?;
        DimensionError::check("columns of S", ny, s.ncols())?;
        check_symmetric("Q", q)?;
        check_symmetric("R", r)?;
        for (name, matrix) in [("A", a), ("C", c), ("S", s)] {
            check_finite(name, matrix)?;
        }
        let (q, r) = (&symmetrised(q), &symmetrised(r));
        Ok(Self::of(Process { a, c, q, r, s })?)
    }

    /// As [`Riccati::solve`], of matrices that are known to fit.
    pub(super) fn of(process: Process) -> Result<Self, FilterError> {
        match Self::by_doubling(process) {
            Err(error @ FilterError::NoSteadySolution { .. }) => {
                Self::from_regularised(process).ok_or(error)
            }
            // With a definite R there is no singular C P C' + R but by rounding.
            Err(FilterError::SingularInnovation) if well_conditioned(process.r).is_some() => {
                Self::from_regularised(process).ok_or(FilterError::SingularInnovation)
            }
            other => other,
        }
    }

    /// Newton's steps from the gain of the equation with a larger Q. Without noise of its own, a
    /// growing mode of `A - S R^-1 C` is nothing that the doubling sees: as many noises as outputs
    /// and a zero outside the unit circle, for example.
    fn from_regularised(process: Process) -> Option<Self> {
        let nx = process.a.nrows();
        let size = match process.q.norm() {
            // Without any, what C makes a share of R.
            0.0 => process.r.norm() / process.c.norm_squared(),
            norm => norm / (nx.max(1) as f64).sqrt(),
        };
        let size = REGULARISATION * size;
        if size == 0.0 || !size.is_finite() {
            return None;
        }
        let q = process.q + DMatrix::identity(nx, nx) * size;
        let (p, iterations) = reduced(Process { q: &q, ..process }).ok()?;
        let mut found = Candidate::new(process, p).ok()?;
        for _ in 0..MOST_NEWTON_STEPS {
            found = found.refined(process)?;
            if found.relative_residual <= REFINED_RESIDUAL {
                let found = found.judged(iterations);
                return (found.spectral_radius <= MAX_CLOSED_LOOP_RADIUS).then_some(found);
            }
        }
        None
    }

    fn by_doubling(process: Process) -> Result<Self, FilterError> {
        let (p, iterations) = reduced(process)?;
        let mut best = Candidate::new(process, p)?;
        for step in 0..MOST_NEWTON_STEPS {
            let enough = if step < NEWTON_STEPS {
                ROUNDING_RESIDUAL
            } else {
                REFINED_RESIDUAL
            };
            if best.relative_residual <= enough {
                break;
            }
            match best.refined(process) {
                Some(refined) if refined.relative_residual < best.relative_residual => {
                    best = refined;
                }
                _ => break,
            }
        }
        let best = best.judged(iterations);
        if best.relative_residual <= MAX_RICCATI_RESIDUAL
            && best.spectral_radius <= MAX_CLOSED_LOOP_RADIUS
        {
            Ok(best)
        } else {
            Err(FilterError::NoSteadySolution {
                limit: MAX_CLOSED_LOOP_RADIUS,
                spectral_radius: best.spectral_radius,
                relative_residual: best.relative_residual,
                iterations,
            })
        }
    }
}

/// What may be a solution, with what is left of the equation.
struct Candidate {
    p: DMatrix<f64>,
    relative_residual: f64,
    closed: ClosedLoop,
}

impl Candidate {
    fn new(process: Process, p: DMatrix<f64>) -> Result<Self, FilterError> {
        let closed = ClosedLoop::of(process, &p)?;
        let own = SmallSquare::from_matrix(&p);
        // In Joseph's form, which the rounding of the gain enters as its square only: where an
        // output hardly shows a large P, that of the other form hides the residual.
        let mut next = congruence(&closed.a, &own);
        next.add(&SmallSquare::from_matrix(&closed.added));
        next.symmetrise();
        next.subtract(&own);
        let residual = next.norm();
        let carried = congruence(process.a, &own).norm();
        let scale = own.norm().max(carried).max(process.q.norm());
        Ok(Self {
            relative_residual: if residual == 0.0 {
                0.0
            } else {
                residual / scale
            },
            p,
            closed,
        })
    }

    /// A Newton step: from a gain that stabilises, `P = F P F' + (what the noise adds)`.
    fn refined(&self, process: Process) -> Option<Self> {
        let p = stein(self.closed.a.clone(), &self.closed.added)?;
        Self::new(process, p).ok()
    }

    fn judged(self, iterations: usize) -> Riccati {
        Riccati {
            spectral_radius: spectral_radius(&self.closed.a),
            relative_residual: self.relative_residual,
            p: self.p,
            iterations,
        }
    }
}

/// The solution by doubling of the equation without its cross term, shifted where R is singular.
fn reduced(process: Process) -> Result<(DMatrix<f64>, usize), FilterError> {
    let Process { a, c, q, r, s } = process;
    let nx = a.nrows();
    if let Some(factor) = well_conditioned(r) {
        return doubling(a, c, q, s, &factor);
    }
    let size = q.norm() / (nx.max(1) as f64).sqrt();
    let shift = if size > 0.0 { size } else { 1.0 };
    let act = a * c.transpose();
    let r = symmetrised(&(r + shift * (c * c.transpose())));
    let s = s + shift * act;
    let q = q + shift * (a * a.transpose() - DMatrix::identity(nx, nx));
    let factor = Cholesky::new(r).ok_or(FilterError::SingularInnovation)?;
    let (p, iterations) = doubling(a, c, &q, &s, &factor)?;
    Ok((p + shift * DMatrix::identity(nx, nx), iterations))
}

pub(super) type Factor = Cholesky<f64, nalgebra::Dyn>;

/// The factor of R, unless R is singular to within [`SMALLEST_PIVOT`].
fn well_conditioned(r: &DMatrix<f64>) -> Option<Factor> {
    let factor = Cholesky::new(r.clone())?;
    let well = (0..r.nrows())
        .all(|row| factor.l_dirty()[(row, row)] >= SMALLEST_PIVOT * r[(row, row)].sqrt());
    well.then_some(factor)
}

/// `X = F X F' + M` by squaring F, or `None` when the sum does not converge.
fn stein(mut f: DMatrix<f64>, m: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut x = symmetrised(m);
    for _ in 0..MAX_DOUBLINGS {
        let step = symmetrised(&(&f * &x * f.transpose()));
        x += &step;
        f = &f * &f;
        if !x.norm().is_finite() {
            return None;
        }
        if step.norm() <= f64::EPSILON * x.norm() {
            return Some(x);
        }
    }
    None
}
