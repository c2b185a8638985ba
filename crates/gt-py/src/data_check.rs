//! `check`: what is in a file, and all that is wrong with it.

use std::path::PathBuf;

use gt_log::{Reading, Selection, TagMap, check as examine};
use pyo3::prelude::*;
use serde_json::Value;

use crate::array::{json_form, json_out};
use crate::dataset::Names;
use crate::error::Failure;
use crate::interrupt::interruptible;
use crate::reading::{in_python, refused, resample, words};

/// What is in a ``.csv``, ``.parquet`` or ``.mcap`` file, and all that ``read`` would refuse.
///
/// Nothing is changed, and nothing that is wrong ends the look at the rest. Which tags look like
/// inputs and which like outputs, by their names and by whose past explains whose, is a suggestion,
/// with how sure it is: in a closed loop a record does not tell.
///
/// Parameters
/// ----------
/// path : path_like
///     The file.
/// inputs, outputs : list of str, optional
///     Tags to look at, or patterns such as ``xmv*``; all where both are left out.
/// time, sample_time_s, topic
///     As of ``read``.
/// encoding, decimal, header_line, bad_values, time_zone, time_format, layout
///     As of ``read``.
/// resample_s, resample_method, hold_at_most_s
///     As of ``read``; times, tags and suggestions are then those of the samples.
/// tags : path_like, optional
///     As of ``read``.
///
/// Returns
/// -------
/// dict
///     What ``gtfdi data check --json`` prints: ``rows``, ``time``, ``tags`` with their units,
///     values, ranges and excitation, ``suggested_inputs`` and ``suggested_outputs``, and
///     ``damages``: each has its ``kind``, ``line`` or ``row``, ``tag``, ``text``, and in
///     ``mended_by`` the keyword of ``read`` that mends it.
///
/// Raises
/// ------
/// LogError
///     The file is not there, or is no table and no log.
/// OptionError
///     A keyword that is none of its values, or that needs another.
///
/// Examples
/// --------
/// >>> text = "time,u,y\n" + "".join(f"{t},{t % 3},{t * t % 7}\n" for t in range(40))
/// >>> _ = open("export.csv", "w").write(text.replace("\n5,2,4\n", "\n5,2,Bad\n"))
/// >>> report = gtfdi.check("export.csv")
/// >>> report["rows"], report["time"]["period_s"], [tag["name"] for tag in report["tags"]]
/// (40, 1.0, ['u', 'y'])
/// >>> [(each["kind"], each["line"], each["mended_by"]) for each in report["damages"]]
/// [('missing', 7, 'missing')]
#[pyfunction]
#[pyo3(signature = (path, *, inputs=None, outputs=None, time=None, sample_time_s=None, topic=None,
    encoding=None, decimal=None, header_line=None, bad_values=None, time_zone=None,
    time_format=None, layout=None, resample_s=None, resample_method=None, hold_at_most_s=None,
    tags=None))]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn check<'py>(
    py: Python<'py>,
    path: PathBuf,
    inputs: Option<Names>,
    outputs: Option<Names>,
    time: Option<String>,
    sample_time_s: Option<f64>,
    topic: Option<String>,
    encoding: Option<String>,
    decimal: Option<&str>,
    header_line: Option<u64>,
    bad_values: Option<Names>,
    time_zone: Option<String>,
    time_format: Option<String>,
    layout: Option<&str>,
    resample_s: Option<f64>,
    resample_method: Option<&str>,
    hold_at_most_s: Option<f64>,
    tags: Option<PathBuf>,
) -> Result<Bound<'py, PyAny>, Failure> {
    let list = |names: Option<Names>| names.map(Vec::from).unwrap_or_default();
    let selection = Selection {
        inputs: list(inputs),
        outputs: list(outputs),
        time,
        sample_time_s,
        topic,
        reading: Reading {
            encoding,
            header_line,
            bad_values: list(bad_values),
            time_zone,
            time_format,
            tags: tags.map(|path| TagMap::read(&path)).transpose()?,
            resample: resample(resample_s, resample_method, hold_at_most_s)?,
            ..words(decimal, layout)?
        },
        ..Selection::default()
    };
    let mut report = interruptible(py, move |_| {
        json_form("check", &examine(&path, &selection).map_err(refused)?)
    })?;
    name_keywords(&mut report);
    json_out(py, "check", &report)
}

/// Names Python's keywords where damages name options of the command line.
fn name_keywords(report: &mut Value) {
    let damages = report.get_mut("damages").and_then(Value::as_array_mut);
    for damage in damages.into_iter().flatten() {
        for key in ["text", "mended_by"] {
            if let Some(Value::String(text)) = damage.get_mut(key) {
                *text = in_python(text);
            }
        }
    }
}
