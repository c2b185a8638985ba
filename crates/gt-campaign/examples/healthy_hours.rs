//! Do banks keep the false-alarm rate that they promise? Noisy healthy running of the simulated
//! turbine, with its load always changing, on records that no limit has seen.
//!
//! Models with noise are identified from 600 s; filters are made for that noise; limits are set on
//! other healthy records for one false alarm in 24 h of all tests together; then the alarms of as
//! many fresh hours as asked are counted.
//!
//! `cargo run --release -p gt-campaign --example healthy_hours [HOURS [CALIBRATION_HOURS]]`

use std::error::Error;

use gt_campaign::{TestPlan, Watch, kalman_generator};
use gtfdi::core::Dataset;
use gtfdi::fdi::{
    Bank, FalseAlarmRate, Glr, ResidualGenerator, StatisticKind, ThresholdRule, Waveform,
};
use gtfdi::ident::OrderChoice;
use gtfdi::ident::eiv::EivIdentification;
use gtfdi::plant::{
    MapSet, NoiseLevel, PlantParameters, Profile, Scenario, Variant, lanes_at_once, simulate_batch,
};
use rayon::prelude::*;

const INPUTS: [&str; 2] = ["a_v", "M_f"];
const OUTPUTS: [&str; 4] = ["q_c", "t3", "p7", "m9"];
/// Order of the relations; two by the likelihood's BIC on such records.
const ORDER: usize = 2;
/// Hours between false alarms that are asked for.
const ASKED_HOURS: f64 = 24.0;
const HOUR_S: f64 = 3600.0;
const SEED: u64 = 1;

/// Records of the turbine's channels, one a run index.
fn records(indices: std::ops::Range<u64>, duration_s: f64) -> Result<Vec<Dataset>, Box<dyn Error>> {
    let profile = Profile::named(Variant::Prototype, "lively")?;
    let scenarios: Vec<Scenario> = indices
        .map(|run_index| Scenario {
            duration_s,
            profile: profile.clone(),
            noise: NoiseLevel::Table8.into(),
            seed: SEED,
            run_index,
            ..Scenario::default()
        })
        .collect();
    let plant = PlantParameters::for_maps(MapSet::Paper);
    let runs: Vec<Result<Dataset, String>> = scenarios
        .par_chunks(lanes_at_once())
        .flat_map_iter(|scenarios| {
            simulate_batch(&plant, scenarios).into_iter().map(|run| {
                let run = run.map_err(|error| error.to_string())?;
                let own = run.measured.select(&INPUTS, &OUTPUTS);
                own.map_err(|error| error.to_string())
            })
        })
        .collect();
    Ok(runs.into_iter().collect::<Result<_, String>>()?)
}

fn generators(
    training: &Dataset,
) -> Result<(gtfdi::ident::ArxModel, Vec<ResidualGenerator>), Box<dyn Error>> {
    let identified = EivIdentification::new(OrderChoice::Given(ORDER))
        .nk(vec![0, 0])
        .identify(training)?;
    for remark in &identified.remarks {
        println!("{remark}");
    }
    let model = identified.model.relation().clone();
    let mut generators = Vec::new();
    for output in 0..OUTPUTS.len() {
        let part = model.output_model(output)?;
        generators.push(kalman_generator(
            &model,
            Some(&identified.model),
            output,
            part,
        )?);
    }
    Ok((model, generators))
}

fn argument(position: usize, default: u64) -> Result<u64, Box<dyn Error>> {
    Ok(match std::env::args().nth(position) {
        Some(text) => text.parse()?,
        None => default,
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let (hours, calibration_hours) = (argument(1, 72)?, argument(2, 24)?);
    let training = records(0..1, 600.0)?.remove(0);
    let (model, generators) = generators(&training)?;
    let healthy = records(1..1 + calibration_hours, HOUR_S)?;
    let fresh = records(10_000..10_000 + hours, HOUR_S)?;
    println!(
        "{hours} fresh hours; limits from {calibration_hours} other hours for one false alarm in \
         {ASKED_HOURS} h of all tests together; seed {SEED}"
    );
    let (smallest, largest) = StatisticKind::DEFAULT_SLOPES;
    let glr = StatisticKind::Glr {
        waveform: Waveform::Ramp,
        smallest,
        largest,
        longest: Glr::DEFAULT_LONGEST,
    };
    let plans = [
        (
            "cusum 0.5",
            StatisticKind::Cusum { allowance: 0.5 },
            Watch::Outputs,
        ),
        (
            "cusum 0.25",
            StatisticKind::Cusum { allowance: 0.25 },
            Watch::Outputs,
        ),
        ("ramp glr", glr, Watch::Outputs),
        (
            "moving average 125",
            StatisticKind::MovingAverage { window: 125 },
            Watch::Outputs,
        ),
        (
            "chi-square 25",
            StatisticKind::ChiSquare { window: 25 },
            Watch::Outputs,
        ),
        (
            "chi-square 25, joint",
            StatisticKind::ChiSquare { window: 25 },
            Watch::Joint,
        ),
    ];
    let mut kept = true;
    for (name, statistic, watch) in plans {
        let plan = TestPlan {
            statistic,
            rule: ThresholdRule::MeanTimeBetweenFalseAlarms {
                hours: ASKED_HOURS,
                consecutive: 1,
            },
            watch,
        };
        let in_sample = vec![false; healthy.len()];
        let tests = plan
            .tests(&model, &generators, &healthy, &in_sample)
            .map_err(|(test, error)| format!("{test}: {error}"))?;
        for test in &tests {
            let whitening = test.evaluation.whitening.as_ref();
            let time = test.false_alarms.mean_time;
            println!(
                "  {name}, {}: whitening of order {}, limit {:.2}, by its tail {:.0} h ({:.0} .. \
                 {:.0}) for {:.0} h",
                test.name,
                whitening.map_or(0, gtfdi::fdi::Whitening::order),
                test.threshold.limit,
                time.and_then(|time| time.hours).unwrap_or(f64::NAN),
                time.and_then(|time| time.hours_low).unwrap_or(f64::NAN),
                time.and_then(|time| time.hours_high).unwrap_or(f64::NAN),
                time.map_or(f64::NAN, |time| time.asked_hours),
            );
        }
        let bank = Bank::new(name, generators.clone(), tests)?;
        let alarms: usize = fresh
            .par_iter()
            .map(|record| bank.run(record).map(|run| run.alarms.len()))
            .collect::<Result<Vec<_>, _>>()?
            .iter()
            .sum();
        let rate = FalseAlarmRate::from_counts(alarms, hours as f64)?;
        let asked = 1.0 / ASKED_HOURS;
        let inside = rate.per_hour_low <= asked && asked <= rate.per_hour_high;
        kept &= inside;
        println!(
            "{name}: {alarms} alarms in {hours} h, {:.4} an hour, 95 % interval {:.4} .. {:.4}; asked \
             {asked:.4}: {}",
            rate.per_hour,
            rate.per_hour_low,
            rate.per_hour_high,
            if inside { "inside" } else { "OUTSIDE" }
        );
    }
    if kept {
        Ok(())
    } else {
        Err("a rate that was asked for is outside the interval of what was counted".into())
    }
}
