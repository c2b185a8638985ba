//! Errors-in-variables methods: noise on the inputs too.

use std::path::Path;

use gt_log::ModelKind;
use gtfdi::core::Dataset;
use gtfdi::ident::IdentError;
use gtfdi::ident::eiv::{EivIdentification, EivMethod};
use gtfdi::ident::frisch::CriterionKind;

use super::structure::parse_order;
use super::{Identified, Model, Orders};
use crate::cli::{Criterion, IdentifyArgs, Method};
use crate::failure::Failure;

/// Fits a relation an output, with the noise of every channel.
pub fn identify(
    method: Method,
    args: &IdentifyArgs,
    path: &Path,
    train: &Dataset,
) -> Result<Identified, Failure> {
    refuse_structures(args)?;
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
        (ModelKind::Eiv, EivMethod::default())
    };
    let mut wish = EivIdentification::new(order).method(method);
    if let Some(nk) = &args.nk {
        wish = wish.nk(nk.clone());
    }
    let found = wish.identify(train).map_err(|error| match error {
        IdentError::EivLag { .. } => Failure::input(error),
        error => Failure::in_file(path, error),
    })?;
    Ok(Identified {
        model: Model::Eiv(kind, found.model),
        orders: found.orders.map(Orders::Eiv),
        warnings: found.remarks.iter().map(ToString::to_string).collect(),
    })
}

/// Refuses options that only another method has.
fn refuse_structures(args: &IdentifyArgs) -> Result<(), Failure> {
    let others = [
        ("--structure", args.structure.is_some()),
        ("--indices", args.indices.is_some()),
        ("--na", args.na.is_some()),
        ("--nb", args.nb.is_some()),
    ];
    match others.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(Failure::input(format!(
            "{option}: expected with --method arx only, found another method: it takes --order \
             and --nk"
        ))),
    }
}
