//! The recorded channels: names and units of inputs and outputs, in the order of the records.

use std::f64::consts::PI;

use gt_core::Signal;

use crate::dynamics::Instant;
use crate::inputs::Inputs;
use crate::real::Real;
use crate::state::State;
use crate::variant::Variant;

/// Most inputs of a record.
pub const INPUTS: usize = 7;
/// Most measured outputs of a record.
pub const OUTPUTS: usize = 31;
/// All outputs: the measured ones, then those that only the simulator knows.
pub const ALL_OUTPUTS: usize = OUTPUTS + HIDDEN_CHANNELS.len();

/// What a channel measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Opening angle of the valve.
    ValveAngle,
    /// Demanded fuel flow.
    FuelDemand,
    /// A set value or a property of the fuel, which is known exactly.
    Known,
    /// Ambient pressure.
    AmbientPressure,
    /// Ambient temperature.
    AmbientTemperature,
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
    /// Angle of the guide vanes.
    VaneAngle,
    /// An efficiency.
    Efficiency,
}

/// Name, unit, kind.
pub type Description = (&'static str, &'static str, Quantity);

/// Inputs; the guide vanes' angle in cogeneration only. It is the position, read with the outputs:
/// outputs depend on it at once (`nk = 0`), as on `M_f`.
pub(crate) const INPUT_CHANNELS: [Description; INPUTS] = [
    ("a_v", "deg", Quantity::ValveAngle),
    ("M_f", "kg/s", Quantity::FuelDemand),
    ("w_ref", "rad/s", Quantity::Known),
    ("p_a", "Pa", Quantity::AmbientPressure),
    ("T_a", "K", Quantity::AmbientTemperature),
    ("LHV", "J/kg", Quantity::Known),
    ("IGV", "deg", Quantity::VaneAngle),
];

/// What only the simulator knows: the efficiencies of Table 3 and the fuel flow that reaches the
/// combustor, which a lazy actuator keeps apart from the demand `M_f`.
pub const HIDDEN_CHANNELS: [Description; 3] = [
    ("e_c", "", Quantity::Efficiency),
    ("e_t", "", Quantity::Efficiency),
    ("M_fc", "kg/s", Quantity::MassFlow),
];

/// Outputs: the 28 of Table 3 of the paper (p7 and t7 by elimination), and in cogeneration the
/// electric power, the reading of the exhaust thermocouple and the exhaust flow.
pub(crate) const OUTPUT_CHANNELS: [Description; OUTPUTS] = [
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
    ("P_e", "W", Quantity::Power),
    ("T_ot", "K", Quantity::Temperature),
    ("m_ot", "kg/s", Quantity::MassFlow),
];

impl Variant {
    /// The inputs that a record of this variant holds.
    pub fn input_channels(self) -> &'static [Description] {
        match self {
            Self::Prototype => &INPUT_CHANNELS[..6],
            Self::Cogeneration => &INPUT_CHANNELS,
        }
    }

    /// The measured outputs of a record of this variant.
    pub fn output_channels(self) -> &'static [Description] {
        match self {
            Self::Prototype => &OUTPUT_CHANNELS[..28],
            Self::Cogeneration => &OUTPUT_CHANNELS,
        }
    }
}

/// The signals of channels.
pub fn signals<'a>(channels: impl IntoIterator<Item = &'a Description>) -> Vec<Signal> {
    channels
        .into_iter()
        .map(|(name, unit, _)| Signal::new(*name, *unit))
        .collect()
}

/// The inputs of a record as the plant has them, and the demanded fuel flow.
pub(crate) fn recorded_inputs(inputs: &Inputs, fuel_kg_s: f64, x: &State) -> [f64; INPUTS] {
    [
        inputs.valve_deg,
        fuel_kg_s,
        inputs.speed_reference_rad_s,
        inputs.ambient_pa,
        inputs.ambient_k,
        inputs.heating_value_j_kg,
        x.guide_vane_deg,
    ]
}

/// All outputs of the plant at an instant: those of cogeneration, then [`HIDDEN_CHANNELS`].
///
/// m1 is the measured one of two intake legs; t6 = t5 because the bleed mixes in upstream. `P_e`
/// is meaningless where no generator is.
#[inline(always)]
pub fn outputs<R: Real>(
    plant: &crate::PlantParameters,
    inputs: &Inputs<R>,
    x: &State<R>,
    instant: &Instant<R>,
) -> [R; ALL_OUTPUTS] {
    let point = &instant.point;
    let w = x.speed_rad_s;
    [
        x.p1_pa,
        point.p2_pa,
        x.p3_pa,
        x.p4_pa,
        x.p5_pa,
        x.p7_pa,
        x.p8_pa,
        x.intake_flow_kg_s * plant.intake.measured_leg_share,
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
        w * (30.0 / PI),
        plant.generator.terminal_w(instant.load_n_m * w),
        x.exhaust_reading_k,
        x.exhaust_flow_kg_s,
        point.compressor_efficiency(inputs, x.p3_pa),
        point.expansion.efficiency,
        instant.actuation.fuel_kg_s,
    ]
}
