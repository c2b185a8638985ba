//! The derivative of the state: the parts of the turbine put together. Nothing here allocates.
//!
//! Stations (spec section 1): 0 ambient; 1 intake plenum; 2 compressor inlet; 3 compressor exit;
//! 4 combustor inlet, where the bleeds m6 and m10 leave; 5 = 6 combustor exit after m6 has mixed
//! in; 7 turbine exit after m10 has mixed in; valve; 8 exhaust duct.

use crate::PlantParameters;
use crate::channels::{OUTPUT_CHANNELS, OUTPUTS, outputs};
use crate::components::compressor::Compression;
use crate::components::exhaust::mixed_k;
use crate::components::governor::Demand;
use crate::components::turbine::Expansion;
use crate::faults::FaultSizes;
use crate::gas::Gas;
use crate::state::{GAS_PATH_STATES, STATES, State};
use crate::{PlantError, channels::Quantity};

/// Ratio of heat capacities of air in the intake plenum.
const PLENUM_GAMMA: f64 = 1.4;

/// Temperatures outside leave the heat capacity polynomial's range, K.
const TEMPERATURE_RANGE_K: (f64, f64) = (200.0, 2000.0);

/// What acts on the plant from outside, constant over a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Opening angle of the valve, degrees.
    pub valve_deg: f64,
    /// Speed reference, rad/s.
    pub speed_reference_rad_s: f64,
    /// Dither added to the fuel demand, kg/s.
    pub fuel_dither_kg_s: f64,
    /// Ambient pressure, Pa.
    pub ambient_pa: f64,
    /// Ambient temperature, K.
    pub ambient_k: f64,
}

impl Inputs {
    /// The inputs of the design point.
    pub fn design(parameters: &PlantParameters) -> Self {
        Self {
            valve_deg: parameters.design.valve_deg,
            speed_reference_rad_s: parameters.design.speed_rad_s,
            fuel_dither_kg_s: 0.0,
            ambient_pa: parameters.design.ambient_pa,
            ambient_k: parameters.design.ambient_k,
        }
    }
}

/// The algebraic quantities of the gas path at one state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Fuel flow that reaches the combustor, kg/s.
    pub fuel_kg_s: f64,
    /// Plenum temperature, K.
    pub t1_k: f64,
    /// Compressor inlet temperature, K.
    pub t2_k: f64,
    /// Compressor inlet pressure, Pa.
    pub p2_pa: f64,
    /// The compressor's operating point.
    pub compression: Compression,
    /// Combustor inlet temperature, K.
    pub t4_k: f64,
    /// Bleed that mixes in upstream of the turbine, kg/s.
    pub m6_kg_s: f64,
    /// Bleed that mixes in downstream of the turbine, kg/s.
    pub m10_kg_s: f64,
    /// Flow out of the combustor before m6 mixes in, kg/s.
    pub m9_kg_s: f64,
    /// Turbine inlet temperature, K.
    pub t5_k: f64,
    /// The turbine's operating point.
    pub expansion: Expansion,
    /// Turbine exit temperature after mixing, K.
    pub t7_k: f64,
    /// Flow through the valve, kg/s.
    pub valve_flow_kg_s: f64,
    /// Products at the turbine inlet.
    pub turbine_gas: Gas,
    /// Ratio of heat capacities at the turbine exit after mixing.
    pub exit_gamma: f64,
}

