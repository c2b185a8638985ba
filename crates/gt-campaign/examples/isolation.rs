//! Minimal detectable faults and the naming of faults on the simulated turbine, for one level of
//! sensor noise and one set of compressor maps.
//!
//! `cargo run --release -p gt-campaign --example isolation [LEVEL [MAPS [RUNS [HOURS]]]]`

use std::error::Error;
use std::time::Instant;

use gt_campaign::isolation::{
    Ambient, LimitSearch, NamingStudy, NamingSummary, Preparation, Setting,
};
use gtfdi::plant::{FaultCase, MapSet, NoiseLevel};

fn main() -> Result<(), Box<dyn Error>> {
    let argument = |place: usize, default: &str| {
        std::env::args()
            .nth(place)
            .unwrap_or_else(|| default.to_owned())
    };
    let level = NoiseLevel::try_from(argument(1, "table8"))?;
    let map_set = if argument(2, "paper") == "axial" {
        MapSet::Axial
    } else {
        MapSet::Paper
    };
    let (runs, healthy_hours): (u64, u64) =
        (argument(3, "200").parse()?, argument(4, "24").parse()?);
    let ambient = if argument(5, "constant") == "measured" {
        Ambient::Measured
    } else {
        Ambient::Constant
    };
    let started = Instant::now();
    let setting = Setting::new(map_set, level, ambient, 1)?;
    let preparation = Preparation {
        healthy_hours,
        arl0_hours: 24.0,
    };
    let prepared = preparation.prepare(&setting)?;
    println!("{}", preparation.definition());
    for remark in &prepared.remarks {
        println!("{remark}");
    }
    let isolator = &prepared.isolator;
    println!(
        "whitening of order {}, limits {:.2?}",
        isolator.whitening().order(),
        isolator.limits()
    );
    for (name, time) in isolator
        .hypotheses()
        .iter()
        .map(|own| own.name.as_str())
        .chain(["any direction"])
        .zip(isolator.mean_times())
    {
        println!(
            "  {name}: {:.0} h ({:.0} .. {:.0})",
            time.hours.unwrap_or(0.0),
            time.hours_low.unwrap_or(0.0),
            time.hours_high.unwrap_or(0.0)
        );
    }
    for own in isolator.hypotheses() {
        println!("  {own:?}");
    }
    for direction in isolator.directions()?.into_iter().flatten() {
        println!("  {:.3?}", direction.as_slice());
    }
    println!("wander after 300 s {:.2?}", isolator.wander().last());
    println!("prepared in {:.0} s", started.elapsed().as_secs_f64());
    let guesses = match level {
        NoiseLevel::None => [0.03, 0.02, 0.04, 0.03],
        NoiseLevel::Tables4And5 => [3.0, 0.7, 1.5, 3.0],
        _ => [0.1, 0.06, 0.25, 0.4],
    };
    let delays = [30.0, 30.0, 60.0, 10.0];
    let mut limits = [0.0; 4];
    let given = argument(6, "");
    if !given.is_empty() {
        for (to, text) in limits.iter_mut().zip(given.split(',')) {
            *to = text.parse()?;
        }
    }
    for (place, case) in FaultCase::ALL.into_iter().enumerate() {
        if !given.is_empty() {
            continue;
        }
        let mut at = vec![delays[place]];
        if place == 3 {
            at.push(30.0);
        }
        if !at.contains(&60.0) {
            at.push(60.0);
        }
        for delay_s in at {
            let search = LimitSearch {
                case,
                delay_s,
                guess: guesses[place],
                runs,
                detection_probability: 0.95,
            };
            let limit = search.find(&prepared)?;
            println!(
                "{} at {delay_s} s: {:.4} {} ({:.4} .. {:.4}), median {:.4}",
                case.name(),
                limit.size,
                case.unit(),
                limit.interval[0],
                limit.interval[1],
                limit.smallest[limit.smallest.len() / 2]
            );
            limits[place] = limit.size;
        }
    }
    println!("limits in {:.0} s", started.elapsed().as_secs_f64());
    let study = NamingStudy {
        limits,
        multiples: [1.0, 4.0],
        runs: argument(7, "400").parse()?,
    };
    let rows = study.rows(&prepared)?;
    println!("{:#?}", NamingSummary::of(&rows));
    for case in 1..=4 {
        let own: Vec<_> = rows
            .iter()
            .filter(|row| row.case == case && row.alarm_s.is_some())
            .collect();
        let n = own.len() as f64;
        let inside = own
            .iter()
            .filter(|row| {
                row.onset_interval_s
                    .is_some_and(|[l, h]| l <= row.onset_s && row.onset_s <= h)
            })
            .count() as f64;
        let early = own
            .iter()
            .filter(|row| row.onset_interval_s.is_some_and(|[_, h]| h < row.onset_s))
            .count() as f64;
        let bias = own
            .iter()
            .map(|row| {
                row.onset_interval_s
                    .map_or(0.0, |[l, h]| 0.5 * (l + h) - row.onset_s)
            })
            .sum::<f64>()
            / n;
        let width = own
            .iter()
            .map(|row| row.onset_interval_s.map_or(0.0, |[l, h]| h - l))
            .sum::<f64>()
            / n;
        let size = own
            .iter()
            .filter(|row| {
                row.magnitude
                    .is_some_and(|m| (m - row.size).abs() < 0.15 * row.size.abs())
            })
            .count() as f64;
        let ratio = own
            .iter()
            .map(|row| row.magnitude.unwrap_or(0.0) / row.size)
            .sum::<f64>()
            / n;
        println!(
            "case {case}: onset inside {:.3}, interval early {:.3}, bias {bias:.2} s, width {width:.1} s; size right {:.3}, mean ratio {ratio:.3}",
            inside / n,
            early / n,
            size / n
        );
    }
    for row in rows
        .iter()
        .filter(|row| row.ever_wrong || row.named.is_none())
        .take(20)
    {
        println!("{row:?}");
    }
    println!("{:.0} s", started.elapsed().as_secs_f64());
    Ok(())
}
