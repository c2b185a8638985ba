//! `gtfdi identify`: a record to a model file.

mod errors_in_variables;
mod report;
mod structure;

use std::fmt::Display;
use std::ops::Range;
use std::path::{Path, PathBuf};

use gt_log::{LogError, ModelFile, ModelKind, write_json};
use gtfdi::core::Dataset;
use gtfdi::ident::eiv::{EivModel, EivOrderTable};
use gtfdi::ident::{Arx, ArxModel, OrderTable, validate};
use serde::Serialize;

use self::report::{Report, noise_reports, noise_variances, output_reports, standard_errors, text};
use self::structure::{Chosen, choose};
use super::SCHEMA_VERSION;
use crate::Outcome;
use crate::cli::{Criterion, GlobalArgs, IdentifyArgs, Method};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{complain, print, print_json};
use crate::record::{Read, check_out, read, selection};

/// What a method found.
struct Identified {
    model: Model,
    orders: Option<Orders>,
    warnings: Vec<String>,
}

/// What the orders were compared by.
#[derive(Serialize)]
#[serde(untagged)]
enum Orders {
    Arx(OrderTable),
    Eiv(EivOrderTable),
}

/// A model of either kind.
enum Model {
    Arx(ArxModel),
    Eiv(ModelKind, EivModel),
}

impl Model {
    /// The equations: of the channels, or of what they would be without noise.
    fn relation(&self) -> &ArxModel {
        match self {
            Self::Arx(model) => model,
            Self::Eiv(_, model) => model.relation(),
        }
    }

    fn eiv(&self) -> Option<&EivModel> {
        match self {
            Self::Arx(_) => None,
            Self::Eiv(_, model) => Some(model),
        }
    }

    fn file(&self, input_sha256: &str) -> Result<ModelFile, LogError> {
        match self {
            Self::Arx(model) => ModelFile::arx(model.clone(), Some(input_sha256)),
            Self::Eiv(kind, model) => ModelFile::with_noise(*kind, model, Some(input_sha256)),
        }
    }
}

/// Fits an ARX model.
fn by_least_squares(
    args: &IdentifyArgs,
    path: &Path,
    train: &Dataset,
) -> Result<Identified, Failure> {
    let Chosen {
        structure,
        orders,
        warning,
    } = choose(args, path, train)?;
    let fitted = Arx::new(structure).fit(train);
    Ok(Identified {
        model: Model::Arx(fitted.map_err(|error| Failure::in_file(path, error))?),
        orders: orders.map(Orders::Arx),
        warnings: warning.into_iter().collect(),
    })
}

/// The training and the validation rows, and the rows of the file that hold both: only those have
/// to be readable.
struct Blocks {
    train: Option<Range<usize>>,
    validate: Option<Range<usize>>,
    window: Option<Range<usize>>,
}

impl Blocks {
    fn of(args: &IdentifyArgs) -> Self {
        let [train, validate] =
            [&args.train, &args.validate].map(|rows| rows.as_ref().map(|rows| rows.0.clone()));
        let window = match (&train, &validate) {
            (Some(train), Some(validate)) => {
                Some(train.start.min(validate.start)..train.end.max(validate.end))
            }
            (Some(train), None) => Some(train.clone()),
            (None, _) => None,
        };
        Self {
            train,
            validate,
            window,
        }
    }

    /// The rows that the file has not, by the option that asks for them.
    fn beyond(&self, path: &Path, total: usize) -> Option<Failure> {
        [("--train", &self.train), ("--validate", &self.validate)]
            .into_iter()
            .filter_map(|(option, rows)| Some((option, rows.as_ref()?)))
            .find(|(_, rows)| rows.end > total)
            .map(|(option, rows)| {
                let (start, end) = (rows.start, rows.end);
                Failure::in_file(
                    path,
                    format!(
                        "{option}: expected rows A:B with B at most {total}, found {start}:{end}"
                    ),
                )
            })
    }
}

