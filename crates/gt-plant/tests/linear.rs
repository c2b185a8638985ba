//! The local model against the plant: derivatives, decay of modes, static gains, longest step.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use gt_plant::channels::outputs;
use gt_plant::components::valve::critical_ratio;
use gt_plant::dynamics::{Instant, derivative};
use gt_plant::linearise::Linearisation;
use gt_plant::stability::amplification;
use gt_plant::state::{STATES, State};
use gt_plant::trim::{Hold, trim};
use gt_plant::{
    ActuatorFault, FaultSizes, Inputs, MapSet, PlantParameters, SAMPLE_TIME_S, Scenario, Variant,
    local_model, longest_step_s, rk4, simulate,
};
use nalgebra::{Complex, DMatrix, DVector};
use proptest::prelude::*;

/// Inputs of a local model.
const LOCAL_INPUTS: usize = 6;
const VARIANTS: [Variant; 2] = [Variant::Prototype, Variant::Cogeneration];
const MAP_SETS: [MapSet; 2] = [MapSet::Paper, MapSet::Axial];

/// The inputs that a local model knows, in its order.
fn input(inputs: &mut Inputs, index: usize) -> &mut f64 {
    match index {
        0 => &mut inputs.valve_deg,
        1 => &mut inputs.fuel_offset_kg_s,
        2 => &mut inputs.speed_reference_rad_s,
        3 => &mut inputs.ambient_pa,
        4 => &mut inputs.ambient_k,
        _ => &mut inputs.heating_value_j_kg,
    }
}

/// The size of each input.
fn input_sizes(plant: &PlantParameters) -> [f64; LOCAL_INPUTS] {
    let mut design = Inputs::design(plant);
    design.fuel_offset_kg_s = plant.governor.design_fuel_kg_s;
    std::array::from_fn(|index| *input(&mut design, index))
}

/// The size of each state: its value, at least 1 for integrals and angles, which may be near zero.
fn state_sizes(x: &State) -> [f64; STATES] {
    let mut sizes = x.to_array().map(f64::abs);
    for size in &mut sizes[13..] {
        *size = size.max(1.0);
    }
    sizes
}

prop_compose! {
    /// A plant with inputs within what profiles and boundary conditions reach; the fuel of the
    /// machine on the mains is between these shares of design.
    fn plants(fuel_share: [f64; 2])(
        variant in prop_oneof![Just(Variant::Prototype), Just(Variant::Cogeneration)],
        map_set in prop_oneof![Just(MapSet::Paper), Just(MapSet::Axial)],
        valve in -1.0..1.0f64,
        speed in -1.0..1.0f64,
        ambient in (-15.0..15.0f64, -3e3..3e3f64, -0.05..0.05f64),
        fuel_share in fuel_share[0]..fuel_share[1],
        disturbance in (-0.02..0.02f64, -50.0..50.0f64),
    ) -> (PlantParameters, Inputs) {
        let plant = PlantParameters::new(variant, map_set);
        let design = Inputs::design(&plant);
        let (valve_deg, speed_share, fuel) = match variant {
            Variant::Prototype => (2.5 * valve, 0.01 * speed, 0.0),
            Variant::Cogeneration => (0.0, 0.0005 * speed, fuel_share - 1.0),
        };
        let inputs = Inputs {
            valve_deg: design.valve_deg + valve_deg,
            speed_reference_rad_s: design.speed_reference_rad_s * (1.0 + speed_share),
            fuel_offset_kg_s: fuel * plant.governor.design_fuel_kg_s,
            ambient_pa: design.ambient_pa + ambient.1,
            ambient_k: design.ambient_k + ambient.0,
            heating_value_j_kg: design.heating_value_j_kg * (1.0 + ambient.2),
            heat_release_fraction: disturbance.0,
            torque_n_m: disturbance.1,
        };
        (plant, inputs)
    }
}

