//! A simulated run as a log.

use std::collections::BTreeMap;
use std::path::Path;

use gtfdi::core::{Dataset, Signal};
use gtfdi::plant::Run;

use crate::model_log::Attached;
use crate::quality::QualityLog;
use crate::remark_log::write_remarks;
use crate::{LogError, LogWriter, RunMetadata, sample_time_ns};

/// What the logs of the embedded plant call their machine.
const ASSET: &str = "gas-turbine";

/// Writes a simulated run to `path`.
///
/// | topic | a field for |
/// |---|---|
/// | `/plant/measured` | every input and output, as the sensors say: noise and faults included |
/// | `/plant/truth` | every input and output as the plant has them, and what no sensor measures: the efficiencies `e_c` and `e_t`, and the fuel flow `M_fc` that reaches the combustor |
/// | `/plant/faults` | the magnitude of every injected fault, named as in [`Run::fault_signals`], then `NAME_active` of each: 1 where its magnitude is not 0, and 0 elsewhere (before the onset, after the end, in the pauses of an intermittent fault); no topic without a fault |
/// | `/plant/quality` | how good the sample of each of `/plant/measured` is ([`Quality`](crate::Quality)), where that changes and once a minute: BAD where the sensor gives nothing valid, else GOOD |
/// | `/log` | the warnings (`foxglove.Log`); no topic without one |
/// | `/ident/model` | the models of `metadata.models`; no topic without one |
///
/// The prototype has 6 inputs and 28 outputs, so that `/plant/measured` has 34 fields and
/// `/plant/truth` 37; cogeneration has 7 and 31, so 38 and 41. Names and units are those of
/// `Variant::input_channels` and `Variant::output_channels` of `gtfdi::plant`.
///
/// The attachment `config.toml` is `metadata.config_toml`, from which the run can be made again.
/// The metadata record `gtfdi.remarks`, where there is something to remark, has the run's warnings
/// (`warning_1`, `warning_2`, ...) and why the record is shorter than asked for (`ended`).
///
/// Log time is the fixed epoch plus the sample's own time, so one scenario gives the same bytes
/// wherever and whenever it is written.
///
/// # Errors
/// [`LogError`] when the file cannot be written; nothing is left under `path` then.
pub fn write_run(path: &Path, run: &Run, metadata: &RunMetadata) -> Result<(), LogError> {
    let mut log = LogWriter::create(path, metadata)?;
    let remarks = remarks(run);
    if !remarks.is_empty() {
        log.note("gtfdi.remarks", remarks.clone())?;
    }
    log.attach(
        "config.toml",
        "application/toml",
        metadata.config_toml.as_bytes(),
    )?;
    let attached = Attached::new(&mut log, &metadata.models)?;
    let period_s = run.truth.sample_time_s();
    let signals = channels(&run.truth);
    let all = [signals.clone(), run.hidden_signals.clone()].concat();
    let truth = log.add_topic("/plant/truth", "Truth", &all, period_s, ASSET)?;
    let measured = log.add_topic("/plant/measured", "Measured", &signals, period_s, ASSET)?;
    let mut quality = QualityLog::new(&mut log, &run.measured, ASSET, &metadata.qualities)?;
    let faults = if run.fault_signals.is_empty() {
        None
    } else {
        let active = |signal: &Signal| Signal::new(format!("{}_active", signal.name), "");
        let mut fields = run.fault_signals.clone();
        fields.extend(run.fault_signals.iter().map(active));
        Some(log.add_topic("/plant/faults", "Faults", &fields, period_s, ASSET)?)
    };
    let first_ns = sample_time_ns(0, period_s);
    let texts = metadata.warnings.iter().map(String::as_str);
    let texts: Vec<&str> = texts.chain(remarks.values().map(String::as_str)).collect();
    write_remarks(&mut log, texts, first_ns, ASSET)?;
    attached.tell(&mut log, first_ns, ASSET)?;
    for k in 0..run.truth.len() {
        let time_ns = sample_time_ns(k, period_s);
        quality.write(&mut log, &run.measured, k, time_ns)?;
        let mut values = sample(&run.truth, k);
        values.extend(run.hidden.column(k).iter());
        log.write(truth, time_ns, &values)?;
        log.write(measured, time_ns, &sample(&run.measured, k))?;
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

/// What a reader of the record should know, by key.
fn remarks(run: &Run) -> BTreeMap<String, String> {
    let warnings = run.warnings.iter().enumerate();
    let ended = run.ended.as_ref();
    warnings
        .map(|(index, warning)| (format!("warning_{}", index + 1), warning.to_string()))
        .chain(ended.map(|reason| ("ended".to_owned(), reason.to_string())))
        .collect()
}

/// The signals of a record, inputs first.
fn channels(data: &Dataset) -> Vec<Signal> {
    data.inputs()
        .iter()
        .chain(data.outputs())
        .cloned()
        .collect()
}

/// Inputs and outputs of a sample.
fn sample(data: &Dataset, k: usize) -> Vec<f64> {
    let (inputs, outputs) = (data.u().column(k), data.y().column(k));
    inputs.iter().chain(outputs.iter()).copied().collect()
}
