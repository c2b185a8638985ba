//! The electric generator on the mains: swing equation, losses.

use serde::{Deserialize, Serialize};

use crate::real::Real;

/// A synchronous generator behind a gear, on a stiff grid.
///
/// The classical second-order model (Kundur, Power System Stability and Control, section 3.9): the
/// load angle integrates the slip, the air-gap power is `P_max sin(angle)` and damper windings add
/// a torque in proportion to the slip. The paper names a generator and prints nothing of it: all
/// values are assumed, for a machine of 2 MVA.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Generator {
    /// Largest air-gap power, W (assumed).
    pub pull_out_power_w: f64,
    /// Damping torque a slip, N m s (at the turbine's shaft; assumed).
    pub damping_n_m_s: f64,
    /// Moment of inertia referred to the turbine's shaft, kg m^2 (assumed).
    pub inertia_kg_m2: f64,
    /// Electrical radians a mechanical radian of the turbine's shaft (derived: 50 Hz at design
    /// speed).
    pub electrical_ratio: f64,
    /// Losses at no load, W (assumed).
    pub no_load_loss_w: f64,
    /// Copper losses a squared watt of air-gap power, 1/W (assumed).
    pub copper_loss_per_w: f64,
}

impl Generator {
    /// Torque on the turbine's shaft, N m, at a load angle and a slip against the grid.
    #[inline(always)]
    pub fn torque_n_m<R: Real>(&self, load_angle_rad: R, slip_rad_s: R, grid_rad_s: R) -> R {
        load_angle_rad.sin() * self.pull_out_power_w / grid_rad_s + slip_rad_s * self.damping_n_m_s
    }

    /// Rate of change of the load angle, electrical rad/s.
    #[inline(always)]
    pub fn angle_rate<R: Real>(&self, slip_rad_s: R) -> R {
        slip_rad_s * self.electrical_ratio
    }

    /// Electric power at the terminals, W, for an air-gap power.
    #[inline(always)]
    pub fn terminal_w<R: Real>(&self, air_gap_w: R) -> R {
        air_gap_w - air_gap_w.squared() * self.copper_loss_per_w - self.no_load_loss_w
    }
}

#[cfg(test)]
mod tests {
    use crate::{MapSet, PlantParameters, Variant};

    #[test]
    fn regress_efficiency_and_swing_are_those_of_a_small_synchronous_machine() {
        let plant = PlantParameters::new(Variant::Cogeneration, MapSet::Paper);
        let (generator, speed) = (plant.generator, plant.design.speed_rad_s);
        let efficiency = generator.terminal_w(1.5e6) / 1.5e6;
        assert!((0.95..0.98).contains(&efficiency), "{efficiency}");
        // Natural frequency of the swing at half the pull-out power: 1 to 2 Hz is usual.
        let stiffness = generator.pull_out_power_w / speed * (0.5f64.asin()).cos();
        let inertia = plant.shaft.inertia_kg_m2 + generator.inertia_kg_m2;
        let hertz =
            (stiffness * generator.electrical_ratio / inertia).sqrt() / std::f64::consts::TAU;
        assert!((1.0..2.0).contains(&hertz), "{hertz}");
    }
}
