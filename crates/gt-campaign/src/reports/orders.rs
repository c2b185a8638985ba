//! The comparison of orders: a table, a reason and a chart.

use gtfdi::ident::eiv::EivOrderTable;
use gtfdi::ident::{CONDITION_LIMIT, OrderTable};
use serde::Serialize;

use super::model::Orders;
use crate::report::Figure;
use crate::report::chart::{Chart, Mark, Series};
use crate::report::text::{digits, table};

/// What the orders were compared by.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum OrderComparison {
    /// Least squares.
    Arx(OrderTable),
    /// Errors in variables, by maximum likelihood.
    Eiv(EivOrderTable),
}

/// The criterion that chooses at one order, and the more generous one beside it.
struct Point {
    order: usize,
    chooses: f64,
    generous: f64,
    usable: bool,
}

impl OrderComparison {
    /// The order that is taken.
    fn best(&self) -> usize {
        match self {
            Self::Arx(orders) => orders.best_mdl(),
            Self::Eiv(orders) => orders.best_bic(),
        }
    }

    /// The criterion that chooses, as sentences and legends have it.
    fn criterion(&self) -> [&'static str; 2] {
        match self {
            Self::Arx(_) => ["MDL", "MDL"],
            Self::Eiv(_) => ["the likelihood's BIC", "BIC"],
        }
    }

    fn points(&self) -> Vec<Point> {
        match self {
            Self::Arx(orders) => {
                let rows = orders.rows.iter();
                rows.map(|row| Point {
                    order: row.order,
                    chooses: row.mdl,
                    generous: row.aic,
                    usable: row.condition <= CONDITION_LIMIT,
                })
                .collect()
            }
            Self::Eiv(orders) => {
                let rows = orders.rows.iter();
                rows.map(|row| Point {
                    order: row.order,
                    chooses: row.bic,
                    generous: row.aic,
                    usable: true,
                })
                .collect()
            }
        }
    }

    /// Why the order was taken, in a sentence.
    pub fn reason(&self) -> String {
        let best = self.best();
        let points = self.points();
        let value = points.iter().find(|point| point.order == best);
        let others = points
            .iter()
            .filter(|point| point.usable && point.order != best);
        let next = others.min_by(|a, b| a.chooses.total_cmp(&b.chooses));
        let [criterion, _] = self.criterion();
        let margin = match (value, next) {
            (Some(value), Some(next)) if (next.chooses - value.chooses).is_finite() => format!(
                "{:.1} below order {}, the next best",
                next.chooses - value.chooses,
                next.order
            ),
            (_, Some(next)) => format!("beside order {} without a finite difference", next.order),
            (_, None) => "the only one that can be fitted".to_owned(),
        };
        let others = match self {
            Self::Arx(orders) => format!(
                "AIC would take order {}, FPE order {}",
                orders.best_aic(),
                orders.best_fpe()
            ),
            Self::Eiv(orders) => format!("AIC would take order {}", orders.best_aic()),
        };
        format!("chosen by {criterion}: order {best}, {margin}; {others}")
    }

    /// The criteria as a table.
    pub fn text(&self) -> String {
        let (head, rows) = self.cells();
        table(head, &rows)
    }

    fn cells(&self) -> (&'static [&'static str], Vec<Vec<String>>) {
        match self {
            Self::Arx(orders) => (
                &["order", "parameters", "AIC", "MDL", "FPE", "PPCRE %"],
                arx_rows(orders),
            ),
            Self::Eiv(orders) => (&["order", "parameters", "AIC", "BIC"], eiv_rows(orders)),
        }
    }

    /// The criteria as a chart by itself, an SVG.
    pub fn svg(&self) -> String {
        self.chart().stand_alone()
    }

    /// The comparison as a report shows it.
    pub fn shown(&self) -> Orders {
        let (head, rows) = self.cells();
        Orders {
            figure: Figure::new(
                self.chart(),
                "Criteria over the order: the lower the better.",
            ),
            head: head.iter().map(|&own| own.to_owned()).collect(),
            rows,
            reason: self.reason(),
        }
    }

    fn chart(&self) -> Chart {
        let [criterion, legend] = self.criterion();
        let points: Vec<Point> = self.points();
        // An order that cannot be fitted is a gap.
        let values = |value: fn(&Point) -> f64| -> Vec<f64> {
            points
                .iter()
                .map(|point| if point.usable { value(point) } else { f64::NAN })
                .collect()
        };
        Chart {
            id: "orders".to_owned(),
            title: format!("Order {} chosen by {criterion}", self.best()),
            x_label: "order".to_owned(),
            y_label: "criterion".to_owned(),
            x: points.iter().map(|point| point.order as f64).collect(),
            series: vec![
                Series::line(legend, values(|point| point.chooses)),
                Series::dashed("AIC", values(|point| point.generous)),
            ],
            marks: vec![Mark {
                at: self.best() as f64,
                label: format!("order {}", self.best()),
            }],
            ..Chart::default()
        }
    }
}

fn arx_rows(orders: &OrderTable) -> Vec<Vec<String>> {
    let rows = orders.rows.iter().map(|row| {
        let criteria = [row.aic, row.mdl].map(|value| format!("{value:.1}"));
        let errors = [row.fpe, row.ppcre_percent].map(|value| digits(value, 4));
        order_cells(
            row.order,
            row.parameters,
            criteria.into_iter().chain(errors),
        )
    });
    rows.collect()
}

fn eiv_rows(orders: &EivOrderTable) -> Vec<Vec<String>> {
    let rows = orders.rows.iter().map(|row| {
        let criteria = [row.aic, row.bic].map(|value| format!("{value:.1}"));
        order_cells(row.order, row.parameters, criteria.into_iter())
    });
    rows.collect()
}

/// A row of a table of orders.
fn order_cells(
    order: usize,
    parameters: usize,
    criteria: impl Iterator<Item = String>,
) -> Vec<String> {
    let counts = [order, parameters].map(|count| count.to_string());
    counts.into_iter().chain(criteria).collect()
}
