//! The parameters of the prototype, each with its unit and its source.
//!
//! Sources: *paper* is printed in Table 3, *derived* follows from Table 3 with the stated laws,
//! *assumed* is a choice that the paper does not settle.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::PlantError;
use crate::components::actuator::Actuator;
use crate::components::bleed::Bleed;
use crate::components::combustor::Combustor;
use crate::components::compressor::Compressor;
use crate::components::duct::Duct;
use crate::components::exhaust::Exhaust;
use crate::components::governor::Governor;
use crate::components::intake::Intake;
use crate::components::shaft::Shaft;
use crate::components::turbine::Turbine;
use crate::components::valve::Valve;
use crate::components::volume::Volume;
use crate::state::State;

/// Which compressor map: the paper prints none.
///
/// `Paper` has flat exponents, defensible only near choke, that were chosen because the plant then
/// shows the signature of the paper's Tables 2 and 9; `Axial` has exponents usual for an axial
/// machine and does not show all of it. A claim that holds with both rests on no such choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapSet {
    /// `aPR, am, s0 = 1.2, 0.4, 0.5` (assumed, chosen for the signature).
    #[default]
    Paper,
    /// `aPR, am, s0 = 2.2, 1.6, 0.12` (assumed, usual for axial machines).
    Axial,
}

impl MapSet {
    /// The names, in the order of the variants.
    pub const NAMES: &[&str] = &["paper", "axial"];
}

impl fmt::Display for MapSet {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Paper => "paper",
            Self::Axial => "axial",
        })
    }
}

impl FromStr for MapSet {
    type Err = PlantError;

    fn from_str(name: &str) -> Result<Self, PlantError> {
        match name {
            "paper" => Ok(Self::Paper),
            "axial" => Ok(Self::Axial),
            _ => Err(PlantError::UnknownName {
                what: "map set",
                expected: Self::NAMES,
                found: name.to_owned(),
            }),
        }
    }
}

/// The steady state of the paper's Table 3 at which the plant is calibrated, where the search for
/// an equilibrium starts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignPoint {
    /// Ambient pressure `p_a`, Pa (paper).
    pub ambient_pa: f64,
    /// Ambient temperature `T_a`, K (paper).
    pub ambient_k: f64,
    /// Valve angle `a_v`, degrees (paper).
    pub valve_deg: f64,
    /// Speed `w_t`, rad/s (paper); the governor's set point.
    pub speed_rad_s: f64,
    /// Intake flow, kg/s (derived: reconciled flows).
    pub intake_flow_kg_s: f64,
    /// Combustor air flow m5, kg/s (derived: reconciled flows).
    pub combustor_flow_kg_s: f64,
    /// Exhaust flow, kg/s (derived: reconciled flows).
    pub exhaust_flow_kg_s: f64,
    /// Pressures p1, p3, p4, p5, p7, p8, Pa (paper).
    pub pressures_pa: [f64; 6],
}

impl DesignPoint {
    /// The design point as a state, with the fuel flow `fuel_kg_s`.
    pub(crate) fn state(&self, fuel_kg_s: f64) -> State {
        let [p1_pa, p3_pa, p4_pa, p5_pa, p7_pa, p8_pa] = self.pressures_pa;
        State {
            speed_rad_s: self.speed_rad_s,
            intake_flow_kg_s: self.intake_flow_kg_s,
            p1_pa,
            p3_pa,
            m4_kg_s: self.intake_flow_kg_s,
            p4_pa,
            m5_kg_s: self.combustor_flow_kg_s,
            p5_pa,
            p7_pa,
            p8_pa,
            exhaust_flow_kg_s: self.exhaust_flow_kg_s,
            speed_error_integral_rad: 0.0,
            actuator_fuel_kg_s: fuel_kg_s,
        }
    }
}

