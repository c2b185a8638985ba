//! `gtfdi data check`: what is in a table or a log, and all that is wrong with it.

use std::fmt::Write as _;
use std::path::Path;

use gt_log::{DataCheck, Suggestion, TagCheck, TagKind, check};
use serde::Serialize;

use super::SCHEMA_VERSION;
use crate::Outcome;
use crate::cli::{DataCheckArgs, GlobalArgs};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{number, print, print_json, table};
use crate::record::selection;

/// Damages that the text names; JSON has them all.
const SHOWN: usize = 30;

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    file: &'a Path,
    #[serde(flatten)]
    check: &'a DataCheck,
}

/// Runs the verb.
pub fn run(args: &DataCheckArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("data-check", args, global)? else {
        return Ok(Outcome::Done);
    };
    let path = args
        .data
        .as_ref()
        .ok_or_else(|| Failure::missing("DATA", "gtfdi data check export.csv"))?;
    let inputs = args.inputs.clone().unwrap_or_default();
    let outputs = args.outputs.clone().unwrap_or_default();
    let wanted = selection(inputs, outputs, &args.reading, None)?;
    let check = check(path, &wanted).map_err(Failure::input)?;
    if global.json {
        print_json(&Report {
            schema_version: SCHEMA_VERSION,
            file: path,
            check: &check,
        })?;
    } else {
        print(&text(path, &check))?;
    }
    Ok(Outcome::Done)
}

/// The report as text. Writing to a string cannot fail.
fn text(path: &Path, check: &DataCheck) -> String {
    let mut text = format!("{}: {} rows", path.display(), check.rows);
    if let Some(layout) = check.layout.filter(|_| check.topic.is_none()) {
        let _ = write!(text, ", {layout}");
    }
    if let Some(topic) = &check.topic {
        let _ = write!(text, " of topic {topic}");
    }
    if let Some(encoding) = check.encoding {
        let _ = write!(text, ", {encoding}");
    }
    if let Some(separator) = check.separator {
        let _ = write!(text, ", separator {separator:?}");
    }
    if let Some(decimal) = check.decimal {
        let _ = write!(text, ", decimal {decimal}");
    }
    text.push('\n');
    if let Some(done) = &check.resampled {
        let step_s = number(Some(done.resample.step_s));
        let _ = writeln!(
            text,
            "resampled to {} samples of {step_s} s: times, tags and roles are theirs",
            done.samples
        );
    }
    match &check.time {
        Some(time) => {
            let _ = writeln!(
                text,
                "time `{}`: {} s, period {} s, {} % of the steps off it, {} gaps, {} repeated, {} \
                 backward",
                time.column,
                number(Some(time.span_s)),
                number(time.period_s),
                number(Some(100.0 * time.off_period_share)),
                time.gaps,
                time.duplicates,
                time.backwards
            );
        }
        None => text.push_str("no time column; name it (--time), or give --sample-time\n"),
    }
    let rows: Vec<Vec<String>> = check.tags.iter().map(row).collect();
    text += &table(
        &[
            "tag", "unit", "values", "missing", "smallest", "largest", "excites", "remarks",
        ],
        &rows,
    );
    if check.damages.is_empty() {
        text.push_str("nothing that identify would refuse\n");
    }
    for damage in check.damages.iter().take(SHOWN) {
        let _ = match damage.mended_by {
            Some(option) => writeln!(text, "{} ({option})", damage.text),
            None => writeln!(text, "{}", damage.text),
        };
    }
    if let Some(more) = check
        .damages
        .len()
        .checked_sub(SHOWN)
        .filter(|&more| more > 0)
    {
        let _ = writeln!(text, "and {more} more; --json names them all");
    }
    text + &roles(check)
}

/// The suggested roles, and that they are no more than that.
fn roles(check: &DataCheck) -> String {
    let mut text = String::new();
    let inputs = check.suggested_inputs.iter().map(|own| (own, "input"));
    let outputs = check.suggested_outputs.iter().map(|own| (own, "output"));
    let rows: Vec<Vec<String>> = inputs.chain(outputs).map(role).collect();
    if rows.is_empty() {
        text.push_str("no tag looks like an input or an output\n");
    } else {
        text.push_str(
            "roles that tags look like: a suggestion; in a closed loop names tell more than the \
             record, and the plant's drawings more than both\n",
        );
        text += &table(&["tag", "looks like", "how sure", "why"], &rows);
        let names = |side: &[Suggestion]| {
            let names: Vec<&str> = side.iter().map(|own| own.tag.as_str()).collect();
            names.join(",")
        };
        if !check.suggested_inputs.is_empty() && !check.suggested_outputs.is_empty() {
            let (inputs, outputs) = (
                names(&check.suggested_inputs),
                names(&check.suggested_outputs),
            );
            let _ = writeln!(text, "--inputs '{inputs}' --outputs '{outputs}'");
        }
    }
    if let Some(done) = check.comparison {
        let (samples, tags, lags) = (done.samples, done.tags, done.lags);
        let _ = writeln!(
            text,
            "which tags lead: {tags} tags on {samples} samples with {lags} lags"
        );
    }
    if let Some(cause) = check.not_compared {
        let _ = writeln!(text, "which tags lead: {cause}");
    }
    text
}

fn role((own, role): (&Suggestion, &str)) -> Vec<String> {
    let reasons: Vec<String> = own.reasons.iter().map(ToString::to_string).collect();
    vec![
        own.tag.clone(),
        role.to_owned(),
        own.confidence.to_string(),
        reasons.join("; "),
    ]
}

fn row(tag: &TagCheck) -> Vec<String> {
    let order = tag.excitation_order.map(|order| order.to_string());
    vec![
        tag.name.clone(),
        tag.unit.clone(),
        tag.values.to_string(),
        tag.missing.to_string(),
        number(tag.minimum),
        number(tag.maximum),
        order.unwrap_or_else(|| "-".to_owned()),
        remarks(tag).join("; "),
    ]
}

fn remarks(tag: &TagCheck) -> Vec<String> {
    let mut remarks = Vec::new();
    match tag.kind {
        TagKind::Text => remarks.push("text".to_owned()),
        TagKind::Empty => remarks.push("empty".to_owned()),
        TagKind::Number => {}
    }
    if tag.constant {
        remarks.push("constant".to_owned());
    }
    if let Some(run) = tag.longest_run.filter(|_| tag.frozen) {
        let from = run.line.map_or_else(
            || format!("row {}", run.row.unwrap_or_default()),
            |line| format!("line {line}"),
        );
        remarks.push(format!("frozen for {} samples from {from} on", run.samples));
    }
    if !tag.outliers.is_empty() {
        remarks.push(format!("{} outliers", tag.outliers.len()));
    }
    for (share, end) in [
        (tag.at_minimum_share, "smallest"),
        (tag.at_maximum_share, "largest"),
    ] {
        if let Some(share) = share.filter(|&share| share >= SATURATED && !is_coarse(tag)) {
            let percent = number(Some(100.0 * share));
            remarks.push(format!("{percent} % at the {end}"));
        }
    }
    if let Some(step) = tag.quantisation_step {
        remarks.push(format!("steps of {}", number(Some(step))));
    }
    remarks
}

/// Share of samples at an end from which a tag looks saturated.
const SATURATED: f64 = 0.05;

/// Whether a tag has so few levels that many samples at its ends say nothing.
fn is_coarse(tag: &TagCheck) -> bool {
    let (Some(least), Some(most)) = (tag.minimum, tag.maximum) else {
        return false;
    };
    tag.quantisation_step
        .is_some_and(|step| (most - least) / step < 20.0)
}
