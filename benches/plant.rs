//! Speed of the simulated turbine: one plant against the derivative evaluations that RK4 cannot do
//! without, many plants at once against the bare lane kernel, and a campaign on all cores.
//!
//! `cargo bench -p gtfdi --bench plant`

mod lanes;
mod timing;

use std::error::Error;
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use gtfdi::core::Dataset;
use gtfdi::plant::dynamics::derivative;
use gtfdi::plant::state::STATES;
use gtfdi::plant::{
    Fault, FaultCase, FaultSizes, NoiseLevel, PlantError, PlantParameters, Scenario, Variant, rk4,
    simulate, simulate_batch, simulate_with, steady_state,
};

use lanes::{Derivatives, Integrated, Steps, sets};
use timing::Contender;

/// Plants in every row of a table: as many as the widest register has lanes.
const PLANTS: usize = 8;
/// Length of their runs, s.
const DURATION_S: f64 = 20.0;
/// Substeps of the reference for the error of the step.
const FINE: usize = 320;
/// Largest difference of the records of lanes and of one plant, relative.
const AGREEMENT: f64 = 1e-12;

/// Runs of the campaign, and of those that one plant at a time does of them.
const CAMPAIGN: usize = 1000;
const SAMPLED: usize = 50;
/// Length of a run of the campaign, s.
const CAMPAIGN_S: f64 = 60.0;
/// Runs of one call: the records of a whole campaign would fill the memory.
const CHUNK: usize = 64;
/// Rounds of the campaign, which takes seconds.
const CAMPAIGN_ROUNDS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    for variant in [Variant::Prototype, Variant::Cogeneration] {
        table(variant)?;
    }
    campaign()
}

/// Runs of a variant, each with its own excitation.
fn runs(variant: Variant, substeps: usize) -> Vec<Scenario> {
    let runs = 0..PLANTS as u64;
    runs.map(|run_index| Scenario {
        duration_s: DURATION_S,
        substeps,
        run_index,
        ..Scenario::of(variant)
    })
    .collect()
}

/// The same with noise of Table 8, which reaches no plant.
fn noisy(mut runs: Vec<Scenario>) -> Vec<Scenario> {
    for run in &mut runs {
        run.noise = NoiseLevel::Table8.into();
    }
    runs
}

/// The same with a fault that grows from the beginning on.
fn faulty(mut runs: Vec<Scenario>) -> Vec<Scenario> {
    let cases = [
        (FaultCase::CompressorFouling, 360.0),
        (FaultCase::TurbineDamage, 360.0),
        (FaultCase::FuelActuatorLag, 36.0),
    ];
    for (run, (case, rate_per_h)) in runs.iter_mut().zip(cases.into_iter().cycle()) {
        run.faults = vec![Fault::growing(case, 0.0, rate_per_h, None)];
    }
    runs
}

/// The fewest substeps that the variant accepts.
fn fewest(variant: Variant) -> Result<usize, Box<dyn Error>> {
    match simulate(&runs(variant, 1)[0]) {
        Err(PlantError::Substeps { least, .. }) => Ok(least),
        _ => Err("one substep should be too few".into()),
    }
}

