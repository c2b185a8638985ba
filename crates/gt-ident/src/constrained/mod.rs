//! Least squares under constraints that plain least squares does not know: stable poles and
//! steady-state gains of known sign, value or range.
//!
//! The stable polynomials of degree 3 and above are no convex set. Around a stable centre `A_c`
//! the set `Re{A(e^jw) / A_c(e^jw)} >= delta` for all `w` is convex and holds stable polynomials
//! only, since `A` then turns round the origin as often as `A_c`. Least squares over it is a
//! quadratic programme; moving the centre to the solution and solving again lowers the cost until
//! nothing is gained. A smaller radius than 1 is the same problem after `z -> z / radius`.

mod cost;
mod dc_gain;
mod fit;
mod nearest;
mod row;
mod stability;

pub use dc_gain::DcGain;
pub use fit::{ActiveConstraint, ConstrainedArx, ConstrainedFit, ConstrainedRow, MAX_RADIUS};
