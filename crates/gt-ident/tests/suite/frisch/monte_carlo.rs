//! Errors over simulated records.

use gt_ident::frisch::{Criterion, Frisch};
use gt_ident::{Arx, ArxStructure};

use super::systems::Vector;

#[test]
fn published_ratio_to_the_bound() {
    let vector = Vector::s1();
    let truth = vector.numbers("theta");
    let bound: Vec<f64> = vector
        .numbers("crlb_std_semi_N500")
        .iter()
        .map(|b| b / 2.0)
        .collect();
    for (criterion, listed) in [
        (Criterion::ShiftRelation, 2.60),
        (Criterion::CovarianceMatch { lags: 5 }, 2.93),
        (Criterion::HighOrderYuleWalker { lags: 5 }, 1.87),
    ] {
        let frisch = Frisch::new(vector.lags()).criterion(criterion);
        for runs in [50, 100, 200] {
            let start = std::time::Instant::now();
            let mut square = vec![0.0; truth.len()];
            for run in 0..runs {
                let found = frisch.fit(&vector.simulate(run, 2000), 0).unwrap();
                for (sum, (a, b)) in square.iter_mut().zip(found.row.theta().iter().zip(&truth)) {
                    *sum += (a - b).powi(2) / runs as f64;
                }
            }
            let ratio: f64 = square
                .iter()
                .zip(&bound)
                .map(|(s, b)| (s.sqrt() / b).ln())
                .sum::<f64>()
                / truth.len() as f64;
            println!(
                "{criterion:?} {runs}: {:.3} ({listed}) {:?}",
                ratio.exp(),
                start.elapsed()
            );
        }
    }
}
