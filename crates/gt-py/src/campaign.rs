//! Campaigns: many runs with drawn faults, and what they say.

use std::path::PathBuf;

use gt_campaign::Progress;
use gt_campaign::campaign::{Comparison, Summary, prepare, prepare_single};
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

/// Runs a campaign on all cores, or what is left of it, and says what its runs say.
///
/// The folder then has ``rows.parquet``, ``summary.json`` and ``report.html``. Ctrl-C leaves whole
/// files: the same call goes on from there, and the rows are the same bits whatever the number of
/// threads (``RAYON_NUM_THREADS``).
///
/// Parameters
/// ----------
/// spec : path_like
///     The campaign's TOML file.
/// out : path_like
///     Its folder: new, or one that this campaign began.
///
/// Returns
/// -------
/// dict
///     What ``gtfdi campaign --json`` prints.
///
/// Raises
/// ------
/// DesignError
///     The file says something that makes no sense, or the folder is another campaign's.
///
/// Examples
/// --------
/// >>> from gtfdi import campaign
/// >>> text = '''
/// ... seed = 1
/// ... runs = 4
/// ... [record]
/// ... duration_s = 40.0
/// ... onset_s = [10.0, 20.0]
/// ... [[faults]]
/// ... case = "thermocouple_drift"
/// ... size = { log_uniform = [0.5, 1.0] }
/// ... shape = { ramp = { rise_s = 5.0 } }
/// ... [bank]
/// ... arl0_h = 0.02
/// ... calibration_h = 0.2
/// ... tests = [{ statistic = "cusum" }]
/// ... '''
/// >>> _ = open("drift.toml", "w").write(text)
/// >>> summary = campaign.run("drift.toml", "drift")
/// >>> summary["runs"], summary["failed"]
/// (4, 0)
#[pyfunction]
pub fn campaign_run(
    py: Python<'_>,
    spec: PathBuf,
    out: PathBuf,
) -> Result<Bound<'_, PyAny>, Failure> {
    let summary = interruptible(py, move |abandoned| {
        let progress = Watch(abandoned);
        let (campaign, folder) = prepare(&spec, &out, &progress)?;
        let rows = campaign.fill(&folder, &progress)?;
        let summary = Summary::new(campaign.spec(), &rows);
        summary.write(&folder)?;
        json_form("summary", &summary)
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
