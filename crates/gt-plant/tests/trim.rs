//! Equilibria: at the trimmed state nothing moves.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use gt_plant::dynamics::{Instant, derivative};
use gt_plant::state::{STATES, State};
use gt_plant::trim::{Hold, trim};
use gt_plant::{FaultSizes, Inputs, MapSet, PlantError, PlantParameters, Variant};
use proptest::prelude::*;

/// Largest rate of a state over its size, 1/s: Newton's method leaves 1e-12.
const TOLERANCE_PER_S: f64 = 1e-9;

prop_compose! {
    /// Boundary conditions and disturbances around design.
    fn surroundings()(
        map_set in prop_oneof![Just(MapSet::Paper), Just(MapSet::Axial)],
        ambient_k in -15.0..15.0f64,
        ambient_pa in -3e3..3e3f64,
        heating_value in 0.97..1.03f64,
        heat_release_fraction in -0.02..0.02f64,
        torque_n_m in -50.0..50.0f64,
    ) -> (MapSet, Inputs) {
        let design = Inputs::design(&PlantParameters::for_maps(map_set));
        let inputs = Inputs {
            ambient_k: design.ambient_k + ambient_k,
            ambient_pa: design.ambient_pa + ambient_pa,
            heating_value_j_kg: design.heating_value_j_kg * heating_value,
            heat_release_fraction,
            torque_n_m,
            ..design
        };
        (map_set, inputs)
    }
}

prop_compose! {
    fn fault_sizes()(
        compressor_flow_loss in 0.0..0.05f64,
        turbine_efficiency_loss in 0.0..0.05f64,
        offset in -0.003..0.003f64,
        gain_error in -0.02..0.02f64,
        lag_s in 0.0..1.0f64,
        stuck in any::<bool>(),
    ) -> FaultSizes {
        let mut sizes = FaultSizes {
            compressor_flow_loss,
            turbine_efficiency_loss,
            ..FaultSizes::HEALTHY
        };
        (sizes.fuel.offset, sizes.fuel.gain_error, sizes.fuel.lag_s) = (offset, gain_error, lag_s);
        // Up to 0.45 degrees of the valve and 0.9 of the vanes: beyond 1 the model ends.
        (sizes.valve.offset, sizes.guide_vanes.offset) = (150.0 * offset, 300.0 * offset);
        (sizes.valve.gain_error, sizes.guide_vanes.gain_error) = (0.1 * gain_error, gain_error);
        if stuck {
            (sizes.guide_vanes.stuck, sizes.guide_vanes.stuck_at) = (1.0, 10.0);
        }
        sizes
    }
}

/// The trimmed state, and the largest rate of a state over its size, 1/s.
fn trimmed(plant: &PlantParameters, inputs: &Inputs, faults: &FaultSizes) -> (State, f64) {
    let state = trim(plant, inputs, faults, Hold::Control).unwrap().state;
    let x: [f64; STATES] = state.to_array();
    let rates = derivative(plant, inputs, faults, &x);
    let worst = x.iter().zip(rates).enumerate().map(|(index, (x, rate))| {
        // Integrals and angles may be near zero.
        let size = if index < 13 {
            x.abs()
        } else {
            x.abs().max(1.0)
        };
        rate.abs() / size
    });
    // A NaN must not get lost.
    let worst = worst.fold(
        0.0,
        |worst: f64, rate| if rate <= worst { worst } else { rate },
    );
    (state, worst)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn prop_the_governed_plant_rests_where_it_is_trimmed(
        (map_set, surroundings) in surroundings(),
        faults in prop_oneof![Just(FaultSizes::HEALTHY), fault_sizes()],
        valve_deg in -2.5..2.5f64,
        speed in 0.99..1.01f64,
        fuel_offset_kg_s in -0.005..0.005f64,
    ) {
        let plant = PlantParameters::for_maps(map_set);
        let inputs = Inputs {
            valve_deg: surroundings.valve_deg + valve_deg,
            speed_reference_rad_s: surroundings.speed_reference_rad_s * speed,
            fuel_offset_kg_s,
            ..surroundings
        };
        let (state, worst_per_s) = trimmed(&plant, &inputs, &faults);
        prop_assert!(worst_per_s < TOLERANCE_PER_S, "{}", worst_per_s);
        prop_assert_eq!(state.speed_rad_s.to_bits(), inputs.speed_reference_rad_s.to_bits());
    }

    #[test]
    fn prop_the_plant_on_the_mains_rests_where_it_is_trimmed(
        (map_set, surroundings) in surroundings(),
        faults in prop_oneof![Just(FaultSizes::HEALTHY), fault_sizes()],
        // From closed vanes over regulating to open ones.
        fuel_share in 0.55..1.15f64,
        grid in 0.9995..1.0005f64,
    ) {
        let plant = PlantParameters::new(Variant::Cogeneration, map_set);
        let inputs = Inputs {
            valve_deg: plant.design.valve_deg,
            speed_reference_rad_s: surroundings.speed_reference_rad_s * grid,
            fuel_offset_kg_s: (fuel_share - 1.0) * plant.governor.design_fuel_kg_s,
            ..surroundings
        };
        let (state, worst_per_s) = trimmed(&plant, &inputs, &faults);
        prop_assert!(worst_per_s < TOLERANCE_PER_S, "{}: {}", fuel_share, worst_per_s);
        // The vanes that stand at a stop stand at the right one.
        let above_k = state.exhaust_reading_k - plant.guide_vanes.set_point_k;
        let right = match stop(&plant, &inputs, &faults, &state) {
            Stop::Open => above_k > 0.0,
            Stop::Closed => above_k < 0.0,
            // Newton's method leaves 1e-12 of 750 K.
            Stop::None => above_k.abs() < 1e-8,
        };
        prop_assert!(right, "{}: {} {}", fuel_share, state.guide_vane_deg, above_k);
    }
}

