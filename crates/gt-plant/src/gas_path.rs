//! The gas path at one state: the parts of the turbine put together. Nothing here allocates.
//!
//! Stations: 0 ambient; 1 intake plenum; 2 compressor inlet; 3 compressor exit; 4 combustor inlet,
//! where the bleeds m6 and m10 leave; 5 = 6 combustor exit after m6 has mixed in; 7 turbine exit
//! after m10 has mixed in; valve; 8 exhaust duct.

use crate::PlantParameters;
use crate::components::compressor::Compression;
use crate::components::exhaust::mixed_k;
use crate::components::turbine::Expansion;
use crate::faults::FaultSizes;
use crate::gas::{Gas, air};
use crate::inputs::Inputs;
use crate::real::Real;
use crate::state::{GAS_PATH_STATES, State};

/// Ratio of heat capacities of air in the intake plenum.
const PLENUM_GAMMA: f64 = 1.4;

/// The algebraic quantities of the gas path at one state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<R = f64> {
    /// Fuel flow that reaches the combustor, kg/s.
    pub fuel_kg_s: R,
    /// Heat released in the combustor, W.
    pub released_w: R,
    /// Plenum temperature, K.
    pub t1_k: R,
    /// Compressor inlet temperature, K.
    pub t2_k: R,
    /// Compressor inlet pressure, Pa.
    pub p2_pa: R,
    /// The compressor's operating point.
    pub compression: Compression<R>,
    /// Combustor inlet temperature, K.
    pub t4_k: R,
    /// Bleed that mixes in upstream of the turbine, kg/s.
    pub m6_kg_s: R,
    /// Bleed that mixes in downstream of the turbine, kg/s.
    pub m10_kg_s: R,
    /// Flow out of the combustor before m6 mixes in, kg/s.
    pub m9_kg_s: R,
    /// Turbine inlet temperature, K.
    pub t5_k: R,
    /// The turbine's operating point.
    pub expansion: Expansion<R>,
    /// Turbine exit temperature after mixing, K.
    pub t7_k: R,
    /// Flow through the valve, kg/s.
    pub valve_flow_kg_s: R,
    /// Products at the turbine inlet.
    pub turbine_gas: Gas<R>,
    /// Ratio of heat capacities at the turbine exit after mixing.
    pub exit_gamma: R,
}

/// What the actuators set: fuel flow, valve angle and guide vane angle as they reach the plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Actuation<R = f64> {
    /// Fuel flow, kg/s.
    pub fuel_kg_s: R,
    /// Valve angle, degrees.
    pub valve_deg: R,
    /// Guide vane angle, degrees from open.
    pub guide_vane_deg: R,
}

impl<R: Real> Point<R> {
    /// The gas path at a state, for what the actuators set and fault sizes.
    #[inline(always)]
    pub fn at(
        plant: &PlantParameters,
        inputs: &Inputs<R>,
        faults: &FaultSizes<R>,
        x: &State<R>,
        actuation: &Actuation<R>,
    ) -> Self {
        let w = x.speed_rad_s;
        let fuel_kg_s = actuation.fuel_kg_s;
        let t1_k = plant.intake.plenum_temperature_k(inputs.ambient_k);
        let t2_k = plant.intake.inlet_temperature_k(t1_k);
        let p2_pa = plant.intake.inlet_pressure_pa(x.p1_pa, x.intake_flow_kg_s);
        let compression = plant.compressor.compress(
            [p2_pa, t2_k],
            x.p3_pa,
            w,
            faults.compressor_flow_loss,
            &plant.guide_vanes.effect(actuation.guide_vane_deg),
        );
        let t4_k = compression.exit_k * plant.compressor.exit_temperature_ratio;
        let root_t4 = t4_k.sqrt();
        let m6_kg_s = plant.turbine_bleed.flow_kg_s(x.p4_pa, root_t4);
        let m10_kg_s = plant.exhaust_bleed.flow_kg_s(x.p4_pa, root_t4);
        let m9_kg_s = x.m5_kg_s + fuel_kg_s;
        let air_kg_s = x.m5_kg_s + m6_kg_s;
        let turbine_gas = Gas::products(fuel_kg_s / air_kg_s);
        let released_w = plant
            .combustor
            .released_w(fuel_kg_s, inputs.heating_value_j_kg)
            * (inputs.heat_release_fraction + 1.0);
        let t5_k = plant
            .combustor
            .exit_k([air_kg_s, fuel_kg_s], t4_k, released_w, &turbine_gas);
        let expansion = plant.turbine.expand(
            &turbine_gas,
            [x.p5_pa, t5_k],
            x.p7_pa,
            w,
            faults.turbine_efficiency_loss,
        );
        let exit_gas = Gas::products(fuel_kg_s / (air_kg_s + m10_kg_s));
        let hot = [expansion.flow_kg_s, turbine_gas.enthalpy(expansion.exit_k)];
        let cold = [m10_kg_s, air::enthalpy(t4_k)];
        let t7_k = mixed_k(hot, cold, &exit_gas, expansion.exit_k);
        let exit_gamma = exit_gas.heat_capacity_ratio(t7_k);
        let valve_flow_kg_s =
            plant
                .valve
                .flow_kg_s(actuation.valve_deg, [x.p7_pa, t7_k], x.p8_pa, exit_gamma);
        Self {
            fuel_kg_s,
            released_w,
            t1_k,
            t2_k,
            p2_pa,
            compression,
            t4_k,
            m6_kg_s,
            m10_kg_s,
            m9_kg_s,
            t5_k,
            expansion,
            t7_k,
            valve_flow_kg_s,
            turbine_gas,
            exit_gamma,
        }
    }

