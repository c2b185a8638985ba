//! The residual generators of a bank.

use std::path::Path;

use gt_campaign::{Refusal, kalman_generator, search_observers, unknown_input_generator};
use gtfdi::core::Dataset;
use gtfdi::fdi::{ObserverDesign, PoleSearch, ResidualGenerator};
use gtfdi::ident::eiv::EivModel;
use gtfdi::ident::{ArxModel, IdentError, OutputModel};

use super::poles::poles;
use super::search::Faulty;
use crate::cli::GeneratorKind;
use crate::failure::Failure;
use crate::output::number;

/// Generators, one an output or one of all.
pub struct Found {
    pub generators: Vec<ResidualGenerator>,
    /// What a search for the poles of each found; none where there was no search.
    pub searched: Vec<Option<ObserverDesign>>,
}

/// The models of the outputs.
pub fn parts(model: &ArxModel) -> Result<Vec<OutputModel>, IdentError> {
    let outputs = 0..model.outputs().len();
    outputs.map(|output| model.output_model(output)).collect()
}

/// The observers of the outputs' `parts` whose poles tell the faults of the records best; with the
/// default poles where the faults change nothing that an observer reads.
pub fn found_by(
    search: &PoleSearch,
    parts: Vec<OutputModel>,
    faulty: &mut Faulty,
    healthy: &[Dataset],
    healthy_paths: &[&Path],
) -> Result<Found, Failure> {
    let (training, validation) = faulty.pairs(healthy);
    let searched = search_observers(search, &parts, &training, &validation)
        .map_err(|(output, error)| faulty.refused(&error, &output, healthy_paths))?;
    if searched.iter().all(Option::is_none) {
        return Err(Failure::input(
            "--faulty: expected a record in which a channel of the model differs from the healthy \
             one, found none",
        ));
    }
    let mut generators = Vec::with_capacity(parts.len());
    for (part, found) in parts.into_iter().zip(&searched) {
        let name = part.model.outputs()[0].name.clone();
        let made = if let Some(found) = found {
            if found.v > 1.0 {
                faulty.warn(format!(
                    "`{name}`: {} times as much is in the residual without the faults as they add to \
                     it, with the best poles found",
                    number(Some(found.v))
                ));
            }
            found.generator(part.model, part.point)
        } else {
            faulty.warn(format!(
                "`{name}`: the faults of --faulty change nothing that its observer reads: it has the \
                 poles that it would have without them"
            ));
            let poles = poles(&[], &name, part.model.nx())?;
            ResidualGenerator::observer_complex(part.model, part.point, &poles)
        };
        generators.push(made.map_err(|error| faulty.refused(&error, &name, healthy_paths))?);
    }
    Ok(Found {
        generators,
        searched,
    })
}

/// One filter that feels no error of the channels `unknown`.
pub fn without(
    unknown: &[String],
    model: &ArxModel,
    noise: Option<&EivModel>,
    model_path: &Path,
) -> Result<Found, Failure> {
    let Some(noise) = noise else {
        return Err(Failure::in_file(
            model_path,
            "--unknown: expected an errors-in-variables model, whose noise says what is left without \
             the channels (identify --method eiv or frisch), found an ARX model",
        ));
    };
    let signals = model.inputs().iter().chain(model.outputs());
    let names: Vec<&str> = signals.map(|signal| signal.name.as_str()).collect();
    if let Some(tag) = unknown.iter().find(|tag| !names.contains(&tag.as_str())) {
        return Err(Failure::input(format!(
            "--unknown: expected a channel of {} ({}), found `{tag}`",
            model_path.display(),
            names.join(", ")
        )));
    }
    let generator = unknown_input_generator(noise, unknown)
        .map_err(|error| Failure::input(format!("--unknown {}: {error}", unknown.join(","))))?;
    Ok(Found {
        generators: vec![generator],
        searched: vec![None; model.outputs().len()],
    })
}

/// The generators of the outputs' `parts` that the options name; the outer error is of the options.
pub fn chosen(
    kind: GeneratorKind,
    model: &ArxModel,
    noise: Option<&EivModel>,
    parts: Vec<OutputModel>,
    wishes: &[String],
) -> Result<Result<Found, Refusal>, Failure> {
    let mut generators = Vec::with_capacity(parts.len());
    for (index, part) in parts.into_iter().enumerate() {
        let name = model.outputs()[index].name.clone();
        let made = match kind {
            GeneratorKind::Observer => {
                let poles = poles(wishes, &name, part.model.nx())?;
                ResidualGenerator::observer_complex(part.model, part.point, &poles)
            }
            GeneratorKind::Kalman => kalman_generator(model, noise, index, part),
        };
        match made {
            Ok(generator) => generators.push(generator),
            Err(error) => return Ok(Err((name, error))),
        }
    }
    let searched = vec![None; generators.len()];
    Ok(Ok(Found {
        generators,
        searched,
    }))
}
