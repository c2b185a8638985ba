//! The convex set of stable denominators around a stable centre.

use std::f64::consts::PI;

use gt_core::ModelError;
use nalgebra::{Complex, DVector};

use super::fit::ActiveConstraint;
use super::nearest::Constraint;
use crate::denominator::Denominator;

/// `delta`: how far `A / A_c` stays right of the imaginary axis. The smaller, the larger the set;
/// each centre may halve the distance to the boundary by this factor.
const DELTA: f64 = 0.01;
/// Modulus that a reflected pole does not exceed, as a part of the radius.
const REFLECTED: f64 = 0.98;
/// Modulus that no pole of a centre exceeds, as a part of the radius.
const CENTRE: f64 = 0.999;
/// Angles at which a violation is looked for, uniform on 0..=pi.
const FINE: usize = 256;

/// `Re{A / A_c} >= DELTA` on the circle of the given radius.
pub(crate) struct InnerSet {
    /// The centre after `z -> z / radius`: stable on the unit circle.
    centre: Denominator,
    radius: f64,
    na: usize,
}

/// A denominator with its poles moved inside `radius`: those outside are reflected to
/// `radius^2 / conj(p)`, and none stays within rounding of the circle.
pub(crate) fn reflected(unstable: &Denominator, radius: f64) -> Result<Denominator, ModelError> {
    let poles: Vec<Complex<f64>> = unstable
        .divided(radius)
        .poles()?
        .iter()
        .map(|pole| {
            let modulus = pole.norm();
            let target = if modulus > 1.0 {
                (1.0 / modulus).min(REFLECTED)
            } else {
                modulus.min(CENTRE)
            };
            pole * if modulus > 0.0 { target / modulus } else { 1.0 }
        })
        .collect();
    let mut centre = Denominator::from_poles(&poles);
    // Multiple poles move far when the coefficients are rounded.
    while centre.radius()? > 0.5 * (1.0 + CENTRE) {
        centre = centre.divided(1.0 / CENTRE);
    }
    Ok(centre.divided(1.0 / radius))
}

impl InnerSet {
    /// The set around `centre`, whose poles lie inside `radius`; `na` is its degree.
    pub fn new(centre: &Denominator, radius: f64, na: usize) -> Self {
        Self {
            centre: centre.divided(radius),
            radius,
            na,
        }
    }

    /// The angles to begin with: uniform ones and those of the centre's poles.
    pub fn angles(&self) -> Result<Vec<f64>, ModelError> {
        let count = 2 * self.na + 8;
        let mut angles: Vec<f64> = (0..=count)
            .map(|index| PI * index as f64 / count as f64)
            .collect();
        angles.extend(near(&self.centre.poles()?));
        Ok(angles)
    }

    /// The constraint at `omega` on the `p` coefficients of a row, own lags first.
    pub fn constraint(&self, omega: f64, p: usize) -> Constraint {
        let inverse = 1.0 / self.centre.response(omega);
        let mut gradient = DVector::zeros(p);
        let mut power = 1.0;
        for lag in 1..=self.na {
            power /= self.radius;
            let turned = Complex::from_polar(power, -omega * lag as f64) * inverse;
            gradient[lag - 1] = -turned.re;
        }
        Constraint {
            gradient,
            lower: DELTA - inverse.re,
            upper: f64::INFINITY,
            exact: false,
            origin: ActiveConstraint::Stability { angle_rad: omega },
        }
    }

    /// Angles between those of the grid where `found` leaves the set: at each dip of `Re{A / A_c}`
    /// below half of what the grid asks for.
    pub fn violations(&self, found: &Denominator) -> Result<Vec<f64>, ModelError> {
        let scaled = found.divided(self.radius);
        let mut angles: Vec<f64> = (0..=FINE)
            .map(|index| PI * index as f64 / FINE as f64)
            .collect();
        angles.extend(near(&self.centre.poles()?));
        angles.extend(near(&scaled.poles()?));
        angles.sort_by(f64::total_cmp);
        let values: Vec<f64> = angles
            .iter()
            .map(|&omega| (scaled.response(omega) / self.centre.response(omega)).re)
            .collect();
        let dips = (0..angles.len()).filter(|&index| {
            let left = index.checked_sub(1).map_or(f64::INFINITY, |at| values[at]);
            let right = values.get(index + 1).copied().unwrap_or(f64::INFINITY);
            values[index] < 0.5 * DELTA && values[index] <= left && values[index] <= right
        });
        Ok(dips.map(|index| angles[index]).collect())
    }
}

/// Angles around each pole, as close as the pole is to the unit circle.
fn near(poles: &[Complex<f64>]) -> Vec<f64> {
    let mut angles = Vec::new();
    for pole in poles {
        let distance = (1.0 - pole.norm()).abs().clamp(1e-6, 1.0);
        for step in [-3.0, -1.0, -0.3, 0.0, 0.3, 1.0, 3.0] {
            let angle = pole.arg() + step * distance;
            if (0.0..=PI).contains(&angle) {
                angles.push(angle);
            }
        }
    }
    angles
}
