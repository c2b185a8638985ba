//! Tails and quantiles of the normal and the chi-square distribution.

use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::erf::erfc_inv;
use statrs::function::gamma::checked_gamma_ur;

/// `P(X > statistic)` of a chi-square variable: the regularised upper incomplete gamma function
/// `Q(k / 2, x / 2)` (Abramowitz and Stegun, 26.4.19).
///
/// The degrees of freedom `k > 0` need not be whole. 1 at and below 0; NaN where `k` is not
/// positive or an argument is NaN.
pub fn chi_square_tail(statistic: f64, degrees_of_freedom: f64) -> f64 {
    if degrees_of_freedom.is_nan() || degrees_of_freedom <= 0.0 || statistic.is_nan() {
        return f64::NAN;
    }
    if statistic <= 0.0 {
        return 1.0;
    }
    if statistic.is_infinite() {
        return 0.0;
    }
    checked_gamma_ur(0.5 * degrees_of_freedom, 0.5 * statistic).unwrap_or(f64::NAN)
}

/// The value that a chi-square variable of `k > 0` degrees of freedom (whole or not) exceeds with
/// the given probability; NaN outside `0 < probability < 1` or where `k` is not positive.
pub fn chi_square_threshold(probability: f64, degrees_of_freedom: f64) -> f64 {
    if !(probability > 0.0 && probability < 1.0) {
        return f64::NAN;
    }
    ChiSquared::new(degrees_of_freedom).map_or(f64::NAN, |law| law.inverse_cdf(1.0 - probability))
}

/// The quantile of the standard normal distribution; NaN outside `0 < probability < 1`.
pub fn normal_quantile(probability: f64) -> f64 {
    if !(probability > 0.0 && probability < 1.0) {
        return f64::NAN;
    }
    -std::f64::consts::SQRT_2 * erfc_inv(2.0 * probability)
}
