//! A run sample by sample, in the order that `simulate` documents, with an integrator of choice.

use gt_plant::drive::Drive;
use gt_plant::dynamics::derivative;
use gt_plant::state::{STATES, State};
use gt_plant::trim::{Hold, trim};
use gt_plant::{FaultSizes, Inputs, PlantParameters, SAMPLE_TIME_S, Scenario, rk4};

/// Runs the plant of a scenario from its healthy equilibrium, with constant fault sizes instead of
/// the scenario's faults.
///
/// `see` gets the inputs that led to each sample and its state; then the inputs move and `advance`
/// takes the state over one sample time.
pub fn run(
    plant: &PlantParameters,
    scenario: &Scenario,
    mut see: impl FnMut(&Inputs, &State),
    advance: impl Fn(&Inputs, &[f64; STATES]) -> [f64; STATES],
) {
    let mut drive = Drive::new(
        &scenario.profile,
        &scenario.boundary,
        &scenario.disturbance,
        scenario.seed,
        scenario.run_index,
    );
    let mut inputs = Inputs::driven(plant, &drive.start());
    let start = trim(plant, &inputs, &FaultSizes::HEALTHY, Hold::Control).unwrap();
    let mut x = start.state.to_array();
    for _ in 1..scenario.samples().unwrap() {
        see(&inputs, &State::from_array(&x));
        inputs = Inputs::driven(plant, &drive.step());
        x = advance(&inputs, &x);
    }
    see(&inputs, &State::from_array(&x));
}

/// The state one sample after `x` by `substeps` steps of RK4.
pub fn by_rk4(
    plant: &PlantParameters,
    inputs: &Inputs,
    faults: &FaultSizes,
    x: &[f64; STATES],
    substeps: usize,
) -> [f64; STATES] {
    let step_s = SAMPLE_TIME_S / substeps as f64;
    let mut x = *x;
    for _ in 0..substeps {
        x = rk4::step(|_, x| derivative(plant, inputs, faults, x), 0.0, &x, step_s);
    }
    x
}
