//! The fuel actuator: ideal when healthy, a first-order lag under fault case 4.

use serde::{Deserialize, Serialize};

/// The fuel actuator.
///
/// A lag shorter than `shortest_lag_s` cannot be integrated as such. There the internal lag stays
/// at `shortest_lag_s` and the fuel is the demand and the lagged demand mixed in the share
/// `tau / shortest_lag_s`: the mean delay (minus the derivative of the transfer function at zero)
/// is then exactly `tau`, and nothing jumps as tau grows from zero through `shortest_lag_s`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Shortest lag that is integrated, s (assumed; numerical).
    pub shortest_lag_s: f64,
}

impl Actuator {
    /// The fuel flow that reaches the combustor and the rate of change of the actuator's state,
    /// from the demand, the state and the lag `lag_s` (0 when healthy).
    pub fn respond(&self, demand_kg_s: f64, state_kg_s: f64, lag_s: f64) -> (f64, f64) {
        let share = (lag_s / self.shortest_lag_s).clamp(0.0, 1.0);
        let fuel_kg_s = demand_kg_s + share * (state_kg_s - demand_kg_s);
        let rate = (demand_kg_s - state_kg_s) / lag_s.max(self.shortest_lag_s);
        (fuel_kg_s, rate)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;
    use proptest::prelude::*;

    const ACTUATOR: Actuator = Actuator {
        shortest_lag_s: 0.01,
    };

    #[test]
    fn healthy_actuator_is_exact() {
        assert_eq!(ACTUATOR.respond(0.3, 0.1, 0.0).0, 0.3);
    }

    proptest! {
        /// On a ramp of slope 1 the lagged fuel trails the demand by exactly tau.
        #[test]
        fn prop_mean_delay_is_tau(lag_s in prop_oneof![0.0..0.02f64, 0.02..5.0f64]) {
            let held_back = lag_s.max(0.01);
            let (fuel, rate) = ACTUATOR.respond(10.0, 10.0 - held_back, lag_s);
            prop_assert!((rate - 1.0).abs() < 1e-9, "the state follows the ramp: {}", rate);
            prop_assert!((10.0 - fuel - lag_s).abs() < 1e-12);
        }

        #[test]
        fn prop_nothing_jumps_as_the_lag_grows(lag_s in 0.0..0.05f64) {
            let at = |lag_s| ACTUATOR.respond(0.3, 0.2, lag_s);
            let ((fuel, rate), (later_fuel, later_rate)) = (at(lag_s), at(lag_s + 1e-9));
            // Steepest slopes: 0.1 kg/s over 0.01 s, and its derivative 0.1 / 0.01^2.
            prop_assert!((later_fuel - fuel).abs() < 1.01e-8);
            prop_assert!((later_rate - rate).abs() < 1.01e-6);
        }
    }
}
