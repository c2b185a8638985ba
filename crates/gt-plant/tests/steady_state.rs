//! The trimmed plant against the paper's Table 3, its balances, modes and static fault effects.
#![expect(
    clippy::unwrap_used,
    reason = "the helpers stand outside the test functions"
)]

use gt_plant::components::exhaust::mixed_k;
use gt_plant::dynamics::derivative;
use gt_plant::gas::{Gas, air};
use gt_plant::linearise::jacobian;
use gt_plant::state::STATES;
use gt_plant::trim::{Hold, trim};
use gt_plant::{
    ActuatorFault, FaultSizes, Inputs, MapSet, PlantError, PlantParameters, SteadyState, Variant,
    steady_state,
};
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;

/// Table 3 of the paper (labels of p7 and t7 as decoded).
const TABLE_3: [(&str, f64); 30] = [
    ("p1", 102066.2356),
    ("p2", 101845.6648),
    ("p3", 1014989.5034),
    ("p4", 978218.3118),
    ("p5", 929453.2286),
    ("p7", 206408.6312),
    ("p8", 100900.0),
    ("m1", 8.1302),
    ("m3", 16.6868),
    ("m4", 16.8355),
    ("m5", 13.1491),
    ("m6", 1.9748),
    ("m8", 15.444),
    ("m9", 13.668),
    ("m10", 1.4617),
    ("t1", 291.8465),
    ("t2", 277.2356),
    ("t3", 577.543),
    ("t4", 577.2024),
    ("t5", 1139.7976),
    ("t6", 1139.7976),
    ("t7", 838.4191),
    ("q_c", 3096.7421),
    ("q_t", 3081.1332),
    ("P_c", 5141363.216),
    ("P_t", 5100672.251),
    ("w_t", 1660.2491),
    ("N_t", 15854.2107),
    ("e_c", 0.87673),
    ("e_t", 0.79353),
];
const TABLE_3_FUEL_KG_S: f64 = 0.21224;

fn paper() -> PlantParameters {
    PlantParameters::for_maps(MapSet::Paper)
}

fn healthy() -> SteadyState {
    steady_state(&paper()).unwrap()
}

#[test]
fn published_table_3_within_the_calibration() {
    let steady = healthy();
    assert_eq!(steady.variables().len(), TABLE_3.len());
    for ((signal, value), (name, published)) in steady.variables().iter().zip(TABLE_3) {
        assert_eq!(signal.name, name);
        // What the table itself contradicts: its powers are no equilibrium (0.8 % apart) and its
        // e_t does not give them; m5 and m9 do not balance (2.3 % apart).
        let tolerance = match name {
            "e_t" => 0.017,
            "m5" | "m9" => 0.012,
            _ => 0.008,
        };
        let error = value / published - 1.0;
        assert!(
            error.abs() < tolerance,
            "{name}: {value} against {published}, {error}"
        );
    }
    let mean = steady
        .variables()
        .iter()
        .zip(TABLE_3)
        .map(|((_, value), (_, published))| (value / published - 1.0).abs() / 30.0)
        .sum::<f64>();
    assert!(mean < 0.003, "mean absolute error {mean}");
    let fuel_error = steady.point.fuel_kg_s / TABLE_3_FUEL_KG_S - 1.0;
    assert!(fuel_error.abs() < 1e-5, "{fuel_error}");
}

#[test]
fn published_table_3_to_the_calibrated_digits() {
    // Pressures, t1 to t6 and speed are calibrated: what remains is the printed flows' rounding.
    let steady = healthy();
    for name in "p1 p2 p3 p4 p5 p7 p8 t1 t2 t3 t4 t5 t6 w_t N_t".split(' ') {
        let published = TABLE_3.iter().find(|entry| entry.0 == name).unwrap().1;
        let error = steady.value(name).unwrap() / published - 1.0;
        assert!(error.abs() < 2e-6, "{name}: {error}");
    }
    assert_eq!(steady.value("p6"), None);
}

#[test]
fn both_map_sets_share_the_design_point() {
    let axial = steady_state(&PlantParameters::for_maps(MapSet::Axial)).unwrap();
    for (paper, axial) in healthy().outputs.iter().zip(axial.outputs) {
        // The map exponents act off design only, and the equilibrium is off by the rounding of
        // the printed flows.
        assert!((axial / paper - 1.0).abs() < 1e-6, "{axial} {paper}");
    }
}