    /// Derivatives of the 11 states of gas path and rotor, in the order of [`State`], where the
    /// generator brakes with `load_n_m`.
    #[inline(always)]
    pub fn rates(
        &self,
        plant: &PlantParameters,
        inputs: &Inputs<R>,
        x: &State<R>,
        load_n_m: R,
    ) -> [R; GAS_PATH_STATES] {
        let w = x.speed_rad_s;
        let (m3, m8) = (self.compression.flow_kg_s, self.expansion.flow_kg_s);
        let (t3, t4, t5, t7) = (self.compression.exit_k, self.t4_k, self.t5_k, self.t7_k);
        let net_n_m =
            (self.expansion.power_w - self.compression.power_w) / w - load_n_m + inputs.torque_n_m;
        let coupled_kg_m2 = plant.coupled_inertia_kg_m2();
        let gamma3 = air::heat_capacity_ratio(t3);
        let gamma4 = air::heat_capacity_ratio(t4);
        let gamma5 = self.turbine_gas.heat_capacity_ratio(t5);
        let gamma7 = self.exit_gamma;
        let out4 = self.m6_kg_s + self.m10_kg_s + x.m5_kg_s;
        let (valve, exhaust) = (self.valve_flow_kg_s, x.exhaust_flow_kg_s);
        [
            plant.shaft.acceleration(net_n_m, w, coupled_kg_m2),
            plant
                .intake
                .duct
                .flow_rate(inputs.ambient_pa, x.p1_pa, x.intake_flow_kg_s),
            plant.intake.plenum.pressure_rate(
                w.like(PLENUM_GAMMA),
                self.t1_k,
                x.intake_flow_kg_s - m3,
            ),
            plant
                .compressor_exit
                .pressure_rate(gamma3, t3, m3 - x.m4_kg_s),
            plant.diffuser.flow_rate(x.p3_pa, x.p4_pa, x.m4_kg_s),
            plant
                .combustor_inlet
                .pressure_rate(gamma4, t4, x.m4_kg_s - out4),
            plant.liner.flow_rate(x.p4_pa, x.p5_pa, x.m5_kg_s),
            plant
                .combustor_exit
                .pressure_rate(gamma5, t5, self.m9_kg_s + self.m6_kg_s - m8),
            plant
                .exhaust
                .turbine_exit
                .pressure_rate(gamma7, t7, m8 + self.m10_kg_s - valve),
            plant
                .exhaust
                .duct_volume
                .pressure_rate(gamma7, t7, valve - exhaust),
            plant
                .exhaust
                .duct
                .flow_rate(x.p8_pa, inputs.ambient_pa, exhaust),
        ]
    }

    /// The compressor's efficiency as Table 3 has it: the isentropic enthalpy rise from ambient to
    /// p3 over the specific work `P_c / m3` (see [`crate::calibration`]).
    #[inline(always)]
    pub fn compressor_efficiency(&self, inputs: &Inputs<R>, p3_pa: R) -> R {
        let exit_k = air::isentropic_k(inputs.ambient_k, p3_pa / inputs.ambient_pa);
        (air::enthalpy(exit_k) - air::enthalpy(inputs.ambient_k)) * self.compression.flow_kg_s
            / self.compression.power_w
    }
}
