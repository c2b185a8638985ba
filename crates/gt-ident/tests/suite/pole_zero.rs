//! Poles and zeros with their errors, and the report on a realisation.

use gt_core::StateSpace;
use gt_ident::pole_zero::{PoleZeroReport, Root, invariant_zeros, pole_zero};
use gt_ident::{
    Arx, ArxModel, CanonicalForm, Estimate, RealisationWarning, parameter_covariance,
    realisation_report,
};
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;

use crate::common::*;
use crate::known::*;

fn space(a: DMatrix<f64>, b: DMatrix<f64>, c: DMatrix<f64>, d: DMatrix<f64>) -> StateSpace {
    let (inputs, outputs) = (signals("u", b.ncols()), signals("y", c.nrows()));
    StateSpace::new([a, b, c, d], 1.0, inputs, outputs).unwrap()
}

/// The largest distance of any of `left` from the nearest of `right`; the counts must agree.
fn distance(left: &[Complex<f64>], right: &[Complex<f64>]) -> f64 {
    assert_eq!(left.len(), right.len(), "{left:?} and {right:?}");
    let nearest = |one: &Complex<f64>| {
        let all = right.iter().map(|other| (one - other).norm());
        all.fold(f64::INFINITY, f64::min)
    };
    left.iter().map(nearest).fold(0.0, f64::max)
}

/// The example of the SLICOT routine AB08ND: three outputs, two inputs, zeros at 2 and -1.
#[test]
fn published_invariant_zeros_of_slicot_ab08nd() {
    let a = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![
        1.0, 1.0, 3.0, -4.0, -1.0, 3.0,
    ]));
    let b = DMatrix::from_row_slice(
        6,
        2,
        &[
            0.0, -1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, 1.0, -1.0, -1.0,
        ],
    );
    let c = DMatrix::from_row_slice(
        3,
        6,
        &[
            1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0,
            1.0,
        ],
    );
    let zeros = invariant_zeros(&space(a, b, c, DMatrix::zeros(3, 2))).unwrap();
    let expected = [Complex::new(2.0, 0.0), Complex::new(-1.0, 0.0)];
    assert!(distance(&zeros, &expected) < 1e-9, "{zeros:?}");
}

/// `A - B D^-1 C` has the zeros of a system with an invertible direct term; one without any way
/// from its inputs to its outputs has none, nor has a chain of delays.
#[test]
fn invariant_zeros_of_simple_systems() {
    let mut rng = generator(2);
    let (a, b) = (normal_matrix(&mut rng, 4, 4), normal_matrix(&mut rng, 4, 2));
    let (c, d) = (normal_matrix(&mut rng, 2, 4), normal_matrix(&mut rng, 2, 2));
    let closed = &a - &b * d.clone().try_inverse().unwrap() * &c;
    let expected: Vec<_> = closed.complex_eigenvalues().iter().copied().collect();
    let zeros = invariant_zeros(&space(a.clone(), b.clone(), c, d)).unwrap();
    assert!(distance(&zeros, &expected) < 1e-9);
    let silent = space(a, b, DMatrix::zeros(2, 4), DMatrix::zeros(2, 2));
    assert_eq!(invariant_zeros(&silent).unwrap(), vec![]);
    let mut shift = DMatrix::zeros(5, 5);
    shift.view_mut((0, 1), (4, 4)).fill_with_identity();
    let mut last = DMatrix::zeros(5, 1);
    last[4] = 1.0;
    let chain = space(
        shift,
        last.clone(),
        DMatrix::identity(1, 5),
        DMatrix::zeros(1, 1),
    );
    assert_eq!(invariant_zeros(&chain).unwrap(), vec![]);
    let gain = DMatrix::from_element(1, 1, 2.0);
    let none = DMatrix::zeros(0, 0);
    let fixed = space(none, DMatrix::zeros(0, 1), DMatrix::zeros(1, 0), gain);
    assert_eq!(invariant_zeros(&fixed).unwrap(), vec![]);
}

