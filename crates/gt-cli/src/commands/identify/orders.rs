//! Where the comparison of orders is drawn.

use std::path::Path;

use gt_campaign::reports::OrderComparison;
use gt_log::write_atomically;

use crate::failure::Failure;

/// Writes the criteria as a chart.
pub fn plot(orders: &OrderComparison, path: &Path) -> Result<(), Failure> {
    write_atomically(path, orders.svg().as_bytes()).map_err(Failure::failed)
}

/// Refuses `--plot` where there will be nothing to draw.
pub fn check_plot(path: &Path, orders: Option<&str>) -> Result<(), Failure> {
    let is_svg = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
    if !is_svg {
        return Err(Failure::input(format!(
            "--plot: expected a file that ends in .svg, found {}",
            path.display()
        )));
    }
    match orders {
        Some(orders) if orders.parse::<usize>().is_err() => Ok(()),
        found => Err(Failure::input(format!(
            "--plot: expected orders to compare, --order auto or a range such as 1..12, found {}",
            found.map_or_else(
                || "no --order".to_owned(),
                |order| format!("--order {order}")
            )
        ))),
    }
}