/// How far a state is from where a law has a kink: limits of fuel and vanes, the slew of the
/// vanes, the choking of the valve; in shares of their range.
fn from_kinks(
    plant: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    x: &State,
    now: &Instant,
) -> f64 {
    let (governor, vanes) = (&plant.governor, &plant.guide_vanes);
    let point = &now.point;
    let choking = x.p8_pa / x.p7_pa - critical_ratio(point.exit_gamma);
    let (fuel_range, fuel) = (
        [governor.minimum_fuel_kg_s, governor.maximum_fuel_kg_s],
        inputs.fuel_offset_kg_s + governor.design_fuel_kg_s,
    );
    let within = |value: f64, [low, high]: [f64; 2]| {
        ((value - low).abs()).min((high - value).abs()) / (high - low)
    };
    let mut distances = vec![choking.abs()];
    match plant.variant {
        Variant::Prototype => {
            let error = inputs.speed_reference_rad_s - x.speed_rad_s;
            let wanted = fuel
                + governor.proportional_gain * error
                + governor.integral_gain * x.speed_error_integral_rad;
            distances.push(within(wanted, fuel_range));
        }
        Variant::Cogeneration => {
            let error = vanes.set_point_k - x.exhaust_reading_k;
            let wanted = vanes.proportional_deg_k * error
                + vanes.integral_deg_k_s * x.exhaust_error_integral_k_s
                - vanes.derivative_deg_s_k * now.rates[15];
            // The rate that the slew may limit.
            let rate = (now.guide_vane_demand_deg - x.guide_vane_deg)
                / (vanes.positioner_s + faults.guide_vanes.lag_s);
            distances.extend([
                within(wanted, [0.0, vanes.closed_deg]),
                within(fuel, fuel_range),
                (rate.abs() / vanes.slew_deg_s - 1.0).abs(),
            ]);
        }
    }
    distances.into_iter().fold(f64::INFINITY, f64::min)
}

/// Rates of the states that take part, then the measured outputs.
fn values(plant: &PlantParameters, inputs: &Inputs, faults: &FaultSizes, x: &State) -> Vec<f64> {
    let now = Instant::at(plant, inputs, faults, x);
    let measured = plant.variant.output_channels().len();
    let rates = plant.variant.states().into_iter();
    rates
        .map(|(index, _)| now.rates[index])
        .chain(outputs(plant, inputs, x, &now).into_iter().take(measured))
        .collect()
}

/// Central differences of [`values`] by the states that take part, then the inputs, each times the
/// size of its variable.
fn differences(
    plant: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    x: &State,
) -> DMatrix<f64> {
    // The cube root of the rounding unit balances truncation against rounding.
    const STEP: f64 = 6e-6;
    let column =
        |up: Vec<f64>, down: Vec<f64>| (DVector::from(up) - DVector::from(down)) / (2.0 * STEP);
    let sizes = state_sizes(x);
    let states = plant.variant.states().into_iter().map(|(index, _)| {
        let at = |sign: f64| {
            let mut moved = x.to_array();
            moved[index] += sign * STEP * sizes[index];
            values(plant, inputs, faults, &State::from_array(&moved))
        };
        column(at(1.0), at(-1.0))
    });
    let by_input = (0..LOCAL_INPUTS).map(|index| {
        let at = |sign: f64| {
            let mut moved = *inputs;
            *input(&mut moved, index) += sign * STEP * input_sizes(plant)[index];
            values(plant, &moved, faults, x)
        };
        column(at(1.0), at(-1.0))
    });
    DMatrix::from_columns(&states.chain(by_input).collect::<Vec<_>>())
}

