//! The combustor: complete heat release without storage of energy.

use serde::{Deserialize, Serialize};

use crate::gas::Gas;

/// Reference temperature of the lower heating value, K.
const REFERENCE_K: f64 = 298.15;
/// Temperature from which the exit temperature is iterated, K (the design value).
const START_K: f64 = 1140.0;
/// Newton steps for the exit temperature.
const NEWTON_STEPS: usize = 3;

/// The combustor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Combustor {
    /// Lower heating value times combustion efficiency, J/kg (derived from Table 3).
    pub effective_heating_value_j_kg: f64,
}

impl Combustor {
    /// Exit temperature t5, K, for `air_kg_s` of air at `air_k` and `fuel_kg_s` of fuel.
    ///
    /// `products` is the mixture that leaves. Air includes the bleed that mixes in upstream of
    /// the turbine (m6), because Table 3 has `t5 = t6` to all digits.
    pub fn exit_k(&self, air_kg_s: f64, air_k: f64, fuel_kg_s: f64, products: &Gas) -> f64 {
        let supplied_w = air_kg_s * (Gas::AIR.enthalpy(air_k) - Gas::AIR.enthalpy(REFERENCE_K))
            + fuel_kg_s * self.effective_heating_value_j_kg;
        let enthalpy = products.enthalpy(REFERENCE_K) + supplied_w / (air_kg_s + fuel_kg_s);
        products.temperature_k(enthalpy, START_K, NEWTON_STEPS)
    }
}