#[derive(Debug, PartialEq)]
enum Stop {
    Open,
    None,
    Closed,
}

/// The stop at which the guide vanes' controller stands.
fn stop(plant: &PlantParameters, inputs: &Inputs, faults: &FaultSizes, state: &State) -> Stop {
    let now = Instant::at(plant, inputs, faults, state);
    let demand_deg = now.guide_vane_demand_deg;
    if demand_deg <= 0.0 {
        Stop::Open
    } else if demand_deg >= plant.guide_vanes.closed_deg {
        Stop::Closed
    } else {
        Stop::None
    }
}

#[test]
fn regress_fuel_at_which_the_vanes_stand_at_their_stops() {
    for map_set in [MapSet::Paper, MapSet::Axial] {
        let plant = PlantParameters::new(Variant::Cogeneration, map_set);
        for (share, expected) in [
            (0.55, Stop::Closed),
            (0.70, Stop::Closed),
            (0.77, Stop::None),
            (0.90, Stop::None),
            (1.00, Stop::None),
            (1.05, Stop::Open),
            (1.15, Stop::Open),
        ] {
            let inputs = Inputs {
                fuel_offset_kg_s: (share - 1.0) * plant.governor.design_fuel_kg_s,
                ..Inputs::design(&plant)
            };
            let (state, worst_per_s) = trimmed(&plant, &inputs, &FaultSizes::HEALTHY);
            assert!(
                worst_per_s < TOLERANCE_PER_S,
                "{map_set} {share}: {worst_per_s}"
            );
            assert_eq!(
                stop(&plant, &inputs, &FaultSizes::HEALTHY, &state),
                expected,
                "{map_set} {share}"
            );
        }
    }
}

/// A fault of the vanes lies between two equal limits, the demand's and the stops. Here the exhaust
/// would be held by vanes 0.3 to 3 degrees past the closed stop, which a demand within its limits
/// asks for: the vanes stand at the stop all the same.
#[test]
fn regress_a_demand_within_its_limits_does_not_move_the_vanes_past_their_stop() {
    let plant = PlantParameters::new(Variant::Cogeneration, MapSet::Paper);
    let mut faults = FaultSizes::HEALTHY;
    (faults.guide_vanes.gain_error, faults.guide_vanes.offset) = (0.0, 3.0);
    let at = |share: f64| Inputs {
        fuel_offset_kg_s: (share - 1.0) * plant.governor.design_fuel_kg_s,
        ..Inputs::design(&plant)
    };
    let mut past_the_stop = 0;
    for step in 0..40 {
        let inputs = at(0.70 + 0.0025 * f64::from(step));
        let (healthy, _) = trimmed(&plant, &inputs, &FaultSizes::HEALTHY);
        let (state, worst_per_s) = trimmed(&plant, &inputs, &faults);
        assert!(worst_per_s < TOLERANCE_PER_S, "{step}: {worst_per_s}");
        // Where the healthy vanes can hold the exhaust the faulty ones can, at the same angle.
        let difference_deg = (state.guide_vane_deg - healthy.guide_vane_deg).abs();
        assert!(difference_deg < 1e-8, "{step}: {difference_deg}");
        past_the_stop += i32::from(state.guide_vane_deg >= plant.guide_vanes.closed_deg);
    }
    assert!((1..40).contains(&past_the_stop), "{past_the_stop}");
}

/// An equilibrium of the gas path that the controllers cannot hold is refused: the fuel's limit, a
/// gain that halves what is burnt, a stuck fuel valve.
#[test]
fn what_no_controller_holds_is_no_equilibrium() {
    let plant = PlantParameters::for_maps(MapSet::Paper);
    let design = Inputs::design(&plant);
    let closed = Inputs {
        valve_deg: design.valve_deg - 10.0,
        ..design
    };
    let mut weak = FaultSizes::HEALTHY;
    weak.fuel.gain_error = -0.5;
    let mut stuck = FaultSizes::HEALTHY;
    (stuck.fuel.stuck, stuck.fuel.stuck_at) = (1.0, 0.2);
    let damaged = FaultSizes {
        turbine_efficiency_loss: 0.25,
        ..FaultSizes::HEALTHY
    };
    for (inputs, faults) in [
        (closed, FaultSizes::HEALTHY),
        (design, weak),
        (design, stuck),
        (design, damaged),
    ] {
        let error = trim(&plant, &inputs, &faults, Hold::Control).unwrap_err();
        let PlantError::NotHeld { found_per_s, .. } = error else {
            panic!("expected a plant that is not held, found {error}");
        };
        assert!(found_per_s > 0.1, "{found_per_s}");
    }
}