/// `[A B; C D]` of a local model, each column times the size of its variable.
fn scaled(plant: &PlantParameters, model: &Linearisation, x: &State) -> DMatrix<f64> {
    let (nx, nu, ny) = (model.nx(), model.nu(), model.ny());
    let mut all = DMatrix::zeros(nx + ny, nx + nu);
    all.view_mut((0, 0), (nx, nx)).copy_from(model.a());
    all.view_mut((0, nx), (nx, nu)).copy_from(model.b());
    all.view_mut((nx, 0), (ny, nx)).copy_from(model.c());
    all.view_mut((nx, nx), (ny, nu)).copy_from(model.d());
    let taking_part = plant.variant.states();
    let sizes = state_sizes(x);
    let states = taking_part.iter().map(|(index, _)| sizes[*index]);
    for (column, size) in states.chain(input_sizes(plant)).enumerate() {
        all.column_mut(column).scale_mut(size);
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn prop_local_model_is_the_derivative_of_rates_and_outputs(
        (plant, inputs) in plants([0.6, 1.02]),
        moved in proptest::array::uniform18(-1e-3..1e-3f64),
        (flow_loss, efficiency_loss) in (0.0..0.05f64, 0.0..0.05f64),
        (gain_error, lag_s) in (-0.03..0.03f64, 0.0..1.0f64),
    ) {
        let lagging = ActuatorFault { gain_error, lag_s, ..ActuatorFault::HEALTHY };
        let faults = FaultSizes {
            compressor_flow_loss: flow_loss,
            turbine_efficiency_loss: efficiency_loss,
            fuel: lagging,
            valve: lagging,
            guide_vanes: ActuatorFault { gain_error: 0.0, ..lagging },
        };
        let state = trim(&plant, &inputs, &FaultSizes::HEALTHY, Hold::Control).unwrap().state;
        let (mut x, sizes) = (state.to_array(), state_sizes(&state));
        for (index, _) in plant.variant.states() {
            x[index] += moved[index] * sizes[index];
        }
        let x = State::from_array(&x);
        let now = Instant::at(&plant, &inputs, &faults, &x);
        prop_assume!(from_kinks(&plant, &inputs, &faults, &x, &now) > 1e-3);

        let model = local_model(&plant, &inputs, &faults, &x).unwrap();
        let exact = scaled(&plant, &model, &x);
        let found = differences(&plant, &inputs, &faults, &x);
        for (row, (exact, found)) in exact.row_iter().zip(found.row_iter()).enumerate() {
            // Relative to the largest entry of the row. Truncation: the square of the step, 4e-11,
            // times a curvature of up to 1e3; rounding: 1e-16 over the step.
            let error = (exact - found).amax();
            prop_assert!(error <= 1e-6 * exact.amax(), "row {}: {} {}", row, error, exact.amax());
        }
    }
}

/// An equilibrium with its local model in states of size one.
struct Equilibrium {
    plant: PlantParameters,
    inputs: Inputs,
    x: [f64; STATES],
    /// Indices of the states that take part.
    states: Vec<usize>,
    sizes: [f64; STATES],
    /// State matrix in states of size one.
    a: DMatrix<f64>,
    poles_per_s: Vec<Complex<f64>>,
}

impl Equilibrium {
    fn new(plant: PlantParameters, inputs: Inputs) -> Self {
        let state = trim(&plant, &inputs, &FaultSizes::HEALTHY, Hold::Control)
            .unwrap()
            .state;
        let model = local_model(&plant, &inputs, &FaultSizes::HEALTHY, &state).unwrap();
        let sizes = state_sizes(&state);
        let states: Vec<usize> = plant
            .variant
            .states()
            .iter()
            .map(|(index, _)| *index)
            .collect();
        let a = DMatrix::from_fn(states.len(), states.len(), |row, column| {
            model.a()[(row, column)] * sizes[states[column]] / sizes[states[row]]
        });
        let poles_per_s = model.poles_per_s().to_vec();
        Self {
            plant,
            inputs,
            x: state.to_array(),
            states,
            sizes,
            a,
            poles_per_s,
        }
    }

    /// The mode of a pole: the vector, of length one, that `A - pole I` turns to nothing.
    fn mode(&self, pole: Complex<f64>) -> DVector<Complex<f64>> {
        let n = self.states.len();
        let shifted = self.a.map(|entry| Complex::new(entry, 0.0))
            - DMatrix::identity(n, n).map(|entry: f64| pole * entry);
        let vectors = shifted.svd(false, true).v_t.unwrap();
        vectors.row(n - 1).adjoint()
    }

    /// The state at a deviation in states of size one.
    fn moved(&self, deviation: &DVector<f64>) -> [f64; STATES] {
        let mut x = self.x;
        for (&index, share) in self.states.iter().zip(deviation.iter()) {
            x[index] += share * self.sizes[index];
        }
        x
    }

    /// The deviation of a state, in states of size one.
    fn deviation(&self, x: &[f64; STATES]) -> DVector<f64> {
        let share = |&index: &usize| (x[index] - self.x[index]) / self.sizes[index];
        DVector::from_iterator(self.states.len(), self.states.iter().map(share))
    }

    fn step(&self, x: &[f64; STATES], step_s: f64) -> [f64; STATES] {
        let rates = |_: f64, x: &[f64; STATES]| {
            derivative(&self.plant, &self.inputs, &FaultSizes::HEALTHY, x)
        };
        rk4::step(rates, 0.0, x, step_s)
    }
}

/// A number of steps, rounded up.
fn whole(steps: f64) -> u32 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let whole = steps.ceil() as u32;
    whole
}

