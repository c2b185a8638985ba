//! Makes what the embedded turbine needs: its scenario (with the noise of its sensors in their units)
//! and its detector.
//!
//! `cargo run --release -p gt-serve --example embedded_turbine crates/gt-serve/assets`

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use gt_campaign::isolation::{Ambient, Preparation, Setting};
use gtfdi::plant::{MapSet, NoiseLevel};

/// Run index of the turbine's movements: not one of those that its detector is made from.
const RUN_INDEX: u64 = 1_000_000;
/// Nobody's: the noise is given in units.
const REFERENCE_S: f64 = 60.0;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("expected a folder")?);
    let setting = Setting::new(MapSet::Paper, NoiseLevel::Table8, Ambient::Constant, 1)?;
    let scenario = setting.scenario(RUN_INDEX, &[], REFERENCE_S)?;
    let text = serde_json::to_string_pretty(&scenario)?;
    fs::write(folder.join("turbine_scenario.json"), text + "\n")?;
    let preparation = Preparation {
        healthy_hours: 16,
        arl0_hours: 24.0,
    };
    let prepared = preparation.prepare(&setting)?;
    println!("{}", preparation.definition());
    let text = serde_json::to_string(&prepared.isolator)?;
    fs::write(folder.join("turbine_detector.json"), text + "\n")?;
    Ok(())
}
