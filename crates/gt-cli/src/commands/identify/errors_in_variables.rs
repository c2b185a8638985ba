//! Errors-in-variables methods: noise on the inputs too.

use gt_campaign::reports::OrderComparison;
use gt_log::ModelKind;
use gtfdi::ident::IdentError;
use gtfdi::ident::eiv::{EivIdentification, EivMethod};
use gtfdi::ident::frisch::CriterionKind;

use super::records::Records;
use super::structure::parse_order;
use super::{Identified, Model};
use crate::cli::{Criterion, IdentifyArgs, Method};
use crate::failure::Failure;

/// Fits a relation an output, with the noise of every channel.
pub fn identify(
    method: Method,
    args: &IdentifyArgs,
    records: &Records,
) -> Result<Identified, Failure> {
    let option = if method == Method::Frisch {
        "--method frisch"
    } else {
        "--method eiv"
    };
    refuse_least_squares(args)?;
    let train = Records::one(option, "training", &records.train)?;
    let order = args.order.as_deref().map(parse_order).transpose()?;
    let order = order.ok_or_else(|| Failure::missing("--order", "--order auto"))?;
    let (kind, method) = if method == Method::Frisch {
        let criterion = match args.criterion {
            Some(Criterion::Shift) => CriterionKind::Shift,
            Some(Criterion::Covariance) => CriterionKind::Covariance,
            Some(Criterion::YuleWalker) => CriterionKind::YuleWalker,
            None => CriterionKind::default(),
        };
        (ModelKind::Frisch, EivMethod::Frisch(criterion))
    } else {
        let method = EivMethod::Likelihood {
            autoregression_order: None,
            frequencies: None,
            pole_prior: args.pole_prior.unwrap_or(0.0),
        };
        (ModelKind::Eiv, method)
    };
    let mut wish = EivIdentification::new(order).method(method);
    if let Some(nk) = &args.nk {
        wish = wish.nk(nk.clone());
    }
    let found = wish.identify(train).map_err(|error| match error {
        IdentError::EivLag { .. } => Failure::input(error),
        IdentError::PolePrior { found } => Failure::input(format!(
            "--pole-prior: expected a finite number of at least 0, found {found}"
        )),
        error => records.refused(&error),
    })?;
    Ok(Identified {
        model: Model::Eiv(kind, found.model),
        covariances: None,
        orders: found.orders.map(OrderComparison::Eiv),
        constrained: None,
        refined: None,
        warnings: found.remarks.iter().map(ToString::to_string).collect(),
    })
}

/// Options that only least squares has are refused.
fn refuse_least_squares(args: &IdentifyArgs) -> Result<(), Failure> {
    let others = [
        ("--structure", args.structure.is_some()),
        ("--indices", args.indices.is_some()),
        ("--na", args.na.is_some()),
        ("--nb", args.nb.is_some()),
        ("--centre", args.centre.is_some()),
        ("--ridge", args.ridge.is_some()),
        ("--equation-errors", args.equation_errors.is_some()),
        ("--solver", args.solver.is_some()),
        ("--stable", args.stable.is_some()),
        ("--dc-gain", args.dc_gain.is_some()),
        ("--refine", args.refine.is_some()),
    ];
    match others.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(Failure::input(format!(
            "{option}: expected with --method arx only, found another method: it takes --order \
             and --nk"
        ))),
    }
}
