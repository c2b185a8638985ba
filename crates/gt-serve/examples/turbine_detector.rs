//! Makes the detector of the embedded turbine: `cargo run --release -p gt-serve --example
//! turbine_detector > crates/gt-serve/assets/turbine_detector.json`.

use std::error::Error;

use gt_campaign::isolation::{Ambient, Preparation, Setting};
use gtfdi::plant::{MapSet, NoiseLevel};

fn main() -> Result<(), Box<dyn Error>> {
    let setting = Setting::new(MapSet::Paper, NoiseLevel::Table8, Ambient::Constant, 1)?;
    let preparation = Preparation {
        healthy_hours: 16,
        arl0_hours: 24.0,
    };
    let prepared = preparation.prepare(&setting)?;
    eprintln!("{}", preparation.definition());
    println!("{}", serde_json::to_string(&prepared.isolator)?);
    Ok(())
}
