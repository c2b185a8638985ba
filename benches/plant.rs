//! Real-time factor of the simulated turbine on one core, against the derivative evaluations that
//! RK4 cannot do without, with the error of the step beside it.
//!
//! `cargo bench -p gtfdi --bench plant`

mod timing;

use std::error::Error;
use std::hint::black_box;

use gtfdi::core::Dataset;
use gtfdi::plant::dynamics::{Inputs, derivative};
use gtfdi::plant::{
    FaultSizes, PlantParameters, Profile, SAMPLE_TIME_S, Scenario, rk4, simulate, steady_state,
};

/// Length of the run, s.
const DURATION_S: f64 = 20.0;
/// Substeps of the default scenario, the fewest that are stable, and those of the reference.
const SUBSTEPS: [usize; 3] = [40, 24, 320];

fn scenario(substeps: usize) -> Result<Scenario, Box<dyn Error>> {
    Ok(Scenario {
        duration_s: DURATION_S,
        substeps,
        profile: Profile::named("standard")?,
        ..Scenario::default()
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let [default, coarse, fine] = [
        scenario(SUBSTEPS[0])?,
        scenario(SUBSTEPS[1])?,
        scenario(SUBSTEPS[2])?,
    ];
    let parameters = PlantParameters::for_maps(default.map_set);
    let inputs = Inputs::design(&parameters);
    let state = steady_state(&parameters)?.state.to_array();
    let steps = default.samples()? * default.substeps;
    let slope = |x: &[f64; _]| derivative(&parameters, &inputs, &FaultSizes::HEALTHY, x);

    let reference = simulate(&fine)?.truth;
    for run in [&default, &coarse] {
        println!(
            "{:.2} ms steps: largest output error {:.1e} of that output's deviation \
             (against {:.2} ms)",
            1e3 * run.step_s(),
            largest_error(&simulate(run)?.truth, &reference),
            1e3 * fine.step_s(),
        );
    }
    // RK4 held at the equilibrium stays there: the bare loop does the work of the real one.
    let held = integrate(slope, &state, steps, default.step_s());
    let drift = held.iter().zip(&state).map(|(x, x0)| (x / x0 - 1.0).abs());
    let drift = drift.filter(|drift| drift.is_finite()).fold(0.0, f64::max);
    println!("bare RK4 loop: leaves the equilibrium by {drift:.1e} (at most 1e-6)");
    if drift > 1e-6 {
        return Err(format!("the bare loop left the equilibrium: {drift:e}").into());
    }

    let times = timing::race(vec![
        (
            "floor: derivative alone, 4 a step",
            Box::new(|| {
                for _ in 0..4 * steps {
                    black_box(slope(black_box(&state)));
                }
            }),
        ),
        (
            "bare RK4 loop, inputs held",
            Box::new(|| {
                black_box(integrate(slope, black_box(&state), steps, default.step_s()));
            }),
        ),
        (
            "simulate, 40 substeps of 2 ms (default)",
            Box::new(|| {
                let _ = black_box(simulate(black_box(&default)));
            }),
        ),
        (
            "simulate, 24 substeps of 3.33 ms",
            Box::new(|| {
                let _ = black_box(simulate(black_box(&coarse)));
            }),
        ),
    ]);
    println!("\nTurbine, {DURATION_S} s at a sample time of {SAMPLE_TIME_S} s, one core");
    times.print(
        "x real time",
        |seconds| DURATION_S / seconds,
        &[0, 1],
        ("", &[]),
    );
    println!(
        "derivative: {:.0} ns",
        1e9 * times.median_s(0) / (4 * steps) as f64
    );
    println!("/ [i]: speed over that of row i, median of rounds; rows 0 and 1 take 2 ms steps.");
    Ok(())
}

/// The state after some steps with held inputs.
fn integrate<const N: usize>(
    slope: impl Fn(&[f64; N]) -> [f64; N],
    start: &[f64; N],
    steps: usize,
    step_s: f64,
) -> [f64; N] {
    let mut x = *start;
    for _ in 0..steps {
        x = rk4::step(|_, x| slope(x), 0.0, &x, step_s);
    }
    x
}

/// The largest difference of an output from the reference, over the standard deviation there.
fn largest_error(found: &Dataset, reference: &Dataset) -> f64 {
    let rows = found.y().row_iter().zip(reference.y().row_iter());
    rows.map(|(found, reference)| (found - reference).amax() / reference.variance().sqrt())
        .filter(|error| error.is_finite())
        .fold(0.0, f64::max)
}
