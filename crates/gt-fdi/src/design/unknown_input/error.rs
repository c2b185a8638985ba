//! Errors of residual generators for unknown inputs.

use thiserror::Error;

/// Why a residual cannot be made robust against unknown inputs or freed of them, or why that cannot
/// be judged.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnknownInputError {
    /// No disturbance enters.
    #[error("disturbances: expected at least one that enters the state or an output, found none")]
    NoDisturbance,
    /// Some combination of outputs shows no disturbance, so that its residual cannot be normalised.
    #[error(
        "R_e = C X C' + F F': expected a smallest eigenvalue of at least {limit:e} of its \
         correlations, found {found:e}: some combination of outputs feels no disturbance"
    )]
    UntouchedOutputs {
        /// Smallest eigenvalue of the correlations of `R_e`.
        found: f64,
        /// The smallest accepted.
        limit: f64,
    },
    /// The outputs do not show every disturbance of the state one step later: `rank(C E) < rank(E)`.
    #[error(
        "disturbances of the state: expected rank(C E) = rank(E) = {expected}, found {found}: the \
         smallest singular value of C E is {smallest:e} of the norm of C, below {limit:e}; each \
         disturbance has to show in an output at once or one sample later (nk 0 or 1), and in \
         other outputs than the rest"
    )]
    HiddenDisturbance {
        /// Rank of E, without what the outputs show at once.
        expected: usize,
        /// Rank of C E, on the outputs that feel no disturbance at once.
        found: usize,
        /// Smallest singular value of C E with an orthonormal basis of E, relative to the norm of C.
        smallest: f64,
        /// The smallest accepted.
        limit: f64,
    },
    /// An invariant zero from the disturbances to the outputs is not inside the unit circle: what
    /// is left without the disturbances does not show an unstable mode.
    #[error(
        "zeros from the disturbances to the outputs: expected them inside the unit circle \
         (detectability), found one of modulus {modulus} at {angle_rad} rad: the singular value \
         that belongs to it is {smallest:e}, below {limit:e}"
    )]
    UnstableZero {
        /// Modulus of the zero.
        modulus: f64,
        /// Its angle in radians a sample.
        angle_rad: f64,
        /// Smallest singular value of `[z I - A; C]` of the model without disturbances, both parts
        /// relative to their norm.
        smallest: f64,
        /// The smallest accepted.
        limit: f64,
    },
    /// All outputs are spent on the disturbances.
    #[error(
        "outputs: expected more than the {disturbances} independent disturbances, found {outputs}"
    )]
    NoOutputLeft {
        /// Independent disturbances.
        disturbances: usize,
        /// Outputs.
        outputs: usize,
    },
    /// A band of frequencies is empty or reaches beyond half of the sampling frequency.
    #[error("band {low_hz}..{high_hz} Hz: expected 0 <= low <= high <= {nyquist_hz} Hz")]
    Band {
        /// Its lower end in hertz.
        low_hz: f64,
        /// Its upper end in hertz.
        high_hz: f64,
        /// Half of the sampling frequency in hertz.
        nyquist_hz: f64,
    },
    /// A gain is asked of a system that has none.
    #[error(
        "gain of a system: expected a stable one, found a spectral radius of {spectral_radius}"
    )]
    Unstable {
        /// Largest modulus of its poles (NaN when they were not found).
        spectral_radius: f64,
    },
    /// Singular values were not found.
    #[error("singular values: no convergence in {iterations} iterations")]
    NoConvergence {
        /// Iterations spent.
        iterations: usize,
    },
}
