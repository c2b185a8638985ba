//! From options and files to a scenario; what is refused names its option or its file.

use std::path::Path;

use gtfdi::plant::maps::{MapKind, SpeedLineTable};
use gtfdi::plant::{Fault, NoiseLevel, PlantError, Profile, Scenario, Variant};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::cli::SimulateArgs;
use crate::failure::Failure;

/// A file of faults.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FaultFile {
    /// The faults, in order.
    #[serde(default)]
    pub fault: Vec<Fault>,
}

/// The scenario that the options ask for: the defaults or a scenario file, and what is given beside
/// it; checked but for what only a start shows.
///
/// # Errors
/// [`Failure::Input`].
pub fn scenario(args: &SimulateArgs) -> Result<Scenario, Failure> {
    let refused = |error: PlantError| refused(&error, args);
    let mut scenario = match &args.scenario {
        Some(path) => read(path)?,
        None => Scenario::default(),
    };
    if let Some(name) = &args.variant {
        let variant: Variant = name.parse().map_err(refused)?;
        if variant != scenario.variant {
            scenario.variant = variant;
            scenario.profile = Profile::standard(variant);
        }
    }
    if let Some(name) = &args.map_set {
        scenario.map_set = name.parse().map_err(refused)?;
    }
    if let Some(path) = &args.compressor_map {
        let table = map(path, "compressor", MapKind::Compressor)?;
        scenario.maps.compressor = Some(table);
    }
    if let Some(path) = &args.turbine_map {
        scenario.maps.turbine = Some(map(path, "turbine", MapKind::Turbine)?);
    }
    if let Some(name) = &args.profile {
        scenario.profile = Profile::named(scenario.variant, name).map_err(refused)?;
    }
    if let Some(name) = &args.noise {
        scenario.noise = name.parse::<NoiseLevel>().map_err(refused)?.into();
    }
    scenario.duration_s = args.seconds.unwrap_or(scenario.duration_s);
    scenario.substeps = args.substeps.unwrap_or(scenario.substeps);
    scenario.seed = args.seed.unwrap_or(scenario.seed);
    scenario.run_index = args.run_index.unwrap_or(scenario.run_index);

    let Some(path) = &args.faults else {
        scenario.validate().map_err(refused)?;
        return Ok(scenario);
    };
    // Without the file's faults first, so that each mistake names the file in which it is.
    scenario.faults.clear();
    scenario.validate().map_err(refused)?;
    scenario.faults = faults(path)?;
    scenario
        .validate()
        .map_err(|error| Failure::in_file(path, error))?;
    Ok(scenario)
}

/// A refusal by the plant, with the option as it is typed or the file in which the reason lies.
pub fn refused(error: &PlantError, args: &SimulateArgs) -> Failure {
    let (option, is_given) = match error {
        PlantError::Duration { .. } => ("--seconds", args.seconds.is_some()),
        PlantError::Substeps { .. } => ("--substeps", args.substeps.is_some()),
        PlantError::UnknownName { what, .. } => match *what {
            "profile" => ("--profile", args.profile.is_some()),
            "map set" => ("--map-set", args.map_set.is_some()),
            "noise" => ("--noise", args.noise.is_some()),
            "variant" => ("--variant", args.variant.is_some()),
            _ => ("", false),
        },
        _ => ("", false),
    };
    let text = error.to_string();
    if is_given {
        let rest = text.split_once(": ").map_or(&*text, |(_, rest)| rest);
        return Failure::input(format!("{option}: {rest}"));
    }
    let files = [&args.scenario, &args.compressor_map, &args.turbine_map];
    // Several files make one plant: which of them is to blame only the reader can say.
    let names: Vec<String> = files
        .into_iter()
        .flatten()
        .map(|path| path.display().to_string())
        .collect();
    if names.is_empty() {
        return Failure::input(text);
    }
    Failure::input(format!("{}: {text}", names.join(", ")))
}

fn faults(path: &Path) -> Result<Vec<Fault>, Failure> {
    let file: FaultFile = read(path)?;
    if file.fault.is_empty() {
        return Err(Failure::in_file(
            path,
            "expected at least one [[fault]] table, found none",
        ));
    }
    Ok(file.fault)
}

fn map(path: &Path, component: &'static str, expected: MapKind) -> Result<SpeedLineTable, Failure> {
    let table: SpeedLineTable = read(path)?;
    let found = table.kind();
    if found == expected {
        return Ok(table);
    }
    let error = PlantError::MapOfOther { component, found };
    Err(Failure::in_file(path, error))
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::in_file(path, error))?;
    toml::from_str(&text).map_err(|error| Failure::in_file(path, error.to_string().trim_end()))
}
