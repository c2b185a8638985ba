//! The noise variances that the covariance of one output's regression vector admits.

use gt_core::DimensionError;
use nalgebra::{DMatrix, DVector};

use super::covariance::{LaggedCovariance, channel_name};
use crate::eiv::{EivLags, EivRow};
use crate::least_squares::{CONDITION_LIMIT, LeastSquares, triangular_factor};
use crate::symmetric::{symmetric_eigen, upper_root};
use crate::{Dependence, IdentError};

/// The admissible noise variances of a relation of order `n`: those for which
/// `Sigma_n - diag(sigma_y^2 I_{n+1}, sigma_1^2 I, ..)` is positive semidefinite and singular.
///
/// `Sigma_n = E phi phi'` with `phi(t) = (y(t..t-n), u_1(t-nk_1..t-n), ..)`. Beghelli, Guidorzi and
/// Soverini (1990), "The Frisch scheme in dynamic system identification", Automatica 26(1).
#[derive(Debug, Clone)]
pub struct AdmissibleSurface {
    lags: EivLags,
    /// `R` upper triangular, `Sigma = R' R`, its columns the inputs' and then the output's.
    root: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// `R^-T E_c R^-1` with `E_c` the identity on the entries of channel `c`, else zero.
    whitened: Vec<DMatrix<f64>>,
    intercepts: Vec<f64>,
    names: Vec<String>,
}

/// A point of an [`AdmissibleSurface`] and the relation that holds there.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePoint {
    /// `(sigma_y^2, sigma_1^2, .., sigma_nu^2)`, in squared units of the covariance.
    pub variances: Vec<f64>,
    /// `(1, a_1..a_n, -b_1, -b_2, ..)`: the null vector of the compensated covariance.
    pub relation: DVector<f64>,
}

impl SurfacePoint {
    /// The relation as coefficients `(a_1..a_n, b_1, b_2, ..)`.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] where the lags are those of another relation.
    pub fn row(&self, lags: &EivLags) -> Result<EivRow, IdentError> {
        let mut theta = self.relation.rows_range(1..).into_owned();
        for coefficient in theta.iter_mut().skip(lags.order()) {
            *coefficient = -*coefficient;
        }
        EivRow::new(lags.clone(), theta)
    }
}

impl AdmissibleSurface {
    /// The surface of an exact covariance `Sigma_n`, `p x p` with `p` one more than
    /// [`EivLags::parameters`], entries in the order of `phi`.
    ///
    /// # Errors
    /// [`IdentError::Dimension`]; [`IdentError::NotPositiveDefinite`].
    pub fn of_covariance(lags: &EivLags, sigma: &DMatrix<f64>) -> Result<Self, IdentError> {
        // First the order alone: the number of entries of a huge one overflows.
        let own = lags.order().min(sigma.nrows());
        DimensionError::check("rows of a covariance", lags.order(), own)?;
        let size = lags.parameters() + 1;
        DimensionError::check("rows of a covariance", size, sigma.nrows())?;
        DimensionError::check("columns of a covariance", size, sigma.ncols())?;
        let order = inputs_first(lags);
        let sorted = sigma.select_columns(&order).select_rows(&order);
        let names = (0..=lags.inputs()).map(channel_name).collect();
        Self::of_root(lags.clone(), upper_root(sorted)?, names)
    }

    /// The surface of the covariances of scaled channels; its variances are in units of their
    /// scales squared.
    ///
    /// # Errors
    /// [`IdentError::Dimension`] where the lags do not fit the covariances;
    /// [`IdentError::RankDeficient`] where the condition of the samples exceeds
    /// [`CONDITION_LIMIT`]: a record without noise, or equal channels.
    pub fn new(lags: &EivLags, covariance: &LaggedCovariance) -> Result<Self, IdentError> {
        DimensionError::check("inputs", lags.inputs(), covariance.inputs())?;
        let known = lags.order().min(covariance.max_lag());
        DimensionError::check("lags of the covariances", lags.order(), known)?;
        let phi = regression_vector(lags);
        let columns: Vec<(usize, usize)> =
            inputs_first(lags).iter().map(|&entry| phi[entry]).collect();
        let samples = covariance.columns(&columns);
        let solution = LeastSquares::new(&samples, &DMatrix::zeros(samples.nrows(), 0));
        if !solution.full_rank() {
            let (channel, lag) = columns[solution.weakest()];
            return Err(IdentError::RankDeficient {
                output: covariance.names()[0].clone(),
                channel: covariance.names()[channel].clone(),
                lag,
                condition: solution.condition,
                limit: CONDITION_LIMIT,
                dependence: Box::new(Dependence::Combination {
                    of: vec!["the other lagged channels".to_owned()],
                    more: 0,
                }),
            });
        }
        let root = triangular_factor(&samples);
        Self::of_root(lags.clone(), root, covariance.names().to_vec())
    }

