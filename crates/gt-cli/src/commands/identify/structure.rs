//! The options of `gtfdi identify` that describe the model's structure.

use gtfdi::core::Dataset;
use gtfdi::ident::{ArxStructure, IdentError, OrderChoice, OrderKind, OrderTable};

use super::records::Records;
use crate::cli::{IdentifyArgs, Structure};
use crate::failure::Failure;

/// Reads `--order`.
pub fn parse_order(text: &str) -> Result<OrderChoice, Failure> {
    let bad = || {
        Failure::input(format!(
            "--order: expected a number from 1, a range such as 1..12, or auto, found `{text}`"
        ))
    };
    let number = |text: &str| match text.trim().parse::<usize>() {
        Ok(order) if order >= 1 => Ok(order),
        _ => Err(bad()),
    };
    match text.trim() {
        "auto" => Ok(OrderChoice::Automatic),
        text => match text.split_once("..") {
            None => number(text).map(OrderChoice::Given),
            Some((low, high)) => {
                let high = high.strip_prefix('=').unwrap_or(high);
                let (low, high) = (number(low)?, number(high)?);
                if low > high {
                    return Err(bad());
                }
                Ok(OrderChoice::Search(low..=high))
            }
        },
    }
}

/// The structure to fit, with the criteria that chose it where orders were compared.
pub struct Chosen {
    pub structure: ArxStructure,
    pub orders: Option<OrderTable>,
    pub warnings: Vec<String>,
}

impl From<ArxStructure> for Chosen {
    fn from(structure: ArxStructure) -> Self {
        Self {
            structure,
            orders: None,
            warnings: Vec::new(),
        }
    }
}

/// The structure that the options ask for, `default` where they name none; orders are compared on
/// the longest record.
pub fn choose(
    args: &IdentifyArgs,
    default: Option<Structure>,
    records: &Records,
) -> Result<Chosen, Failure> {
    let outputs = records.longest().map_or(0, Dataset::ny);
    let nk = args.nk.clone().unwrap_or_else(|| vec![1]);
    let lags = args.na.is_some() || args.nb.is_some();
    let order = args.order.as_deref().map(parse_order).transpose()?;
    let canonical_by_default = args.indices.is_some() || order.is_some() && outputs > 1;
    let structure = args
        .structure
        .or(default)
        .unwrap_or(if canonical_by_default {
            Structure::Canonical
        } else {
            Structure::Full
        });
    let kind = match structure {
        Structure::Canonical if lags => {
            return Err(Failure::input(
                "--structure canonical: expected --order or --indices, found --na or --nb",
            ));
        }
        Structure::Canonical => OrderKind::Canonical {
            feedthrough: feedthrough(&nk)?,
        },
        _ if args.indices.is_some() => {
            return Err(Failure::input(
                "--indices: expected with --structure canonical only, found another structure",
            ));
        }
        Structure::Diag => OrderKind::Diagonal { nk: nk.clone() },
        Structure::Full => OrderKind::Full { nk: nk.clone() },
    };
    match (order, structure) {
        (Some(order), _) => by_order(&order, &kind, records),
        (None, Structure::Canonical) => canonical(args, &kind),
        (None, Structure::Full | Structure::Diag) => {
            let (na, nb) = match (args.na, args.nb.clone()) {
                (Some(na), Some(nb)) => (na, nb),
                (None, None) => {
                    return Err(Failure::missing("--order, or --na and --nb", "--order 8"));
                }
                (Some(_), None) => return Err(Failure::missing("--nb", "--nb 2")),
                (None, Some(_)) => return Err(Failure::missing("--na", "--na 2")),
            };
            Ok(Chosen::from(match structure {
                Structure::Diag => ArxStructure::Diagonal { na, nb, nk },
                _ => ArxStructure::Full { na, nb, nk },
            }))
        }
    }
}

/// Whether the canonical structure has a direct term.
fn feedthrough(nk: &[usize]) -> Result<bool, Failure> {
    match nk {
        [1] => Ok(false),
        [0] => Ok(true),
        _ => {
            let found: Vec<String> = nk.iter().map(ToString::to_string).collect();
            Err(Failure::input(format!(
                "--nk: the canonical structure has lags from 1, or from 0 (a direct term), for \
                 all inputs alike; expected 1 or 0, found {}",
                found.join(",")
            )))
        }
    }
}

fn canonical(args: &IdentifyArgs, kind: &OrderKind) -> Result<Chosen, Failure> {
    match (&args.indices, kind) {
        (Some(indices), OrderKind::Canonical { feedthrough }) => {
            Ok(Chosen::from(ArxStructure::Canonical {
                indices: indices.clone(),
                feedthrough: *feedthrough,
            }))
        }
        _ => Err(Failure::missing("--order or --indices", "--order 8")),
    }
}

fn by_order(order: &OrderChoice, kind: &OrderKind, records: &Records) -> Result<Chosen, Failure> {
    let Some(longest) = records.longest() else {
        return Err(records.refused(&IdentError::NoRecords));
    };
    let chosen = kind.choose(longest, order).map_err(|error| match error {
        IdentError::OrderTooSmall { order, outputs } => Failure::input(format!(
            "--order: expected at least {outputs}, one for each output, found {order}"
        )),
        error => records.refused(&error),
    })?;
    let mut warnings = Vec::new();
    if let Some(orders) = chosen.shortened {
        let (low, high) = (orders.start(), orders.end());
        warnings.push(format!(
            "{} rows bear no order above {high}: --order auto looked at {low}..{high}",
            longest.len()
        ));
    }
    if chosen.orders.is_some() && records.train.len() > 1 {
        warnings.push(format!(
            "orders are compared on the longest of {} records without a break, {} rows",
            records.train.len(),
            longest.len()
        ));
    }
    Ok(Chosen {
        structure: chosen.structure,
        orders: chosen.orders,
        warnings,
    })
}

#[cfg(test)]
mod tests {
    use gtfdi::ident::OrderChoice;

    use super::parse_order;

    #[test]
    fn orders_are_a_number_a_range_or_auto() {
        for (text, order) in [
            ("8", OrderChoice::Given(8)),
            ("1..12", OrderChoice::Search(1..=12)),
            ("2..=4", OrderChoice::Search(2..=4)),
            ("auto", OrderChoice::Automatic),
        ] {
            assert_eq!(parse_order(text).expect(text), order);
        }
        for bad in ["0", "", "-1", "0..3", "3..2", "1..", "x", "1.5"] {
            let error = parse_order(bad).expect_err(bad);
            let text = error.error().to_string();
            assert!(text.ends_with(&format!("found `{bad}`")), "{text}");
        }
    }
}
