//! The butterfly valve behind the turbine, choked at the design point.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::gas::GAS_CONSTANT_J_KG_K;
use crate::real::Real;

/// Mechanical stops of the valve, degrees (assumed: it never closes, and opens fully).
pub const VALVE_STOPS_DEG: [f64; 2] = [1.0, 90.0];

/// A butterfly valve with ideal nozzle flow.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Valve {
    /// Effective area times `1 / (1 - cos ``a_v``)`, m^2 (derived from Table 3).
    pub full_area_m2: f64,
}

impl Valve {
    /// Mass flow, kg/s, at the angle `angle_deg` (0 closed, 90 open) from `(p7, T7)` to p8.
    #[inline(always)]
    pub fn flow_kg_s<R: Real>(
        &self,
        angle_deg: R,
        [inlet_pa, inlet_k]: [R; 2],
        outlet_pa: R,
        gamma: R,
    ) -> R {
        let area_m2 = (-(angle_deg * (PI / 180.0)).cos() + 1.0) * self.full_area_m2;
        area_m2 * inlet_pa / (inlet_k * GAS_CONSTANT_J_KG_K).sqrt()
            * nozzle_function(outlet_pa / inlet_pa, gamma)
    }
}

/// The pressure ratio below which the flow is choked.
#[inline(always)]
pub fn critical_ratio<R: Real>(gamma: R) -> R {
    let base = gamma.like(2.0) / (gamma + 1.0);
    base * (base.ln() / (gamma - 1.0)).exp()
}

/// Nozzle flow function of the pressure ratio, constant below the critical ratio; none backwards.
#[inline(always)]
pub fn nozzle_function<R: Real>(pressure_ratio: R, gamma: R) -> R {
    let base = gamma.like(2.0) / (gamma + 1.0);
    let power = (base.ln() / (gamma - 1.0)).exp();
    let critical = base * power;
    critical.where_less(
        pressure_ratio,
        #[inline(always)]
        || {
            let one = gamma.like(1.0);
            // The general law factored: r^(2/g) (1 - r^((g-1)/g)) without cancellation near r = 1.
            let log = pressure_ratio.at_most(one).ln() / gamma;
            let squared =
                -((log * (gamma - 1.0)).exp_m1()) * (log * 2.0).exp() * gamma * 2.0 / (gamma - 1.0);
            squared.at_least(gamma.like(0.0)).sqrt()
        },
        // The general law at the critical ratio base^(g/(g-1)), simplified.
        #[inline(always)]
        || (gamma * base).sqrt() * power,
    )
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