proptest! {
    #![proptest_config(cases(100))]

    /// A single-input single-output canonical form has the roots of `Q` as zeros, and state
    /// feedback or other coordinates do not move them. Roots are drawn at least 0.1 apart on
    /// circles, which keeps their condition below 1e6.
    #[test]
    fn prop_invariant_zeros_are_the_roots_of_the_numerator(
        n in 2_usize..6, less in 1_usize..3, seed: u64, direct: bool,
    ) {
        let mut rng = generator(seed);
        let less = less.min(n);
        let roots: Vec<f64> = (0..n - usize::from(!direct))
            .skip(less - 1)
            .enumerate()
            .map(|(index, _)| 0.9 - 0.35 * index as f64)
            .collect();
        // Ascending powers, padded with zeros.
        let mut q = vec![1.0];
        for root in &roots {
            q = (0..=q.len())
                .map(|k| {
                    let shifted = if k > 0 { q[k - 1] } else { 0.0 };
                    shifted - root * q.get(k).copied().unwrap_or(0.0)
                })
                .collect();
        }
        q.resize(n + usize::from(direct), 0.0);
        let alpha: Vec<f64> = normal_matrix(&mut rng, 1, n).iter().map(|a| 0.3 * a).collect();
        let beta = q.iter().map(|&value| vec![value]).collect();
        let form = CanonicalForm::new(vec![n], vec![vec![alpha]], vec![beta]).unwrap();
        let model = state_space(&form);
        let expected: Vec<_> = roots.iter().map(|&root| Complex::new(root, 0.0)).collect();
        let zeros = invariant_zeros(&model).unwrap();
        prop_assert!(distance(&zeros, &expected) < 1e-6);
        let turn = normal_matrix(&mut rng, n, n).qr().q();
        let feedback = normal_matrix(&mut rng, 1, n);
        let (a, c) = (model.a() + model.b() * &feedback, model.c() + model.d() * &feedback);
        let moved = space(
            turn.tr_mul(&a) * &turn, turn.tr_mul(model.b()), c * &turn, model.d().clone(),
        );
        prop_assert!(distance(&invariant_zeros(&moved).unwrap(), &expected) < 1e-6);
    }

    /// At a zero the Rosenbrock matrix of a square system loses rank, and a system of `n` states
    /// and `m` channels with `C B` invertible has `n - m` of them.
    #[test]
    fn prop_rosenbrock_matrix_is_singular_at_invariant_zeros(n in 2_usize..7, seed: u64) {
        let mut rng = generator(seed);
        let (a, b) = (normal_matrix(&mut rng, n, n), normal_matrix(&mut rng, n, 2));
        let c = normal_matrix(&mut rng, 2, n);
        let product = (&c * &b).singular_values();
        prop_assume!(product.min() > 1e-2);
        let zeros = invariant_zeros(&space(a.clone(), b.clone(), c.clone(), DMatrix::zeros(2, 2)));
        let zeros = zeros.unwrap();
        prop_assert_eq!(zeros.len(), n - 2);
        for zero in zeros {
            let mut pencil = DMatrix::zeros(n + 2, n + 2);
            let complex = |matrix: &DMatrix<f64>| matrix.map(|value| Complex::new(value, 0.0));
            let shifted = complex(&a) - DMatrix::identity(n, n) * zero;
            pencil.view_mut((0, 0), (n, n)).copy_from(&shifted);
            pencil.view_mut((0, n), (n, 2)).copy_from(&complex(&b));
            pencil.view_mut((n, 0), (2, n)).copy_from(&complex(&c));
            let values = pencil.singular_values();
            prop_assert!(values.min() < 1e-9 * values.max(), "{:e}", values.min());
        }
    }
}

fn poles(report: &PoleZeroReport) -> Vec<Complex<f64>> {
    report.poles.iter().map(|pole| pole.root.value).collect()
}

fn no_errors(model: &ArxModel) -> Vec<DMatrix<f64>> {
    let sizes = model.rows().iter().map(|row| row.terms.len());
    sizes
        .map(|size| DMatrix::identity(size, size) * 1e-20)
        .collect()
}

