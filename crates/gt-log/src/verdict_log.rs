//! What a bank of detectors said of a record, as a log.

use std::path::Path;

use gtfdi::core::{Dataset, Signal};
use gtfdi::fdi::{Alarm, Bank, BankRun};
use serde::Serialize;

use crate::model_log::Attached;
use crate::quality::QualityLog;
use crate::remark_log::write_remarks;
use crate::{EPOCH_NS, LogError, LogWriter, RunMetadata, sample_time_ns};

/// Thresholds are repeated this often, so that a reader who starts in the middle finds them.
pub(crate) const THRESHOLD_PERIOD_S: f64 = 60.0;
/// Severity of an alarm (1 to 1000 after OPC 10000-9); thresholds alone do not grade it.
pub(crate) const SEVERITY: u16 = 500;

/// A change of an alarm's state, as it stands in `/alarms`.
#[derive(Serialize)]
pub(crate) struct AlarmEvent<'a> {
    pub(crate) source: &'a str,
    pub(crate) state: &'static str,
    pub(crate) severity: u16,
    pub(crate) onset_s: f64,
    /// None of a statistic of many residuals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) residual: Option<f64>,
    pub(crate) statistic: f64,
    pub(crate) limit: f64,
}

/// The JSON Schema of an [`AlarmEvent`].
pub(crate) fn alarm_schema() -> serde_json::Value {
    serde_json::json!({
        "type": "object",
        "properties": {
            "source": {"type": "string"},
            "state": {"enum": ["active", "inactive"]},
            "severity": {"type": "integer", "minimum": 1, "maximum": 1000},
            "onset_s": {"type": "number"},
            "residual": {"type": "number"},
            "statistic": {"type": "number"},
            "limit": {"type": "number"}
        }
    })
}

/// Writes residuals, statistics, thresholds and alarms of `run` over `data` to `path`; the bank itself is
/// attached, and so are the models of `metadata` (`/ident/model`). `/plant/quality` says of each
/// input and output how good its sample is, `/log` has the warnings of `metadata`.
///
/// # Errors
/// [`LogError`] when the file cannot be written; nothing is left under `path` then.
pub fn write_verdicts(
    path: &Path,
    bank: &Bank,
    data: &Dataset,
    run: &BankRun,
    metadata: &RunMetadata,
) -> Result<(), LogError> {
    let mut log = LogWriter::create(path, metadata)?;
    let name = &bank.name;
    let document = serde_json::to_vec_pretty(bank).map_err(|cause| LogError::NotJson {
        path: path.to_owned(),
        cause: cause.to_string(),
    })?;
    log.attach(
        &format!("models/{name}.json"),
        "application/json",
        &document,
    )?;
    let attached = Attached::new(&mut log, &metadata.models)?;
    let signals: Vec<Signal> = bank
        .generators()
        .iter()
        .flat_map(|generator| generator.outputs().iter().cloned())
        .collect();
    let tests: Vec<Signal> = Signal::named(&bank.test_names());
    let period_s = data.sample_time_s();
    let topic = |what: &str| format!("/fdi/{name}/{what}");
    let residual = log.add_topic(&topic("residual"), "Residual", &signals, period_s, name)?;
    let threshold = log.add_topic(
        &topic("threshold"),
        "Threshold",
        &tests,
        THRESHOLD_PERIOD_S,
        name,
    )?;
    let statistic = log.add_topic(&topic("statistic"), "Statistic", &tests, period_s, name)?;
    let alarms = log.add_json_topic("/alarms", "Alarm", &alarm_schema(), name)?;

    let limits: Vec<f64> = bank
        .tests()
        .iter()
        .map(|test| test.threshold.limit)
        .collect();
    let mut events: Vec<(f64, &Alarm, &'static str)> = Vec::new();
    for alarm in &run.alarms {
        events.push((alarm.time_s, alarm, "active"));
        if let Some(end_s) = alarm.end_s {
            events.push((end_s, alarm, "inactive"));
        }
    }
    let mut quality = QualityLog::new(&mut log, data, name, &metadata.qualities)?;
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut events = events.into_iter().peekable();
    let start_ns = sample_time_ns(1, data.start_time_s()) - EPOCH_NS;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
    let repeat = ((THRESHOLD_PERIOD_S / period_s) as usize).max(1);
    let first_ns = sample_time_ns(0, period_s).saturating_add(start_ns);
    let remarks = metadata.warnings.iter().map(String::as_str);
    write_remarks(&mut log, remarks, first_ns, name)?;
    attached.tell(&mut log, first_ns, name)?;
    for k in 0..data.len() {
        let time_ns = sample_time_ns(k, period_s).saturating_add(start_ns);
        quality.write(&mut log, data, k, time_ns)?;
        if k % repeat == 0 {
            log.write(threshold, time_ns, &limits)?;
        }
        let residuals: Vec<f64> = run.residuals.column(k).iter().copied().collect();
        log.write(residual, time_ns, &residuals)?;
        let statistics: Vec<f64> = run.statistics.column(k).iter().copied().collect();
        log.write(statistic, time_ns, &statistics)?;
        while let Some((_, alarm, state)) = events.next_if(|event| event.0 <= data.time_s(k)) {
            let event = AlarmEvent {
                source: &alarm.tag,
                state,
                severity: SEVERITY,
                onset_s: alarm.onset_s.unwrap_or(alarm.first_exceedance_s),
                residual: Some(alarm.residual),
                statistic: alarm.statistic,
                limit: alarm.threshold,
            };
            log.write_json(alarms, time_ns, &event)?;
        }
    }
    log.finish()
}