fn table(variant: Variant) -> Result<(), Box<dyn Error>> {
    let least = fewest(variant)?;
    let default = runs(variant, Scenario::default().substeps);
    let (measured, coarse) = (noisy(default.clone()), noisy(runs(variant, least)));
    let growing = faulty(default.clone());
    let parameters = default[0].parameters();
    let start = steady_state(&parameters)?.state.to_array();
    let steps = Steps {
        parameters: &parameters,
        start: &start,
        plants: PLANTS,
        count: default[0].samples()? * default[0].substeps,
        step_s: default[0].step_s(),
    };

    println!(
        "\n{variant}: {PLANTS} runs of {DURATION_S} s, one core; steps of {:.2} ms, the longest \
         that are stable {:.2} ms",
        1e3 * default[0].step_s(),
        1e3 * coarse[0].step_s(),
    );
    for runs in [&measured, &coarse] {
        print_step_error(&runs[0])?;
    }
    for (what, runs) in [("noise", &measured), ("growing faults", &growing)] {
        check_batch(&parameters, what, runs)?;
    }
    check_kernels(&steps)?;

    let sets = sets();
    let mut contenders: Vec<Contender> = vec![
        (
            "floor: derivative alone, 4 a step",
            Box::new(|| derivatives(&steps)),
        ),
        (
            "bare RK4, inputs held",
            Box::new(|| {
                black_box(integrated(&steps));
            }),
        ),
        (
            "simulate, noise",
            Box::new(|| one_by_one(&parameters, &measured)),
        ),
        (
            "simulate, growing faults",
            Box::new(|| one_by_one(&parameters, &growing)),
        ),
        (
            "simulate, noise, longest stable steps",
            Box::new(|| one_by_one(&parameters, &coarse)),
        ),
        (
            "simulate_batch, noise",
            Box::new(|| together(&parameters, &measured)),
        ),
        (
            "simulate_batch, growing faults",
            Box::new(|| together(&parameters, &growing)),
        ),
        (
            "simulate_batch, noise, longest stable steps",
            Box::new(|| together(&parameters, &coarse)),
        ),
    ];
    let first_limit = contenders.len();
    for set in &sets {
        contenders.push((
            set.limit,
            Box::new(|| {
                black_box(set.arch.dispatch(Integrated(steps)));
            }),
        ));
    }
    for set in &sets {
        contenders.push((
            set.floor,
            Box::new(|| set.arch.dispatch(Derivatives(steps))),
        ));
    }
    let times = timing::race(contenders);
    println!();
    times.print(
        "x real time",
        |seconds| PLANTS as f64 * DURATION_S / seconds,
        &[0, 2, 3, first_limit],
        ("", &[]),
    );
    println!(
        "derivative of one plant: {:.0} ns",
        1e9 * times.median_s(0) / (4 * steps.count * PLANTS) as f64
    );
    Ok(())
}

/// A campaign: runs with noise, every second one with a fault (and thus integrated twice, because
/// noise is scaled by the healthy record).
fn campaign() -> Result<(), Box<dyn Error>> {
    let (runs, sampled) = if timing::is_measuring() {
        (CAMPAIGN, SAMPLED)
    } else {
        (16, 4)
    };
    let scenarios: Vec<Scenario> = (0..runs as u64)
        .map(|run_index| Scenario {
            duration_s: CAMPAIGN_S,
            run_index,
            noise: NoiseLevel::Table8.into(),
            faults: if run_index % 2 == 0 {
                Vec::new()
            } else {
                vec![Fault::growing(
                    FaultCase::TurbineDamage,
                    0.5 * CAMPAIGN_S,
                    180.0,
                    None,
                )]
            },
            ..Scenario::default()
        })
        .collect();
    let parameters = scenarios[0].parameters();
    let cores = thread::available_parallelism()?.get();
    println!(
        "\nCampaign: {runs} runs of {CAMPAIGN_S} s, noise, every second one with a growing fault, \
         calls of {CHUNK} runs, {cores} cores"
    );
    let times = timing::race_rounds(
        vec![
            (
                "simulate, one core, the first runs alone",
                Box::new(|| one_by_one(&parameters, &scenarios[..sampled])),
            ),
            (
                "simulate_batch, one core",
                Box::new(|| on_threads(&parameters, &scenarios, 1)),
            ),
            (
                "simulate_batch, all cores",
                Box::new(|| on_threads(&parameters, &scenarios, cores)),
            ),
        ],
        CAMPAIGN_ROUNDS,
    );
    let names = [
        "simulate, one core",
        "simulate_batch, one core",
        "simulate_batch, all cores",
    ];
    for (row, (name, runs)) in names.iter().zip([sampled, runs, runs]).enumerate() {
        let rate = runs as f64 / times.median_s(row);
        let speed = times.speed_over(row, 0) * runs as f64 / sampled as f64;
        println!(
            "{name:<32}{rate:>8.1} runs/s{:>9.0} x real time{speed:>8.2} / one by one",
            rate * CAMPAIGN_S,
        );
    }
    println!(
        "\n/ [i]: speed over that of row i, median of rounds. One by one is scaled up from the first \
         {sampled} runs."
    );
    Ok(())
}

