//! The poles that an observer was given.

use nalgebra::{Complex, DVector};
use serde::{Deserialize, Serialize};

use super::super::observer::{check_pole_count, check_poles, place, place_complex};
use super::PlacementError;
use crate::FdiError;
use gt_core::StateSpace;

/// The poles of an observer as a file has them: numbers when all are real, else pairs `[re, im]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(in crate::design) enum PlacedPoles {
    Real(Vec<f64>),
    Complex(Vec<Complex<f64>>),
}

impl PlacedPoles {
    pub(in crate::design) fn new(poles: &[Complex<f64>]) -> Self {
        if poles.iter().all(|pole| pole.im == 0.0) {
            Self::Real(poles.iter().map(|pole| pole.re).collect())
        } else {
            Self::Complex(poles.to_vec())
        }
    }

    /// The poles when all of them are real, else none.
    pub(in crate::design) fn real(&self) -> &[f64] {
        match self {
            Self::Real(poles) => poles,
            Self::Complex(_) => &[],
        }
    }

    pub(in crate::design) fn complex(&self) -> Vec<Complex<f64>> {
        match self {
            Self::Real(poles) => poles.iter().map(|&re| Complex::new(re, 0.0)).collect(),
            Self::Complex(poles) => poles.clone(),
        }
    }

    /// Refuses what is not the list of poles of an observer of `nx` states.
    pub(in crate::design) fn check(&self, nx: usize) -> Result<(), FdiError> {
        match self {
            Self::Real(poles) => check_poles(nx, poles),
            Self::Complex(poles) => check_complex(nx, poles),
        }
    }

    /// The gain that places them.
    pub(in crate::design) fn place(&self, model: &StateSpace) -> Result<DVector<f64>, FdiError> {
        match self {
            Self::Real(poles) => place(model, poles),
            Self::Complex(poles) => place_complex(model, poles),
        }
    }
}

/// Refuses a wrong number of poles, poles that are not inside the unit circle and a pole without
/// its conjugate.
pub(in crate::design) fn check_complex(nx: usize, poles: &[Complex<f64>]) -> Result<(), FdiError> {
    check_pole_count(nx, poles.len())?;
    for (index, pole) in poles.iter().enumerate() {
        let found = pole.norm();
        if found.is_nan() || found >= 1.0 {
            return Err(FdiError::PoleOutside { index, found });
        }
    }
    pair(poles).map(|_| ()).map_err(FdiError::from)
}

/// Where each pole's conjugate stands, its own position for a real pole. Conjugates are paired in
/// the order of the list, and must agree bit for bit.
pub(in crate::design) fn pair(poles: &[Complex<f64>]) -> Result<Vec<usize>, PlacementError> {
    let mut partners: Vec<Option<usize>> = vec![None; poles.len()];
    for (index, &found) in poles.iter().enumerate() {
        if !(found.re.is_finite() && found.im.is_finite()) {
            return Err(PlacementError::NotFinite { index, found });
        }
        if found.im == 0.0 {
            partners[index] = Some(index);
        } else if partners[index].is_none() {
            let partner = (index + 1..poles.len())
                .find(|&other| partners[other].is_none() && poles[other] == found.conj())
                .ok_or(PlacementError::Unpaired { index, found })?;
            partners[index] = Some(partner);
            partners[partner] = Some(index);
        }
    }
    // Every pole got one, or an error came first.
    Ok(partners.into_iter().flatten().collect())
}

/// Coefficients of the monic polynomial with these roots, that of `z^l` at index `l`; complex
/// roots come in pairs, whose quadratic factors are real.
pub(in crate::design) fn polynomial(roots: &[Complex<f64>]) -> Result<Vec<f64>, PlacementError> {
    let mut coefficients = vec![1.0];
    for (index, (root, partner)) in roots.iter().zip(pair(roots)?).enumerate() {
        if partner == index {
            times(&mut coefficients, &[-root.re]);
        } else if partner > index {
            times(&mut coefficients, &[root.norm_sqr(), -2.0 * root.re]);
        }
    }
    Ok(coefficients)
}

/// Multiplies by a monic polynomial, of which `lower` holds all but the leading coefficient.
fn times(coefficients: &mut Vec<f64>, lower: &[f64]) {
    let degree = lower.len();
    let mut product = vec![0.0; coefficients.len() + degree];
    product[degree..].copy_from_slice(coefficients);
    for (l, value) in coefficients.iter().enumerate() {
        for (k, factor) in lower.iter().enumerate() {
            product[l + k] += factor * value;
        }
    }
    *coefficients = product;
}