/// Whether the guide vanes have room both ways; at a stop their integral rests, a pole at zero.
fn regulates(plant: &PlantParameters, x: &State) -> bool {
    plant.variant == Variant::Prototype
        || (1.0..plant.guide_vanes.closed_deg - 1.0).contains(&x.guide_vane_deg)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Each mode alone, from a deviation of a millionth over one time constant.
    #[test]
    fn prop_poles_predict_the_decay_of_a_small_deviation(
        (plant, inputs) in plants([0.88, 0.95])
    ) {
        const SMALL: f64 = 1e-6;
        let at = Equilibrium::new(plant, inputs);
        prop_assume!(regulates(&at.plant, &State::from_array(&at.x)));
        for &pole in at.poles_per_s.iter().filter(|pole| pole.im >= 0.0) {
            prop_assert!(pole.re < 0.0);
            let mode = at.mode(pole);
            let duration_s = -1.0 / pole.re;
            // Short for the mode and stable for the fastest, of some 760 1/s.
            let steps = whole(duration_s * (20.0 * pole.norm()).max(1000.0));
            let mut x = at.moved(&(mode.map(|entry| entry.re) * SMALL));
            for _ in 0..steps {
                x = at.step(&x, duration_s / f64::from(steps));
            }
            let turned = mode * (pole * duration_s).exp();
            let expected = turned.map(|entry| entry.re);
            // Curvature leaves some 1e-5, the equilibrium and rounding 1e-6, RK4 1e-5.
            let error = (at.deviation(&x) / SMALL - &expected).norm();
            prop_assert!(error < 1e-3 * turned.norm(), "{}: {} {}", pole, error, turned.norm());
        }
    }

    /// Central differences of equilibria whose inputs are 1e-4 apart.
    #[test]
    fn prop_dc_gain_is_the_difference_of_equilibria((plant, inputs) in plants([0.88, 0.95])) {
        const STEP: f64 = 1e-4;
        let settled = |inputs: &Inputs| {
            trim(&plant, inputs, &FaultSizes::HEALTHY, Hold::Control).unwrap()
        };
        let centre = settled(&inputs);
        prop_assume!(regulates(&plant, &centre.state));
        // The valve chokes with a jump of curvature, which a central difference across it sees; the
        // inputs' step moves its pressure ratio by less than 10 times itself.
        let now = Instant::at(&plant, &inputs, &FaultSizes::HEALTHY, &centre.state);
        let kink = from_kinks(&plant, &inputs, &FaultSizes::HEALTHY, &centre.state, &now);
        prop_assume!(kink > 10.0 * STEP);
        let model = local_model(&plant, &inputs, &FaultSizes::HEALTHY, &centre.state).unwrap();
        let mut gain = model.dc_gain().unwrap();
        let mut found = DMatrix::zeros(gain.nrows(), LOCAL_INPUTS);
        for (index, size) in input_sizes(&plant).into_iter().enumerate() {
            let outputs = |sign: f64| {
                let mut moved = inputs;
                *input(&mut moved, index) += sign * STEP * size;
                settled(&moved).outputs
            };
            let (up, down) = (outputs(1.0), outputs(-1.0));
            for row in 0..gain.nrows() {
                found[(row, index)] = (up[row] - down[row]) / (2.0 * STEP);
            }
            gain.column_mut(index).scale_mut(size);
        }
        for (row, (gain, found)) in gain.row_iter().zip(found.row_iter()).enumerate() {
            // Relative to the output: it moves by about its own size with an input's size.
            // Truncation 1e-8 times the curvature, rounding of the equilibria 1e-12 / 1e-4.
            let error = (gain - found).amax();
            let size = centre.outputs[row].abs();
            prop_assert!(error < 1e-4 * size, "{}: {} {}", row, error, size);
        }
    }
}

