//! `gtfdi campaign`: many runs with drawn faults, and what they say.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use gt_campaign::campaign::{Comparison, NamingCounts, Summary, prepare, prepare_single};
use gt_campaign::{CampaignError, Progress};

use crate::Outcome;
use crate::cli::{CampaignArgs, GlobalArgs};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{complain, number, print, print_json, table};
use crate::progress::Shown;

/// Whether Ctrl-C was pressed.
static STOPPED: AtomicBool = AtomicBool::new(false);

/// Shows progress, and says when Ctrl-C was pressed.
struct Interruptible(Shown);

impl Progress for Interruptible {
    fn report(&self, what: &str, done: usize, total: usize) {
        self.0.report(what, done, total);
    }

    fn is_stopped(&self) -> bool {
        STOPPED.load(Ordering::Relaxed)
    }
}

/// The first Ctrl-C ends the work at the next chunk, the second one at once; every file is whole in
/// both cases.
fn listen() {
    let listening = ctrlc::set_handler(|| {
        if STOPPED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(Failure::STOPPED));
        }
    });
    if let Err(error) = listening {
        // Ctrl-C then ends the process as it always does, and the folder is resumable all the same.
        complain(&format!("warning: Ctrl-C: {error}"));
    }
}

/// Runs the verb.
pub fn run(args: &CampaignArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("campaign", args, global)? else {
        return Ok(Outcome::Done);
    };
    if let Some(folders) = &args.compare {
        return compare(folders, args.out.as_deref(), global);
    }
    let spec = args
        .spec
        .as_ref()
        .ok_or_else(|| Failure::missing("SPEC.toml", "gtfdi campaign drift.toml --out drift"))?;
    listen();
    let progress = Interruptible(Shown::new(global.progress));
    if let Some(index) = args.only {
        let campaign = prepare_single(spec, args.out.as_deref(), &progress).map_err(failure)?;
        let row = campaign.row(index).map_err(|error| match error {
            CampaignError::Value(problem) => {
                Failure::input(format!("--only {index}: {}", problem.reason))
            }
            error => failure(error),
        })?;
        print_json(&row)?;
        return Ok(Outcome::Done);
    }
    let out = args
        .out
        .as_ref()
        .ok_or_else(|| Failure::missing("--out", "--out drift"))?;
    let (campaign, folder) =
        prepare(spec, out, &progress).map_err(|error| stoppable(error, spec, out))?;
    let rows = campaign
        .fill(&folder, &progress)
        .map_err(|error| stoppable(error, spec, out))?;
    let summary = Summary::new(campaign.spec(), &rows);
    summary.write(&folder).map_err(failure)?;
    if global.json {
        print_json(&summary)?;
    } else {
        print(&text(&summary))?;
        print(&format!("report: {}\n", out.join("report.html").display()))?;
    }
    Ok(Outcome::Done)
}

/// Puts finished campaigns side by side.
fn compare(
    folders: &[PathBuf],
    out: Option<&Path>,
    global: &GlobalArgs,
) -> Result<Outcome, Failure> {
    let out = out.ok_or_else(|| Failure::missing("--out", "--out compared"))?;
    if folders.len() < 2 {
        let found = folders.len();
        return Err(Failure::input(format!(
            "--compare: expected two folders or more, separated by commas, found {found}"
        )));
    }
    if let Some(same) = folders.iter().find(|folder| folder.as_path() == out) {
        return Err(Failure::input(format!(
            "--out: expected another folder than those that are compared, found {}",
            same.display()
        )));
    }
    let comparison = Comparison::read(folders).map_err(failure)?;
    comparison.write(out).map_err(failure)?;
    if global.json {
        print_json(&comparison)?;
        return Ok(Outcome::Done);
    }
    let names = comparison.campaigns.iter().map(|own| own.name.as_str());
    let head: Vec<&str> = std::iter::once("found from size").chain(names).collect();
    print(&table(&head, &comparison.limit_rows()))?;
    let page = out.join("comparison.html");
    print(&format!("report: {}\n", page.display()))?;
    Ok(Outcome::Done)
}

/// A failure with the exit code of its kind.
fn failure(error: CampaignError) -> Failure {
    match error {
        CampaignError::Spec { .. }
        | CampaignError::SpecFile { .. }
        | CampaignError::SpecText { .. }
        | CampaignError::Value(_)
        | CampaignError::Changed { .. }
        | CampaignError::Foreign { .. } => Failure::input(error),
        CampaignError::Stopped { .. } => Failure::stopped(error),
        error => Failure::failed(error),
    }
}

/// The same, with how to go on after Ctrl-C.
fn stoppable(error: CampaignError, spec: &Path, out: &Path) -> Failure {
    match error {
        CampaignError::Stopped { total: 0, .. } => {
            Failure::stopped("stopped before the first run; the same command begins again")
        }
        CampaignError::Stopped { .. } => Failure::stopped(format!(
            "{error}; `gtfdi campaign {} --out {}` goes on from there",
            spec.display(),
            out.display()
        )),
        error => failure(error),
    }
}

fn text(summary: &Summary) -> String {
    let rows: Vec<Vec<String>> = summary
        .faults
        .iter()
        .map(|fault| {
            let quantile = |share: f64| {
                let all = fault.delay_s.iter();
                let mut own = all.filter(|found| found.share.total_cmp(&share).is_eq());
                own.next()
                    .map_or_else(|| "-".to_owned(), ToString::to_string)
            };
            let limit = fault.size_limits.last().and_then(|own| own.limit.size);
            vec![
                format!("{} {}, {}", fault.case, fault.fault, fault.waveform),
                fault.detected.of.to_string(),
                fault.detected.to_string(),
                quantile(0.5),
                quantile(0.9),
                limit.map_or_else(
                    || "-".to_owned(),
                    |size| format!("{} {}", number(Some(size)), fault.unit),
                ),
            ]
        })
        .collect();
    let head = [
        "fault",
        "runs",
        "detected %",
        "median delay s",
        "90 % within s",
        "found from size",
    ];
    let mut text = format!(
        "{} runs: {} whole, {} failed, {} without a fault\n",
        summary.runs, summary.ok, summary.failed, summary.healthy
    );
    for failure in &summary.failures {
        let fault = failure.fault.as_deref().unwrap_or("healthy");
        let _ = writeln!(
            text,
            "failed: {} of {fault}: {}",
            failure.runs, failure.reason
        );
    }
    text.push_str(&table(&head, &rows));
    if let Some(naming) = &summary.naming {
        let heads = NamingCounts::HEAD.iter();
        for (head, cell) in heads.zip(naming.cells()) {
            let _ = writeln!(text, "{head}: {cell}");
        }
    }
    if let Some(rate) = &summary.false_alarms {
        let _ = writeln!(
            text,
            "false alarms: {} in {} h, {} an hour ({} .. {})",
            rate.alarms,
            number(Some(rate.hours)),
            number(Some(rate.per_hour)),
            number(Some(rate.per_hour_low)),
            number(Some(rate.per_hour_high))
        );
    }
    text
}
