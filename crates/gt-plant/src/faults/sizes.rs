//! What the plant feels of all faults at one moment.

use super::ActuatorId;
use crate::real::Real;

/// The state of an actuator's faults at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActuatorFault<R = f64> {
    /// Relative error of the position.
    pub gain_error: R,
    /// What is added to the position, in the actuator's unit.
    pub offset: R,
    /// 1 where the actuator holds its position, else 0.
    pub stuck: R,
    /// The position that is held, in the actuator's unit.
    pub stuck_at: R,
    /// Time constant of a first-order lag behind the position, s.
    pub lag_s: R,
}

impl ActuatorFault {
    /// No fault.
    pub const HEALTHY: Self = Self {
        gain_error: 0.0,
        offset: 0.0,
        stuck: 0.0,
        stuck_at: 0.0,
        lag_s: 0.0,
    };
}

impl<R: Real> ActuatorFault<R> {
    /// The position for a demand, before the lag: `demand (1 + gain_error) + offset`, or
    /// `stuck_at`. A healthy actuator gives exactly the demand.
    #[inline(always)]
    #[must_use]
    pub fn position(&self, demand: R) -> R {
        let moving = demand * (self.gain_error + 1.0) + self.offset;
        moving * (-self.stuck + 1.0) + self.stuck * self.stuck_at
    }
}

/// Sizes of the faults at one moment, as the plant's laws use them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultSizes<R = f64> {
    /// Share of the compressor's mass flow that is lost (case 1).
    pub compressor_flow_loss: R,
    /// Share of the turbine's efficiency that is lost (case 3).
    pub turbine_efficiency_loss: R,
    /// The fuel valve, kg/s (case 4 is its lag).
    pub fuel: ActuatorFault<R>,
    /// The pressurising valve, degrees.
    pub valve: ActuatorFault<R>,
    /// The inlet guide vanes, degrees.
    pub guide_vanes: ActuatorFault<R>,
}

impl FaultSizes {
    /// No fault.
    pub const HEALTHY: Self = Self {
        compressor_flow_loss: 0.0,
        turbine_efficiency_loss: 0.0,
        fuel: ActuatorFault::HEALTHY,
        valve: ActuatorFault::HEALTHY,
        guide_vanes: ActuatorFault::HEALTHY,
    };

    /// The same sizes as numbers of the kind of `kind`.
    #[inline(always)]
    pub fn like<R: Real>(&self, kind: R) -> FaultSizes<R> {
        let actuator = |of: &ActuatorFault| ActuatorFault {
            gain_error: kind.like(of.gain_error),
            offset: kind.like(of.offset),
            stuck: kind.like(of.stuck),
            stuck_at: kind.like(of.stuck_at),
            lag_s: kind.like(of.lag_s),
        };
        FaultSizes {
            compressor_flow_loss: kind.like(self.compressor_flow_loss),
            turbine_efficiency_loss: kind.like(self.turbine_efficiency_loss),
            fuel: actuator(&self.fuel),
            valve: actuator(&self.valve),
            guide_vanes: actuator(&self.guide_vanes),
        }
    }
}

impl<R> FaultSizes<R> {
    /// An actuator's faults by its name.
    pub fn actuator(&self, actuator: ActuatorId) -> &ActuatorFault<R> {
        match actuator {
            ActuatorId::Fuel => &self.fuel,
            ActuatorId::Valve => &self.valve,
            ActuatorId::GuideVanes => &self.guide_vanes,
        }
    }

    /// An actuator's faults by its name, to be changed.
    pub fn actuator_mut(&mut self, actuator: ActuatorId) -> &mut ActuatorFault<R> {
        match actuator {
            ActuatorId::Fuel => &mut self.fuel,
            ActuatorId::Valve => &mut self.valve,
            ActuatorId::GuideVanes => &mut self.guide_vanes,
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "these values are exact")]

    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn prop_positions(demand in -1e3..1e3f64, gain_error in -1.0..1.0f64, offset in -9.0..9.0f64) {
            prop_assert_eq!(ActuatorFault::HEALTHY.position(demand), demand);
            let moving = ActuatorFault { gain_error, offset, ..ActuatorFault::HEALTHY };
            prop_assert_eq!(moving.position(demand), demand * (1.0 + gain_error) + offset);
            let held = ActuatorFault { stuck: 1.0, stuck_at: 0.3, ..moving };
            prop_assert_eq!(held.position(demand), 0.3);
        }
    }
}
