//! `gtfdi identify`: records to a model file.

mod blocks;
mod centre;
mod constraints;
mod errors_in_variables;
mod hint;
mod least_squares;
mod orders;
mod records;
mod refinement;
mod report;
mod structure;

use gt_campaign::reports::{ModelReport, OrderComparison, model_report};
use gt_log::{LogError, ModelFile, ModelKind, write_json};
use gtfdi::core::{Dataset, Never};
use gtfdi::ident::constrained::ConstrainedRow;
use gtfdi::ident::eiv::EivModel;
use gtfdi::ident::output_error::RefinedOutput;
use gtfdi::ident::{ArxModel, Start, Validation, ValidationOptions, validate_records};
use nalgebra::DMatrix;

use self::orders::{check_plot, plot};
use self::records::{Records, Source};
use self::report::{Report, output_reports, standard_errors, text};
use super::SCHEMA_VERSION;
use super::finding::residual_findings;
use super::noise::{noise_reports, noise_variances};
use super::report_folder::{check_folder, provenance, write_report};
use crate::Outcome;
use crate::cli::{GlobalArgs, IdentifyArgs, Method};
use crate::config::layered;
use crate::failure::Failure;
use crate::output::{complain, print, print_json};

/// What a method found.
struct Identified {
    model: Model,
    /// Covariances of the coefficients of each row, where they are those of least squares.
    covariances: Option<Vec<DMatrix<f64>>>,
    orders: Option<OrderComparison>,
    constrained: Option<Vec<ConstrainedRow>>,
    refined: Option<Vec<RefinedOutput>>,
    warnings: Vec<String>,
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

    fn file(&self, input_sha256: Option<&str>) -> Result<ModelFile, LogError> {
        match self {
            Self::Arx(model) => ModelFile::arx(model.clone(), input_sha256),
            Self::Eiv(kind, model) => ModelFile::with_noise(*kind, model, input_sha256),
        }
    }
}

/// Runs the verb.
pub fn run(args: &IdentifyArgs, global: &GlobalArgs) -> Result<Outcome, Failure> {
    let Some(args) = layered("identify", args, global)? else {
        return Ok(Outcome::Done);
    };
    if let Some(folder) = &args.report {
        check_folder(folder)?;
    }
    if let Some(path) = &args.plot {
        check_plot(path, args.order.as_deref())?;
    }
    let mut records = Records::read(&args)?;
    let method = args.method.unwrap_or(Method::Arx);
    let mut identified = fit(method, &args, &records)?;
    let mut warnings = std::mem::take(&mut records.warnings);
    for warning in std::mem::take(&mut identified.warnings) {
        complain(&format!("warning: {}: {warning}", records.name()));
        warnings.push(warning);
    }
    let model = identified.model.relation();
    // Noise on the first samples would ring through a run that takes them as they are.
    let start = match identified.model {
        Model::Arx(_) => Start::Measured,
        Model::Eiv(..) => Start::Fitted,
    };
    let options = ValidationOptions {
        origin: records.origin,
        start,
        residual_tests: start == Start::Measured,
    };
    let validation = records.validation();
    let scores = validate_records(model, &validation, options)
        .map_err(|error| records.refused_validation(&error))?;
    if let (Some(path), Some(orders)) = (&args.plot, &identified.orders) {
        plot(orders, path)?;
    }
    // The file has room for one digest.
    let only = match &records.sources[..] {
        [only] => Some(only),
        _ => None,
    };
    let input_sha256 = only.map(|source| source.input_sha256.as_str());
    if let Some(out) = &args.out {
        let file = identified.model.file(input_sha256);
        write_json(out, &file.map_err(Failure::failed)?).map_err(Failure::failed)?;
    }
    write_report(args.report.as_ref(), || {
        let files = records.sources.iter().chain(&records.holdout);
        let files = files.map(|own| (own.data.as_path(), Some(own.input_sha256.as_str())));
        let source = provenance(files, "identify", &args, &warnings)?;
        let page = page(&identified, method, &records, &validation, &scores, start);
        model_report(&page, &source, &Never).map_err(Failure::failed)
    })?;
    let spectral_radius = model
        .state_space()
        .ok()
        .and_then(|ss| ss.spectral_radius().ok());
    let divergences = scores.outputs.iter().filter_map(|fit| fit.diverges_at_s);
    let eiv = identified.model.eiv();
    let report = Report {
        schema_version: SCHEMA_VERSION,
        method,
        structure: model.structure(),
        sample_time_s: model.sample_time_s(),
        spectral_radius,
        stable: spectral_radius.map(|radius| radius < 1.0),
        free_run_start: start,
        diverges_at: divergences.reduce(f64::min),
        train_rows: only.and_then(Source::train_rows),
        validation_rows: records
            .holdout
            .as_ref()
            .or(only)
            .and_then(Source::validation_rows),
        records: &records.sources,
        holdout: records.holdout.as_ref(),
        outputs: output_reports(model, &scores),
        standard_errors: standard_errors(model),
        residuals: scores.residuals.as_ref(),
        constraints: identified.constrained.as_deref(),
        refinement: identified.refined.as_deref(),
        noise_variances: eiv.map(noise_variances),
        noise: eiv.map(noise_reports),
        order_table: identified.orders.as_ref(),
        order_reason: identified.orders.as_ref().map(OrderComparison::reason),
        input_sha256,
        warnings,
        plot: args.plot.as_deref(),
        out: args.out.as_deref(),
        folder: args.report.as_deref(),
    };
    if global.json {
        print_json(&report)?;
    } else {
        let validated = records.validation.iter().map(Dataset::len).sum();
        print(&text(&report, records.samples(), validated))?;
    }
    Ok(Outcome::Done)
}

/// What the report shows.
fn page<'a>(
    identified: &'a Identified,
    method: Method,
    records: &Records,
    validation: &'a [&'a Dataset],
    scores: &'a Validation,
    start: Start,
) -> ModelReport<'a> {
    let findings = scores.residuals.as_ref().map_or_else(Vec::new, |verdict| {
        let findings = residual_findings(verdict).into_iter();
        findings.map(|finding| finding.line()).collect()
    });
    ModelReport {
        model: identified.model.relation(),
        method: method.name(),
        noise: identified.model.eiv(),
        covariances: identified.covariances.as_deref(),
        train_samples: records.samples(),
        validation,
        scores,
        start,
        orders: identified.orders.as_ref().map(OrderComparison::shown),
        findings,
    }
}

/// Fits the model by the method.
fn fit(method: Method, args: &IdentifyArgs, records: &Records) -> Result<Identified, Failure> {
    refuse_options_of_others(method, args)?;
    match method {
        Method::Arx => least_squares::identify(args, records),
        Method::Frisch | Method::Eiv => errors_in_variables::identify(method, args, records),
    }
}

/// A criterion chooses a point of the Frisch scheme, a prior belongs to the likelihood.
fn refuse_options_of_others(method: Method, args: &IdentifyArgs) -> Result<(), Failure> {
    let criterion = args.criterion.is_some() && method != Method::Frisch;
    let prior = args.pole_prior.is_some() && method != Method::Eiv;
    let (option, own) = match (criterion, prior) {
        (true, _) => ("--criterion", "frisch"),
        (false, true) => ("--pole-prior", "eiv"),
        (false, false) => return Ok(()),
    };
    Err(Failure::input(format!(
        "{option}: expected with --method {own} only, found another method"
    )))
}
