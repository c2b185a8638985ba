//! `read`: files into records.

use std::path::PathBuf;
use std::sync::Arc;

use gt_log::{
    Decimal, Layout, LogError, Reading, Resample, ResampleMethod, Selection, TagMap, read_dataset,
};
use gtfdi::ident::Missing;
use pyo3::prelude::*;

use crate::choice::named;
use crate::dataset::{Names, PyDataset};
use crate::error::Failure;
use crate::warning::warn;

/// The keywords whose names are not those of the command line with underscores.
const RENAMED: [(&str, &str); 3] = [
    ("--resample", "resample_s"),
    ("--hold-at-most", "hold_at_most_s"),
    ("--sample-time", "sample_time_s"),
];

/// Reads a ``.csv``, ``.parquet`` or ``.mcap`` file.
///
/// What a reader should know, such as samples that are not valid and what resampling did, is issued
/// as a ``UserWarning``.
///
/// Parameters
/// ----------
/// path : path_like
///     The file.
/// inputs, outputs : list of str
///     Tags, or patterns such as ``xmv*``.
/// time : str, optional
///     The time column of a table; a column named ``time``, ``timestamp`` or ``t`` is one.
/// sample_time_s : float, optional
///     Sample time in seconds, in place of the times in the file.
/// topic : str, optional
///     The topic of an MCAP log, ``/plant/measured`` where left out.
/// rows : tuple of int, optional
///     First row and one past the last, 0-based.
/// missing : {"refuse", "break"}
///     With ``"break"`` cells without a number, words for that and gaps in time are samples that are
///     NaN; ``arx(..., missing="break")`` fits around them.
/// encoding : str, optional
///     The encoding of a CSV file, such as ``windows-1252``; UTF-8 where left out.
/// decimal : {"point", "comma"}, optional
///     The decimal sign of a CSV file; recognised where left out.
/// header_line : int, optional
///     The line of a CSV file's header, from 1.
/// bad_values : list of str, optional
///     Words for a missing value, beside those that are known.
/// time_zone : str, optional
///     The zone of times without an offset, such as ``Europe/Rome``; UTC where left out.
/// time_format : str, optional
///     How times are written, such as ``%d/%m/%Y %H:%M:%S``, or ``excel``.
/// layout : {"wide", "long"}, optional
///     A row for each time, or for each reading; recognised where left out.
/// resample_s : float, optional
///     Make samples of this period in seconds from readings at any times; rows are then samples.
/// resample_method : {"mean", "hold", "linear"}, optional
///     What stands for a sample; the mean where left out.
/// hold_at_most_s : float, optional
///     The oldest reading that is held, and the longest step that is bridged.
/// tags : path_like, optional
///     A TOML file of names, units and ranges of the tags, as the command line reads it.
///
/// Returns
/// -------
/// Dataset
///
/// Raises
/// ------
/// LogError
///     Names the file, the line or time, the column or the keyword, what was expected and what was
///     found.
/// OptionError
///     A keyword that is none of its values, or that needs another.
///
/// Examples
/// --------
/// >>> gtfdi.simulate(60.0, seed=3).write("run.mcap")
/// >>> gtfdi.read("run.mcap", inputs=["a_v", "M_f"], outputs="q_c", rows=(0, 500))
/// Dataset(500 samples of 0.08 s, inputs: a_v, M_f, outputs: q_c)
#[pyfunction]
#[pyo3(signature = (path, *, inputs, outputs, time=None, sample_time_s=None, topic=None,
    rows=None, missing="refuse", encoding=None, decimal=None, header_line=None, bad_values=None,
    time_zone=None, time_format=None, layout=None, resample_s=None, resample_method=None,
    hold_at_most_s=None, tags=None))]
#[allow(clippy::too_many_arguments)] // Python names them
pub fn read(
    py: Python<'_>,
    path: PathBuf,
    inputs: Names,
    outputs: Names,
    time: Option<String>,
    sample_time_s: Option<f64>,
    topic: Option<String>,
    rows: Option<(usize, usize)>,
    missing: &str,
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
) -> Result<PyDataset, Failure> {
    let ways = [("refuse", Missing::Refuse), ("break", Missing::Break)];
    let selection = Selection {
        inputs: inputs.into(),
        outputs: outputs.into(),
        time,
        sample_time_s,
        topic,
        rows: rows.map(|(start, end)| start..end),
        missing: named("missing", missing, &ways)?,
        reading: Reading {
            encoding,
            header_line,
            bad_values: bad_values.map(Vec::from).unwrap_or_default(),
            time_zone,
            time_format,
            tags: tags.map(|path| TagMap::read(&path)).transpose()?,
            resample: resample(resample_s, resample_method, hold_at_most_s)?,
            ..words(decimal, layout)?
        },
    };
    let imported = py.detach(|| {
        let imported = read_dataset(&path, &selection)?;
        imported.filled(&path)
    });
    let imported = imported.map_err(refused)?;
    for remark in imported.remarks() {
        warn(py, &format!("{}: {}", path.display(), in_python(&remark)))?;
    }
    Ok(PyDataset::new(Arc::new(imported.dataset)))
}

/// What of a reading is given by a word.
pub fn words(decimal: Option<&str>, layout: Option<&str>) -> Result<Reading, Failure> {
    let decimals = [("point", Decimal::Point), ("comma", Decimal::Comma)];
    let layouts = [("wide", Layout::Wide), ("long", Layout::Long)];
    let decimal = decimal.map(|given| named("decimal", given, &decimals));
    let layout = layout.map(|given| named("layout", given, &layouts));
    Ok(Reading {
        decimal: decimal.transpose()?,
        layout: layout.transpose()?,
        ..Reading::default()
    })
}

/// How readings become samples; what only goes with a period is refused without one.
pub fn resample(
    step_s: Option<f64>,
    method: Option<&str>,
    hold_at_most_s: Option<f64>,
) -> Result<Option<Resample>, Failure> {
    let methods = [
        ("mean", ResampleMethod::Mean),
        ("hold", ResampleMethod::Hold),
        ("linear", ResampleMethod::Linear),
    ];
    let method = method.map(|given| named("resample_method", given, &methods));
    let method = method.transpose()?;
    let Some(step_s) = step_s else {
        let more = [
            ("resample_method", method.is_some()),
            ("hold_at_most_s", hold_at_most_s.is_some()),
        ];
        return match more.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => Err(Failure::Refusal {
                option,
                reason: "expected with resample_s, found without".to_owned(),
            }),
            None => Ok(None),
        };
    };
    Ok(Some(Resample {
        step_s,
        method: method.unwrap_or_default(),
        hold_at_most_s,
    }))
}

/// A refusal that names keywords instead of the command line's options.
#[allow(clippy::needless_pass_by_value)] // for map_err
pub fn refused(error: LogError) -> Failure {
    let text = error.to_string();
    let own = in_python(&text);
    if own == text {
        return Failure::Log(error);
    }
    Failure::Reading { text: own }
}

/// A text with Python's keywords in the place of the command line's options.
pub fn in_python(text: &str) -> String {
    let mut parts = text.split("--");
    let mut found = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part.find(|letter: char| !letter.is_ascii_lowercase() && letter != '-');
        let (name, rest) = part.split_at(end.unwrap_or(part.len()));
        let option = format!("--{name}");
        let renamed = RENAMED.iter().find(|(known, _)| *known == option);
        match renamed {
            Some((_, own)) => found.push_str(own),
            None if name.is_empty() => found.push_str("--"),
            None => found.push_str(&name.replace('-', "_")),
        }
        found.push_str(rest);
    }
    found
}
