//! `gtfdi simulate`: the embedded turbine to an MCAP log.

use std::path::{Path, PathBuf};
use std::time::Instant;

use gt_log::RunMetadata;
use gtfdi::plant::{Fault, PlantError, Profile, SAMPLE_TIME_S, Scenario, simulate};
use serde::{Deserialize, Serialize};

use super::SCHEMA_VERSION;
use crate::Outcome;
use crate::cli::{GlobalArgs, SimulateArgs, Variant};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{complain, print, print_json};
use crate::record::check_out;

/// A file of faults.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FaultFile {
    #[serde(default)]
    fault: Vec<Fault>,
}

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    samples: usize,
    sample_time_s: f64,
    substep_s: f64,
    real_time_factor: f64,
    warnings: Vec<String>,
    out: &'a Path,
}

fn defaults() -> SimulateArgs {
    SimulateArgs {
        variant: Some(Variant::Prototype),
        map_set: Some("paper".into()),
        profile: Some("standard".into()),
        noise: Some("low".into()),
        seconds: Some(60.0),
        seed: Some(1),
        run_index: Some(0),
        substeps: Some(40),
        ..SimulateArgs::default()
    }
}

fn faults(path: &Path) -> Result<Vec<Fault>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::in_file(path, error))?;
    let file: FaultFile = toml::from_str(&text)
        .map_err(|error| Failure::in_file(path, error.to_string().trim_end()))?;
    if file.fault.is_empty() {
        return Err(Failure::in_file(
            path,
            "expected at least one [[fault]] table, found none",
        ));
    }
    Ok(file.fault)
}

/// A refusal that names the option as it is typed.
fn refused(error: &PlantError) -> Failure {
    let text = error.to_string();
    let option = match error {
        PlantError::Duration { .. } => "--seconds",
        PlantError::Substeps { .. } => "--substeps",
        PlantError::UnknownName {
            what: "profile", ..
        } => "--profile",
        PlantError::UnknownName {
            what: "map set", ..
        } => "--map-set",
        PlantError::UnknownName { what: "noise", .. } => "--noise",
        _ => return Failure::input(text),
    };
    let rest = text
        .split_once(": ")
        .map_or(text.as_str(), |(_, rest)| rest);
    Failure::input(format!("{option}: {rest}"))
}

/// Runs the verb.
pub fn run(args: &SimulateArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("simulate", args, &defaults(), global)? else {
        return Ok(Outcome::Done);
    };
    let out = args
        .out
        .ok_or_else(|| Failure::missing("--out", "--out run.mcap"))?;
    let inputs: Vec<&Path> = args.faults.iter().map(PathBuf::as_path).collect();
    check_out(&out, &inputs)?;
    let standard = Scenario::default();
    let scenario = Scenario {
        map_set: args
            .map_set
            .unwrap_or_default()
            .parse()
            .map_err(|error| refused(&error))?,
        duration_s: args.seconds.unwrap_or(standard.duration_s),
        substeps: args.substeps.unwrap_or(standard.substeps),
        profile: Profile::named(&args.profile.unwrap_or_default())
            .map_err(|error| refused(&error))?,
        noise: args
            .noise
            .unwrap_or_default()
            .parse()
            .map_err(|error| refused(&error))?,
        faults: args.faults.as_deref().map_or(Ok(Vec::new()), faults)?,
        seed: args.seed.unwrap_or(standard.seed),
        run_index: args.run_index.unwrap_or(standard.run_index),
    };
    scenario.validate().map_err(|error| match error {
        PlantError::Scenario { .. } | PlantError::RepeatedFault { .. } => {
            Failure::in_file(args.faults.as_deref().unwrap_or(Path::new("faults")), error)
        }
        error => refused(&error),
    })?;
    let started = Instant::now();
    let simulated = simulate(&scenario).map_err(Failure::input)?;
    let integration_s = started.elapsed().as_secs_f64();
    let metadata = RunMetadata {
        seed: Some(scenario.seed),
        run_index: Some(scenario.run_index),
        config_toml: toml::to_string(&scenario).map_err(Failure::failed)?,
        data_sha256: None,
    };
    gt_log::write_run(&out, &simulated, &metadata).map_err(Failure::failed)?;

    let samples = simulated.truth.len();
    let report = Report {
        schema_version: SCHEMA_VERSION,
        samples,
        sample_time_s: SAMPLE_TIME_S,
        substep_s: SAMPLE_TIME_S / scenario.substeps as f64,
        real_time_factor: samples as f64 * SAMPLE_TIME_S / integration_s,
        warnings: simulated.warnings.iter().map(ToString::to_string).collect(),
        out: &out,
    };
    for warning in &report.warnings {
        complain(&format!("warning: {warning}"));
    }
    if global.json {
        print_json(&report)?;
    } else {
        print(&format!(
            "{}: {samples} samples of {SAMPLE_TIME_S} s, {} outputs, {:.0} times real time\n",
            out.display(),
            simulated.truth.ny(),
            report.real_time_factor
        ))?;
    }
    Ok(Outcome::Done)
}
