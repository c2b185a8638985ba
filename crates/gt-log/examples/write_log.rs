//! Writes a small log with everything other readers find hard: tags that are no identifiers, an
//! absent field, NaN, signed zero, subnormals, JSON.
//!
//! `cargo run -p gt-log --example write_log F.mcap`

use std::path::Path;

use gt_core::Signal;
use gt_log::{LogError, LogWriter, RunMetadata, sample_time_ns};

fn main() -> Result<(), LogError> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "log.mcap".to_owned());
    let run = RunMetadata {
        seed: Some(1),
        ..RunMetadata::default()
    };
    let mut log = LogWriter::create(Path::new(&path), &run)?;
    log.attach("config.toml", "application/toml", b"seed = 1\n")?;
    let fields = [
        Signal::new("fuel_flow_kg_s", "kg/s"),
        Signal::new("TI-101.PV", "K"),
        Signal::new("TI_101_PV", "degC"),
    ];
    let measured = log.add_topic("/plant/measured", "Measured", &fields, 0.08, "GT1")?;
    let residual = log.add_topic("/fdi/main/residual", "Residual", &fields[..1], 0.08, "GT1")?;
    let schema = serde_json::json!({"type": "object", "properties": {"k": {"type": "integer"}}});
    let diagnosis = log.add_json_topic("/fdi/diagnosis", "Diagnosis", &schema, "GT1")?;
    // More than one chunk of 1 MiB.
    for k in 0..20_000_usize {
        let time_ns = sample_time_ns(k, 0.08);
        let x = k as f64;
        let last = if k % 1000 == 7 { None } else { Some(x / 3.0) };
        let second = if k % 1000 == 8 { f64::NAN } else { -x * 5e-324 };
        log.write_partial(measured, time_ns, &[Some(0.1 * x), Some(second), last])?;
        log.write(residual, time_ns, &[x.sin()])?;
        if k % 5000 == 0 {
            log.write_json(diagnosis, time_ns, &serde_json::json!({"k": k}))?;
        }
    }
    log.finish()
}
