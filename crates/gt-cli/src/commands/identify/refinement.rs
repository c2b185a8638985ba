//! The option `--refine`.

use gtfdi::ident::output_error::{OutputErrorRefinement, Refined};
use gtfdi::ident::{ArxModel, IdentError};

use super::records::Records;
use crate::cli::IdentifyArgs;
use crate::failure::Failure;

const OPTION: &str = "--refine output-error";

/// Lowers the error of the free run over the training rows, where the validation rows agree. Poles
/// stay within the radius of `--stable`.
pub fn refine(
    model: &ArxModel,
    args: &IdentifyArgs,
    records: &Records,
) -> Result<Refined, Failure> {
    if args.dc_gain.is_some() {
        return Err(Failure::input(format!(
            "{OPTION}: expected without --dc-gain, found both: a refined model would not keep the \
             gain"
        )));
    }
    if !records.has_fresh_rows() {
        return Err(Failure::input(format!(
            "{OPTION}: expected --validate with other rows than --train, or --holdout, found \
             training rows: rows that the fit has seen cannot confirm it"
        )));
    }
    let train = Records::one(OPTION, "training", &records.train)?;
    let fresh = Records::one(OPTION, "validation", &records.validation)?;
    let refinement = match args.stable {
        // A radius of 1 is allowed for a fit; a free run needs less.
        Some(radius) => OutputErrorRefinement::new().max_radius(radius.min(1.0 - f64::EPSILON)),
        None => OutputErrorRefinement::new(),
    };
    refinement
        .refine(model, train, fresh)
        .map_err(|error| match &error {
            IdentError::NotDiagonal { structure, .. } => Failure::input(format!(
                "{OPTION}: expected --structure diag, found {structure}"
            )),
            IdentError::UnstableStart {
                output,
                limit,
                found,
            } => Failure::input(format!(
                "{OPTION}: output `{output}`: expected poles within {limit} to start from, found \
                 {found}; fit it with --stable"
            )),
            _ => records.refused(&error),
        })
}
