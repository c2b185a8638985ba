//! The bound on what any observer could reach.

use gt_fdi::design::{Criterion, EnergyRatio, PoleSearch, RecordPair, Sections};
use nalgebra::{Cholesky, Complex, DMatrix};

use crate::toys::{Fault, Toy, changed};

/// Few starts: the bound does not depend on them.
fn search(criterion: Criterion, pole: f64, functions: usize) -> PoleSearch {
    PoleSearch {
        criterion,
        diagonal_starts: 1,
        random_starts: 0,
        bound_pole: pole,
        bound_functions: functions,
        ..PoleSearch::default()
    }
}

/// Observers with poles at the functions' pole and at 0 lie in the span, as many at the pole as
/// there are functions: none of them is below the bound, with four functions or more.
#[test]
fn no_observer_in_the_span_is_below_the_bound() {
    for fault in [Fault::Ramp(1.0), Fault::Component(0.02)] {
        let toy = Toy::new(&[0.95, 0.8, 0.5, 0.2], fault);
        let records = toy.records(3, 500);
        for criterion in [Criterion::Paper, Criterion::FaultEnergy] {
            let point = Toy::point();
            let ratio =
                EnergyRatio::new(criterion, &toy.model, &point, &[records.pair()], 0).unwrap();
            for pole in [-0.5, 0.3, 0.9, 0.97] {
                for functions in [4, 8, 16] {
                    let design = search(criterion, pole, functions)
                        .design(&toy.model, &point, &[records.pair()], &[])
                        .unwrap();
                    assert_eq!(design.bound.validation, None);
                    assert_eq!(design.bound.weights.len(), 4 + functions + 1);
                    assert!(design.bound.value <= design.v * (1.0 + 1e-9));
                    for at_pole in 0..=4 {
                        let poles: Vec<Complex<f64>> = (0..4)
                            .map(|k| Complex::new(if k < at_pole { pole } else { 0.0 }, 0.0))
                            .collect();
                        let v = ratio.value(&Sections::from_poles(&poles).unwrap());
                        // Rounding of Laguerre functions of up to sixteen sections.
                        assert!(
                            design.bound.value <= v * (1.0 + 1e-9),
                            "{criterion:?}, {pole}, {functions}: {} {v}",
                            design.bound.value
                        );
                    }
                }
            }
        }
    }
}

/// Against the Gram matrices of `z^-k eps / (P (1 - p z^-1)^2)`, `k = 0..3`, and their generalised
/// eigenvalues by a Cholesky factor: the same span in another basis.
#[test]
fn bound_is_the_generalised_eigenvalue_in_another_basis() {
    let toy = Toy::new(&[0.6], Fault::Ramp(0.5));
    let (records, others) = (toy.records(5, 300), toy.records(6, 300));
    let pole = 0.4;
    let design = search(Criterion::FaultEnergy, pole, 2)
        .design(
            &toy.model,
            &Toy::point(),
            &[records.pair()],
            &[others.pair()],
        )
        .unwrap();
    let placed = design.poles[0].re;
    let gram = |signal: &dyn Fn(&RecordPair, usize) -> (f64, f64)| {
        let mut eps: Vec<f64> = Vec::new();
        let pair = records.pair();
        let (mut y_last, mut u_last) = (0.0, 0.0);
        for t in 0..300 {
            let (u, y) = signal(&pair, t);
            eps.push(y - 0.6 * y_last - u_last);
            (y_last, u_last) = (y, u);
        }
        for root in [placed, pole, pole] {
            let mut last = 0.0;
            for value in &mut eps {
                *value += root * last;
                last = *value;
            }
        }
        let delayed = |t: usize, k: usize| if t >= k { eps[t - k] } else { 0.0 };
        DMatrix::from_fn(4, 4, |i, j| {
            (0..300).map(|t| delayed(t, i) * delayed(t, j)).sum::<f64>()
        })
    };
    let healthy = gram(&|pair, t| (pair.healthy.u()[(0, t)], pair.healthy.y()[(0, t)]));
    let effect = gram(&|pair, t| {
        let of = |data: &gt_core::Dataset| (data.u()[(0, t)], data.y()[(0, t)]);
        let ((u_f, y_f), (u_h, y_h)) = (of(pair.faulty), of(pair.healthy));
        (u_f - u_h, y_f - y_h)
    });
    let factor = Cholesky::new(healthy).unwrap().l();
    let half = factor.solve_lower_triangular(&effect).unwrap();
    let square = factor.solve_lower_triangular(&half.transpose()).unwrap();
    let expected = 1.0 / square.symmetric_eigenvalues().max();
    // The condition of the Gram matrices is about 1e4.
    let found = design.bound.value;
    assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected}");
    let validation = design.bound.validation.unwrap();
    // Of a ramp in the same noise, it is of the same size and above the least there is.
    assert!(
        validation > 0.3 * found && validation < 3.0 * found,
        "{validation} {found}"
    );
    assert!(found <= design.v);
}

/// A healthy equation error of one impulse five samples before the end: of ten functions no more
/// than five are independent there, so some filter leaves none of it.
#[test]
fn records_that_a_filter_silences_have_the_bound_zero() {
    let toy = Toy::new(&[0.0], Fault::Bias(1.0));
    let records = toy.records(1, 60);
    let silent = changed(records.pair().healthy, |u, y| {
        u.fill(0.0);
        y.fill(0.0);
        y[(0, 55)] = 1.0;
    });
    let faulty = changed(&silent, |_, y| y[(0, 10)] = 1.0);
    let pair = RecordPair {
        healthy: &silent,
        faulty: &faulty,
    };
    let design = search(Criterion::FaultEnergy, 0.9, 8)
        .design(&toy.model, &Toy::point(), &[pair], &[])
        .unwrap();
    assert_eq!(design.bound.value, 0.0);
}
