//! How many runs a second: 60 s of the turbine, 750 samples through four observers with a CUSUM each.
//!
//! Noise-free and with the noise of Table 8; with the steps that a campaign has where nobody says
//! otherwise, and with the longest that are stable.
//! The share of the simulation alone is measured beside.
//!
//! `cargo run --release -p gt-campaign --example campaign_throughput [RUNS]`

use std::error::Error;
use std::time::Instant;

use gt_campaign::Silent;
use gt_campaign::campaign::{BankChoice, Campaign, Spec};
use gt_log::DetectorFile;
use gtfdi::plant::{
    NoiseLevel, PlantError, PlantParameters, Scenario, lanes_at_once, simulate, simulate_batch,
};
use rayon::prelude::*;

/// Runs where nobody asks for another number.
const RUNS: u64 = 512;

/// A campaign of `runs` runs, half of them healthy, one fault in four a drift of the thermocouple.
fn spec(runs: u64, noise: NoiseLevel, substeps: usize) -> Result<Spec, Box<dyn Error>> {
    let mut spec: Spec = toml::from_str(
        "seed = 1\nruns = 1\nhealthy_share = 0.5\n\
         [record]\nduration_s = 60.0\nonset_s = [20.0, 40.0]\n\
         [[faults]]\ncase = 1\nsize = { uniform = [0.5, 2.0] }\nshape = { ramp = { rise_s = 10.0 } }\n\
         [[faults]]\ncase = 2\nsize = { uniform = [0.5, 2.0] }\nshape = { ramp = { rise_s = 10.0 } }\n\
         [[faults]]\ncase = 3\nsize = { uniform = [0.5, 2.0] }\nshape = { ramp = { rise_s = 10.0 } }\n\
         [[faults]]\ncase = 4\nsize = { uniform = [0.1, 0.5] }\nshape = { ramp = { rise_s = 10.0 } }\n\
         [bank]\ncalibration_h = 2.0",
    )?;
    spec.runs = runs;
    spec.plant.noise = noise;
    spec.plant.substeps = substeps;
    Ok(spec)
}

/// The fewest steps a sample that the plant accepts.
fn fewest() -> Result<usize, Box<dyn Error>> {
    let scenario = Scenario {
        substeps: 1,
        ..Scenario::default()
    };
    match simulate(&scenario) {
        Err(PlantError::Substeps { least, .. }) => Ok(least),
        _ => Err("one substep should be too few".into()),
    }
}

/// Runs a second of some work on all of them.
fn rate(runs: u64, work: impl FnOnce()) -> f64 {
    let started = Instant::now();
    work();
    runs as f64 / started.elapsed().as_secs_f64()
}

fn main() -> Result<(), Box<dyn Error>> {
    let runs = match std::env::args().nth(1) {
        Some(text) => text.parse()?,
        None => RUNS,
    };
    let default = Scenario::default().substeps;
    println!(
        "{runs} runs of 60 s, {} at once in a core, {} threads",
        lanes_at_once(),
        rayon::current_num_threads()
    );
    for noise in [NoiseLevel::None, NoiseLevel::Table8] {
        let base = spec(runs, noise, default)?;
        let BankChoice::Tests(family) = &base.bank else {
            return Err("the bank is made".into());
        };
        let bank = base.make_bank(family, &base.noise()?, &Silent)?;
        for substeps in [default, fewest()?] {
            let spec = spec(runs, noise, substeps)?;
            let plant = PlantParameters::for_maps(spec.plant.map_set);
            let campaign = Campaign::new(spec, DetectorFile::Bank(bank.clone()))?;
            let indices: Vec<u64> = (0..runs).collect();
            let groups = || indices.par_chunks(lanes_at_once());
            let mut failed = Ok(());
            let whole = rate(runs, || {
                failed = groups().try_for_each(|group| campaign.rows(group).map(|_| ()));
            });
            failed?;
            let scenarios = indices
                .iter()
                .map(|&run| campaign.scenario(run))
                .collect::<Result<Vec<Scenario>, _>>()?;
            let simulated = rate(runs, || {
                let groups = scenarios.par_chunks(lanes_at_once());
                groups.for_each(|group| drop(simulate_batch(&plant, group)));
            });
            println!(
                "noise {noise}, {substeps} steps a sample: {whole:.0} runs/s, simulation alone \
                 {simulated:.0} runs/s; 10 000 runs in {:.0} s",
                10_000.0 / whole
            );
        }
    }
    Ok(())
}
