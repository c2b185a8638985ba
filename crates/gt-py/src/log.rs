//! MCAP logs: what is in one, whether it is whole, what can be saved, and tables of it.

use std::path::PathBuf;

use gt_log::{
    ExportOptions, ExportTime, export, info, read_attachment, read_json_messages, recover, verify,
};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::array::{json_form, json_out};
use crate::choice::named;
use crate::dataset::Names;
use crate::error::Failure;
use crate::interrupt::interruptible;

/// What an MCAP log holds.
///
/// Parameters
/// ----------
/// path : path_like
///     The log.
///
/// Returns
/// -------
/// dict
///     What ``gtfdi log info --json`` prints: times, topics with their fields and units, metadata,
///     attachments.
///
/// Raises
/// ------
/// LogError
///     The file cannot be read.
///
/// Examples
/// --------
/// >>> from gtfdi import log
/// >>> gtfdi.simulate(8.0).write("run.mcap")
/// >>> topics = {topic["topic"]: topic["messages"] for topic in log.info("run.mcap")["topics"]}
/// >>> topics["/plant/measured"]
/// 100
#[pyfunction]
pub fn log_info(py: Python<'_>, path: PathBuf) -> Result<Bound<'_, PyAny>, Failure> {
    let report = interruptible(py, move |_| json_form("log", &info(&path)?))?;
    json_out(py, "log", &report)
}

/// Whether an MCAP log is whole: every byte is looked at.
///
/// Parameters
/// ----------
/// path : path_like
///     The log.
///
/// Returns
/// -------
/// dict
///     What ``gtfdi log verify --json`` prints; ``problems`` is empty where nothing is wrong.
///
/// Raises
/// ------
/// LogError
///     The file cannot be read at all.
///
/// Examples
/// --------
/// >>> from gtfdi import log
/// >>> gtfdi.simulate(8.0).write("run.mcap")
/// >>> log.verify("run.mcap")["problems"]
/// []
#[pyfunction]
pub fn log_verify(py: Python<'_>, path: PathBuf) -> Result<Bound<'_, PyAny>, Failure> {
    let report = interruptible(py, move |_| json_form("log", &verify(&path)?))?;
    json_out(py, "log", &report)
}

/// Writes all that can be read of a damaged or unfinished MCAP log into a new one.
///
/// Parameters
/// ----------
/// path, out : path_like
///     The log, and the new one, which appears when it is whole.
///
/// Returns
/// -------
/// dict
///     What ``gtfdi log recover --json`` prints: what is in the new log and what was lost.
///
/// Raises
/// ------
/// LogError
///     Nothing can be read, or the new log cannot be written.
///
/// Examples
/// --------
/// >>> from gtfdi import log
/// >>> gtfdi.simulate(8.0).write("run.mcap")
/// >>> whole = open("run.mcap", "rb").read()
/// >>> _ = open("cut.mcap.part", "wb").write(whole[:-2000])
/// >>> _ = log.recover("cut.mcap.part", "cut.mcap")
/// >>> log.verify("cut.mcap")["problems"]
/// []
#[pyfunction]
pub fn log_recover(
    py: Python<'_>,
    path: PathBuf,
    out: PathBuf,
) -> Result<Bound<'_, PyAny>, Failure> {
    let report = interruptible(py, move |_| json_form("log", &recover(&path, &out)?))?;
    json_out(py, "log", &report)
}

/// Writes a topic of an MCAP log as a table.
///
/// Parameters
/// ----------
/// path : path_like
///     The log.
/// out : path_like
///     A file ``.csv`` or ``.parquet``.
/// topic : str, optional
///     The topic; ``/plant/measured`` or the only one where left out.
/// tags : str or list of str, optional
///     Tags or patterns such as ``t*``; all where left out.
/// rows : tuple of int, optional
///     First row and the one after the last.
/// time : {"iso", "seconds"}, default "iso"
///     How a CSV file has the time: ISO 8601, or seconds since the first message.
///
/// Returns
/// -------
/// dict
///     ``topic``, ``time`` (the name of that column), ``columns`` and ``rows``.
///
/// Raises
/// ------
/// LogError
///     There is no such topic, tag or row, or the file cannot be read or written.
///
/// Examples
/// --------
/// >>> from gtfdi import log
/// >>> gtfdi.simulate(8.0).write("run.mcap")
/// >>> log.export("run.mcap", "run.csv", tags=["t3", "p7"], rows=(0, 50))["rows"]
/// 50
#[pyfunction]
#[pyo3(signature = (path, out, topic=None, tags=None, rows=None, time="iso"))]
pub fn log_export<'py>(
    py: Python<'py>,
    path: PathBuf,
    out: PathBuf,
    topic: Option<String>,
    tags: Option<Names>,
    rows: Option<(usize, usize)>,
    time: &str,
) -> Result<Bound<'py, PyAny>, Failure> {
    let times = [("iso", ExportTime::Iso), ("seconds", ExportTime::Seconds)];
    let options = ExportOptions {
        topic,
        tags: tags.map_or_else(Vec::new, Into::into),
        rows: rows.map(|(first, end)| first..end),
        time: named("time", time, &times)?,
    };
    let report = interruptible(py, move |_| {
        json_form("log", &export(&path, &out, &options)?)
    })?;
    json_out(py, "log", &report)
}

