//! `reproduce`: the source paper's tables and figures again.

use std::path::PathBuf;

use gt_campaign::{Depth, reproduce as compute};
use pyo3::prelude::*;

use crate::array::{json_form, json_out};
use crate::campaign::Watch;
use crate::error::Failure;
use crate::interrupt::interruptible;

/// Computes the source paper's tables and figures again from one seed, on all cores, and writes a
/// report of them.
///
/// The folder then has ``index.html``, which explains itself, ``tables.json``, the figures as SVG
/// and CSV, the logs and the models behind them. It takes about a minute and a half on two cores, a
/// quarter of an hour where it is full. Ctrl-C ends it, and nothing is written where it comes
/// before the end.
///
/// Parameters
/// ----------
/// folder : path_like
///     The folder, which is made where it is missing; what is in it is replaced file by file.
/// seed : int, default 1
///     Everything follows from it; the number of threads does not matter to any number.
/// full : bool, default False
///     More runs and so narrower intervals, all levels of noise, both sets of maps, a varying
///     ambient, and mean delays beside the bound that no detector beats.
///
/// Returns
/// -------
/// dict
///     What ``gtfdi reproduce --json`` prints: ``table3`` and so on, the paper's number beside ours
///     with the definition used, ``detection``, ``isolation`` and ``fault_effects``.
///
/// Raises
/// ------
/// LogError
///     The folder cannot be made or written to.
/// OptionError
///     A file stands in the place of the folder.
///
/// Examples
/// --------
/// >>> tables = gtfdi.reproduce("out")  # doctest: +SKIP
/// >>> tables["table10"][0]["case"]  # doctest: +SKIP
/// 1
#[pyfunction]
#[pyo3(signature = (folder, *, seed=1, full=false))]
pub fn reproduce(
    py: Python<'_>,
    folder: PathBuf,
    seed: u64,
    full: bool,
) -> Result<Bound<'_, PyAny>, Failure> {
    let standing = folder.ancestors().find(|own| own.exists());
    if let Some(standing) = standing.filter(|own| !own.is_dir()) {
        return Err(Failure::Option {
            option: "folder",
            expected: "a folder".to_owned(),
            found: format!("the file {}", standing.display()),
        });
    }
    let depth = if full { Depth::Full } else { Depth::Short };
    let tables = interruptible(py, move |abandoned| {
        let progress = Watch(abandoned);
        let reproduction = compute(seed, depth, &progress)?;
        reproduction.write(&folder, &progress)?;
        json_form("tables", &reproduction.tables)
    })?;
    json_out(py, "tables", &tables)
}
