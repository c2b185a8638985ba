//! A simulated run as a log.

use std::path::Path;

use gtfdi::core::{Dataset, Signal};
use gtfdi::plant::Run;

use crate::{LogError, LogWriter, RunMetadata, TopicId, sample_time_ns};

/// What the logs of the embedded plant call their machine.
const ASSET: &str = "gas-turbine";

/// Writes a simulated run to `path`: `/plant/truth` and `/plant/measured` with a field for every
/// input and output, and `/plant/faults` with the magnitude and the activity (0 or 1) of every
/// injected fault, where there is one.
///
/// Log time is the fixed epoch plus the sample's own time, so one scenario gives the same bytes
/// wherever and whenever it is written.
///
/// # Errors
/// [`LogError`] when the file cannot be written; nothing is left under `path` then.
pub fn write_run(path: &Path, run: &Run, metadata: &RunMetadata) -> Result<(), LogError> {
    let mut log = LogWriter::create(path, metadata)?;
    log.attach(
        "config.toml",
        "application/toml",
        metadata.config_toml.as_bytes(),
    )?;
    let period_s = run.truth.sample_time_s();
    let signals = channels(&run.truth);
    let truth = log.add_topic("/plant/truth", "Truth", &signals, period_s, ASSET)?;
    let measured = log.add_topic("/plant/measured", "Measured", &signals, period_s, ASSET)?;
    let faults = if run.fault_signals.is_empty() {
        None
    } else {
        let active = |signal: &Signal| Signal::new(format!("{}_active", signal.name), "");
        let mut fields = run.fault_signals.clone();
        fields.extend(run.fault_signals.iter().map(active));
        Some(log.add_topic("/plant/faults", "Faults", &fields, period_s, ASSET)?)
    };
    for k in 0..run.truth.len() {
        let time_ns = sample_time_ns(k, period_s);
        write_sample(&mut log, truth, time_ns, &run.truth, k)?;
        write_sample(&mut log, measured, time_ns, &run.measured, k)?;
        if let Some(topic) = faults {
            let magnitudes = run.fault_magnitudes.column(k);
            let active = magnitudes
                .iter()
                .map(|value| f64::from(u8::from(*value != 0.0)));
            let values: Vec<f64> = magnitudes.iter().copied().chain(active).collect();
            log.write(topic, time_ns, &values)?;
        }
    }
    log.finish()
}

/// The signals of a record, inputs first.
fn channels(data: &Dataset) -> Vec<Signal> {
    data.inputs()
        .iter()
        .chain(data.outputs())
        .cloned()
        .collect()
}

fn write_sample(
    log: &mut LogWriter,
    topic: TopicId,
    time_ns: u64,
    data: &Dataset,
    k: usize,
) -> Result<(), LogError> {
    let inputs = data.u().column(k);
    let outputs = data.y().column(k);
    let values: Vec<f64> = inputs.iter().chain(outputs.iter()).copied().collect();
    log.write(topic, time_ns, &values)
}
