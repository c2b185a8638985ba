//! Chi-square values on the scale of a standard normal variable.

/// How many standard deviations a normal variable would have to lie above its mean to be as rare as
/// a chi-square variable of `degrees` of freedom (above 0) at `chi_square`, after Wilson and
/// Hilferty: the cube root of `chi_square / degrees` is nearly normal with the mean `1 - v` and the
/// variance `v = 2 / (9 degrees)` (*Proceedings of the National Academy of Sciences* 17, 1931).
pub(super) fn normal_score(chi_square: f64, degrees: f64) -> f64 {
    let variance = 2.0 / (9.0 * degrees);
    (libm::cbrt(chi_square / degrees) - (1.0 - variance)) / libm::sqrt(variance)
}
