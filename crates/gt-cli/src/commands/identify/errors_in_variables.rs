//! Errors-in-variables methods: noise on the inputs too.

use std::path::Path;

use gt_log::ModelKind;
use gtfdi::core::Dataset;
use gtfdi::ident::eiv::{Eiv, EivLags, EivModel};
use gtfdi::ident::frisch::{self, Frisch};

use super::structure::{Order, parse_order};
use super::{Identified, Model, refuse_criterion};
use crate::cli::{Criterion, IdentifyArgs, Method};
use crate::failure::Failure;

/// Lags beyond the order of the criteria that look at some.
const CRITERION_LAGS: usize = 5;

/// Fits a relation an output, with the noise of every channel.
pub fn identify(args: &IdentifyArgs, path: &Path, train: &Dataset) -> Result<Identified, Failure> {
    let lags = lags(args, train.nu())?;
    let in_file = |error| Failure::in_file(path, error);
    let mut warnings = Vec::new();
    let (kind, model) = match args.method {
        Some(Method::Frisch) => {
            let order = lags.order();
            let scheme = Frisch::new(lags).criterion(match args.criterion {
                Some(Criterion::Shift) => frisch::Criterion::ShiftRelation,
                Some(Criterion::Covariance) => frisch::Criterion::CovarianceMatch {
                    lags: order + CRITERION_LAGS,
                },
                Some(Criterion::YuleWalker) | None => frisch::Criterion::HighOrderYuleWalker {
                    lags: CRITERION_LAGS,
                },
            });
            let found = scheme.fit_shared(train).map_err(in_file)?;
            (ModelKind::Frisch, found.model(train).map_err(in_file)?)
        }
        _ => {
            refuse_criterion(args.criterion)?;
            let found = Eiv::new(vec![lags; train.ny()])
                .fit(train)
                .map_err(in_file)?;
            if found.short_record {
                warnings.push(format!(
                    "{} rows are few for this model: the standard errors promise too much",
                    train.len()
                ));
            }
            if !found.converged {
                warnings.push("the search for the likelihood's maximum did not end".to_owned());
            }
            (ModelKind::Eiv, found.model(train).map_err(in_file)?)
        }
    };
    warnings.extend(not_told(&model));
    Ok(Identified {
        model: Model::Eiv(kind, model),
        orders: None,
        warnings,
    })
}

/// The lags that the options ask for, the same for every output.
fn lags(args: &IdentifyArgs, inputs: usize) -> Result<EivLags, Failure> {
    let others = [
        ("--structure", args.structure.is_some()),
        ("--indices", args.indices.is_some()),
        ("--na", args.na.is_some()),
        ("--nb", args.nb.is_some()),
    ];
    if let Some((option, _)) = others.into_iter().find(|(_, given)| *given) {
        return Err(Failure::input(format!(
            "{option}: expected with --method arx only, found another method: it takes --order \
             and --nk"
        )));
    }
    let order = match args.order.as_deref().map(parse_order).transpose()? {
        Some(Order::One(order)) => order,
        Some(_) => {
            return Err(Failure::input(
                "--order: expected one order with --method frisch or eiv, found several",
            ));
        }
        None => return Err(Failure::missing("--order", "--order 2")),
    };
    let mut nk = args.nk.clone().unwrap_or_else(|| vec![1]);
    if nk.len() == 1 {
        nk = vec![nk[0]; inputs];
    }
    EivLags::new(order, nk).map_err(Failure::input)
}

/// What the record does not tell, in words.
fn not_told(model: &EivModel) -> Vec<String> {
    let untold = model
        .noise()
        .filter(|(_, noise)| noise.identifiable() == Some(false));
    untold
        .map(|(signal, noise)| {
            let why = match noise.standard_error {
                _ if noise.at_limit => "it stands at a limit of the search".to_owned(),
                Some(error) => format!("standard error {error:.3e}"),
                None => "no standard error".to_owned(),
            };
            format!(
                "the record does not tell the noise of `{}`: variance {:.3e}, {why}",
                signal.name, noise.variance
            )
        })
        .collect()
}
