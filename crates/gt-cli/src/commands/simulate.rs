//! `gtfdi simulate`: the embedded turbine to an MCAP log.

use std::path::Path;
use std::time::Instant;

use gt_log::RunMetadata;
use gtfdi::plant::{Profile, SAMPLE_TIME_S, Scenario, Variant, simulate};
use serde::Serialize;

use super::SCHEMA_VERSION;
use crate::Outcome;
use crate::cli::{GlobalArgs, SimulateArgs};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{complain, print, print_json};
use crate::record::check_out;
use crate::scenario::{refused, scenario};

#[derive(Serialize)]
struct Report<'a> {
    schema_version: u32,
    variant: Variant,
    /// The name of the profile; `null` for one of its own.
    profile: Option<&'static str>,
    samples: usize,
    sample_time_s: f64,
    substep_s: f64,
    real_time_factor: f64,
    warnings: Vec<String>,
    /// Why the record is shorter than asked for, if it is.
    ended: Option<String>,
    out: &'a Path,
}

/// The name of the profile, if it is a named one.
fn profile_name(scenario: &Scenario) -> Option<&'static str> {
    let variant = scenario.variant;
    Profile::names(variant)
        .iter()
        .find(|name| Profile::named(variant, name).as_ref() == Ok(&scenario.profile))
        .copied()
}

/// Runs the verb.
pub fn run(args: &SimulateArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("simulate", args, global)? else {
        return Ok(Outcome::Done);
    };
    let out = args
        .out
        .clone()
        .ok_or_else(|| Failure::missing("--out", "--out run.mcap"))?;
    let inputs: Vec<&Path> = [
        &args.scenario,
        &args.compressor_map,
        &args.turbine_map,
        &args.faults,
    ]
    .into_iter()
    .filter_map(|path| path.as_deref())
    .collect();
    check_out(&out, &inputs)?;
    let scenario = scenario(&args)?;
    let started = Instant::now();
    let simulated = simulate(&scenario).map_err(|error| refused(&error, &args))?;
    let integration_s = started.elapsed().as_secs_f64();
    let samples = simulated.truth.len();
    if let (0, Some(reason)) = (samples, &simulated.ended) {
        // A plant that rests where it may not is no run that ended.
        return Err(refused(reason, &args));
    }
    let metadata = RunMetadata {
        seed: Some(scenario.seed),
        run_index: Some(scenario.run_index),
        config_toml: toml::to_string(&scenario).map_err(Failure::failed)?,
        ..RunMetadata::default()
    };
    gt_log::write_run(&out, &simulated, &metadata).map_err(Failure::failed)?;

    let report = Report {
        schema_version: SCHEMA_VERSION,
        variant: scenario.variant,
        profile: profile_name(&scenario),
        samples,
        sample_time_s: SAMPLE_TIME_S,
        substep_s: scenario.step_s(),
        real_time_factor: samples as f64 * SAMPLE_TIME_S / integration_s,
        warnings: simulated.warnings.iter().map(ToString::to_string).collect(),
        ended: simulated.ended.as_ref().map(ToString::to_string),
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
    match &report.ended {
        None => Ok(Outcome::Done),
        Some(reason) => Err(Failure::failed(format!(
            "the run ended after {samples} of {} samples, because the plant left the range in \
             which the model means something: {reason}; {} holds what there is",
            scenario.samples().map_err(Failure::failed)?,
            out.display()
        ))),
    }
}