/// All parameters of the turbine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantParameters {
    /// The calibrated steady state.
    pub design: DesignPoint,
    /// Intake.
    pub intake: Intake,
    /// Compressor.
    pub compressor: Compressor,
    /// Volume at the compressor exit, station 3 (assumed).
    pub compressor_exit: Volume,
    /// Duct from station 3 to 4 (inertance assumed, loss derived from Table 3).
    pub diffuser: Duct,
    /// Volume at the combustor inlet, station 4 (assumed).
    pub combustor_inlet: Volume,
    /// Bleed m6, which mixes in upstream of the turbine.
    pub turbine_bleed: Bleed,
    /// Bleed m10, which mixes in downstream of the turbine.
    pub exhaust_bleed: Bleed,
    /// Duct from station 4 to 5 (inertance assumed, loss derived from Table 3).
    pub liner: Duct,
    /// Combustor.
    pub combustor: Combustor,
    /// Volume at the combustor exit, station 5 (assumed).
    pub combustor_exit: Volume,
    /// Turbine.
    pub turbine: Turbine,
    /// Exhaust.
    pub exhaust: Exhaust,
    /// Butterfly valve.
    pub valve: Valve,
    /// Shaft.
    pub shaft: Shaft,
    /// Speed governor.
    pub governor: Governor,
    /// Fuel actuator.
    pub actuator: Actuator,
}

impl PlantParameters {
    /// The parameters with the given compressor map; sources stand with the fields.
    pub fn for_maps(map_set: MapSet) -> Self {
        let [pressure_exponent, flow_exponent, line_slope] = match map_set {
            MapSet::Paper => [1.2, 0.4, 0.5],
            MapSet::Axial => [2.2, 1.6, 0.12],
        };
        let duct = |inertance_per_m, loss_pa_s2_kg2, head_pa| Duct {
            inertance_per_m,
            loss_pa_s2_kg2,
            head_pa,
        };
        let volume = |volume_m3| Volume { volume_m3 };
        Self {
            design: DesignPoint {
                ambient_pa: 101325.0,
                ambient_k: 288.16,
                valve_deg: 48.4934,
                speed_rad_s: 1660.2491,
                intake_flow_kg_s: 16.6638,
                combustor_flow_kg_s: 13.2319,
                exhaust_flow_kg_s: 16.8760,
                pressures_pa: [
                    102066.2356,
                    1014989.5034,
                    978218.3118,
                    929453.2286,
                    206408.6312,
                    100900.0,
                ],
            },
            intake: Intake {
                duct: duct(12.0, 7.2024774, 2741.2356),
                plenum: volume(0.5),
                plenum_temperature_ratio: 1.0127932,
                inlet_temperature_ratio: 0.94993635,
                inlet_loss_pa_s2_kg2: 0.79432811,
            },
            compressor: Compressor {
                design_flow_kg_s: 16.261601,
                design_pressure_ratio: 9.9659569,
                design_corrected_speed: 99.712305,
                design_efficiency: 0.83943697,
                pressure_exponent,
                flow_exponent,
                line_slope,
                efficiency_speed_curvature: 0.6,
                efficiency_pressure_curvature: 0.25,
                exit_temperature_ratio: 0.99941,
            },
            compressor_exit: volume(0.08),
            diffuser: duct(8.0, 132.42184, 0.0),
            combustor_inlet: volume(0.20),
            turbine_bleed: Bleed {
                flow_function: 4.8432304e-5,
            },
            exhaust_bleed: Bleed {
                flow_function: 3.5855132e-5,
            },
            liner: duct(10.0, 278.52524, 0.0),
            combustor: Combustor {
                effective_heating_value_j_kg: 46.984711e6,
            },
            combustor_exit: volume(0.15),
            turbine: Turbine {
                flow_constant: 5.7430714e-4,
                design_efficiency: 0.80811502,
                design_velocity_ratio: 2.5880762,
                efficiency_curvature: 1.0,
            },
            exhaust: Exhaust {
                turbine_exit: volume(0.8),
                duct_volume: volume(2.0),
                duct: duct(15.0, 10.533681, 3425.0),
            },
            valve: Valve {
                full_area_m2: 0.17558347,
            },
            shaft: Shaft {
                inertia_kg_m2: 4.0,
                loss_n_m_s2: 4.37029e-6,
            },
            governor: Governor {
                proportional_gain: 1.4e-3,
                integral_gain: 1.0e-3,
                design_fuel_kg_s: 0.21224,
                minimum_fuel_kg_s: 0.05,
                maximum_fuel_kg_s: 0.35,
            },
            actuator: Actuator {
                shortest_lag_s: 0.01,
            },
        }
    }
}