/// Poles 0.9 and 0.5 +- 0.3i of one output, 0.8 and 0 of the other (a coefficient of 0), zeros
/// -0.5 and none.
#[test]
fn poles_and_zeros_of_known_rows() {
    let first = [1.9, -1.24, 0.306, 1.0, 0.5];
    let second = [0.8, 0.0, 0.0, 2.0, 0.0];
    let model = known_model(diagonal(3, 2), 1, &[&first, &second], 100);
    let report = pole_zero(&model, &no_errors(&model)).unwrap();
    let expected = [
        Complex::new(0.9, 0.0),
        Complex::new(0.5, 0.3),
        Complex::new(0.5, -0.3),
        Complex::new(0.8, 0.0),
    ];
    assert!(distance(&poles(&report), &expected) < 1e-12);
    assert_eq!(
        report
            .poles
            .iter()
            .map(|pole| pole.output)
            .collect::<Vec<_>>(),
        [Some(0), Some(0), Some(0), Some(1)]
    );
    let values = |index: usize| -> Vec<Complex<f64>> {
        report.channels[index]
            .zeros
            .iter()
            .map(|zero| zero.value)
            .collect()
    };
    let origin = Complex::new(0.0, 0.0);
    // z^3 P and z^3 Q: one zero at the origin beside the root of Q.
    assert!(distance(&values(0), &[Complex::new(-0.5, 0.0), origin]) < 1e-12);
    assert_eq!(values(1), vec![origin]);
    assert!(report.superfluous_poles.is_empty());
    // At 0.9 and 0.5 s a sample: 4.7 s; at 0.5 + 0.3i: |ln z| = sqrt(.5394^2 + .5404^2).
    let slow = report
        .poles
        .iter()
        .find(|pole| pole.root.value.re > 0.85)
        .unwrap();
    let time_constant = slow.root.time_constant_s(0.5).unwrap();
    assert!((time_constant.value + 0.5 / 0.9_f64.ln()).abs() < 1e-9);
    assert!((slow.root.damping().unwrap().value - 1.0).abs() < 1e-12);
    let pair = report
        .poles
        .iter()
        .find(|pole| pole.root.value.im > 0.1)
        .unwrap();
    let logarithm = Complex::new(0.5_f64, 0.3).ln();
    let damping = pair.root.damping().unwrap().value;
    assert!((damping + logarithm.re / logarithm.norm()).abs() < 1e-9);
    let frequency = pair.root.natural_frequency_hz(0.5).unwrap().value;
    assert!((frequency - logarithm.norm() / std::f64::consts::PI).abs() < 1e-9);
    assert!(report.channels[1].zeros[0].time_constant_s(0.5).is_none());
}

/// A double pole is flagged, a pair of poles closer than their errors allow is too, and the same
/// pair with small errors is not.
#[test]
fn repeated_poles_are_not_resolvable() {
    let double = known_model(diagonal(2, 1), 1, &[&[1.6, -0.64, 1.0]], 100);
    let report = pole_zero(&double, &no_errors(&double)).unwrap();
    assert!(
        report
            .poles
            .iter()
            .all(|pole| pole.root.covariance.is_none())
    );
    assert!(
        report
            .poles
            .iter()
            .all(|pole| pole.root.standard_error().is_none())
    );
    // 0.8 and 0.7.
    let close = known_model(diagonal(2, 1), 1, &[&[1.5, -0.56, 1.0]], 100);
    let report = pole_zero(&close, &no_errors(&close)).unwrap();
    assert!(
        report
            .poles
            .iter()
            .all(|pole| pole.root.covariance.is_some())
    );
    let wide = vec![DMatrix::identity(3, 3) * 1e-4];
    let report = pole_zero(&close, &wide).unwrap();
    assert!(
        report
            .poles
            .iter()
            .all(|pole| pole.root.covariance.is_none())
    );
    // Two outputs may have the same pole: each row has its own.
    let same = known_model(diagonal(1, 1), 1, &[&[0.8, 1.0], &[0.8, 1.0]], 100);
    let report = pole_zero(&same, &no_errors(&same)).unwrap();
    assert!(
        report
            .poles
            .iter()
            .all(|pole| pole.root.covariance.is_some())
    );
}

