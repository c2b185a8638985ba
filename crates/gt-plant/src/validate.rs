//! What parameters are physically possible.

use crate::components::duct::Duct;
use crate::components::governor::Governor;
use crate::{PlantError, PlantParameters};

/// What a value must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    Positive,
    NotNegative,
    Finite,
    /// Above 0 and at most 1.
    Efficiency,
    /// Above 1.
    AboveOne,
    /// Above 0 and at most 90.
    Angle,
}

impl Rule {
    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Positive => value > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::Finite => true,
                Self::Efficiency => value > 0.0 && value <= 1.0,
                Self::AboveOne => value > 1.0,
                Self::Angle => value > 0.0 && value <= 90.0,
            }
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Positive => "a finite number above 0",
            Self::NotNegative => "a finite number of at least 0",
            Self::Finite => "a finite number",
            Self::Efficiency => "a number above 0 and at most 1",
            Self::AboveOne => "a finite number above 1",
            Self::Angle => "a number above 0 and at most 90",
        }
    }
}

impl PlantParameters {
    /// Refuses what is physically impossible.
    ///
    /// # Errors
    /// [`PlantError::Parameter`] with the first impossible value.
    pub fn validate(&self) -> Result<(), PlantError> {
        let numbers = self
            .design_numbers()
            .into_iter()
            .chain(self.cold_numbers())
            .chain(self.hot_numbers());
        for (name, found, rule) in numbers {
            if !rule.holds(found) {
                return Err(PlantError::Parameter {
                    name,
                    expected: rule.expected(),
                    found,
                });
            }
        }
        for &found in &self.design.pressures_pa {
            if !Rule::Positive.holds(found) {
                let expected = Rule::Positive.expected();
                return Err(PlantError::Parameter {
                    name: "design.pressures_pa",
                    expected,
                    found,
                });
            }
        }
        let Governor {
            design_fuel_kg_s,
            minimum_fuel_kg_s,
            maximum_fuel_kg_s,
            ..
        } = self.governor;
        if minimum_fuel_kg_s > design_fuel_kg_s {
            return Err(PlantError::Parameter {
                name: "governor.minimum_fuel_kg_s",
                expected: "at most governor.design_fuel_kg_s",
                found: minimum_fuel_kg_s,
            });
        }
        if maximum_fuel_kg_s < design_fuel_kg_s {
            return Err(PlantError::Parameter {
                name: "governor.maximum_fuel_kg_s",
                expected: "at least governor.design_fuel_kg_s",
                found: maximum_fuel_kg_s,
            });
        }
        Ok(())
    }

