//! The plant without its governor against plants whose governor does nothing, and against the
//! non-linear plant.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use gt_plant::dynamics::Instant;
use gt_plant::trim::{Hold, trim};
use gt_plant::{
    FaultSizes, Inputs, MapSet, PlantParameters, Profile, SAMPLE_TIME_S, Scenario, Variant,
    local_model, open_loop_model, simulate, steady_state,
};
use nalgebra::{DMatrix, DVector};

/// A governor without gains leaves the demand where it is put: the local model of such a plant,
/// at the same speed and fuel, has the same entries.
#[test]
fn without_feedback_the_plant_is_that_of_a_governor_without_gains() {
    for (map_set, valve_deg) in [(MapSet::Paper, 0.7), (MapSet::Axial, -1.2)] {
        let plant = PlantParameters::for_maps(map_set);
        let mut inputs = Inputs::design(&plant);
        inputs.valve_deg += valve_deg;
        let faults = FaultSizes::HEALTHY;
        let state = trim(&plant, &inputs, &faults, Hold::Control).unwrap().state;
        let found = open_loop_model(&plant, &inputs, &faults, &state).unwrap();

        let demand = Instant::at(&plant, &inputs, &faults, &state).fuel_demand_kg_s;
        let mut idle = plant.clone();
        idle.governor.proportional_gain = 0.0;
        // Zero would leave the way back from a limit undefined.
        idle.governor.integral_gain = 1e-30;
        inputs.fuel_offset_kg_s = demand - plant.governor.design_fuel_kg_s;
        let mut free = state;
        free.speed_error_integral_rad = 0.0;
        let expected = local_model(&idle, &inputs, &faults, &free).unwrap();

        let names: Vec<&str> = found.inputs().iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["a_v", "M_f", "p_a", "T_a", "LHV"]);
        assert_eq!(found.outputs(), expected.outputs());
        assert_eq!(found.nx() + 1, expected.nx());
        let x: Vec<usize> = (0..expected.nx())
            .filter(|&k| expected.states()[k] != "speed_error_integral")
            .collect();
        let u = [0, 1, 3, 4, 5];
        let y: Vec<usize> = (0..expected.ny()).collect();
        for (found, expected, rows, columns) in [
            (found.a(), expected.a(), &x, x.as_slice()),
            (found.b(), expected.b(), &x, &u),
            (found.c(), expected.c(), &y, &x),
            (found.d(), expected.d(), &y, &u),
        ] {
            let expected = expected.select_rows(rows).select_columns(columns);
            for (found, expected) in found.row_iter().zip(expected.row_iter()) {
                // Rounding of one product and one difference; the demands differ by theirs.
                let error = (found - expected).amax();
                assert!(error <= 1e-10 * expected.amax(), "{error:e}");
            }
        }
        // What is left is the rotor: the paper's time constant of about 3 s, and all the rest is
        // faster than a sample or two.
        let slowest = found.time_constants_s().into_iter().fold(0.0, f64::max);
        assert!(
            (slowest - 3.2).abs() < 0.5 || map_set == MapSet::Axial,
            "{slowest}"
        );
        assert!(found.is_stable());
    }
}

/// On the mains the fuel is an input already.
#[test]
fn the_machine_on_the_mains_keeps_its_local_model() {
    let plant = Scenario::of(Variant::Cogeneration).parameters();
    let state = steady_state(&plant).unwrap().state;
    let inputs = Inputs::design(&plant);
    let faults = FaultSizes::HEALTHY;
    assert_eq!(
        open_loop_model(&plant, &inputs, &faults, &state).unwrap(),
        local_model(&plant, &inputs, &faults, &state).unwrap()
    );
}

/// Driven by what a small run's valve and governor did, the linear plant gives the run's outputs.
#[test]
fn the_open_loop_follows_a_small_run_of_the_plant() {
    let scenario = Scenario {
        duration_s: 120.0,
        profile: Profile::named(Variant::Prototype, "gentle").unwrap(),
        seed: 3,
        ..Scenario::default()
    };
    let tags = ["q_c", "t3", "p7", "m9", "w_t"];
    let truth = simulate(&scenario).unwrap().truth;
    let truth = truth.select(&["a_v", "M_f"], &tags).unwrap();
    let plant = scenario.parameters();
    let rest = steady_state(&plant).unwrap();
    let design = Inputs::design(&plant);
    let model = open_loop_model(&plant, &design, &FaultSizes::HEALTHY, &rest.state)
        .unwrap()
        .discretise(SAMPLE_TIME_S)
        .unwrap();
    let mut u = DMatrix::zeros(model.nu(), truth.len());
    for t in 0..truth.len() {
        u[(0, t)] = truth.u()[(0, t)] - design.valve_deg;
        u[(1, t)] = truth.u()[(1, t)] - plant.governor.design_fuel_kg_s;
    }
    let y = model.simulate(&DVector::zeros(model.nx()), &u).unwrap();
    for (row, tag) in tags.iter().enumerate() {
        let index = model.outputs().iter().position(|s| s.name == *tag).unwrap();
        let own = truth.y().row(row).add_scalar(-rest.value(tag).unwrap());
        let error = (y.row(index) - &own).variance() / own.variance();
        println!("{tag}: {error:e}");
        // The fuel moves within the sample and is held here: a share of its change per sample; and
        // the plant bends by a few per cent over +-0.75 deg.
        assert!(error < 2e-2, "{tag}: {error:e}");
    }
}