/// The equations of conservation at an equilibrium, each as a relative residual.
fn balances(parameters: &PlantParameters, steady: &SteadyState) -> Vec<(&'static str, f64)> {
    let value = |name| steady.value(name).unwrap();
    let x = steady.state;
    let point = &steady.point;
    let fuel = point.fuel_kg_s;
    let air = value("m5") + value("m6");
    let products = Gas::products(fuel / air);
    let exhaust = Gas::products(fuel / (air + value("m10")));
    let h = |t| air::enthalpy(t);
    let heat = fuel * parameters.design.heating_value_j_kg * parameters.combustor.efficiency;
    let combustor_in = air * (h(value("t4")) - h(298.15)) + heat;
    let combustor_out = value("m8") * (products.enthalpy(value("t5")) - products.enthalpy(298.15));
    let compressor_power = value("m3") * (h(value("t3")) - h(value("t2")));
    let blades = products.enthalpy(point.expansion.exit_k);
    let turbine_power = value("m8") * (products.enthalpy(value("t5")) - blades);
    let mixed_in = value("m8") * blades + value("m10") * h(value("t4"));
    let mixed_out = (value("m8") + value("m10")) * exhaust.enthalpy(value("t7"));
    let loss = parameters.shaft.loss_n_m_s2 * value("w_t").powi(2);
    let valve = point.valve_flow_kg_s;
    vec![
        (
            "intake",
            value("m1") / parameters.intake.measured_leg_share / value("m3") - 1.0,
        ),
        ("compressor exit", value("m4") / value("m3") - 1.0),
        ("bleeds", (air + value("m10")) / value("m4") - 1.0),
        ("fuel", (value("m5") + fuel) / value("m9") - 1.0),
        (
            "turbine inlet",
            (value("m9") + value("m6")) / value("m8") - 1.0,
        ),
        ("turbine exit", (value("m8") + value("m10")) / valve - 1.0),
        ("exhaust", x.exhaust_flow_kg_s / valve - 1.0),
        (
            "shaft torque",
            (value("q_t") - value("q_c") - loss) / value("q_c"),
        ),
        ("combustor energy", combustor_out / combustor_in - 1.0),
        ("compressor energy", compressor_power / value("P_c") - 1.0),
        ("turbine energy", turbine_power / value("P_t") - 1.0),
        ("mixing energy", mixed_out / mixed_in - 1.0),
        (
            "compressor torque",
            value("q_c") * value("w_t") / value("P_c") - 1.0,
        ),
        (
            "speed units",
            value("N_t") * std::f64::consts::PI / 30.0 / value("w_t") - 1.0,
        ),
        ("ambient intake", pressure_residual(parameters, steady)),
    ]
}

/// Pressure drop of the intake duct against fan head, over ambient pressure.
fn pressure_residual(parameters: &PlantParameters, steady: &SteadyState) -> f64 {
    let duct = parameters.intake.duct;
    let loss = duct.loss_pa_s2_kg2 * steady.state.intake_flow_kg_s.powi(2);
    let ambient = parameters.design.ambient_pa;
    (ambient + duct.head_pa - loss - steady.state.p1_pa) / ambient
}

