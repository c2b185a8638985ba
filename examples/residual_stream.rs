//! Embeds the detector: makes a bank for the thermocouple t3 of the simulated turbine, feeds it
//! sample by sample and prints what changes.
//!
//! `cargo run -p gtfdi --example residual_stream`

use std::error::Error;

use gtfdi::core::Dataset;
use gtfdi::fdi::{Bank, Detector, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule};
use gtfdi::ident::{Arx, ArxStructure};
use gtfdi::plant::{Fault, FaultCase, Scenario, simulate};

/// Inputs `a_v` and `M_f`, output `t3`, of a run of the turbine.
fn record(run_index: u64, faults: Vec<Fault>) -> Result<Dataset, Box<dyn Error>> {
    let scenario = Scenario {
        duration_s: 300.0,
        faults,
        run_index,
        ..Scenario::default()
    };
    Ok(simulate(&scenario)?
        .measured
        .select(&["a_v", "M_f"], &["t3"])?)
}

/// A bank with one observer: ARX model, output observer, threshold from healthy records.
fn bank() -> Result<Bank, Box<dyn Error>> {
    let (na, nb, nk) = (8, vec![8, 9], vec![1, 0]);
    let model = Arx::new(ArxStructure::Diagonal { na, nb, nk }).fit(&record(0, vec![])?)?;
    let part = model.output_model(0)?;
    let poles = vec![0.3; part.model.nx()];
    let generator = ResidualGenerator::observer(part.model, part.point, &poles)?;
    let healthy = [record(1, vec![])?, record(2, vec![])?];
    let (factor, consecutive) = (2.0, 3);
    let rule = ThresholdRule::Margin {
        factor,
        consecutive,
    };
    let statistic = StatisticKind::Modulus;
    let test = ResidualTest::calibrate("t3", &[&generator], &healthy, statistic, rule)?;
    Ok(Bank::new("thermocouple", vec![generator], vec![test])?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let bank = bank()?;
    println!("limit on |r|: {:.4} K", bank.tests()[0].threshold.limit);
    let drift = Fault::nominal(FaultCase::ThermocoupleDrift, 60.0);
    println!("the thermocouple drifts by 5 % an hour from 60 s on");
    let stream = record(3, vec![drift])?;

    let mut detector = Detector::new(&bank);
    let mut before = "start";
    for k in 0..stream.len() {
        let (u, y) = (stream.u().column(k), stream.y().column(k));
        let verdict = detector.step(stream.time_s(k), u.as_slice(), y.as_slice())?;
        let channel = &verdict.channels[0];
        let state = match (channel.settling, channel.alarm) {
            (true, _) => "settling",
            (false, true) => "ALARM",
            (false, false) => "healthy",
        };
        if state != before {
            let onset = channel
                .first_exceedance_s
                .map(|t| format!(", above the limit since {t:.2} s"));
            println!(
                "{:8.2} s  r = {:8.4} K  {state}{}",
                verdict.time_s,
                channel.residual,
                onset.unwrap_or_default()
            );
            before = state;
        }
    }
    Ok(())
}
