//! Numbers side by side.

/// Numbers side by side: the lanes of the widest register.
pub(crate) const LANES: usize = 8;

/// Numbers in one line of the cache. A register that is loaded from two takes twice as long, which is
/// what most of the time of a step would be.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Lanes(pub(crate) [f64; LANES]);

impl Lanes {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);
}
