//! Runs a campaign's file into a folder, or goes on with what is there, and prints how each fault
//! was found.
//!
//! `cargo run --release -p gt-campaign --example small_campaign -- CAMPAIGN.toml FOLDER`

use std::env;
use std::error::Error;
use std::path::PathBuf;

use gt_campaign::Progress;
use gt_campaign::campaign::{Proportion, Summary, prepare};

/// Says on standard error how far it is.
struct Told;

impl Progress for Told {
    fn report(&self, what: &str, done: usize, total: usize) {
        eprintln!("{what}: {done} of {total}");
    }
}

fn shown(share: &Proportion) -> String {
    let (count, of) = (share.count, share.of);
    format!(
        "{count} of {of} runs, {:.2} to {:.2}",
        share.low, share.high
    )
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [file, folder] = &arguments[..] else {
        return Err("expected CAMPAIGN.toml FOLDER".into());
    };
    let (campaign, folder) = prepare(file, folder, &Told)?;
    let rows = campaign.fill(&folder, &Told)?;
    let summary = Summary::new(campaign.spec(), &rows);
    println!("{} runs, {} failed", summary.runs, summary.failed);
    if let Some(rate) = &summary.false_alarms {
        let (alarms, hours) = (rate.alarms, rate.hours);
        println!("{alarms} false alarms in {hours:.2} h before the onsets");
    }
    for fault in &summary.faults {
        println!(
            "{} ({}): {}",
            fault.fault,
            fault.unit,
            shown(&fault.detected)
        );
        for bin in &fault.sizes {
            println!(
                "  {:.3} to {:.3}: {}",
                bin.from,
                bin.to,
                shown(&bin.detected)
            );
        }
    }
    // Any run is made again alone, the same bits.
    let again = campaign.row(0)?;
    println!("run 0 again is the same: {}", again == rows[0]);
    Ok(())
}