proptest! {
    #![proptest_config(cases(60))]

    /// The poles of a full or canonical model are the eigenvalues of its realisation, and each
    /// covariance is that of a derivative by differences. The step of 1e-5 leaves 1e-10 of the third
    /// derivative, at most 1e3 here, and 1e-4 of rounding where another zero lies far out.
    #[test]
    fn prop_coupled_poles_and_zeros_move_as_their_covariance_says(
        seed: u64, canonical: bool, pick in 0_usize..1000,
    ) {
        let mut rng = generator(seed);
        let truth = random_form(&mut rng, &[2, 1], 2, false);
        let data = record(&mut rng, &truth, 300, 0.3);
        let structure = if canonical {
            gt_ident::ArxStructure::Canonical { indices: vec![2, 1], feedthrough: false }
        } else {
            full(2, 2)
        };
        let model = Arx::new(structure).fit(&data).unwrap();
        let row = pick % 2;
        let term = (pick / 2) % model.rows()[row].terms.len();
        let mut covariances: Vec<DMatrix<f64>> =
            no_errors(&model).iter().map(|matrix| matrix * 0.0).collect();
        covariances[row][(term, term)] = 1e-12;
        let step = 1e-5;
        let report = pole_zero(&model, &covariances).unwrap();
        let eigenvalues = model.state_space().unwrap().poles().unwrap();
        prop_assert!(distance(&poles(&report), &eigenvalues) < 1e-7);
        let moved = |by: f64| {
            let mut value = serde_json::to_value(&model).unwrap();
            let place = &mut value["rows"][row]["terms"][term]["coefficient"];
            *place = (place.as_f64().unwrap() + by).into();
            let model: ArxModel = serde_json::from_value(value).unwrap();
            pole_zero(&model, &covariances).unwrap()
        };
        let (above, below) = (moved(step), moved(-step));
        let lists = |report: &PoleZeroReport| -> Vec<Vec<Root>> {
            let poles = report.poles.iter().map(|pole| pole.root.clone()).collect();
            let zeros = report.channels.iter().map(|channel| channel.zeros.clone());
            std::iter::once(poles).chain(zeros).collect()
        };
        let (here, above, below) = (lists(&report), lists(&above), lists(&below));
        for ((here, above), below) in here.iter().zip(&above).zip(&below) {
            for root in here {
                let z = root.value;
                let others = here.iter().filter(|other| other.value != z);
                let gap = others.map(|other| (other.value - z).norm()).fold(1.0, f64::min);
                // Roots far out or close together amplify what differences lose.
                if gap < 0.05 || z.norm() > 3.0 || z.norm() < 0.05 {
                    continue;
                }
                let near = |list: &[Root]| {
                    let all = list.iter().map(|other| other.value);
                    all.min_by(|a, b| (a - z).norm().total_cmp(&(b - z).norm())).unwrap()
                };
                let slope = (near(above) - near(below)) / (2.0 * step);
                let Some(error) = root.standard_error() else { continue };
                let expected = error / 1e-6;
                let tolerance = 1e-4 * (1.0 + expected).powi(2) / gap;
                prop_assert!((slope.norm() - expected).abs() < tolerance, "{} {}", slope, expected);
            }
        }
    }
}

