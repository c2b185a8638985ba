//! Structured doubling of discrete Riccati equations.

use nalgebra::DMatrix;

use super::filter_error::FilterError;
use super::riccati::{Factor, MAX_CLOSED_LOOP_RADIUS, MAX_DOUBLINGS};
use super::small_square::SmallSquare;
use crate::runtime::wide::{Simd, Wide, Work};

/// The solution of `P = F P (I + G P)^-1 F' + H` with `F = A - S R^-1 C`, `G = C' R^-1 C`,
/// `H = Q - S R^-1 S'`, and the doublings spent (E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang,
/// Int. J. Control 77, 2004).
///
/// # Errors
/// [`FilterError::NoSteadySolution`] when it does not converge.
pub(super) fn doubling(
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    q: &DMatrix<f64>,
    s: &DMatrix<f64>,
    r: &Factor,
) -> Result<(DMatrix<f64>, usize), FilterError> {
    let (weighted_c, weighted_s) = (r.solve(c), r.solve(&s.transpose()));
    let mut doubled = Doubling::new(
        SmallSquare::from_matrix(&(a - s * &weighted_c).transpose()),
        SmallSquare::from_matrix(&(c.transpose() * weighted_c)),
        SmallSquare::from_matrix(&(q - s * weighted_s)),
    );
    match Wide::new().run(&mut doubled) {
        (Progress::Done, iterations) => Ok((doubled.h.to_matrix(), iterations)),
        (_, iterations) => Err(FilterError::NoSteadySolution {
            limit: MAX_CLOSED_LOOP_RADIUS,
            spectral_radius: f64::NAN,
            relative_residual: f64::NAN,
            iterations,
        }),
    }
}

/// What a doubling came to.
enum Progress {
    Further,
    Done,
    /// A singular matrix, or no finite number.
    Lost,
}

/// The matrices of the iteration, `F` transposed, and room for what lies between.
struct Doubling {
    f: SmallSquare,
    g: SmallSquare,
    h: SmallSquare,
    between: [SmallSquare; 4],
}

/// What the iteration came to, and the doublings spent. Its loops are those of [`SmallSquare`], in
/// the widest registers of the machine.
impl Work for &mut Doubling {
    type Output = (Progress, usize);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (Progress, usize) {
        for iteration in 1..=MAX_DOUBLINGS {
            match self.step(simd) {
                Progress::Further => {}
                end => return (end, iteration),
            }
        }
        (Progress::Further, MAX_DOUBLINGS)
    }
}

impl Doubling {
    fn new(f: SmallSquare, mut g: SmallSquare, mut h: SmallSquare) -> Self {
        g.symmetrise();
        h.symmetrise();
        let between = [(); 4].map(|()| f.clone());
        Self { f, g, h, between }
    }

    /// `F <- F W F`, `G <- G + F W G F'`, `H <- H + F' H W F`, where `W = (I + G H)^-1`.
    #[inline(always)]
    fn step<S: Simd>(&mut self, simd: S) -> Progress {
        let Self { f, g, h, between } = self;
        let [factor, of_f, of_g, room] = between;
        factor.set_product(simd, g, h);
        factor.add_identity();
        of_f.clone_from(f);
        of_g.clone_from(g);
        if !factor.solve(simd, [&mut *of_f, &mut *of_g]) {
            return Progress::Lost;
        }
        room.set_product(simd, f, of_g);
        // From here on the factor is room too, and so is W G.
        let transposed = factor;
        transposed.set_transpose(f);
        of_g.set_product(simd, room, transposed);
        g.add(of_g);
        g.symmetrise();
        room.set_product(simd, transposed, h);
        let change = of_g;
        change.set_product(simd, room, of_f);
        change.symmetrise();
        h.add(change);
        room.set_product(simd, f, of_f);
        core::mem::swap(f, room);
        let (change, norm, left) = (change.norm(), h.norm(), f.norm());
        if !(change.is_finite() && norm.is_finite()) {
            return Progress::Lost;
        }
        // The next change is no larger than that of the last, F' H F.
        if change <= f64::EPSILON * norm || left * left <= f64::EPSILON {
            return Progress::Done;
        }
        Progress::Further
    }
}
