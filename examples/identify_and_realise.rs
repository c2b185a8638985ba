//! Simulates the turbine, identifies an ARX model of the temperature t3, realises it in state space
//! and compares its free run with a record that it has not seen.
//!
//! `cargo run -p gtfdi --example identify_and_realise`

use std::error::Error;

use gtfdi::core::Dataset;
use gtfdi::ident::{Arx, ArxStructure, validate};
use gtfdi::plant::{Scenario, simulate};

/// Ten minutes of the turbine under excitation, without noise.
fn record(run_index: u64) -> Result<Dataset, Box<dyn Error>> {
    let scenario = Scenario {
        run_index,
        ..Scenario::default()
    };
    Ok(simulate(&scenario)?
        .measured
        .select(&["a_v", "M_f"], &["t3"])?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let (training, fresh) = (record(0)?, record(1)?);

    // The valve is held from its sample on; the demanded fuel acts at once, hence its lag 0.
    let structure = ArxStructure::Diagonal {
        na: 8,
        nb: vec![8, 9],
        nk: vec![1, 0],
    };
    let model = Arx::new(structure).fit(&training)?;
    println!(
        "{}, {} rows, condition {:.1e}",
        model.structure(),
        model.rows_used(),
        model.condition()[0]
    );

    let realisation = model.state_space()?;
    println!("{} states; poles:", realisation.nx());
    let mut poles = realisation.poles()?;
    poles.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    for pole in poles {
        println!(
            "  {:9.6} {:+9.6}i  (modulus {:.6})",
            pole.re,
            pole.im,
            pole.norm()
        );
    }

    for (name, data) in [("training", &training), ("fresh", &fresh)] {
        let fit = &validate(&model, data)?.outputs[0];
        let free_run = fit
            .sse_simulation
            .map_or("diverges".to_owned(), |sse| format!("{sse:.2e}"));
        println!(
            "{name:9} mean square error over variance: {:.2e} one step ahead, {free_run} free run",
            fit.sse_prediction
        );
    }
    Ok(())
}
