//! Identification that is stopped ends: whatever look of it says so, not many more follow.

use std::sync::atomic::{AtomicUsize, Ordering};

use gt_core::{Dataset, Signal, Stop};
use nalgebra::DMatrix;

use crate::eiv::{EivIdentification, EivMethod, eiv_order_table_until};
use crate::frisch::{CriterionKind, frisch_order_table_until};
use crate::{Arx, ArxStructure, IdentError, OrderChoice, OrderKind, ResidualOptions};

/// Stops at the look with this number, and from then on.
struct At(usize, AtomicUsize);

impl Stop for At {
    fn is_stopped(&self) -> bool {
        self.1.fetch_add(1, Ordering::Relaxed) + 1 >= self.0
    }
}

/// Two inputs, two outputs of first order, noise on all: a fixed sequence without a generator.
fn record() -> Dataset {
    let noise = |k: usize, seed: usize| {
        let value = (((k * 7919 + seed * 104_729) % 65_537) as f64 * 12.9898).sin() * 43_758.545;
        value - value.floor() - 0.5
    };
    let n = 600;
    let clean = DMatrix::from_fn(2, n, |row, k| noise(k, row));
    let mut y = DMatrix::<f64>::zeros(2, n);
    for k in 1..n {
        for row in 0..2 {
            y[(row, k)] = 0.7 * y[(row, k - 1)] + clean[(row, k - 1)];
        }
    }
    let u = DMatrix::from_fn(2, n, |row, k| clean[(row, k)] + 0.1 * noise(k, row + 2));
    let y = DMatrix::from_fn(2, n, |row, k| y[(row, k)] + 0.1 * noise(k, row + 4));
    let names = |name: &str| {
        [1, 2]
            .map(|k| Signal::new(format!("{name}{k}"), ""))
            .to_vec()
    };
    Dataset::new(names("u"), names("y"), u, y, 1.0).expect("a record")
}

/// Looks after the one that stops. The searches end by finding no finite value any more: a line
/// search has 40 trials, a minimum along a segment 100, a simplex of two dimensions 500, twice.
const MOST_AFTER: usize = 1200;

fn stops(work: impl Fn(&dyn Stop) -> Option<IdentError>) {
    let never = At(usize::MAX, AtomicUsize::new(0));
    assert_eq!(work(&never), None);
    let all = never.1.into_inner();
    assert!(all > 3, "{all} looks");
    for tenths in [0, 1, 5, 9] {
        let last = 1 + all * tenths / 10;
        let stop = At(last, AtomicUsize::new(0));
        assert_eq!(
            work(&stop),
            Some(gt_core::Stopped.into()),
            "{last} of {all}"
        );
        let looks = stop.1.into_inner();
        assert!(
            looks < last + MOST_AFTER,
            "{looks} looks, {last} of {all} to stop"
        );
    }
}

#[test]
fn errors_in_variables_end_where_they_are_stopped() {
    let data = record();
    for method in [
        EivMethod::default(),
        EivMethod::Frisch(CriterionKind::YuleWalker),
    ] {
        let wish = EivIdentification::new(OrderChoice::Given(2)).method(method);
        stops(|stop| wish.identify_until(&data, stop).err());
    }
}

#[test]
fn tables_of_orders_end_where_they_are_stopped() {
    let data = record();
    stops(|stop| eiv_order_table_until(&data, 1..=2, &[1, 1], stop).err());
    stops(|stop| frisch_order_table_until(&data, 0, 1..=2, &[1, 1], stop).err());
}

#[test]
fn tests_of_residuals_end_where_they_are_stopped() {
    let data = record();
    let kind = OrderKind::Diagonal { nk: vec![1, 1] };
    let structure: ArxStructure = kind.structure(1, 2).expect("a structure");
    let model = Arx::new(structure).fit(&data).expect("a model");
    let options = ResidualOptions::for_residuals(599);
    stops(|stop| crate::test_residuals_until(&model, &data, &options, stop).err());
}