/// The gas path at a state, for a fuel flow and fault sizes.
pub fn operating_point(
    parameters: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    x: &State,
    fuel_kg_s: f64,
) -> Point {
    let w = x.speed_rad_s;
    let t1_k = parameters.intake.plenum_temperature_k(inputs.ambient_k);
    let t2_k = parameters.intake.inlet_temperature_k(t1_k);
    let p2_pa = parameters
        .intake
        .inlet_pressure_pa(x.p1_pa, x.intake_flow_kg_s);
    let compression =
        parameters
            .compressor
            .compress([p2_pa, t2_k], x.p3_pa, w, faults.compressor_flow_loss);
    let t4_k = parameters.compressor.exit_temperature_ratio * compression.exit_k;
    let root_t4 = t4_k.sqrt();
    let m6_kg_s = parameters.turbine_bleed.flow_kg_s(x.p4_pa, root_t4);
    let m10_kg_s = parameters.exhaust_bleed.flow_kg_s(x.p4_pa, root_t4);
    let m9_kg_s = x.m5_kg_s + fuel_kg_s;
    let air_kg_s = x.m5_kg_s + m6_kg_s;
    let turbine_gas = Gas::products(fuel_kg_s / air_kg_s);
    let t5_k = parameters
        .combustor
        .exit_k(air_kg_s, t4_k, fuel_kg_s, &turbine_gas);
    let expansion = parameters.turbine.expand(
        &turbine_gas,
        [x.p5_pa, t5_k],
        x.p7_pa,
        w,
        faults.turbine_efficiency_loss,
    );
    let exit_gas = Gas::products(fuel_kg_s / (air_kg_s + m10_kg_s));
    let hot = (expansion.flow_kg_s, turbine_gas.enthalpy(expansion.exit_k));
    let cold = (m10_kg_s, Gas::AIR.enthalpy(t4_k));
    let t7_k = mixed_k(hot, cold, &exit_gas, expansion.exit_k);
    let exit_gamma = exit_gas.heat_capacity_ratio(t7_k);
    let valve_flow_kg_s =
        parameters
            .valve
            .flow_kg_s(inputs.valve_deg, [x.p7_pa, t7_k], x.p8_pa, exit_gamma);
    Point {
        fuel_kg_s,
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

/// Derivatives of the 11 states of gas path and rotor, in the order of [`State`].
pub fn gas_path_rates(
    parameters: &PlantParameters,
    inputs: &Inputs,
    x: &State,
    point: &Point,
) -> [f64; GAS_PATH_STATES] {
    let p = parameters;
    let w = x.speed_rad_s;
    let Compression {
        flow_kg_s: mc,
        exit_k: t3,
        power_w: pc,
        ..
    } = point.compression;
    let Expansion {
        flow_kg_s: m8,
        power_w: pt,
        ..
    } = point.expansion;
    let (m6, m10, t4, t5, t7) = (
        point.m6_kg_s,
        point.m10_kg_s,
        point.t4_k,
        point.t5_k,
        point.t7_k,
    );
    let valve = point.valve_flow_kg_s;
    let gamma3 = Gas::AIR.heat_capacity_ratio(t3);
    let gamma4 = Gas::AIR.heat_capacity_ratio(t4);
    let gamma5 = point.turbine_gas.heat_capacity_ratio(t5);
    let gamma7 = point.exit_gamma;
    [
        p.shaft.acceleration(pt / w, pc / w, w),
        p.intake
            .duct
            .flow_rate(inputs.ambient_pa, x.p1_pa, x.intake_flow_kg_s),
        p.intake
            .plenum
            .pressure_rate(PLENUM_GAMMA, point.t1_k, x.intake_flow_kg_s - mc),
        p.compressor_exit.pressure_rate(gamma3, t3, mc - x.m4_kg_s),
        p.diffuser.flow_rate(x.p3_pa, x.p4_pa, x.m4_kg_s),
        p.combustor_inlet
            .pressure_rate(gamma4, t4, x.m4_kg_s - m6 - m10 - x.m5_kg_s),
        p.liner.flow_rate(x.p4_pa, x.p5_pa, x.m5_kg_s),
        p.combustor_exit
            .pressure_rate(gamma5, t5, point.m9_kg_s + m6 - m8),
        p.exhaust
            .turbine_exit
            .pressure_rate(gamma7, t7, m8 + m10 - valve),
        p.exhaust
            .duct_volume
            .pressure_rate(gamma7, t7, valve - x.exhaust_flow_kg_s),
        p.exhaust
            .duct
            .flow_rate(x.p8_pa, inputs.ambient_pa, x.exhaust_flow_kg_s),
    ]
}

/// What the governor asks for at a state.
pub fn demand(parameters: &PlantParameters, inputs: &Inputs, x: &State) -> Demand {
    let error_rad_s = inputs.speed_reference_rad_s - x.speed_rad_s;
    parameters.governor.demand(
        error_rad_s,
        x.speed_error_integral_rad,
        inputs.fuel_dither_kg_s,
    )
}

/// The derivative of the state (13).
pub fn derivative(
    parameters: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    x: &[f64; STATES],
) -> [f64; STATES] {
    let x = State::from_array(x);
    let demand = demand(parameters, inputs, &x);
    let (fuel_kg_s, actuator_rate) =
        parameters
            .actuator
            .respond(demand.fuel_kg_s, x.actuator_fuel_kg_s, faults.fuel_lag_s);
    let point = operating_point(parameters, inputs, faults, &x, fuel_kg_s);
    let [w, mi, p1, p3, m4, p4, m5, p5, p7, p8, mex] =
        gas_path_rates(parameters, inputs, &x, &point);
    [
        w,
        mi,
        p1,
        p3,
        m4,
        p4,
        m5,
        p5,
        p7,
        p8,
        mex,
        demand.integral_rate,
        actuator_rate,
    ]
}

/// A sample: the governor's demand and the true outputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// What the governor asks for.
    pub demand: Demand,
    /// The true outputs, in the order of [`OUTPUT_CHANNELS`].
    pub outputs: [f64; OUTPUTS],
}

/// Demand and true outputs at a state.
///
/// # Errors
/// [`PlantError::OutOfRange`] when the state or a temperature left the model's validity.
pub fn sample(
    parameters: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    x: &State,
    time_s: f64,
) -> Result<Sample, PlantError> {
    x.check(time_s)?;
    let demand = demand(parameters, inputs, x);
    let (fuel_kg_s, _) =
        parameters
            .actuator
            .respond(demand.fuel_kg_s, x.actuator_fuel_kg_s, faults.fuel_lag_s);
    let point = operating_point(parameters, inputs, faults, x, fuel_kg_s);
    let outputs = outputs(x, &point);
    check_outputs(&outputs, time_s)?;
    Ok(Sample { demand, outputs })
}

fn check_outputs(outputs: &[f64; OUTPUTS], time_s: f64) -> Result<(), PlantError> {
    for (&found, &(quantity, _, kind)) in outputs.iter().zip(&OUTPUT_CHANNELS) {
        let (low, high) = match kind {
            Quantity::Temperature => TEMPERATURE_RANGE_K,
            // Everything else is positive in forward running; the states bound it from above.
            _ => (0.0, f64::MAX),
        };
        if !(low < found && found < high) {
            return Err(PlantError::OutOfRange {
                time_s,
                quantity,
                low,
                high,
                found,
            });
        }
    }
    Ok(())
}
