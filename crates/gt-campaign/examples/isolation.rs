//! Minimal detectable faults and the naming of faults on the simulated turbine, for one level of
//! sensor noise and one set of compressor maps.
//!
//! `cargo run --release -p gt-campaign --example isolation [LEVEL [MAPS [RUNS [HOURS [NAMED]]]]]`:
//! level of noise, `paper` or `axial`, runs a limit, healthy hours behind the alarms, named runs.

use std::error::Error;
use std::time::Instant;

use gt_campaign::isolation::{
    Ambient, LimitSearch, NamingStudy, NamingSummary, Preparation, Prepared, Setting,
};
use gtfdi::plant::{FaultCase, MapSet, NoiseLevel};

/// Seconds in which the faults grow, as in the naming study.
const DELAY_S: f64 = 60.0;

fn argument(place: usize, default: &str) -> String {
    std::env::args()
        .nth(place)
        .unwrap_or_else(|| default.to_owned())
}

fn show(prepared: &Prepared) {
    for remark in &prepared.remarks {
        println!("{remark}");
    }
    let isolator = &prepared.isolator;
    println!(
        "whitening of order {}, {} samples to settle",
        isolator.whitening().order(),
        isolator.settle_samples()
    );
    let names = isolator.hypotheses().iter().map(|own| own.name.as_str());
    let limits = isolator.limits().iter().zip(isolator.mean_times());
    for (name, (limit, time)) in names.chain(["any direction"]).zip(limits) {
        println!(
            "  {name}: limit {limit:.2}, {:.0} .. {:.0} h for {:.0} h",
            time.hours_low.unwrap_or(f64::NAN),
            time.hours_high.unwrap_or(f64::NAN),
            time.asked_hours
        );
    }
    let directions = isolator.directions();
    for (own, direction) in isolator.hypotheses().iter().zip(directions) {
        let direction = direction.map(|own| own.as_slice().to_vec());
        println!("  {}: {:?}, {direction:.3?}", own.name, own.effect);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let level = NoiseLevel::try_from(argument(1, "table8"))?;
    let map_set = match argument(2, "paper").as_str() {
        "axial" => MapSet::Axial,
        _ => MapSet::Paper,
    };
    let (runs, healthy_hours) = (argument(3, "120").parse()?, argument(4, "16").parse()?);
    let started = Instant::now();
    let setting = Setting::new(map_set, level, Ambient::Constant, 1)?;
    let preparation = Preparation {
        healthy_hours,
        arl0_hours: 24.0,
    };
    let prepared = preparation.prepare(&setting)?;
    println!("{}", preparation.definition());
    show(&prepared);
    let guesses = match level {
        NoiseLevel::None => [0.03, 0.02, 0.04, 0.03],
        NoiseLevel::Tables4And5 => [3.0, 0.7, 1.5, 3.0],
        _ => [0.1, 0.06, 0.25, 0.4],
    };
    let mut limits = [0.0; 4];
    for ((case, guess), to) in FaultCase::ALL.into_iter().zip(guesses).zip(&mut limits) {
        let search = LimitSearch {
            case,
            delay_s: DELAY_S,
            guess,
            largest: if case == FaultCase::ALL[3] { 2.9 } else { 25.0 },
            runs,
            detection_probability: 0.95,
        };
        let limit = search.find(&prepared.setting, &prepared.isolator)?;
        let [low, high] = limit.interval;
        let (size, unit) = (limit.size, case.unit());
        println!("{case:?} in {DELAY_S} s: {size:.4} {unit} ({low:.4} .. {high:.4})");
        *to = size;
    }
    let study = NamingStudy {
        limits,
        multiples: [1.0, 4.0],
        runs: argument(5, "1000").parse()?,
    };
    let summary = NamingSummary::of(&study.rows(&prepared)?);
    println!("{summary:#.1?}\n{:.0} s", started.elapsed().as_secs_f64());
    Ok(())
}