#[test]
fn prop_rk4_decays_below_the_longest_step_and_grows_above() {
    const SMALL: f64 = 1e-9;
    for (variant, map_set) in VARIANTS
        .into_iter()
        .zip(MAP_SETS)
        .chain(VARIANTS.into_iter().zip(MAP_SETS.into_iter().rev()))
    {
        let plant = PlantParameters::new(variant, map_set);
        // In cogeneration the vanes have room both ways.
        let fuel = if variant == Variant::Cogeneration {
            -0.08
        } else {
            0.0
        };
        let inputs = Inputs {
            fuel_offset_kg_s: fuel * plant.governor.design_fuel_kg_s,
            ..Inputs::design(&plant)
        };
        let at = Equilibrium::new(plant, inputs);
        let limit_s = longest_step_s(&at.plant, &at.inputs, &State::from_array(&at.x)).unwrap();
        for (factor, grows) in [(0.97, false), (1.03, true)] {
            let step_s = factor * limit_s;
            let factor_of = |pole: &Complex<f64>| amplification(pole * limit_s);
            let decisive = at.poles_per_s.iter().copied();
            let decisive = decisive
                .max_by(|a, b| factor_of(a).total_cmp(&factor_of(b)))
                .unwrap();
            let gain = amplification(decisive * step_s);
            assert_eq!(gain > 1.0, grows, "{variant} {map_set} {gain}");
            // As many steps as change the decisive mode a hundredfold.
            let steps = whole(100.0f64.ln() / gain.ln().abs());
            let mut x = at.moved(&(at.mode(decisive).map(|entry| entry.re) * SMALL));
            let start = at.deviation(&x).norm();
            for _ in 0..steps {
                x = at.step(&x, step_s);
            }
            let change = at.deviation(&x).norm() / start;
            let expected = gain.powf(f64::from(steps));
            // The length of a vector of a turning mode depends on where in its turn it is.
            assert!(
                change < 6.0 * expected && 6.0 * change > expected,
                "{variant} {map_set} {factor}: {change} {expected}"
            );
        }
    }
}

#[test]
fn a_step_beyond_the_longest_is_refused() {
    for (variant, least) in [(Variant::Prototype, 24), (Variant::Cogeneration, 23)] {
        let scenario = Scenario {
            substeps: least - 1,
            duration_s: 0.8,
            ..Scenario::of(variant)
        };
        let plant = PlantParameters::new(variant, MapSet::Paper);
        let inputs = match variant {
            Variant::Prototype => Inputs::design(&plant),
            Variant::Cogeneration => Inputs {
                fuel_offset_kg_s: (0.92 - 1.0) * plant.governor.design_fuel_kg_s,
                ..Inputs::design(&plant)
            },
        };
        let at = Equilibrium::new(plant, inputs);
        // 4 % are kept for the plant's motion.
        let limit_s =
            0.96 * longest_step_s(&at.plant, &at.inputs, &State::from_array(&at.x)).unwrap();
        assert_eq!(
            simulate(&scenario).unwrap_err().to_string(),
            format!(
                "substeps: expected {least} to 10000 a sample (a step of at most {limit_s:.6} s), \
                 found {}",
                least - 1
            )
        );
        assert!(SAMPLE_TIME_S / (least as f64) <= limit_s);
        let accepted = Scenario {
            substeps: least,
            ..scenario
        };
        assert_eq!(simulate(&accepted).unwrap().truth.len(), 10);
    }
}
