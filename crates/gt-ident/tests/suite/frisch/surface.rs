//! Identities of the admissible surface on random covariances.

use gt_ident::eiv::EivLags;
use gt_ident::frisch::{AdmissibleSurface, SurfacePoint};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::common::{cases, generator, normal_matrix};

/// Relative to the size of the covariance, whose condition is below 1e5 here.
const TOLERANCE: f64 = 1e-9;

/// A random covariance and its lags; entries of one channel share a scale.
struct Case {
    lags: EivLags,
    sigma: DMatrix<f64>,
    channels: Vec<usize>,
    rng: ChaCha8Rng,
}

impl Case {
    fn new(seed: u64) -> Self {
        let mut rng = generator(seed);
        let order = rng.random_range(1..=3);
        let nk: Vec<usize> = (0..rng.random_range(0..=3))
            .map(|_| rng.random_range(0..=order))
            .collect();
        let mut channels = vec![0; order + 1];
        for (input, first) in nk.iter().enumerate() {
            channels.extend(std::iter::repeat_n(input + 1, order + 1 - first));
        }
        let lags = EivLags::new(order, nk).unwrap();
        let size = channels.len();
        let root = normal_matrix(&mut rng, size + 2, size);
        let sigma = root.tr_mul(&root) + DMatrix::identity(size, size) * 0.01;
        Self {
            lags,
            sigma,
            channels,
            rng,
        }
    }

    fn surface(&self) -> AdmissibleSurface {
        AdmissibleSurface::of_covariance(&self.lags, &self.sigma).unwrap()
    }

    fn direction(&mut self) -> Vec<f64> {
        let count = self.lags.inputs() + 1;
        (0..count)
            .map(|_| self.rng.random_range(0.05..1.0))
            .collect()
    }

    /// The covariance without the noise of a point.
    fn compensated(&self, point: &SurfacePoint) -> DMatrix<f64> {
        let noise = self.channels.iter().map(|&c| point.variances[c]);
        let diagonal = DVector::from_iterator(self.channels.len(), noise);
        &self.sigma - DMatrix::from_diagonal(&diagonal)
    }

    /// The point is on the surface and its relation is the null vector.
    fn check(&self, point: &SurfacePoint) -> Result<(), TestCaseError> {
        let compensated = self.compensated(point);
        let size = self.sigma.norm();
        let smallest = compensated.clone().symmetric_eigenvalues().min();
        prop_assert!(smallest.abs() <= TOLERANCE * size, "smallest {smallest:e}");
        prop_assert_eq!(point.relation[0], 1.0);
        let left = (&compensated * &point.relation).norm();
        prop_assert!(
            left <= TOLERANCE * size * point.relation.norm(),
            "left {left:e}"
        );
        Ok(())
    }
}

fn near(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= TOLERANCE * scale
}

proptest! {
    #![proptest_config(cases(300))]

    /// A ray is hit where the compensated covariance is singular and nothing before is.
    #[test]
    fn prop_rays_end_on_the_surface(seed in any::<u64>()) {
        let mut case = Case::new(seed);
        let surface = case.surface();
        let direction = case.direction();
        let point = surface.along(&direction).unwrap();
        case.check(&point)?;
        let length = point.variances[0] / direction[0];
        for (channel, entry) in direction.iter().enumerate() {
            let variance = point.variances[channel];
            prop_assert!(near(variance, length * entry, variance));
            prop_assert!(variance <= surface.intercepts()[channel] * (1.0 + TOLERANCE));
            // An axis meets the surface at its intercept.
            let mut axis = vec![0.0; direction.len()];
            axis[channel] = 3.0;
            let own = surface.intercepts()[channel];
            let corner = surface.along(&axis).unwrap();
            prop_assert!(near(corner.variances[channel], own, own));
            case.check(&corner)?;
        }
    }

    /// The Schur complement and the ray meet the surface in the same point.
    #[test]
    fn prop_input_variances_give_the_point_of_the_ray(seed in any::<u64>()) {
        let mut case = Case::new(seed);
        let surface = case.surface();
        let direction = case.direction();
        let inside = case.rng.random_range(0.0..1.0);
        let edge = surface.along(&direction).unwrap();
        let inputs: Vec<f64> = edge.variances[1..].iter().map(|v| v * inside).collect();
        let point = surface.at_inputs(&inputs).unwrap();
        case.check(&point)?;
        prop_assert_eq!(&point.variances[1..], &inputs[..]);
        let ray = surface.along(&point.variances).unwrap();
        for (a, b) in point.variances.iter().zip(&ray.variances) {
            prop_assert!(near(*a, *b, surface.intercepts()[0].max(*b)), "{a} {b}");
        }
        // Less noise on the inputs leaves room for more on the output.
        prop_assert!(point.variances[0] >= edge.variances[0] * (1.0 - 1e-6));
        if !inputs.is_empty() {
            let beyond: Vec<f64> = surface.intercepts()[1..].iter().map(|v| v * 1.01).collect();
            prop_assert!(surface.at_inputs(&beyond).is_err());
        }
    }

    /// Channels in other units: variances by the square, coefficients by the ratio of the units.
    #[test]
    fn prop_units_scale_the_point(seed in any::<u64>()) {
        let mut case = Case::new(seed);
        let direction = case.direction();
        let point = case.surface().along(&direction).unwrap();
        let powers: Vec<f64> = direction
            .iter()
            .map(|_| 2.0_f64.powi(case.rng.random_range(-12..12)))
            .collect();
        let channels = case.channels.clone();
        let scale = |row: usize| powers[channels[row]];
        let scaled = DMatrix::from_fn(channels.len(), channels.len(), |i, j| {
            case.sigma[(i, j)] * scale(i) * scale(j)
        });
        let surface = AdmissibleSurface::of_covariance(&case.lags, &scaled).unwrap();
        let there: Vec<f64> = direction.iter().zip(&powers).map(|(d, s)| d * s * s).collect();
        let other = surface.along(&there).unwrap();
        for (channel, power) in powers.iter().enumerate() {
            let expected = point.variances[channel] * power * power;
            prop_assert!(near(other.variances[channel], expected, expected));
        }
        // The relation as a null vector: near a double eigenvalue it is itself not well defined.
        let back = DVector::from_fn(channels.len(), |row, _| {
            other.relation[row] * scale(row) / powers[0]
        });
        let left = (case.compensated(&point) * &back).norm();
        prop_assert!(left <= 1e-8 * case.sigma.norm() * back.norm());
    }
}
