//! The combustor: heat release without storage of energy.

use serde::{Deserialize, Serialize};

use crate::gas::{Gas, air};
use crate::real::Real;

/// Reference temperature of the lower heating value, K.
pub(crate) const REFERENCE_K: f64 = 298.15;
/// Temperature from which the exit temperature is iterated, K (the design value).
const START_K: f64 = 1140.0;
/// Newton steps for the exit temperature.
const NEWTON_STEPS: usize = 3;

/// The combustor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Combustor {
    /// Share of the lower heating value that is released (assumed).
    pub efficiency: f64,
}

impl Combustor {
    /// Exit temperature t5, K, for `air_kg_s` of air at `air_k` and a heat release of
    /// `released_w` from `fuel_kg_s` of fuel.
    ///
    /// `products` is the mixture that leaves. Air includes the bleed that mixes in upstream of
    /// the turbine (m6), because Table 3 has `t5 = t6` to all digits.
    #[inline(always)]
    pub fn exit_k<R: Real>(
        &self,
        [air_kg_s, fuel_kg_s]: [R; 2],
        air_k: R,
        released_w: R,
        products: &Gas<R>,
    ) -> R {
        let reference = air_k.like(REFERENCE_K);
        let supplied_w =
            air_kg_s.mul_add(air::enthalpy(air_k) - air::enthalpy(reference), released_w);
        let enthalpy = products.enthalpy(reference) + supplied_w / (air_kg_s + fuel_kg_s);
        products.temperature_k(enthalpy, air_k.like(START_K), NEWTON_STEPS)
    }

    /// Heat release, W, of a fuel with the lower heating value `heating_value_j_kg`.
    #[inline(always)]
    pub fn released_w<R: Real>(&self, fuel_kg_s: R, heating_value_j_kg: R) -> R {
        fuel_kg_s * heating_value_j_kg * self.efficiency
    }
}
