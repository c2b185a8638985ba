//! A pole or a zero with its covariance.

use nalgebra::{Complex, DMatrix, Matrix2};
use serde::Serialize;

use crate::Estimate;
use crate::transfer::{propagate, standard_error};

/// A root that has another root of the same polynomial within this many standard errors is not
/// told from a double one: to first order nothing can be said about its error.
pub const RESOLUTION: f64 = 2.0;

/// A pole or a zero `z` of the discrete model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Root {
    /// Its place in the plane of `z`.
    pub value: Complex<f64>,
    /// Covariance of its real and imaginary part (delta method); `None` where it is not resolved
    /// from another root of the same polynomial (see [`RESOLUTION`]).
    pub covariance: Option<Matrix2<f64>>,
    /// Derivatives by the coefficients, row by row.
    #[serde(skip)]
    pub(crate) gradient: Vec<(usize, Vec<Complex<f64>>)>,
}

impl Root {
    /// A root that the structure puts at the origin, without error.
    pub(crate) fn at_origin() -> Self {
        Self {
            value: Complex::new(0.0, 0.0),
            covariance: Some(Matrix2::zeros()),
            gradient: Vec::new(),
        }
    }

    /// The covariance of the differences of two roots of the same model.
    pub(crate) fn covariance_of_difference(
        &self,
        other: &Self,
        covariances: &[DMatrix<f64>],
    ) -> Matrix2<f64> {
        let mut total = Matrix2::zeros();
        for (row, covariance) in covariances.iter().enumerate() {
            let mut difference = vec![Complex::new(0.0, 0.0); covariance.nrows()];
            for (root, sign) in [(self, 1.0), (other, -1.0)] {
                for (_, gradient) in root.gradient.iter().filter(|(index, _)| *index == row) {
                    for (sum, value) in difference.iter_mut().zip(gradient) {
                        *sum += value * sign;
                    }
                }
            }
            total += propagate(&difference, covariance);
        }
        total
    }

    /// The standard error of its place, `sqrt(var re + var im)`.
    pub fn standard_error(&self) -> Option<f64> {
        self.covariance
            .map(|covariance| covariance.trace().max(0.0).sqrt())
    }

    /// `|z|`; below 1 a pole is stable.
    pub fn magnitude(&self) -> Estimate {
        let size = self.value.norm();
        let (re, im) = (self.value.re, self.value.im);
        let standard_error = self
            .covariance
            .filter(|_| size > 0.0)
            .map(|covariance| standard_error([re / size, im / size], &covariance));
        Estimate {
            value: size,
            standard_error,
        }
    }

    /// The time constant `-Ts / ln |z|` in seconds; `None` outside `0 < |z| < 1`.
    pub fn time_constant_s(&self, sample_time_s: f64) -> Option<Estimate> {
        let (decay, _) = self.logarithm()?;
        (decay < 0.0)
            .then(|| self.estimate(-sample_time_s / decay, sample_time_s / (decay * decay), 0.0))
    }

    /// The damping ratio `-ln |z| / |ln z|`: 1 for a real positive stable root, 0 on the unit
    /// circle. `None` for 0 and 1.
    pub fn damping(&self) -> Option<Estimate> {
        let (decay, angle) = self.logarithm()?;
        let size = decay.hypot(angle);
        (size > 0.0).then(|| {
            let cube = size.powi(3);
            self.estimate(-decay / size, -angle * angle / cube, decay * angle / cube)
        })
    }

    /// The natural frequency `|ln z| / (2 pi Ts)` in Hz. `None` for 0 and 1.
    pub fn natural_frequency_hz(&self, sample_time_s: f64) -> Option<Estimate> {
        let (decay, angle) = self.logarithm()?;
        let size = decay.hypot(angle);
        let unit = std::f64::consts::TAU * sample_time_s;
        (size > 0.0).then(|| self.estimate(size / unit, decay / size / unit, angle / size / unit))
    }

    /// `ln z`, the continuous root times the sample time; `None` at the origin.
    fn logarithm(&self) -> Option<(f64, f64)> {
        let size = self.value.norm();
        (size > 0.0).then(|| (size.ln(), self.value.arg()))
    }

    /// A function of `ln z` with its derivatives by the real and the imaginary part of that.
    fn estimate(&self, value: f64, by_decay: f64, by_angle: f64) -> Estimate {
        // d ln z = dz / z.
        let inverse = self.value.inv();
        let gradient = [
            by_decay * inverse.re + by_angle * inverse.im,
            by_angle * inverse.re - by_decay * inverse.im,
        ];
        let standard_error = self
            .covariance
            .map(|covariance| standard_error(gradient, &covariance))
            .filter(|error| error.is_finite());
        Estimate {
            value,
            standard_error,
        }
    }
}