    fn of_root(lags: EivLags, root: DMatrix<f64>, names: Vec<String>) -> Result<Self, IdentError> {
        let size = root.nrows();
        let mut inverse = DMatrix::identity(size, size);
        if !root.solve_upper_triangular_mut(&mut inverse) {
            return Err(IdentError::NotPositiveDefinite { size });
        }
        let mut first = 0;
        let mut whitened = Vec::with_capacity(lags.inputs() + 1);
        for channel in (0..lags.inputs()).map(|input| input + 1).chain([0]) {
            let count = channel_terms(&lags, channel);
            let rows = inverse.rows(first, count);
            whitened.push(rows.tr_mul(&rows));
            first += count;
        }
        whitened.rotate_right(1);
        let mut intercepts = Vec::with_capacity(whitened.len());
        for matrix in &whitened {
            let largest = symmetric_eigen(matrix.clone()).map_or(f64::NAN, |(values, _)| {
                values.iter().copied().fold(0.0, f64::max)
            });
            if !(largest.is_finite() && largest > 0.0) {
                return Err(IdentError::NotPositiveDefinite { size });
            }
            intercepts.push(1.0 / largest);
        }
        Ok(Self {
            lags,
            root,
            inverse,
            whitened,
            intercepts,
            names,
        })
    }

    /// The lags of the relation.
    pub fn lags(&self) -> &EivLags {
        &self.lags
    }

    /// The largest variance of each channel, `1 / lambda_max((Sigma_n^-1)_jj)`: where an axis
    /// meets the surface. The output comes first.
    pub fn intercepts(&self) -> &[f64] {
        &self.intercepts
    }

    /// The point where the ray from the origin along `direction` (`1 + nu` entries, the output
    /// first) meets the surface.
    ///
    /// With `Sigma = L L'` and `mu = lambda_max(L^-1 diag(direction) L^-T)` it is `direction / mu`.
    ///
    /// # Errors
    /// [`IdentError::Dimension`]; [`IdentError::NoiseDirection`] for an entry that is negative or
    /// not finite and where none is positive; [`IdentError::NoRelation`] where the null vector has
    /// no part at `y(t)`.
    pub fn along(&self, direction: &[f64]) -> Result<SurfacePoint, IdentError> {
        self.eigen_along(direction)?.point
    }

    /// The point with the given input variances (`nu` entries): by the Schur complement,
    /// `sigma_y^2 = lambda_min(Sigma_yy - Sigma_yu (Sigma_uu - diag(sigma_u^2))^-1 Sigma_uy)`.
    ///
    /// # Errors
    /// [`IdentError::Dimension`]; [`IdentError::NoiseDirection`] for a variance that is negative or
    /// not finite; [`IdentError::NotAdmissible`] where no output variance goes with these;
    /// [`IdentError::NoRelation`] where the null vector has no part at `y(t)`.
    pub fn at_inputs(&self, variances: &[f64]) -> Result<SurfacePoint, IdentError> {
        DimensionError::check("input variances", self.lags.inputs(), variances.len())?;
        check_entries(variances, 1)?;
        let refused = || IdentError::NotAdmissible {
            output: self.names[0].clone(),
            variances: variances.to_vec(),
        };
        let outputs = self.lags.order() + 1;
        let inputs = self.root.nrows() - outputs;
        let mut noise = DMatrix::zeros(inputs, inputs);
        for (whitened, &variance) in self.whitened[1..].iter().zip(variances) {
            noise += whitened.view((0, 0), (inputs, inputs)) * variance;
        }
        // Sigma_uu - diag = R_uu' (I - K) R_uu, and K = Q diag(lambda) Q'.
        let (lambda, q) = symmetric_eigen(noise).ok_or_else(refused)?;
        if lambda.iter().any(|&value| value >= 1.0) {
            return Err(refused());
        }
        let own = self.root.view((inputs, inputs), (outputs, outputs));
        let rotated = q.tr_mul(&self.root.view((0, inputs), (inputs, outputs)));
        let mut weighted = rotated.clone();
        let mut solved = rotated.clone();
        for (row, &value) in lambda.iter().enumerate() {
            weighted
                .row_mut(row)
                .apply(|entry| *entry *= value / (1.0 - value));
            solved
                .row_mut(row)
                .apply(|entry| *entry *= 1.0 / (1.0 - value));
        }
        let schur = own.tr_mul(&own) - rotated.tr_mul(&weighted);
        let size = schur.norm();
        let (values, vectors) = symmetric_eigen(schur).ok_or_else(refused)?;
        // On the border the eigenvalue is zero to rounding.
        if values[0] < -f64::EPSILON * size * outputs as f64 {
            return Err(refused());
        }
        let a = vectors.column(0);
        let b = self.inverse.view((0, 0), (inputs, inputs)) * (q * (solved * a));
        let mut sorted = DVector::zeros(inputs + outputs);
        sorted.rows_mut(0, inputs).copy_from(&-b);
        sorted.rows_mut(inputs, outputs).copy_from(&a);
        let mut point = vec![values[0].max(0.0)];
        point.extend_from_slice(variances);
        self.point(point, &sorted)
    }

