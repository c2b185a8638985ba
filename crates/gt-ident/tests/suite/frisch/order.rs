//! The order from the admissible surfaces.

use gt_ident::eiv::EivLags;
use gt_ident::frisch::{AdmissibleSurface, LaggedCovariance, frisch_order_table};

use super::systems::Vector;

/// With exact covariances the surfaces of the true order and of the next touch at the true
/// variances; elsewhere the next lies below. 1e-9: the touching eigenvalue of order 3 is double.
#[test]
fn published_surfaces_touch_at_the_truth() {
    for vector in [Vector::s1(), Vector::m1()] {
        let covariance = LaggedCovariance::of_process(&vector.autocovariance()).unwrap();
        let scaled: Vec<f64> = vector
            .numbers("sigma2")
            .iter()
            .zip(covariance.scales())
            .map(|(variance, scale)| variance / scale.powi(2))
            .collect();
        let surfaces: Vec<AdmissibleSurface> = (1..=3)
            .map(|order| {
                let lags = EivLags::new(order, vec![1; covariance.inputs()]).unwrap();
                AdmissibleSurface::new(&lags, &covariance).unwrap()
            })
            .collect();
        let part = |surface: &AdmissibleSurface, direction: &[f64]| {
            surface.along(direction).unwrap().variances[0] / direction[0]
        };
        let along_truth: Vec<f64> = surfaces.iter().map(|s| part(s, &scaled)).collect();
        assert!(along_truth[0] > 1.1, "{along_truth:?}");
        assert!((along_truth[1] - 1.0).abs() < 1e-9 && (along_truth[2] - 1.0).abs() < 1e-9);
        let elsewhere = surfaces[0].intercepts();
        assert!(part(&surfaces[2], elsewhere) < 0.9 * part(&surfaces[1], elsewhere));
    }
}

/// The true order is 2. The surface of the next order lies close below it, far below before it
/// (sample covariances: a few per cent of their distance to the origin).
#[test]
fn the_order_of_simulated_systems_is_found() {
    const RUNS: u64 = 20;
    let mut right = 0;
    for (vector, before) in [(Vector::s1(), 0.4), (Vector::m1(), 0.1)] {
        let mut gaps = [0.0; 4];
        for run in 0..RUNS {
            let record = vector.simulate(run, 500);
            let table = frisch_order_table(&record, 0, 1..=3, vector.lags().nk()).unwrap();
            // Lags up to 3 + 5.
            assert_eq!(table.window_rows, 492);
            right += u32::from(table.best() == Some(2));
            for row in &table.rows {
                gaps[row.order] += row.surface_gap / RUNS as f64;
            }
            let ranks: Vec<f64> = table.rows.iter().map(|row| row.rank_ratio).collect();
            assert!(ranks[1] < 0.5 * ranks[0], "{ranks:?}");
        }
        println!("mean gaps of orders 1 to 3: {:.4?}", &gaps[1..]);
        assert!(gaps[1] > before && gaps[2] < 0.05, "{gaps:?}");
    }
    println!("right in {right} of 40");
    assert!(right >= 36, "right in {right} of 40");
}

/// Every order uses the same moments of the same window, and the statistic falls with the order.
#[test]
fn orders_share_one_window() {
    let vector = Vector::s1();
    let table = frisch_order_table(&vector.record(), 0, 2..=3, &[1]).unwrap();
    assert_eq!(table.window_rows, 492);
    let degrees: Vec<usize> = table
        .rows
        .iter()
        .map(|row| row.degrees_of_freedom)
        .collect();
    // Two channels at 9 lags less 2 n + 2 unknowns.
    assert_eq!(degrees, [12, 10]);
    for row in &table.rows {
        let statistic = row.statistic.unwrap();
        let expected = statistic - row.degrees_of_freedom as f64 * 492.0_f64.ln();
        assert!((row.selection.unwrap() - expected).abs() < 1e-9);
    }
}
