//! An actuator: ideal when healthy; faults change its gain, its offset, hold it or make it lag.

use serde::{Deserialize, Serialize};

use crate::faults::ActuatorFault;
use crate::real::Real;

/// An actuator.
///
/// A lag shorter than `shortest_lag_s` cannot be integrated as such. There the internal lag stays
/// at `shortest_lag_s` and what is received is the demand and the lagged demand mixed in the share
/// `tau / shortest_lag_s`: the mean delay (minus the derivative of the transfer function at zero)
/// is then exactly `tau`, and nothing jumps as tau grows from zero through `shortest_lag_s`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Shortest lag that is integrated, s (assumed; numerical).
    pub shortest_lag_s: f64,
}

impl Actuator {
    /// What reaches the plant and the rate of change of the actuator's state, from the demand and
    /// the state, all in the actuator's own unit.
    ///
    /// Gain, offset and a stuck position act first, then the mechanical stops, the lag after them.
    #[inline(always)]
    pub fn respond<R: Real>(
        &self,
        demand: R,
        state: R,
        fault: &ActuatorFault<R>,
        stops: [f64; 2],
    ) -> (R, R) {
        let commanded = between(stops, fault.position(demand));
        let shortest = demand.like(self.shortest_lag_s);
        let share = (fault.lag_s / self.shortest_lag_s).at_most(demand.like(1.0));
        let received = share.mul_add(state - commanded, commanded);
        let rate = (commanded - state) / fault.lag_s.at_least(shortest);
        (received, rate)
    }
}

/// A position between mechanical stops.
#[inline(always)]
pub fn between<R: Real>([low, high]: [f64; 2], position: R) -> R {
    position
        .at_most(position.like(high))
        .at_least(position.like(low))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;
    use proptest::prelude::*;

    const ACTUATOR: Actuator = Actuator {
        shortest_lag_s: 0.01,
    };

    const STOPS: [f64; 2] = [0.0, 20.0];

    #[test]
    fn a_fault_does_not_pass_the_stops() {
        let offset = |offset| ActuatorFault {
            offset,
            ..ActuatorFault::HEALTHY
        };
        assert_eq!(ACTUATOR.respond(0.3, 0.3, &offset(-1.0), STOPS).0, 0.0);
        assert_eq!(ACTUATOR.respond(0.3, 0.3, &offset(90.0), STOPS).0, 20.0);
    }

    fn lagging(lag_s: f64) -> ActuatorFault {
        ActuatorFault {
            lag_s,
            ..ActuatorFault::HEALTHY
        }
    }

    #[test]
    fn healthy_actuator_is_exact() {
        assert_eq!(ACTUATOR.respond(0.3, 0.1, &lagging(0.0), STOPS).0, 0.3);
    }

    #[test]
    fn a_stuck_actuator_ignores_the_demand() {
        let stuck = ActuatorFault {
            stuck: 1.0,
            stuck_at: 0.17,
            gain_error: 0.5,
            ..ActuatorFault::HEALTHY
        };
        assert_eq!(ACTUATOR.respond(0.3, 0.1, &stuck, STOPS).0, 0.17);
    }

    proptest! {
        /// On a ramp of slope 1 the lagged fuel trails the demand by exactly tau.
        #[test]
        fn prop_mean_delay_is_tau(lag_s in prop_oneof![0.0..0.02f64, 0.02..5.0f64]) {
            let held_back = lag_s.max(0.01);
            let (fuel, rate) = ACTUATOR.respond(10.0, 10.0 - held_back, &lagging(lag_s), STOPS);
            prop_assert!((rate - 1.0).abs() < 1e-9, "the state follows the ramp: {}", rate);
            prop_assert!((10.0 - fuel - lag_s).abs() < 1e-12);
        }

        #[test]
        fn prop_nothing_jumps_as_the_lag_grows(lag_s in 0.0..0.05f64) {
            let at = |lag_s| ACTUATOR.respond(0.3, 0.2, &lagging(lag_s), STOPS);
            let ((fuel, rate), (later_fuel, later_rate)) = (at(lag_s), at(lag_s + 1e-9));
            // Steepest slopes: 0.1 kg/s over 0.01 s, and its derivative 0.1 / 0.01^2.
            prop_assert!((later_fuel - fuel).abs() < 1.01e-8);
            prop_assert!((later_rate - rate).abs() < 1.01e-6);
        }
    }
}