    /// What an intersection of a ray knows beside the point.
    pub(crate) fn eigen_along(&self, direction: &[f64]) -> Result<RayEigen, IdentError> {
        DimensionError::check(
            "entries of a noise direction",
            self.whitened.len(),
            direction.len(),
        )?;
        check_entries(direction, 0)?;
        let largest = direction.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            return Err(IdentError::NoiseDirection {
                channel: 0,
                found: 0.0,
            });
        }
        let size = self.root.nrows();
        let mut noise = DMatrix::zeros(size, size);
        for (whitened, &entry) in self.whitened.iter().zip(direction) {
            noise += whitened * (entry / largest);
        }
        let no_relation = || IdentError::NoRelation {
            output: self.names[0].clone(),
        };
        let (values, vectors) = symmetric_eigen(noise).ok_or_else(no_relation)?;
        let top = values[size - 1];
        let vector = &self.inverse * vectors.column(size - 1);
        let variances = direction
            .iter()
            .map(|entry| entry / largest / top)
            .collect();
        Ok(RayEigen {
            point: self.point(variances, &vector),
            scale: 1.0 / (largest * top),
            relative: values / top,
            vectors,
        })
    }

    /// `R x` for `x` in the order of `phi` (`p x k`).
    pub(crate) fn root_times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        &self.root * x.select_rows(&inputs_first(&self.lags))
    }

    fn point(
        &self,
        variances: Vec<f64>,
        vector: &DVector<f64>,
    ) -> Result<SurfacePoint, IdentError> {
        let mut relation = DVector::zeros(vector.len());
        for (position, entry) in inputs_first(&self.lags).into_iter().enumerate() {
            relation[entry] = vector[position];
        }
        let lead = relation[0];
        if !lead.is_finite() || lead.abs() <= f64::EPSILON * relation.amax() {
            return Err(IdentError::NoRelation {
                output: self.names[0].clone(),
            });
        }
        relation /= lead;
        relation[0] = 1.0;
        Ok(SurfacePoint {
            variances,
            relation,
        })
    }
}

/// The intersection of a ray in whitened coordinates.
pub(crate) struct RayEigen {
    pub point: Result<SurfacePoint, IdentError>,
    /// The point over the direction.
    pub scale: f64,
    /// Eigenvalues over the largest, ascending: `Sigma - diag(P) = R' V (I - diag) V' R`.
    pub relative: DVector<f64>,
    pub vectors: DMatrix<f64>,
}

/// The lagged channels of `phi`, channel 0 the output.
pub(crate) fn regression_vector(lags: &EivLags) -> Vec<(usize, usize)> {
    let mut phi: Vec<_> = (0..=lags.order()).map(|lag| (0, lag)).collect();
    for (input, &first) in lags.nk().iter().enumerate() {
        phi.extend((first..=lags.order()).map(|lag| (input + 1, lag)));
    }
    phi
}

/// Number of entries of a channel in `phi`.
pub(crate) fn channel_terms(lags: &EivLags, channel: usize) -> usize {
    match channel.checked_sub(1) {
        None => lags.order() + 1,
        Some(input) => lags.input_terms(input),
    }
}

/// The entries of `phi` with the inputs' before the output's.
fn inputs_first(lags: &EivLags) -> Vec<usize> {
    let own = lags.order() + 1;
    (own..=lags.parameters()).chain(0..own).collect()
}

fn check_entries(entries: &[f64], first_channel: usize) -> Result<(), IdentError> {
    let wrong = |entry: &f64| !(entry.is_finite() && *entry >= 0.0);
    match entries.iter().position(wrong) {
        Some(index) => Err(IdentError::NoiseDirection {
            channel: index + first_channel,
            found: entries[index],
        }),
        None => Ok(()),
    }
}
