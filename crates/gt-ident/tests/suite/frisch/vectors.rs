//! The exact covariances of two systems, and 500 samples of each.

use gt_ident::Channel;
use gt_ident::frisch::{AdmissibleSurface, Criterion, Frisch, FrischEstimate, LaggedCovariance};

use super::systems::{Vector, dataset};

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

/// The reference estimates on 500 samples took raw samples, another scaling and a grid that ends
/// before the boundary. Removing means moves an estimate by a part of its standard error, which is
/// itself 2 to 4 times the bound: coefficients agree to one bound, variances to two.
#[test]
fn published_estimates_on_500_samples() {
    let criteria = [
        ("F-SR", Criterion::ShiftRelation),
        ("F-CM", MATCH),
        ("F-YW", YULE_WALKER),
    ];
    for vector in [Vector::s1(), Vector::m1()] {
        let record = vector.record();
        let bound = vector.numbers("crlb_std_semi_N500");
        for (name, criterion) in criteria {
            let frisch = Frisch::new(vector.lags()).criterion(criterion);
            let found = frisch.fit(&record, 0).unwrap();
            let numbers = all_numbers(&found);
            let listed = vector.result(name);
            let pairs = numbers.iter().zip(&listed).zip(&bound);
            let errors: Vec<f64> = pairs.map(|((a, b), bound)| (a - b).abs() / bound).collect();
            println!("{name}: errors over the bound {errors:.2?}");
            let coefficients = found.row.theta().len();
            assert!(
                errors[..coefficients].iter().all(|error| *error < 1.0),
                "{errors:?}"
            );
            assert!(
                errors[coefficients..].iter().all(|error| *error < 2.0),
                "{errors:?}"
            );
            assert_eq!(found.window_rows, 500 - criterion.max_lag(2));
        }
    }
}

/// On the sample covariance of the file the listed variances are points of the surface, with the
/// listed relation: 1e-6, the listed points are intersections to 7 digits.
#[test]
fn published_estimates_lie_on_the_sample_surface() {
    for vector in [Vector::s1(), Vector::m1()] {
        let sigma = vector.matrix("sample_Sigma_n");
        let surface = AdmissibleSurface::of_covariance(&vector.lags(), &sigma).unwrap();
        for name in ["F-SR", "F-CM", "F-YW"] {
            let listed = vector.result(name);
            let (theta, variances) = listed.split_at(vector.lags().parameters());
            let point = surface.along(variances).unwrap();
            let row = point.row(&vector.lags()).unwrap();
            assert_near(row.theta().as_slice(), theta, 1e-6, name);
            assert_near(&point.variances, variances, 1e-6, name);
        }
    }
}

/// Shift relation and covariance match end at no noise on the input of S1.
#[test]
fn published_boundary_solutions_are_reported() {
    let vector = Vector::s1();
    for (criterion, boundary) in [
        (Criterion::ShiftRelation, vec![Channel::Input(0)]),
        (MATCH, vec![Channel::Input(0)]),
        (YULE_WALKER, vec![]),
    ] {
        let frisch = Frisch::new(vector.lags()).criterion(criterion);
        let found = frisch.fit(&vector.record(), 0).unwrap();
        assert_eq!(found.boundary(), boundary);
        for noise in &found.channels {
            assert!(!noise.at_boundary || !noise.is_identifiable());
            assert!(noise.variance <= noise.largest * (1.0 + 1e-12));
        }
    }
}

/// Channels in units that are powers of two give the same estimate in those units, exactly.
#[test]
fn units_do_not_matter() {
    let vector = Vector::m1();
    let record = vector.record();
    let mut u = record.u().clone();
    for (mut row, unit) in u.row_iter_mut().zip([2.0_f64.powi(40), 0.25]) {
        row *= unit;
    }
    let scaled = dataset(u, record.y() * 2.0_f64.powi(-30));
    let frisch = Frisch::new(vector.lags());
    let (one, other) = (
        frisch.fit(&record, 0).unwrap(),
        frisch.fit(&scaled, 0).unwrap(),
    );
    assert_eq!(one.row.a(), other.row.a());
    for (a, b) in one.row.b(0).iter().zip(other.row.b(0)) {
        assert_eq!(*a, b * 2.0_f64.powi(70));
    }
    for (a, b) in one.row.b(1).iter().zip(other.row.b(1)) {
        assert_eq!(*a, b * 2.0_f64.powi(28));
    }
    assert_eq!(one.noise.output, other.noise.output * 2.0_f64.powi(60));
    assert_eq!(
        one.noise.inputs[0],
        other.noise.inputs[0] * 2.0_f64.powi(-80)
    );
}
