//! The measured channels: names and units of inputs and outputs, in the order of the records.

use std::f64::consts::PI;

use gt_core::Signal;

use crate::dynamics::Point;
use crate::state::State;

/// Number of inputs of a record.
pub const INPUTS: usize = 5;
/// Number of outputs of a record.
pub const OUTPUTS: usize = 28;

/// What a channel measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Opening angle of the valve.
    ValveAngle,
    /// Demanded fuel flow.
    FuelDemand,
    /// Set values and ambient conditions, which are known exactly.
    Known,
    /// A pressure.
    Pressure,
    /// A mass flow.
    MassFlow,
    /// A temperature.
    Temperature,
    /// A torque.
    Torque,
    /// A power.
    Power,
    /// A rotational speed.
    Speed,
}

/// Inputs: name, unit, kind.
pub const INPUT_CHANNELS: [(&str, &str, Quantity); INPUTS] = [
    ("a_v", "deg", Quantity::ValveAngle),
    ("M_f", "kg/s", Quantity::FuelDemand),
    ("w_ref", "rad/s", Quantity::Known),
    ("p_a", "Pa", Quantity::Known),
    ("T_a", "K", Quantity::Known),
];

/// Outputs: name, unit, kind (Table 3 of the paper; p7 and t7 as decoded in the spec).
pub const OUTPUT_CHANNELS: [(&str, &str, Quantity); OUTPUTS] = [
    ("p1", "Pa", Quantity::Pressure),
    ("p2", "Pa", Quantity::Pressure),
    ("p3", "Pa", Quantity::Pressure),
    ("p4", "Pa", Quantity::Pressure),
    ("p5", "Pa", Quantity::Pressure),
    ("p7", "Pa", Quantity::Pressure),
    ("p8", "Pa", Quantity::Pressure),
    ("m1", "kg/s", Quantity::MassFlow),
    ("m3", "kg/s", Quantity::MassFlow),
    ("m4", "kg/s", Quantity::MassFlow),
    ("m5", "kg/s", Quantity::MassFlow),
    ("m6", "kg/s", Quantity::MassFlow),
    ("m8", "kg/s", Quantity::MassFlow),
    ("m9", "kg/s", Quantity::MassFlow),
    ("m10", "kg/s", Quantity::MassFlow),
    ("t1", "K", Quantity::Temperature),
    ("t2", "K", Quantity::Temperature),
    ("t3", "K", Quantity::Temperature),
    ("t4", "K", Quantity::Temperature),
    ("t5", "K", Quantity::Temperature),
    ("t6", "K", Quantity::Temperature),
    ("t7", "K", Quantity::Temperature),
    ("q_c", "N m", Quantity::Torque),
    ("q_t", "N m", Quantity::Torque),
    ("P_c", "W", Quantity::Power),
    ("P_t", "W", Quantity::Power),
    ("w_t", "rad/s", Quantity::Speed),
    ("N_t", "rpm", Quantity::Speed),
];

/// Row of the thermocouple t3 among the outputs.
pub(crate) const T3: usize = 17;

/// The input signals.
pub fn input_signals() -> Vec<Signal> {
    INPUT_CHANNELS
        .iter()
        .map(|(name, unit, _)| Signal::new(*name, *unit))
        .collect()
}

/// The output signals.
pub fn output_signals() -> Vec<Signal> {
    OUTPUT_CHANNELS
        .iter()
        .map(|(name, unit, _)| Signal::new(*name, *unit))
        .collect()
}

/// The outputs of a state and its operating point, in the order of [`OUTPUT_CHANNELS`].
///
/// m1 is one of two equal intake legs; t6 = t5 because the bleed mixes in upstream.
pub fn outputs(x: &State, point: &Point) -> [f64; OUTPUTS] {
    let w = x.speed_rad_s;
    [
        x.p1_pa,
        point.p2_pa,
        x.p3_pa,
        x.p4_pa,
        x.p5_pa,
        x.p7_pa,
        x.p8_pa,
        0.5 * x.intake_flow_kg_s,
        point.compression.flow_kg_s,
        x.m4_kg_s,
        x.m5_kg_s,
        point.m6_kg_s,
        point.expansion.flow_kg_s,
        point.m9_kg_s,
        point.m10_kg_s,
        point.t1_k,
        point.t2_k,
        point.compression.exit_k,
        point.t4_k,
        point.t5_k,
        point.t5_k,
        point.t7_k,
        point.compression.power_w / w,
        point.expansion.power_w / w,
        point.compression.power_w,
        point.expansion.power_w,
        w,
        w * 30.0 / PI,
    ]
}
