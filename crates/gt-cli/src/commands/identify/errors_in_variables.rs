//! Errors-in-variables methods: noise on the inputs too.

use std::ops::RangeInclusive;

use gt_log::ModelKind;
use gtfdi::core::Dataset;
use gtfdi::ident::IdentError;
use gtfdi::ident::eiv::{Eiv, EivLags, EivOrderTable, eiv_order_table};
use gtfdi::ident::frisch::{self, Frisch};

use super::orders::Orders;
use super::records::Records;
use super::structure::{Order, parse_order};
use super::{Identified, Model};
use crate::cli::{Criterion, IdentifyArgs, Method};
use crate::commands::noise::not_told;
use crate::failure::Failure;

/// Lags beyond the order of the criteria that look at some.
const CRITERION_LAGS: usize = 5;
/// Orders that `--order auto` looks at, as far as the record bears them.
const AUTO_ORDERS: RangeInclusive<usize> = 1..=6;

/// Fits a relation an output, with the noise of every channel.
pub fn identify(
    method: Method,
    args: &IdentifyArgs,
    records: &Records,
) -> Result<Identified, Failure> {
    let in_file = |error: IdentError| records.refused(&error);
    let option = if method == Method::Frisch {
        "--method frisch"
    } else {
        "--method eiv"
    };
    let mut warnings = Vec::new();
    refuse_least_squares(args)?;
    let train = Records::one(option, "training", &records.train)?;
    let nk = smallest_lags(args, train.nu());
    let (order, orders) = match args.order.as_deref().map(parse_order).transpose()? {
        Some(Order::One(order)) => (order, None),
        Some(Order::Range(orders)) => {
            let table = eiv_order_table(train, orders, &nk).map_err(in_file)?;
            (table.best_bic(), Some(table))
        }
        Some(Order::Auto) => {
            let table = as_far_as_the_record_bears(train, &nk).map_err(in_file)?;
            let highest = table.rows.last().map_or(0, |row| row.order);
            if highest < *AUTO_ORDERS.end() {
                warnings.push(format!(
                    "{} rows bear no order above {highest}: --order auto looked no further",
                    train.len()
                ));
            }
            (table.best_bic(), Some(table))
        }
        None => return Err(Failure::missing("--order", "--order auto")),
    };
    let lags = EivLags::new(order, nk).map_err(Failure::input)?;
    let (kind, model) = if method == Method::Frisch {
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
    } else {
        let eiv = Eiv::new(vec![lags; train.ny()]);
        let found = eiv.fit(train).map_err(in_file)?;
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
    };
    warnings.extend(not_told(&model));
    Ok(Identified {
        model: Model::Eiv(kind, model),
        orders: orders.map(Orders::Eiv),
        constrained: None,
        refined: None,
        warnings,
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

/// The smallest lag of each input.
fn smallest_lags(args: &IdentifyArgs, inputs: usize) -> Vec<usize> {
    let nk = args.nk.clone().unwrap_or_else(|| vec![1]);
    if nk.len() == 1 {
        vec![nk[0]; inputs]
    } else {
        nk
    }
}

/// The table of [`AUTO_ORDERS`], of as many as the record is long enough for.
fn as_far_as_the_record_bears(train: &Dataset, nk: &[usize]) -> Result<EivOrderTable, IdentError> {
    let first = nk.iter().copied().fold(*AUTO_ORDERS.start(), usize::max);
    let mut last = first.max(*AUTO_ORDERS.end());
    loop {
        match eiv_order_table(train, first..=last, nk) {
            Err(IdentError::EivTooFewSamples { .. }) if last > first => last -= 1,
            result => return result,
        }
    }
}
