//! The exhaust: the turbine's exit, where cooling air mixes in, and the duct to ambient.

use serde::{Deserialize, Serialize};

use super::duct::Duct;
use super::volume::Volume;
use crate::gas::Gas;
use crate::real::Real;

/// How far below the blade exit the mixture's temperature is first guessed, K.
const START_BELOW_K: f64 = 25.0;
/// Newton steps for the mixture's temperature.
const NEWTON_STEPS: usize = 3;

/// Turbine exit (station 7), duct behind the valve (station 8) and its way out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exhaust {
    /// Volume between turbine and valve (assumed).
    pub turbine_exit: Volume,
    /// Volume behind the valve (assumed).
    pub duct_volume: Volume,
    /// Duct to ambient (inertance and loss assumed, draught derived from Table 3).
    pub duct: Duct,
}

/// Temperature, K, of two mixed streams, each a mass flow in kg/s and a specific enthalpy in J/kg,
/// with the composition `mixture`; the hot one left the blades at `blade_exit_k`.
#[inline(always)]
pub fn mixed_k<R: Real>(hot: [R; 2], cold: [R; 2], mixture: &Gas<R>, blade_exit_k: R) -> R {
    let enthalpy = hot[0].mul_add(hot[1], cold[0] * cold[1]) / (hot[0] + cold[0]);
    mixture.temperature_k(enthalpy, blade_exit_k - START_BELOW_K, NEWTON_STEPS)
}
