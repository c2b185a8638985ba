//! Numbers side by side.

/// Numbers side by side: the lanes of the widest register.
pub(crate) const LANES: usize = 8;

/// Numbers in one line of the cache, so that no register is loaded from two.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Lanes(pub(crate) [f64; LANES]);

impl Lanes {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);
}