/// Shares the calls of a campaign among threads.
fn on_threads(parameters: &PlantParameters, scenarios: &[Scenario], threads: usize) {
    let next = AtomicUsize::new(0);
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let calls = || {
                    scenarios
                        .chunks(CHUNK)
                        .nth(next.fetch_add(1, Ordering::Relaxed))
                };
                while let Some(call) = calls() {
                    together(parameters, call);
                }
            });
        }
    });
}

fn one_by_one(parameters: &PlantParameters, scenarios: &[Scenario]) {
    for scenario in scenarios {
        let _ = black_box(simulate_with(parameters, black_box(scenario)));
    }
}

fn together(parameters: &PlantParameters, scenarios: &[Scenario]) {
    black_box(simulate_batch(parameters, black_box(scenarios)));
}

/// The derivatives that the steps take, one plant at a time.
fn derivatives(of: &Steps) {
    let inputs = of.inputs();
    for _ in 0..4 * of.count * of.plants {
        let healthy = &FaultSizes::HEALTHY;
        black_box(derivative(
            of.parameters,
            &inputs,
            healthy,
            black_box(of.start),
        ));
    }
}

/// The steps, one plant at a time; gives the last plant's state.
fn integrated(of: &Steps) -> [f64; STATES] {
    let inputs = of.inputs();
    let slope = |_, x: &[f64; _]| derivative(of.parameters, &inputs, &FaultSizes::HEALTHY, x);
    let mut x = *of.start;
    for _ in 0..of.plants {
        x = *black_box(of.start);
        for _ in 0..of.count {
            x = rk4::step(slope, 0.0, &x, of.step_s);
        }
    }
    x
}

/// The largest difference of an output from that of fine steps, over its standard deviation.
fn print_step_error(run: &Scenario) -> Result<(), Box<dyn Error>> {
    let fine = Scenario {
        substeps: FINE,
        ..run.clone()
    };
    let error = largest_error(&simulate(run)?.truth, &simulate(&fine)?.truth);
    println!(
        "steps of {:.2} ms: largest output error {error:.1e} of that output's deviation (against \
         {:.2} ms)",
        1e3 * run.step_s(),
        1e3 * fine.step_s(),
    );
    Ok(())
}

fn largest_error(found: &Dataset, reference: &Dataset) -> f64 {
    let rows = found.y().row_iter().zip(reference.y().row_iter());
    rows.map(|(found, reference)| (found - reference).amax() / reference.variance().sqrt())
        .filter(|error| error.is_finite())
        .fold(0.0, f64::max)
}

/// Refuses to time lanes that do not do what one plant does.
fn check_batch(
    parameters: &PlantParameters,
    what: &str,
    runs: &[Scenario],
) -> Result<(), Box<dyn Error>> {
    let mut largest: f64 = 0.0;
    for (run, lane) in runs.iter().zip(simulate_batch(parameters, runs)) {
        let (alone, lane) = (simulate_with(parameters, run)?, lane?);
        if alone.ended.is_some() || alone.truth.len() != lane.truth.len() {
            return Err(format!("{what}: a run ended early").into());
        }
        largest = largest.max(relative_difference(
            lane.measured.y().as_slice(),
            alone.measured.y().as_slice(),
        ));
    }
    agreement(&format!("lanes and one plant, {what}"), largest, AGREEMENT)
}

/// The bare loops do the same work: the plants leave the equilibrium together.
fn check_kernels(steps: &Steps) -> Result<(), Box<dyn Error>> {
    let alone = integrated(steps);
    if relative_difference(&alone, steps.start) < 1e-3 {
        return Err("the plant rests".into());
    }
    for set in sets() {
        let lane = set.arch.dispatch(Integrated(*steps));
        let difference = relative_difference(&lane, &alone);
        agreement(set.limit, difference, AGREEMENT)?;
    }
    Ok(())
}

fn relative_difference(found: &[f64], expected: &[f64]) -> f64 {
    let pairs = found.iter().zip(expected);
    pairs
        .map(|(found, expected)| (found / expected - 1.0).abs())
        .filter(|difference| !difference.is_nan())
        .fold(0.0, f64::max)
}

fn agreement(what: &str, found: f64, most: f64) -> Result<(), Box<dyn Error>> {
    println!("{what}: differ by {found:.1e} (at most {most:.0e})");
    if found > most {
        return Err(format!("{what}: differ by {found:e}").into());
    }
    Ok(())
}