/// Runs the verb.
pub fn run(args: &IdentifyArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let defaults = IdentifyArgs {
        method: Some(Method::Arx),
        ..IdentifyArgs::default()
    };
    let Some(args) = layered("identify", args, &defaults, global)? else {
        return Ok(Outcome::Done);
    };
    let path: PathBuf = args
        .data
        .clone()
        .ok_or_else(|| Failure::missing("DATA", "gtfdi identify run.csv"))?;
    let inputs = args.inputs.clone().unwrap_or_default();
    let outputs = args
        .outputs
        .clone()
        .ok_or_else(|| Failure::missing("--outputs", "--outputs y"))?;
    if let Some(out) = &args.out {
        check_out(out, &[&path])?;
    }
    let blocks = Blocks::of(&args);
    let wanted = selection(inputs, outputs, &args.reading, blocks.window.clone());
    let Read {
        imported,
        mut warnings,
    } = read(&path, &wanted).map_err(|error| match error {
        LogError::Rows { total, .. } => blocks
            .beyond(&path, total)
            .unwrap_or_else(|| Failure::input(error)),
        error => Failure::input(error),
    })?;
    if let Some(failure) = blocks.beyond(&path, imported.total_rows) {
        return Err(failure);
    }
    let data = &imported.dataset;
    let shift = blocks.window.as_ref().map_or(0, |window| window.start);
    let block = |rows: Option<Range<usize>>, default: Range<usize>| {
        rows.map_or(default, |rows| rows.start - shift..rows.end - shift)
    };
    let train_rows = block(blocks.train, 0..data.len());
    let validation_rows = block(blocks.validate, train_rows.clone());
    let in_file = |error: &dyn Display| Failure::in_file(&path, error);
    let rows = |rows: &Range<usize>| data.rows(rows.clone()).map_err(|error| in_file(&error));
    let (train, validation) = (rows(&train_rows)?, rows(&validation_rows)?);

    let method = args.method.unwrap_or(Method::Arx);
    let identified = fit(method, &args, &path, &train)?;
    for warning in identified.warnings {
        complain(&format!("warning: {}: {warning}", path.display()));
        warnings.push(warning);
    }
    let model = identified.model.relation();
    let scores = validate(model, &validation).map_err(|error| {
        let rows = args.validate.as_ref().map_or_else(
            || "the training rows".to_owned(),
            |rows| format!("--validate {rows}"),
        );
        in_file(&format!("{rows}: {error}"))
    })?;
    if let Some(out) = &args.out {
        let file = identified.model.file(&imported.sha256);
        write_json(out, &file.map_err(Failure::failed)?).map_err(Failure::failed)?;
    }
    let spectral_radius = model
        .state_space()
        .ok()
        .and_then(|ss| ss.spectral_radius().ok());
    let divergences = scores.outputs.iter().filter_map(|fit| fit.diverges_at_s);
    let noise = identified.model.eiv().map(noise_reports);
    let absolute = |rows: Range<usize>| [rows.start + shift, rows.end + shift];
    let report = Report {
        schema_version: SCHEMA_VERSION,
        method,
        structure: model.structure(),
        sample_time_s: model.sample_time_s(),
        spectral_radius,
        stable: spectral_radius.map(|radius| radius < 1.0),
        diverges_at: divergences.reduce(f64::min),
        train_rows: absolute(train_rows),
        validation_rows: absolute(validation_rows),
        outputs: output_reports(model, &scores),
        standard_errors: standard_errors(model),
        noise_variances: identified.model.eiv().map(noise_variances),
        noise,
        order_table: identified.orders.as_ref(),
        input_sha256: &imported.sha256,
        warnings,
        out: args.out.as_deref(),
    };
    if global.json {
        print_json(&report)?;
    } else {
        print(&text(&report, train.len()))?;
    }
    Ok(Outcome::Done)
}

/// Fits the model by the method.
fn fit(
    method: Method,
    args: &IdentifyArgs,
    path: &Path,
    train: &Dataset,
) -> Result<Identified, Failure> {
    if method != Method::Frisch {
        refuse_criterion(args.criterion)?;
    }
    match method {
        Method::Arx => by_least_squares(args, path, train),
        Method::Frisch | Method::Eiv => errors_in_variables::identify(method, args, path, train),
    }
}

/// A criterion chooses a point of the Frisch scheme and nothing else.
fn refuse_criterion(criterion: Option<Criterion>) -> Result<(), Failure> {
    match criterion {
        None => Ok(()),
        Some(_) => Err(Failure::input(
            "--criterion: expected with --method frisch only, found another method",
        )),
    }
}
