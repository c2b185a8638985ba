//! The derivative of the state: gas path, actuators and controllers. Nothing here allocates.

use crate::PlantParameters;
use crate::components::actuator::between;
use crate::components::valve::VALVE_STOPS_DEG;
use crate::faults::FaultSizes;
use crate::gas_path::{Actuation, Point};
use crate::inputs::Inputs;
use crate::real::Real;
use crate::state::{STATES, State};
use crate::variant::Variant;

/// The plant at one state: what the controllers ask for, what reaches the plant, what it does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant<R = f64> {
    /// Demanded fuel flow, kg/s.
    pub fuel_demand_kg_s: R,
    /// Demanded guide vane angle, degrees from open.
    pub guide_vane_demand_deg: R,
    /// What reaches the plant.
    pub actuation: Actuation<R>,
    /// The gas path.
    pub point: Point<R>,
    /// Torque of the generator, N m.
    pub load_n_m: R,
    /// The derivative of the state (18), in the order of [`State`].
    pub rates: [R; STATES],
}

impl<R: Real> Instant<R> {
    /// The plant at a state.
    #[inline(always)]
    pub fn at(
        plant: &PlantParameters,
        inputs: &Inputs<R>,
        faults: &FaultSizes<R>,
        x: &State<R>,
    ) -> Self {
        let zero = x.speed_rad_s.like(0.0);
        let (fuel_demand_kg_s, speed_integral_rate) = match plant.variant {
            Variant::Prototype => {
                let error = inputs.speed_reference_rad_s - x.speed_rad_s;
                let demand = plant.governor.demand(
                    error,
                    x.speed_error_integral_rad,
                    inputs.fuel_offset_kg_s,
                );
                (demand.fuel_kg_s, demand.integral_rate)
            }
            Variant::Cogeneration => {
                let fuel = inputs.fuel_offset_kg_s + plant.governor.design_fuel_kg_s;
                (plant.governor.limited(fuel), zero)
            }
        };
        let (fuel_kg_s, fuel_rate) = plant.actuator.respond(
            fuel_demand_kg_s,
            x.fuel_actuator_kg_s,
            &faults.fuel,
            plant.fuel_stops(),
        );
        let (valve_deg, valve_rate) = plant.actuator.respond(
            inputs.valve_deg,
            x.valve_actuator_deg,
            &faults.valve,
            VALVE_STOPS_DEG,
        );
        let actuation = Actuation {
            fuel_kg_s,
            valve_deg,
            guide_vane_deg: x.guide_vane_deg,
        };
        let point = Point::at(plant, inputs, faults, x, &actuation);
        let mut instant = Self {
            fuel_demand_kg_s,
            guide_vane_demand_deg: zero,
            actuation,
            point,
            load_n_m: zero,
            rates: [zero; STATES],
        };
        instant.rates[11] = fuel_rate;
        instant.rates[12] = valve_rate;
        instant.rates[13] = speed_integral_rate;
        if plant.variant == Variant::Cogeneration {
            instant.connect_to_the_mains(plant, inputs, faults, x);
        }
        let gas_path = point.rates(plant, inputs, x, instant.load_n_m);
        instant.rates[..gas_path.len()].copy_from_slice(&gas_path);
        instant
    }

    /// Generator and guide vanes.
    #[inline(always)]
    fn connect_to_the_mains(
        &mut self,
        plant: &PlantParameters,
        inputs: &Inputs<R>,
        faults: &FaultSizes<R>,
        x: &State<R>,
    ) {
        let (generator, vanes) = (&plant.generator, &plant.guide_vanes);
        let grid = inputs.speed_reference_rad_s;
        let slip = x.speed_rad_s - grid;
        self.load_n_m = generator.torque_n_m(x.load_angle_rad, slip, grid);
        let reading_rate = vanes.reading_rate(self.point.t7_k, x.exhaust_reading_k);
        let (demand, integral_rate) = vanes.demand(
            x.exhaust_reading_k,
            reading_rate,
            x.exhaust_error_integral_k_s,
        );
        self.guide_vane_demand_deg = demand;
        let commanded = between(vanes.stops_deg(), faults.guide_vanes.position(demand));
        self.rates[14] = generator.angle_rate(slip);
        self.rates[15] = reading_rate;
        self.rates[16] = integral_rate;
        self.rates[17] = vanes.angle_rate(commanded, x.guide_vane_deg, faults.guide_vanes.lag_s);
    }
}

/// The derivative of the state (18).
#[inline(always)]
pub fn derivative<R: Real>(
    plant: &PlantParameters,
    inputs: &Inputs<R>,
    faults: &FaultSizes<R>,
    x: &[R; STATES],
) -> [R; STATES] {
    Instant::at(plant, inputs, faults, &State::from_array(x)).rates
}
