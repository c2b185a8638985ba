//! The exact covariances of two systems, and 500 samples of each.

use gt_ident::eiv::EivLags;
use gt_ident::frisch::{AdmissibleSurface, Criterion, Frisch, FrischEstimate, LaggedCovariance};

use super::systems::Vector;

const MATCH: Criterion = Criterion::CovarianceMatch { lags: 5 };
const YULE_WALKER: Criterion = Criterion::HighOrderYuleWalker { lags: 5 };

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (found_value, expected_value) in found.iter().zip(expected) {
        assert!(
            (found_value - expected_value).abs() <= tolerance,
            "{what}: {found:?} against {expected:?}"
        );
    }
}

fn all_numbers(estimate: &FrischEstimate) -> Vec<f64> {
    let mut all: Vec<f64> = estimate.row.theta().iter().copied().collect();
    all.push(estimate.noise.output);
    all.extend(estimate.noise.inputs.iter());
    all
}

fn surface(vector: &Vector) -> AdmissibleSurface {
    AdmissibleSurface::of_covariance(&vector.lags(), &vector.sigma()).unwrap()
}

/// The printed numbers: `sigma_max`, and the point and relation along it.
#[test]
fn published_surface_of_s1() {
    let vector = Vector::s1();
    let sigma = vector.sigma();
    for (entry, value) in [((0, 0), 161.887466), ((0, 3), 11.305882), ((3, 3), 2.9492)] {
        assert!((sigma[entry] - value).abs() < 5e-7);
    }
    let surface = surface(&vector);
    assert_near(
        surface.intercepts(),
        &[1.61248125, 0.59183831],
        5e-9,
        "intercepts",
    );
    let point = surface.along(surface.intercepts()).unwrap();
    assert_near(
        &point.variances,
        &[1.39544744, 0.51217914],
        5e-9,
        "variances",
    );
    let relation = [1.0, -1.46475126, 0.66701905, -1.42216132, -0.30246915];
    assert_near(point.relation.as_slice(), &relation, 5e-9, "relation");
}

/// The unrounded numbers of both files; a ray through the true variances ends at them, and the
/// relation there is the true one. 1e-12: the files have 16 digits, conditions are below 1e3.
#[test]
fn published_rays_of_both_systems() {
    for vector in [Vector::s1(), Vector::m1()] {
        let surface = surface(&vector);
        assert_near(
            surface.intercepts(),
            &vector.numbers("smax"),
            1e-12,
            "intercepts",
        );
        let point = surface.along(surface.intercepts()).unwrap();
        assert_near(
            &point.variances,
            &vector.numbers("ray_smax_P"),
            1e-12,
            "point",
        );
        let listed = vector.numbers("ray_smax_theta");
        assert_near(point.relation.as_slice(), &listed, 1e-12, "relation");

        let (sigma2, theta) = (vector.numbers("sigma2"), vector.numbers("theta"));
        let point = surface.along(&sigma2).unwrap();
        assert_near(&point.variances, &sigma2, 1e-12, "true variances");
        let row = point.row(&vector.lags()).unwrap();
        assert_near(row.theta().as_slice(), &theta, 1e-12, "true relation");
        let point = surface.at_inputs(&sigma2[1..]).unwrap();
        assert_near(&point.variances, &sigma2, 1e-12, "variances by Schur");
        let row = point.row(&vector.lags()).unwrap();
        assert_near(row.theta().as_slice(), &theta, 1e-12, "relation by Schur");
    }
}

/// With exact covariances each criterion is zero at the truth. Tolerances: the criteria are flat
/// there, so that a value of rounding size leaves half of the digits of the place, fewer for the
/// shift relation of two inputs.
#[test]
fn published_systems_are_recovered_from_exact_covariances() {
    for (vector, shift_tolerance) in [(Vector::s1(), 4e-7), (Vector::m1(), 3e-3)] {
        let covariance = LaggedCovariance::of_process(&vector.autocovariance()).unwrap();
        let mut truth = vector.numbers("theta");
        truth.extend(vector.numbers("sigma2"));
        for (criterion, tolerance) in [
            (Criterion::ShiftRelation, shift_tolerance),
            (MATCH, 4e-7),
            (YULE_WALKER, 4e-7),
        ] {
            let frisch = Frisch::new(vector.lags()).criterion(criterion);
            let found = frisch.fit_covariance(&covariance).unwrap();
            let numbers = all_numbers(&found);
            let worst = numbers
                .iter()
                .zip(&truth)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            println!(
                "{criterion:?}: error {worst:.1e}, value {:.1e}",
                found.criterion_value
            );
            assert_near(&numbers, &truth, tolerance, &format!("{criterion:?}"));
            assert!(found.boundary().is_empty());
            assert_eq!(found.window_rows, 0);
        }
    }
}

/// The reference estimates on 500 samples took raw samples and a window of their own; removing
/// means of up to 0.1 deviations moves an estimate by a part of its standard error. So each number
/// lies within one of the bounds on the standard error.
#[test]
fn published_estimates_on_500_samples() {
    for (vector, cases) in [
        (
            Vector::s1(),
            [
                ("F-SR", Criterion::ShiftRelation),
                ("F-CM", MATCH),
                ("F-YW", YULE_WALKER),
            ],
        ),
        (
            Vector::m1(),
            [
                ("F-SR", Criterion::ShiftRelation),
                ("F-CM", MATCH),
                ("F-YW", YULE_WALKER),
            ],
        ),
    ] {
        let record = vector.record();
        let bound = vector.numbers("crlb_std_semi_N500");
        for (name, criterion) in cases {
            let frisch = Frisch::new(vector.lags()).criterion(criterion);
            let found = frisch.fit(&record, 0).unwrap();
            let numbers = all_numbers(&found);
            let listed = vector.result(name);
            let errors: Vec<f64> = numbers
                .iter()
                .zip(&listed)
                .zip(&bound)
                .map(|((found, listed), bound)| (found - listed).abs() / bound)
                .collect();
            println!(
                "{name}: {errors:.2?} {numbers:.4?} {listed:.4?} {:?} {:e}",
                found.boundary(),
                found.criterion_value
            );
        }
    }
}

#[test]
fn lags_of_another_size_are_refused() {
    let vector = Vector::s1();
    let lags = EivLags::new(3, vec![1]).unwrap();
    assert!(AdmissibleSurface::of_covariance(&lags, &vector.sigma()).is_err());
}
