//! Writes a log that begins a new file every hour, and prints the names of the files.
//!
//! `cargo run -p gt-log --example rotate_log -- FOLDER`

use std::env;
use std::error::Error;
use std::path::PathBuf;

use gt_core::Signal;
use gt_log::{EPOCH_NS, LogHead, RotatingLog, RotationOptions, TopicHead};

/// Time between samples in seconds.
const PERIOD_S: u64 = 60;
/// Samples: two and a half hours.
const SAMPLES: u64 = 150;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = env::args_os().nth(1).map(PathBuf::from);
    let folder = folder.ok_or("expected the folder of the log, found no argument")?;
    let head = LogHead {
        topics: vec![TopicHead {
            topic: "/plant/measured".to_owned(),
            message: "Measured".to_owned(),
            fields: vec![Signal::new("T-101", "K"), Signal::new("level", "m")],
            sample_period_s: PERIOD_S as f64,
            asset: "tank".to_owned(),
        }],
        attachments: vec![(
            "config.toml".to_owned(),
            "application/toml".to_owned(),
            b"asset = \"tank\"\n".to_vec(),
        )],
        ..LogHead::default()
    };
    let mut log = RotatingLog::create(RotationOptions::new(&folder), head)?;
    for k in 0..SAMPLES {
        let time_ns = EPOCH_NS + k * PERIOD_S * 1_000_000_000;
        let level = (0.1 * k as f64).sin();
        // The level meter is silent every tenth minute.
        let values = [Some(300.0 + level), (k % 10 != 9).then_some(level)];
        log.write(0, time_ns, &values)?;
    }
    log.finish()?;
    let mut names = Vec::new();
    for entry in folder.read_dir()? {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    println!("{}", names.join("\n"));
    Ok(())
}