/// Standard errors against the spread of 300 fits: 4 % is the error of a spread, four of them and
/// a few per cent for the second order.
#[test]
fn errors_of_poles_and_zeros_are_the_spread_over_monte_carlo_runs() {
    const TOLERANCE: f64 = 0.2;
    const RUNS: u32 = 300;
    let names = [
        "magnitude",
        "damping",
        "natural frequency",
        "time constant",
        "re",
        "zero",
    ];
    let mut values = vec![Vec::new(); names.len()];
    let mut errors = vec![0.0; names.len()];
    for run in 0..RUNS {
        let mut rng = generator(u64::from(run) + 700);
        let data = second_order_record(&mut rng, 1.0, 0.3, 1500);
        let model = Arx::new(diagonal(2, 2)).fit(&data).unwrap();
        let covariances = parameter_covariance(&model, &data).unwrap();
        let report = pole_zero(&model, &covariances).unwrap();
        let pole = report
            .poles
            .iter()
            .find(|pole| pole.root.value.im > 0.0)
            .unwrap();
        let (root, zero) = (&pole.root, &report.channels[0].zeros[0]);
        let re = |root: &Root| Estimate {
            value: root.value.re,
            standard_error: root.covariance.map(|covariance| covariance[(0, 0)].sqrt()),
        };
        let found = [
            root.magnitude(),
            root.damping().unwrap(),
            root.natural_frequency_hz(0.5).unwrap(),
            root.time_constant_s(0.5).unwrap(),
            re(root),
            re(zero),
        ];
        assert!(report.superfluous_poles.is_empty());
        for (index, estimate) in found.iter().enumerate() {
            values[index].push(estimate.value);
            errors[index] += estimate.standard_error.unwrap() / f64::from(RUNS);
        }
    }
    for (name, (values, error)) in names.iter().zip(values.iter().zip(errors)) {
        let mean = values.iter().sum::<f64>() / f64::from(RUNS);
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let spread = (squares / f64::from(RUNS)).sqrt();
        println!("{name}: mean {mean:.5}, spread {spread:.5}, error {error:.5}");
        assert!(
            (error / spread - 1.0).abs() < TOLERANCE,
            "{name}: {error} of {spread}"
        );
    }
}

/// An order too high leaves a pole that a zero cancels within error; the right order does not.
/// Of 50 runs each: in the plane two standard errors hold 86 % of true cancellations, 43 of 50, with
/// a deviation of 2.4; three of them below.
#[test]
fn superfluous_poles_tell_of_an_order_too_high() {
    let (mut high, mut right) = (0, 0);
    for run in 0..50 {
        let mut rng = generator(run + 60);
        let data = second_order_record(&mut rng, 1.0, 0.3, 800);
        let superfluous = |order: usize| {
            let model = Arx::new(diagonal(order, order)).fit(&data).unwrap();
            let covariances = parameter_covariance(&model, &data).unwrap();
            pole_zero(&model, &covariances)
                .unwrap()
                .superfluous_poles
                .len()
        };
        high += usize::from(superfluous(3) > 0);
        right += usize::from(superfluous(2) > 0);
    }
    println!("superfluous poles: {high} of 50 at order 3, {right} of 50 at order 2");
    assert!(high >= 35, "{high}");
    assert_eq!(right, 0);
}

/// The coefficients of `(1 - 0.95 z^-1)^order y = z^-1 u`.
fn slow_row(order: usize) -> Vec<f64> {
    let mut denominator = vec![0.0; order + 1];
    denominator[0] = 1.0;
    for _ in 0..order {
        for k in (1..=order).rev() {
            denominator[k] -= 0.95 * denominator[k - 1];
        }
    }
    let outputs = denominator[1..].iter().map(|value| -value);
    outputs.chain([1.0]).collect()
}

/// Single output, all poles at 0.95.
#[test]
fn published_condition_of_m_at_slow_poles() {
    for (order, expected, digits) in [
        (2, 5.4, 0.05),
        (4, 229.0, 0.5),
        (6, 1.1e4, 500.0),
        (8, 5.3e5, 5e3),
    ] {
        let coefficients = slow_row(order);
        let model = known_model(diagonal(order, 1), 1, &[&coefficients], 100);
        let report = realisation_report(&model).unwrap();
        println!("n = {order}: cond(M) = {:.6e}", report.m_condition);
        assert!(
            (report.m_condition - expected).abs() <= digits,
            "{}",
            report.m_condition
        );
        // Rounding of det, amplified by the condition.
        assert!((report.m_determinant - 1.0).abs() < 1e-13 * report.m_condition);
        assert_eq!(report.order, order);
        assert!(report.warnings.is_empty());
        assert_eq!((report.minimal_order, report.reachable), (order, order));
    }
}

