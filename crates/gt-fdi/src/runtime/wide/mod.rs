//! The instruction set that work runs with: found at run time with the feature `design`, else that of
//! the build. Which it is changes the speed of sums side by side and not a bit of them:
//! multiplications and additions stay as they are written, and where they are written as one
//! (`mul_add_f64s`) they are rounded once, if need be by software.

#[cfg(feature = "design")]
mod dispatched;
#[cfg(not(feature = "design"))]
mod plain;

#[cfg(feature = "design")]
use dispatched as set;
#[cfg(not(feature = "design"))]
use plain as set;

pub(super) use set::{FEW_LANES, lanes_of};
pub(crate) use set::{Simd, Wide, Work, registers, registers_mut};

/// It is a matter of the machine, not of what is computed.
impl PartialEq for Wide {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
