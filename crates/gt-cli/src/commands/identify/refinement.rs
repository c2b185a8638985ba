//! The option `--refine`.

use gtfdi::ident::output_error::{OutputErrorRefinement, Refined};
use gtfdi::ident::{ArxModel, IdentError};

use super::records::Records;
use crate::failure::Failure;

const OPTION: &str = "--refine output-error";

/// Lowers the error of the free run over the training rows, where the validation rows agree.
pub fn refine(model: &ArxModel, records: &Records) -> Result<Refined, Failure> {
    if !records.has_fresh_rows() {
        return Err(Failure::input(format!(
            "{OPTION}: expected --validate with other rows than --train, or --holdout, found \
             training rows: rows that the fit has seen cannot confirm it"
        )));
    }
    let train = Records::one(OPTION, "training", &records.train)?;
    let fresh = Records::one(OPTION, "validation", &records.validation)?;
    OutputErrorRefinement::new()
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