#[test]
fn realisations_that_deserve_a_warning() {
    // All poles at 0.95 of order 14: cond(M) is beyond 1e8.
    let coefficients = slow_row(14);
    let model = known_model(diagonal(14, 1), 1, &[&coefficients], 100);
    let report = realisation_report(&model).unwrap();
    assert!(matches!(
        report.warnings[0],
        RealisationWarning::IllConditioned { condition, limit } if condition > limit
    ));
    // Two lags of the one input, one of the outputs: two modes and one delay, in 2 x 2 states.
    let rows: [&[f64]; 2] = [&[0.5, 0.2, 1.0, 0.3], &[-0.1, 0.7, 0.4, -0.6]];
    let report = realisation_report(&known_model(full(1, 2), 1, &rows, 100)).unwrap();
    assert_eq!((report.order, report.minimal_order), (4, 3));
    assert_eq!((report.reachable, report.observable), (3, 4));
    assert_eq!(
        report.warnings,
        vec![RealisationWarning::NotMinimal {
            order: 4,
            minimal: 3
        }]
    );
    // An unstable model has no Hankel singular values.
    let unstable = known_model(diagonal(1, 1), 1, &[&[1.1, 1.0]], 100);
    let report = realisation_report(&unstable).unwrap();
    assert_eq!(report.hankel_singular_values, None);
    assert_eq!(report.minimal_order, 1);
}

/// Two outputs with poles of their own, one in units ten thousand million times as small as the
/// other's: all states count, whatever the unit, though the singular values are those of the units.
#[test]
fn units_hide_no_states() {
    for unit in [1e-10, 1.0, 1e10] {
        let rows: [&[f64]; 2] = [&[1.2, -0.4, unit, 0.5 * unit], &[0.9, -0.5, 1.0, -0.3]];
        let report = realisation_report(&known_model(diagonal(2, 2), 1, &rows, 100)).unwrap();
        assert_eq!((report.order, report.minimal_order), (4, 4), "{unit}");
        assert!(report.warnings.is_empty(), "{unit}");
        let values = report.hankel_singular_values.unwrap();
        let spread = values[0] / values[3];
        assert!((spread > 1e9) == (unit != 1.0), "{unit}: {spread}");
    }
}

proptest! {
    #![proptest_config(cases(40))]

    /// The singular values of the Hankel matrix of the Markov parameters, over as many samples as
    /// the response (radius 0.9 at most) takes to decay to 1e-9: 0.9^200.
    #[test]
    fn prop_hankel_singular_values_are_those_of_the_hankel_matrix(seed: u64) {
        let mut rng = generator(seed);
        let form = random_form(&mut rng, &[1, 2], 1, false);
        let coefficients: Vec<Vec<f64>> = {
            let data = record(&mut rng, &form, 200, 0.0);
            let structure = gt_ident::ArxStructure::Canonical { indices: vec![1, 2], feedthrough: false };
            let Ok(model) = Arx::new(structure).fit(&data) else { return Ok(()) };
            model.rows().iter().map(|row| row.terms.iter().map(|term| term.coefficient).collect()).collect()
        };
        let lists: Vec<&[f64]> = coefficients.iter().map(Vec::as_slice).collect();
        let structure = gt_ident::ArxStructure::Canonical { indices: vec![1, 2], feedthrough: false };
        let model = known_model(structure, 1, &lists, 100);
        let space = model.state_space().unwrap();
        prop_assume!(space.spectral_radius().unwrap() < 0.9);
        let markov = space.markov_parameters(241);
        let hankel = DMatrix::from_fn(240, 120, |row, column| {
            markov[row / 2 + column + 1][(row % 2, 0)]
        });
        // By faer: the symmetric eigenvalues of nalgebra once held an infinity here.
        let mut expected = gt_core::la::as_faer(&hankel).singular_values().unwrap();
        expected.sort_by(|a, b| b.total_cmp(a));
        let found = realisation_report(&model).unwrap().hankel_singular_values.unwrap();
        prop_assert_eq!(found.len(), 3);
        for (a, b) in found.iter().zip(&expected) {
            // 0.9^120 is 3e-6 of the tail in each direction; its square in the singular values.
            prop_assert!((a - b).abs() < 1e-4 * expected[0], "{:?} {:?}", found, &expected[..4]);
        }
    }
}
