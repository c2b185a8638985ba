//! What an isolator said of a record, as a log.

use std::path::Path;

use gtfdi::core::{Dataset, Signal};
use gtfdi::fdi::{FdiError, IsolationEvent, IsolationMonitor, Isolator, NamedDiagnosis};
use serde::Serialize;

use crate::model_log::Attached;
use crate::quality::QualityLog;
use crate::remark_log::write_remarks;
use crate::verdict_log::{AlarmEvent, SEVERITY, THRESHOLD_PERIOD_S, alarm_schema};
use crate::{EPOCH_NS, LogError, LogWriter, RunMetadata, sample_time_ns};

/// What stands in `/fdi/diagnosis`, at each diagnosis while an alarm is up.
#[derive(Serialize)]
struct DiagnosisEvent<'a> {
    model: &'a str,
    detected: bool,
    #[serde(flatten)]
    diagnosis: NamedDiagnosis,
}

/// The JSON Schema of a [`DiagnosisEvent`].
fn diagnosis_schema() -> serde_json::Value {
    let number = || serde_json::json!({"type": "number"});
    let maybe = |kind: &str| serde_json::json!({"type": [kind, "null"]});
    let pair = |kind: &str| {
        let items = serde_json::json!({"type": kind});
        serde_json::json!({"type": "array", "items": items, "minItems": 2, "maxItems": 2})
    };
    let hypothesis = serde_json::json!({
        "type": "object",
        "properties": {
            "fault": {"type": "string"},
            "unit": {"type": "string"},
            "probability": number(),
            "magnitude": number(),
            "magnitude_interval": pair("number"),
            "onset_s": number(),
            "onset_interval_s": pair("number")
        }
    });
    serde_json::json!({
        "type": "object",
        "properties": {
            "model": {"type": "string"},
            "detected": {"type": "boolean"},
            "diagnosed_s": number(),
            "finding": {"enum": ["undecided", "named", "both", "none_of_these"]},
            "fault": maybe("string"),
            "unit": maybe("string"),
            "probability": maybe("number"),
            "onset_s": maybe("number"),
            "magnitude": maybe("number"),
            "hypotheses": {"type": "array", "items": hypothesis},
            "none_of_these": number(),
            "pair": {
                "type": ["object", "null"],
                "properties": {
                    "faults": pair("string"),
                    "probability": number(),
                    "magnitudes": pair("number"),
                    "onsets_s": pair("number")
                }
            }
        }
    })
}

/// Runs an isolator over `data` and writes statistics, limits, alarms and diagnoses to `path`; the
/// isolator itself is attached, and so are the models of `metadata`. `/plant/quality`, `/log` and
/// `/ident/model` are as those of [`write_verdicts`](crate::write_verdicts).
///
/// # Errors
/// [`LogError::Unfit`] when the record does not fit, [`LogError`] when the file cannot be written;
/// nothing is left under `path` then.
pub fn write_diagnoses(
    path: &Path,
    isolator: &Isolator,
    data: &Dataset,
    metadata: &RunMetadata,
) -> Result<(), LogError> {
    let refused = |error: FdiError| LogError::Unfit {
        path: path.to_owned(),
        cause: error.to_string(),
    };
    let data = &data
        .select(&isolator.inputs(), &isolator.outputs())
        .map_err(|error| refused(error.into()))?;
    let mut log = LogWriter::create(path, metadata)?;
    let name = &isolator.name;
    let document = serde_json::to_vec_pretty(isolator).map_err(|cause| LogError::NotJson {
        path: path.to_owned(),
        cause: cause.to_string(),
    })?;
    let attachment = format!("models/{name}.json");
    log.attach(&attachment, "application/json", &document)?;
    let attached = Attached::new(&mut log, &metadata.models)?;
    let tests = isolator.statistic_names();
    let signals = Signal::named(&tests);
    let period_s = data.sample_time_s();
    let topic = |what: &str| format!("/fdi/{name}/{what}");
    let statistic = log.add_topic(&topic("statistic"), "Statistic", &signals, period_s, name)?;
    let period = THRESHOLD_PERIOD_S;
    let threshold = log.add_topic(&topic("threshold"), "Threshold", &signals, period, name)?;
    let alarms = log.add_json_topic("/alarms", "Alarm", &alarm_schema(), name)?;
    let diagnoses = log.add_json_topic("/fdi/diagnosis", "Diagnosis", &diagnosis_schema(), name)?;
    let start_ns = sample_time_ns(1, data.start_time_s()) - EPOCH_NS;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
    let repeat = ((THRESHOLD_PERIOD_S / period_s) as usize).max(1);
    let mut quality = QualityLog::new(&mut log, data, name, &metadata.qualities)?;
    let first_ns = sample_time_ns(0, period_s).saturating_add(start_ns);
    let remarks = metadata.warnings.iter().map(String::as_str);
    write_remarks(&mut log, remarks, first_ns, name)?;
    attached.tell(&mut log, first_ns, name)?;
    let mut monitor = IsolationMonitor::new(isolator).map_err(refused)?;
    let mut last_s = f64::NEG_INFINITY;
    for k in 0..data.len() {
        let time_ns = sample_time_ns(k, period_s).saturating_add(start_ns);
        quality.write(&mut log, data, k, time_ns)?;
        if k % repeat == 0 {
            log.write(threshold, time_ns, isolator.limits())?;
        }
        let (u, y) = (data.u().column(k), data.y().column(k));
        let events = monitor
            .step(data.time_s(k), u.as_slice(), y.as_slice())
            .map_err(|error| refused(error.into()))?
            .to_vec();
        let verdict = monitor.verdict();
        log.write(statistic, time_ns, &verdict.statistics)?;
        for event in &events {
            let (state, leading) = match event {
                IsolationEvent::Alarm { leading, .. } => ("active", Some(*leading)),
                IsolationEvent::End { .. } => ("inactive", None),
                IsolationEvent::Name { .. } => continue,
            };
            // At its end an alarm has no statistic above its limit: the one nearest to it.
            let nearest = || {
                let ratios = verdict.statistics.iter().zip(isolator.limits());
                let ratios = ratios.map(|(own, limit)| own / limit).enumerate();
                ratios.max_by(|left, right| left.1.total_cmp(&right.1))
            };
            let place = leading.or_else(|| Some(nearest()?.0)).unwrap_or(0);
            let event = AlarmEvent {
                source: tests.get(place).copied().unwrap_or(Isolator::ANY_DIRECTION),
                state,
                severity: SEVERITY,
                onset_s: data.time_s(k),
                residual: None,
                statistic: verdict.statistics[place],
                limit: isolator.limits()[place],
            };
            log.write_json(alarms, time_ns, &event)?;
        }
        if let (Some(finding), Some((time_s, diagnosis))) = (monitor.name(), monitor.diagnosis())
            && *time_s > last_s
        {
            last_s = *time_s;
            let event = DiagnosisEvent {
                model: name,
                detected: true,
                diagnosis: isolator.named(*time_s, finding, diagnosis),
            };
            log.write_json(diagnoses, time_ns, &event)?;
        }
    }
    log.finish()
}