    fn design_numbers(&self) -> [(&'static str, f64, Rule); 14] {
        let (design, governor) = (&self.design, &self.governor);
        [
            ("design.ambient_pa", design.ambient_pa, Rule::Positive),
            ("design.ambient_k", design.ambient_k, Rule::Positive),
            ("design.valve_deg", design.valve_deg, Rule::Angle),
            ("design.speed_rad_s", design.speed_rad_s, Rule::Positive),
            (
                "design.intake_flow_kg_s",
                design.intake_flow_kg_s,
                Rule::Positive,
            ),
            (
                "design.combustor_flow_kg_s",
                design.combustor_flow_kg_s,
                Rule::Positive,
            ),
            (
                "design.exhaust_flow_kg_s",
                design.exhaust_flow_kg_s,
                Rule::Positive,
            ),
            (
                "governor.proportional_gain",
                governor.proportional_gain,
                Rule::NotNegative,
            ),
            (
                "governor.integral_gain",
                governor.integral_gain,
                Rule::Positive,
            ),
            (
                "governor.design_fuel_kg_s",
                governor.design_fuel_kg_s,
                Rule::Positive,
            ),
            (
                "governor.minimum_fuel_kg_s",
                governor.minimum_fuel_kg_s,
                Rule::NotNegative,
            ),
            (
                "governor.maximum_fuel_kg_s",
                governor.maximum_fuel_kg_s,
                Rule::Positive,
            ),
            (
                "actuator.shortest_lag_s",
                self.actuator.shortest_lag_s,
                Rule::Positive,
            ),
            (
                "shaft.inertia_kg_m2",
                self.shaft.inertia_kg_m2,
                Rule::Positive,
            ),
        ]
    }

    fn cold_numbers(&self) -> [(&'static str, f64, Rule); 23] {
        let (intake, compressor) = (&self.intake, &self.compressor);
        let Duct {
            inertance_per_m,
            loss_pa_s2_kg2,
            head_pa,
        } = intake.duct;
        [
            (
                "intake.duct.inertance_per_m",
                inertance_per_m,
                Rule::Positive,
            ),
            (
                "intake.duct.loss_pa_s2_kg2",
                loss_pa_s2_kg2,
                Rule::NotNegative,
            ),
            ("intake.duct.head_pa", head_pa, Rule::Finite),
            (
                "intake.plenum.volume_m3",
                intake.plenum.volume_m3,
                Rule::Positive,
            ),
            (
                "intake.plenum_temperature_ratio",
                intake.plenum_temperature_ratio,
                Rule::Positive,
            ),
            (
                "intake.inlet_temperature_ratio",
                intake.inlet_temperature_ratio,
                Rule::Positive,
            ),
            (
                "intake.inlet_loss_pa_s2_kg2",
                intake.inlet_loss_pa_s2_kg2,
                Rule::NotNegative,
            ),
            (
                "compressor.design_flow_kg_s",
                compressor.design_flow_kg_s,
                Rule::Positive,
            ),
            (
                "compressor.design_pressure_ratio",
                compressor.design_pressure_ratio,
                Rule::AboveOne,
            ),
            (
                "compressor.design_corrected_speed",
                compressor.design_corrected_speed,
                Rule::Positive,
            ),
            (
                "compressor.design_efficiency",
                compressor.design_efficiency,
                Rule::Efficiency,
            ),
            (
                "compressor.pressure_exponent",
                compressor.pressure_exponent,
                Rule::NotNegative,
            ),
            (
                "compressor.flow_exponent",
                compressor.flow_exponent,
                Rule::NotNegative,
            ),
            (
                "compressor.line_slope",
                compressor.line_slope,
                Rule::NotNegative,
            ),
            (
                "compressor.efficiency_speed_curvature",
                compressor.efficiency_speed_curvature,
                Rule::NotNegative,
            ),
            (
                "compressor.efficiency_pressure_curvature",
                compressor.efficiency_pressure_curvature,
                Rule::NotNegative,
            ),
            (
                "compressor.exit_temperature_ratio",
                compressor.exit_temperature_ratio,
                Rule::Positive,
            ),
            (
                "compressor_exit.volume_m3",
                self.compressor_exit.volume_m3,
                Rule::Positive,
            ),
            (
                "diffuser.inertance_per_m",
                self.diffuser.inertance_per_m,
                Rule::Positive,
            ),
            (
                "diffuser.loss_pa_s2_kg2",
                self.diffuser.loss_pa_s2_kg2,
                Rule::NotNegative,
            ),
            ("diffuser.head_pa", self.diffuser.head_pa, Rule::Finite),
            (
                "combustor_inlet.volume_m3",
                self.combustor_inlet.volume_m3,
                Rule::Positive,
            ),
            (
                "turbine_bleed.flow_function",
                self.turbine_bleed.flow_function,
                Rule::NotNegative,
            ),
        ]
    }

    fn hot_numbers(&self) -> [(&'static str, f64, Rule); 17] {
        let (turbine, exhaust) = (&self.turbine, &self.exhaust);
        [
            (
                "exhaust_bleed.flow_function",
                self.exhaust_bleed.flow_function,
                Rule::NotNegative,
            ),
            (
                "liner.inertance_per_m",
                self.liner.inertance_per_m,
                Rule::Positive,
            ),
            (
                "liner.loss_pa_s2_kg2",
                self.liner.loss_pa_s2_kg2,
                Rule::NotNegative,
            ),
            ("liner.head_pa", self.liner.head_pa, Rule::Finite),
            (
                "combustor.effective_heating_value_j_kg",
                self.combustor.effective_heating_value_j_kg,
                Rule::Positive,
            ),
            (
                "combustor_exit.volume_m3",
                self.combustor_exit.volume_m3,
                Rule::Positive,
            ),
            (
                "turbine.flow_constant",
                turbine.flow_constant,
                Rule::Positive,
            ),
            (
                "turbine.design_efficiency",
                turbine.design_efficiency,
                Rule::Efficiency,
            ),
            (
                "turbine.design_velocity_ratio",
                turbine.design_velocity_ratio,
                Rule::Positive,
            ),
            (
                "turbine.efficiency_curvature",
                turbine.efficiency_curvature,
                Rule::NotNegative,
            ),
            (
                "exhaust.turbine_exit.volume_m3",
                exhaust.turbine_exit.volume_m3,
                Rule::Positive,
            ),
            (
                "exhaust.duct_volume.volume_m3",
                exhaust.duct_volume.volume_m3,
                Rule::Positive,
            ),
            (
                "exhaust.duct.inertance_per_m",
                exhaust.duct.inertance_per_m,
                Rule::Positive,
            ),
            (
                "exhaust.duct.loss_pa_s2_kg2",
                exhaust.duct.loss_pa_s2_kg2,
                Rule::NotNegative,
            ),
            ("exhaust.duct.head_pa", exhaust.duct.head_pa, Rule::Finite),
            (
                "valve.full_area_m2",
                self.valve.full_area_m2,
                Rule::Positive,
            ),
            (
                "shaft.loss_n_m_s2",
                self.shaft.loss_n_m_s2,
                Rule::NotNegative,
            ),
        ]
    }
}
