//! Campaigns: many runs with drawn faults, and what they say.

use std::path::PathBuf;

use gt_campaign::Progress;
use gt_campaign::campaign::{Campaign, Comparison, Folder, Summary, prepare, prepare_single};
use pyo3::prelude::*;

use crate::array::{json_form, json_out};
use crate::error::Failure;
use crate::interrupt::{Abandoned, interruptible};

/// Ends a campaign at the next place where it can be taken up again once its caller has gone.
pub struct Watch<'a>(pub &'a Abandoned);

impl Progress for Watch<'_> {
    fn report(&self, _what: &str, _done: usize, _total: usize) {}

    fn is_stopped(&self) -> bool {
        self.0.is_set()
    }
}

/// Runs what a campaign's folder has not, on all cores, and writes what all its rows say.
pub fn summary_of(
    campaign: &Campaign,
    folder: &Folder,
    progress: &dyn Progress,
) -> Result<serde_json::Value, Failure> {
    let rows = campaign.fill(folder, progress)?;
    let summary = Summary::new(campaign.spec(), &rows);
    summary.write(folder)?;
    json_form("summary", &summary)
}

/// Runs a campaign on all cores of this process; ``gtfdi.campaign.run`` says the rest.
#[pyfunction]
pub fn campaign_run(
    py: Python<'_>,
    spec: PathBuf,
    out: PathBuf,
) -> Result<Bound<'_, PyAny>, Failure> {
    let summary = interruptible(py, move |abandoned| {
        let progress = Watch(abandoned);
        let (campaign, folder) = prepare(&spec, &out, &progress)?;
        summary_of(&campaign, &folder, &progress)
    })?;
    json_out(py, "summary", &summary)
}

/// Rows of single runs of a campaign, computed here and now; each is the same bit for bit whatever
/// runs beside it.
///
/// Parameters
/// ----------
/// spec : path_like
///     The campaign's TOML file.
/// runs : list of int
///     Indices of the runs, from 0.
/// out : path_like, optional
///     The campaign's folder, which lends its bank; without one the bank is made first.
///
/// Returns
/// -------
/// list of dict
///     The rows in the order of the indices, with the columns of ``rows.parquet``.
///
/// Raises
/// ------
/// DesignError
///     The file says something that makes no sense, or the campaign has no such run.
#[pyfunction]
#[pyo3(signature = (spec, runs, out=None))]
pub fn campaign_rows(
    py: Python<'_>,
    spec: PathBuf,
    runs: Vec<u64>,
    out: Option<PathBuf>,
) -> Result<Bound<'_, PyAny>, Failure> {
    let rows = interruptible(py, move |abandoned| {
        let campaign = prepare_single(&spec, out.as_deref(), &Watch(abandoned))?;
        let rows = runs.iter().map(|&run| campaign.row(run));
        let rows = rows.collect::<Result<Vec<_>, _>>()?;
        json_form("rows", &rows)
    })?;
    json_out(py, "rows", &rows)
}

/// Puts finished campaigns side by side: what differs between their files, and what that did to each
/// fault's detectable size.
///
/// Parameters
/// ----------
/// folders : list of path_like
///     Folders of finished campaigns, two or more.
/// out : path_like
///     Where ``comparison.html`` and its data go.
///
/// Returns
/// -------
/// dict
///     What ``gtfdi campaign --compare --json`` prints.
///
/// Raises
/// ------
/// DesignError
///     A folder has no finished campaign.
/// OptionError
///     There are fewer than two.
#[pyfunction]
pub fn campaign_compare(
    py: Python<'_>,
    folders: Vec<PathBuf>,
    out: PathBuf,
) -> Result<Bound<'_, PyAny>, Failure> {
    if folders.len() < 2 {
        return Err(Failure::Option {
            option: "folders",
            expected: "two or more".to_owned(),
            found: folders.len().to_string(),
        });
    }
    let comparison = interruptible(py, move |_| {
        let comparison = Comparison::read(&folders)?;
        comparison.write(&out)?;
        json_form("comparison", &comparison)
    })?;
    json_out(py, "comparison", &comparison)
}
