//! Least squares: the inputs are exact.

use gt_campaign::reports::OrderComparison;
use gtfdi::ident::{Arx, ArxFit, ArxStructure, EquationErrors, IdentError, Solver};

use super::centre::centre;
use super::constraints::Constraints;
use super::records::Records;
use super::refinement::refine;
use super::structure::{Chosen, choose};
use super::{Identified, Model};
use crate::cli::{ErrorModel, IdentifyArgs, LeastSquaresSolver, Structure};
use crate::failure::Failure;

/// Fits an ARX model, and refines it where that is asked for.
pub fn identify(args: &IdentifyArgs, records: &Records) -> Result<Identified, Failure> {
    let constraints = Constraints::of(args)?;
    // Both take the lags of the own output only.
    let diagonal = constraints.is_some() || args.refine.is_some();
    let Chosen {
        structure,
        orders,
        warnings,
    } = choose(args, diagonal.then_some(Structure::Diag), records)?;
    let (mut model, constrained, mut covariances) = if let Some(constraints) = &constraints {
        let fit = constraints.fit(structure, records)?;
        (fit.model, Some(fit.rows), None)
    } else {
        let fit = plain(args, structure, records)?;
        (fit.model, None, Some(fit.covariance))
    };
    let mut refined = None;
    if args.refine.is_some() {
        let found = refine(&model, args, records)?;
        (model, refined) = (found.model, Some(found.outputs));
        // Its coefficients are others, with errors that nobody computes.
        covariances = None;
    }
    Ok(Identified {
        model: Model::Arx(model),
        covariances,
        orders: orders.map(OrderComparison::Arx),
        constrained,
        refined,
        warnings,
    })
}

/// Fits to all records without constraints.
fn plain(
    args: &IdentifyArgs,
    structure: ArxStructure,
    records: &Records,
) -> Result<ArxFit, Failure> {
    let mut arx = Arx::new(structure);
    if let (Some(text), Some(data)) = (&args.centre, records.longest()) {
        arx = arx.centre(centre(text, data.inputs(), data.outputs())?);
    }
    if let Some(ridge) = args.ridge {
        arx = arx.ridge(ridge);
    }
    if args.equation_errors == Some(ErrorModel::Correlated) {
        arx = arx.equation_errors(EquationErrors::Correlated);
    }
    if args.solver == Some(LeastSquaresSolver::Automatic) {
        arx = arx.solver(Solver::Automatic);
    }
    arx.fit_in_full(&records.train())
        .map_err(|error| match error {
            IdentError::Ridge { found } => Failure::input(format!(
                "--ridge: expected a finite number of at least 0, found {found}"
            )),
            IdentError::JointRidge { found } => Failure::input(format!(
                "--ridge: expected 0 with --equation-errors correlated, found {found}"
            )),
            error => records.refused(&error),
        })
}
