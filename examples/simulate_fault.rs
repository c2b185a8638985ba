//! Runs the turbine with a fouled compressor and prints what the fault does to the four
//! monitored outputs.
//!
//! `cargo run -p gtfdi --example simulate_fault`

use std::error::Error;

use gtfdi::core::index_of;
use gtfdi::plant::{Fault, FaultCase, Profile, Scenario, Variant, simulate};

/// The monitored outputs: compressor torque, its exit temperature, a pressure and a mass flow.
const MONITORED: [&str; 4] = ["q_c", "t3", "p7", "m9"];
/// When the fault is complete and its transient over, s.
const SETTLED_S: f64 = 90.0;

fn main() -> Result<(), Box<dyn Error>> {
    let fault = Fault::growing(FaultCase::CompressorFouling, 10.0, 300.0, Some(5.0));
    let healthy = Scenario {
        duration_s: 120.0,
        profile: Profile::named(Variant::Prototype, "steady")?,
        ..Scenario::default()
    };
    let faulty = Scenario {
        faults: vec![fault.clone()],
        ..healthy.clone()
    };
    let (healthy, faulty) = (simulate(&healthy)?.measured, simulate(&faulty)?.measured);

    println!(
        "{}: {} {} from {} s on",
        fault.signal().name,
        fault.magnitude(SETTLED_S),
        fault.unit(),
        fault.onset_s
    );
    println!(
        "{:<6}{:<6}{:>12}{:>12}{:>10}",
        "", "unit", "healthy", "faulty", "change"
    );
    let last = healthy.len() - 1;
    for tag in MONITORED {
        let row = index_of(healthy.outputs(), tag)?;
        let (before, after) = (healthy.y()[(row, last)], faulty.y()[(row, last)]);
        println!(
            "{tag:<6}{:<6}{before:>12.3}{after:>12.3}{:>8.2} %",
            healthy.outputs()[row].unit,
            100.0 * (after / before - 1.0)
        );
    }
    Ok(())
}