#[test]
fn mass_and_energy_balance_at_equilibrium() {
    for (name, residual) in balances(&paper(), &healthy()) {
        // Three Newton steps from 1140 K leave less than 1e-12; the rest is rounding.
        assert!(residual.abs() < 1e-11, "{name}: {residual}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn prop_balances_hold_off_design(
        valve in 45.0..52.0f64, flow_loss in 0.0..0.08f64, efficiency_loss in 0.0..0.06f64,
        ambient_k in 278.0..298.0f64
    ) {
        let parameters = paper();
        let inputs =
            Inputs { valve_deg: valve, ambient_k, ..Inputs::design(&parameters) };
        let faults = FaultSizes {
            compressor_flow_loss: flow_loss,
            turbine_efficiency_loss: efficiency_loss,
            ..FaultSizes::HEALTHY
        };
        let steady = trim(&parameters, &inputs, &faults, Hold::Control).unwrap();
        for (name, residual) in balances(&parameters, &steady) {
            // Off design the three Newton steps start up to 200 K away.
            prop_assert!(residual.abs() < 1e-8, "{}: {}", name, residual);
        }
    }

    #[test]
    fn prop_mixing_lies_between_its_streams(hot in 700.0..1000.0f64, share in 0.01..0.3f64) {
        let mixture = Gas::products(0.01);
        let hot_stream = [1.0, mixture.enthalpy(hot)];
        let cold_stream = [share, mixture.enthalpy(580.0)];
        let mixed = mixed_k(hot_stream, cold_stream, &mixture, hot);
        prop_assert!(580.0 < mixed && mixed < hot);
    }
}

/// Open loop eigenvalues of the first prototype, 1/s: real and imaginary part.
const OPEN_LOOP: [(f64, f64); 7] = [
    (-0.314, 0.0),
    (-21.8, 0.0),
    (-33.7, 0.0),
    (-11.9, 103.0),
    (-48.0, 134.0),
    (-379.0, 400.0),
    (-309.0, 696.0),
];

#[test]
fn regress_open_loop_modes() {
    let parameters = paper();
    let steady = healthy();
    let inputs = Inputs::design(&parameters);
    let full = steady.state.to_array();
    let z: [f64; 11] = std::array::from_fn(|i| full[i]);
    // A stuck actuator opens the loop.
    let faults = FaultSizes {
        fuel: ActuatorFault {
            stuck: 1.0,
            stuck_at: steady.point.fuel_kg_s,
            ..ActuatorFault::HEALTHY
        },
        ..FaultSizes::HEALTHY
    };
    let rates = |z: &[f64; 11]| {
        let mut x = full;
        x[..11].copy_from_slice(z);
        let rates = derivative(&parameters, &inputs, &faults, &x);
        std::array::from_fn(|i| rates[i])
    };
    let matrix = jacobian(rates, &z, &z);
    let modes = DMatrix::from_column_slice(11, 11, matrix.as_slice()).complex_eigenvalues();
    for (re, im) in OPEN_LOOP {
        let nearest = modes
            .iter()
            .map(|mode| (mode - Complex::new(re, im)).norm())
            .fold(f64::INFINITY, f64::min);
        // Printed to three digits, for flows that are 0.4 % smaller.
        assert!(
            nearest < 0.01 * re.hypot(im),
            "{re} + {im}i: off by {nearest}"
        );
    }
}

/// The largest real part of the closed loop's eigenvalues for a fuel lag, 1/s.
fn closed_loop_growth(fuel_lag_s: f64) -> f64 {
    let parameters = paper();
    let inputs = Inputs::design(&parameters);
    let faults = FaultSizes {
        fuel: ActuatorFault {
            lag_s: fuel_lag_s,
            ..ActuatorFault::HEALTHY
        },
        ..FaultSizes::HEALTHY
    };
    let full = healthy().state.to_array();
    let taking_part = Variant::Prototype.states();
    assert_eq!(taking_part.len(), 14);
    let z: [f64; 14] = std::array::from_fn(|i| full[i]);
    // The integral of the speed error is near zero; its size is about 1 rad.
    let scale: [f64; 14] = std::array::from_fn(|i| if i == 13 { 1.0 } else { full[i] });
    let rates = |z: &[f64; 14]| {
        let mut x: [f64; STATES] = full;
        x[..14].copy_from_slice(z);
        let rates = derivative(&parameters, &inputs, &faults, &x);
        std::array::from_fn(|i| rates[i])
    };
    let matrix = jacobian(rates, &z, &scale);
    let modes = DMatrix::from_column_slice(14, 14, matrix.as_slice()).complex_eigenvalues();
    modes
        .iter()
        .map(|mode| mode.re)
        .fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn regress_speed_loop_and_its_loss_of_stability() {
    // The first prototype: -1.03 healthy, -0.002 at a lag of 3.0 s, +0.024 at 4.0 s.
    for (lag_s, growth, tolerance) in [(0.0, -1.03, 5e-3), (3.0, -0.002, 6e-4), (4.0, 0.024, 6e-4)]
    {
        let found = closed_loop_growth(lag_s);
        assert!(
            (found - growth).abs() < tolerance,
            "lag {lag_s} s: {found} against {growth}"
        );
    }
}

/// Static effect of 5 % faults in percent (spec section 6): output; closed loop for cases 1 and 3;
/// against the healthy plant at the same valve and fuel for cases 1 and 3.
const EFFECTS: [(&str, [f64; 4]); 24] = [
    ("p1", [0.07, 0.06, -0.00, 0.22]),
    ("p2", [0.08, 0.06, -0.00, 0.25]),
    ("p3", [-2.81, 1.38, 0.05, -5.01]),
    ("p4", [-2.78, 1.54, 0.05, -4.81]),
    ("p5", [-2.73, 1.84, 0.05, -4.47]),
    ("p7", [-2.84, 3.18, 0.04, -3.55]),
    ("p8", [-0.12, -0.07, 0.00, -0.33]),
    ("m1", [-1.91, -1.41, 0.06, -5.37]),
    ("m3", [-1.91, -1.41, 0.06, -5.37]),
    ("m4", [-1.91, -1.41, 0.06, -5.37]),
    ("m5", [-1.80, -2.13, 0.07, -5.74]),
    ("m6", [-2.36, 1.34, 0.05, -3.96]),
    ("m10", [-2.36, 1.34, 0.05, -3.96]),
    ("m8", [-1.91, -1.48, 0.06, -5.43]),
    ("m9", [-1.84, -1.89, 0.06, -5.64]),
    ("t1", [0.0, 0.0, 0.0, 0.0]),
    ("t3", [-0.86, 0.39, -0.00, -1.76]),
    ("t5", [-1.66, 6.69, -0.03, 1.93]),
    ("t7", [-1.73, 8.66, -0.05, 3.54]),
    ("q_c", [-3.57, -0.65, -3.27, -1.64]),
    ("q_t", [-3.55, -0.65, -3.23, -1.69]),
    ("P_c", [-3.57, -0.65, 0.06, -8.59]),
    ("P_t", [-3.55, -0.65, 0.09, -8.64]),
    ("w_t", [0.0, 0.0, 3.44, -7.07]),
];

#[test]
fn regress_static_fault_effects() {
    let parameters = paper();
    let inputs = Inputs::design(&parameters);
    let base = healthy();
    let fouling = FaultSizes {
        compressor_flow_loss: 0.05,
        ..FaultSizes::HEALTHY
    };
    let damage = FaultSizes {
        turbine_efficiency_loss: 0.05,
        ..FaultSizes::HEALTHY
    };
    for (column, faults) in [fouling, damage].iter().enumerate() {
        let faulty = trim(&parameters, &inputs, faults, Hold::Control).unwrap();
        let hold = Hold::Fuel {
            kg_s: faulty.point.fuel_kg_s,
        };
        let expected = trim(&parameters, &inputs, &FaultSizes::HEALTHY, hold).unwrap();
        for (name, effects) in EFFECTS {
            let value = faulty.value(name).unwrap();
            let closed_loop = 100.0 * (value / base.value(name).unwrap() - 1.0);
            let at_same_inputs = 100.0 * (value / expected.value(name).unwrap() - 1.0);
            // 1.5 % of the effect and 0.04 points, where effects cancel to little: the
            // throw-away prototype that printed it had 0.4 % smaller flows and twice the loss.
            let case = 2 * column + 1;
            let (published, found) = (effects[column], closed_loop);
            assert!(
                (found - published).abs() < 0.04 + 0.015 * published.abs(),
                "{name}, case {case}: {found}, {published}"
            );
            let (published, found) = (effects[2 + column], at_same_inputs);
            assert!(
                (found - published).abs() < 0.04 + 0.015 * published.abs(),
                "{name}, case {case}: {found}, {published}"
            );
        }
    }
}

#[test]
fn ambient_effects_at_held_inputs() {
    // Spec section 9: T_a + 1 K moves t3 +.28, m9 -.23, p7 -.11 %; p_a + .1 % moves q_c +.087 %.
    let parameters = paper();
    let design = Inputs::design(&parameters);
    let hold = Hold::Fuel {
        kg_s: healthy().point.fuel_kg_s,
    };
    let effect = |inputs: Inputs, name| {
        let moved = trim(&parameters, &inputs, &FaultSizes::HEALTHY, hold).unwrap();
        100.0 * (moved.value(name).unwrap() / healthy().value(name).unwrap() - 1.0)
    };
    let warm = Inputs {
        ambient_k: design.ambient_k + 1.0,
        ..design
    };
    let dense = Inputs {
        ambient_pa: design.ambient_pa * 1.001,
        ..design
    };
    for (inputs, name, expected, tolerance) in [
        (warm, "t3", 0.28, 0.009),
        (warm, "m9", -0.23, 0.009),
        (warm, "p7", -0.11, 0.009),
        (dense, "q_c", 0.087, 0.002),
    ] {
        let found = effect(inputs, name);
        assert!(
            (found - expected).abs() < tolerance,
            "{name}: {found} against {expected}"
        );
    }
}

#[test]
fn a_plant_without_equilibrium_is_an_error() {
    let mut parameters = paper();
    parameters.design.heating_value_j_kg = 1e3;
    let error = steady_state(&parameters).unwrap_err();
    assert!(
        matches!(
            error,
            PlantError::Trim { .. } | PlantError::OutOfRange { .. }
        ),
        "expected no equilibrium with fuel that does not burn, found {error}"
    );
}
