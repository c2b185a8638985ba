//! Restarts in the middle of a stream: a detector is fed sample by sample, all that it remembers is
//! saved as JSON, and another one, made from the bank's JSON, goes on as if nothing had happened.
//!
//! `cargo run -p gtfdi --example saved_state`

use std::error::Error;

use gtfdi::core::Dataset;
use gtfdi::fdi::{
    Bank, Detector, DetectorState, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule,
};
use gtfdi::ident::{Arx, ArxStructure};
use gtfdi::plant::{Fault, FaultCase, Scenario, simulate};

/// The sample before which the first detector stops: in the middle of the fault.
const RESTART: usize = 2000;

/// Inputs `a_v` and `M_f`, output `t3`, of five minutes of the turbine.
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

/// An observer with a cumulative sum on its whitened residual.
fn bank() -> Result<Bank, Box<dyn Error>> {
    let (na, nb, nk) = (8, vec![8, 9], vec![1, 0]);
    let model = Arx::new(ArxStructure::Diagonal { na, nb, nk }).fit(&record(0, vec![])?)?;
    let part = model.output_model(0)?;
    let poles = vec![0.3; part.model.nx()];
    let generator = ResidualGenerator::observer(part.model, part.point, &poles)?;
    let healthy = [record(1, vec![])?, record(2, vec![])?];
    let rule = ThresholdRule::Margin {
        factor: 1.5,
        consecutive: 1,
    };
    let statistic = StatisticKind::Cusum { allowance: 0.5 };
    let test = ResidualTest::calibrate("t3", &[&generator], &healthy, statistic, rule)?;
    Ok(Bank::new("thermocouple", vec![generator], vec![test])?)
}

/// Feeds some samples of a stream; the verdicts as text, every bit of their numbers included.
fn feed(
    detector: &mut Detector,
    stream: &Dataset,
    samples: std::ops::Range<usize>,
) -> Result<Vec<String>, Box<dyn Error>> {
    let step = |k: usize| {
        let (u, y) = (stream.u().column(k), stream.y().column(k));
        let verdict = detector.step(stream.time_s(k), u.as_slice(), y.as_slice())?;
        Ok(format!("{verdict:?}"))
    };
    samples.map(step).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let bank = bank()?;
    let drift = Fault::nominal(FaultCase::ThermocoupleDrift, 60.0);
    let stream = record(3, vec![drift])?;
    let mut unbroken = Detector::new(&bank);
    let expected = feed(&mut unbroken, &stream, 0..stream.len())?;

    let mut first = Detector::new(&bank);
    feed(&mut first, &stream, 0..RESTART)?;
    let (bank_text, state_text) = (
        serde_json::to_string(&bank)?,
        serde_json::to_string(&first.state())?,
    );
    println!("saved after {RESTART} samples: {} bytes", state_text.len());

    // Whoever starts again has the two texts and nothing else. Both are checked.
    let bank: Bank = serde_json::from_str(&bank_text)?;
    let state: DetectorState = serde_json::from_str(&state_text)?;
    let mut second = Detector::new(&bank);
    second.resume(&state)?;
    let found = feed(&mut second, &stream, RESTART..stream.len())?;
    let alike = found.iter().zip(&expected[RESTART..]);
    println!(
        "{} of {} verdicts are those without a restart",
        alike.filter(|(one, other)| one == other).count(),
        found.len()
    );
    Ok(())
}
