//! The butterfly valve behind the turbine, choked at the design point.

use serde::{Deserialize, Serialize};

use crate::gas::GAS_CONSTANT_J_KG_K;

/// A butterfly valve with ideal nozzle flow.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Valve {
    /// Effective area times `1 / (1 - cos ``a_v``)`, m^2 (derived from Table 3).
    pub full_area_m2: f64,
}

impl Valve {
    /// Mass flow, kg/s, at the angle `angle_deg` (0 closed, 90 open) from `(p7, T7)` to p8.
    pub fn flow_kg_s(
        &self,
        angle_deg: f64,
        [inlet_pa, inlet_k]: [f64; 2],
        outlet_pa: f64,
        gamma: f64,
    ) -> f64 {
        let area_m2 = self.full_area_m2 * (1.0 - angle_deg.to_radians().cos());
        area_m2 * inlet_pa / (GAS_CONSTANT_J_KG_K * inlet_k).sqrt()
            * nozzle_function(outlet_pa / inlet_pa, gamma)
    }
}

/// Nozzle flow function of the pressure ratio, constant below the critical ratio.
pub fn nozzle_function(pressure_ratio: f64, gamma: f64) -> f64 {
    let base = 2.0 / (gamma + 1.0);
    let power = (base.ln() / (gamma - 1.0)).exp();
    if pressure_ratio <= base * power {
        // The general law at the critical ratio base^(g/(g-1)), simplified.
        (gamma * base).sqrt() * power
    } else {
        let log = pressure_ratio.min(1.0).ln();
        let squared = 2.0 * gamma / (gamma - 1.0)
            * ((2.0 / gamma * log).exp() - ((gamma + 1.0) / gamma * log).exp());
        squared.max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;
    use proptest::prelude::*;

    #[test]
    fn published_choked_air() {
        // Any gas dynamics table: gamma 1.4 chokes at 0.5283 with a flow function of 0.6847.
        assert!((nozzle_function(0.3, 1.4) - 0.6847).abs() < 5e-5);
        assert_eq!(
            nozzle_function(0.5282, 1.4).to_bits(),
            nozzle_function(0.1, 1.4).to_bits()
        );
        assert!(nozzle_function(0.5284, 1.4) <= nozzle_function(0.5282, 1.4));
        assert!(nozzle_function(0.6, 1.4) < 0.68);
        assert_eq!(nozzle_function(1.0, 1.4), 0.0);
    }

    proptest! {
        #[test]
        fn prop_continuous_at_the_critical_ratio(gamma in 1.2..1.6f64) {
            let critical = (2.0 / (gamma + 1.0)).powf(gamma / (gamma - 1.0));
            let below = nozzle_function(critical * (1.0 - 1e-9), gamma);
            let above = nozzle_function(critical * (1.0 + 1e-9), gamma);
            prop_assert!((below / above - 1.0).abs() < 1e-12);
        }
    }
}