/// The bytes of an attachment of an MCAP log, such as ``config.toml``; of several with one name the
/// first. ``info`` lists the names.
///
/// Parameters
/// ----------
/// path : path_like
///     The log.
/// name : str
///     The attachment.
///
/// Returns
/// -------
/// bytes
///
/// Raises
/// ------
/// LogError
///     There is no such attachment, or the file cannot be read.
///
/// Examples
/// --------
/// >>> from gtfdi import log
/// >>> run = gtfdi.simulate(8.0)
/// >>> run.write("run.mcap")
/// >>> log.attachment("run.mcap", "config.toml").decode() == run.config
/// True
#[pyfunction]
pub fn log_attachment(
    py: Python<'_>,
    path: PathBuf,
    name: String,
) -> Result<Bound<'_, PyBytes>, Failure> {
    let bytes = interruptible(py, move |_| Ok(read_attachment(&path, &name)?))?;
    Ok(PyBytes::new(py, &bytes))
}

/// The messages of a topic of JSON in an MCAP log, such as ``/alarms``, in the order of the file.
///
/// Parameters
/// ----------
/// path : path_like
///     The log.
/// topic : str
///     The topic.
///
/// Returns
/// -------
/// list of dict
///     Of each message the ``time_ns`` since 1970 at which it was published, and its ``value``.
///
/// Raises
/// ------
/// LogError
///     There is no such topic, it is not of JSON, or the file cannot be read.
///
/// Examples
/// --------
/// >>> from gtfdi import log
/// >>> drift = {"case": "thermocouple_drift", "onset_s": 10.0, "rate_percent_per_h": 50.0}
/// >>> drifting = gtfdi.simulate(60.0, seed=4, faults=[drift]).measured
/// >>> reads = gtfdi.arx(drifting[:120], order=1, inputs=["a_v", "M_f"], outputs="t3")
/// >>> watch = gtfdi.design(reads, [drifting[:120]], poles=0.9, margin=1.2)
/// >>> watch.write_verdicts("verdicts.mcap", drifting)
/// >>> log.messages("verdicts.mcap", "/alarms")[0]["value"]["state"]
/// 'active'
#[pyfunction]
pub fn log_messages(
    py: Python<'_>,
    path: PathBuf,
    topic: String,
) -> Result<Vec<Bound<'_, PyDict>>, Failure> {
    let messages = interruptible(py, move |_| Ok(read_json_messages(&path, &topic)?))?;
    let of_message = |message: &gt_log::JsonMessage| {
        let entry = PyDict::new(py);
        entry.set_item("time_ns", message.time_ns)?;
        entry.set_item("value", json_out(py, "message", &message.value)?)?;
        Ok(entry)
    };
    messages.iter().map(of_message).collect()
}
