//! Linear plants: poles, gains and the zero-order hold against roots, simulation and each other.

#![allow(clippy::float_cmp, reason = "values compared exactly are exact")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::f64::consts::PI;

use gt_core::{DimensionError, ModelError, Signal};
use gt_plant::linearise::Linearisation;
use gt_plant::{PlantError, rk4};
use nalgebra::{Complex, DMatrix, DVector, SMatrix};
use proptest::prelude::*;

fn names(prefix: &str, count: usize) -> Vec<String> {
    (0..count).map(|i| format!("{prefix}{i}")).collect()
}

fn plant(matrices: [DMatrix<f64>; 4]) -> Linearisation {
    let [a, b, c, _] = &matrices;
    let states = names("x", a.nrows());
    let inputs = Signal::named(&names("u", b.ncols()));
    let outputs = Signal::named(&names("y", c.nrows()));
    Linearisation::new(matrices, states, inputs, outputs).unwrap()
}

/// The plant with all states as outputs and one input into each.
fn states_of(a: DMatrix<f64>) -> Linearisation {
    let n = a.nrows();
    let identity = DMatrix::identity(n, n);
    plant([a, identity.clone(), identity, DMatrix::zeros(n, n)])
}

/// Coefficients of the monic polynomial with these roots, lowest first, without the leading 1.
fn polynomial(roots: &[Complex<f64>]) -> Vec<f64> {
    let mut coefficients = vec![Complex::new(1.0, 0.0)];
    for root in roots {
        let mut next = vec![Complex::new(0.0, 0.0); coefficients.len() + 1];
        for (power, coefficient) in coefficients.iter().enumerate() {
            next[power + 1] += coefficient;
            next[power] -= coefficient * root;
        }
        coefficients = next;
    }
    coefficients.pop();
    coefficients.iter().map(|entry| entry.re).collect()
}

fn companion(coefficients: &[f64]) -> DMatrix<f64> {
    let n = coefficients.len();
    DMatrix::from_fn(n, n, |row, column| {
        if row + 1 == n {
            -coefficients[column]
        } else {
            f64::from(u8::from(column == row + 1))
        }
    })
}

/// `S A S^-1` with S = diag(10^decades): the same plant in other units.
fn in_units(a: &DMatrix<f64>, decades: &[f64]) -> DMatrix<f64> {
    let unit = |i: usize| 10f64.powf(decades[i % decades.len()]);
    DMatrix::from_fn(a.nrows(), a.ncols(), |row, column| {
        a[(row, column)] * unit(row) / unit(column)
    })
}

fn sorted(mut poles: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
    poles.sort_by(|p, q| {
        q.re.total_cmp(&p.re)
            .then(p.im.abs().total_cmp(&q.im.abs()))
            .then(q.im.total_cmp(&p.im))
    });
    poles
}

fn largest_distance(found: &[Complex<f64>], expected: &[Complex<f64>]) -> f64 {
    assert_eq!(found.len(), expected.len());
    found
        .iter()
        .zip(expected)
        .map(|(p, q)| (p - q).norm())
        .fold(0.0, f64::max)
}

/// Real poles and pairs with distinct real parts, so that a polynomial defines them well.
fn roots() -> impl Strategy<Value = Vec<Complex<f64>>> {
    prop::collection::vec((0.0..0.5f64, prop_oneof![Just(0.0), 0.3..3.0f64]), 1..5).prop_map(
        |parts| {
            let mut roots = Vec::new();
            for (k, (offset, im)) in (0u8..).zip(parts) {
                let re = 0.5 - f64::from(k) - offset;
                roots.push(Complex::new(re, im));
                if im != 0.0 {
                    roots.push(Complex::new(re, -im));
                }
            }
            roots
        },
    )
}

proptest! {
    /// The error of a root is the rounding times its condition, below 1e6 for these.
    #[test]
    fn prop_poles_of_a_companion_matrix_are_the_roots(roots in roots()) {
        let found = states_of(companion(&polynomial(&roots)));
        let error = largest_distance(found.poles_per_s(), &sorted(roots));
        prop_assert!(error < 1e-9, "{error}");
    }

    /// Neither by the balancing nor by units over eight decades are poles moved.
    #[test]
    fn prop_poles_do_not_depend_on_units(
        entries in prop::collection::vec(-1.0..1.0f64, 36),
        decades in prop::collection::vec(-2.0..6.0f64, 6),
    ) {
        let a = DMatrix::from_vec(6, 6, entries);
        let plain = sorted(a.complex_eigenvalues().iter().copied().collect());
        let found = states_of(a.clone());
        let scaled = states_of(in_units(&a, &decades));
        // Matched to the nearest: real parts that tie may change places by rounding.
        for poles in [found.poles_per_s(), scaled.poles_per_s()] {
            for pole in &plain {
                let distance = poles.iter().map(|p| (p - pole).norm()).fold(1.0, f64::min);
                // The square root of rounding: two random poles may nearly coincide.
                prop_assert!(distance < 1e-7, "{distance}");
            }
        }
    }

    #[test]
    fn prop_conjugates_stand_together_and_slow_comes_first(
        entries in prop::collection::vec(-1.0..1.0f64, 49),
    ) {
        let found = states_of(DMatrix::from_vec(7, 7, entries));
        let poles = found.poles_per_s();
        prop_assert!(poles.windows(2).all(|pair| pair[0].re >= pair[1].re));
        let mut rest = poles;
        while let [first, others @ ..] = rest {
            rest = if first.im == 0.0 {
                others
            } else {
                prop_assert!(first.im > 0.0);
                prop_assert_eq!(others[0], first.conj());
                &others[1..]
            };
        }
        prop_assert_eq!(found.decay_per_s(), -poles[0].re);
        prop_assert_eq!(found.is_stable(), poles[0].re < 0.0);
    }
}

#[test]
fn published_poles_of_gallery_3() {
    // Moler, Numerical Computing with MATLAB, section 10.7: built to have the eigenvalues 1, 2, 3.
    let a = [
        -149.0, -50.0, -154.0, 537.0, 180.0, 546.0, -27.0, -9.0, -25.0,
    ];
    let found = states_of(DMatrix::from_row_slice(3, 3, &a));
    let expected = [3.0, 2.0, 1.0].map(|re| Complex::new(re, 0.0));
    // Rounding times the norm (818) times the condition of the worst eigenvalue (604).
    assert!(largest_distance(found.poles_per_s(), &expected) < 1e-10);
}

#[test]
fn cyclic_matrices_have_the_roots_of_one_as_poles() {
    // The QR iteration without exceptional shifts stands still on these.
    for n in 1..=16u8 {
        for sign in [1.0, -1.0] {
            let mut coefficients = vec![0.0; usize::from(n)];
            coefficients[0] = -sign;
            let found = states_of(companion(&coefficients));
            for k in 0..n {
                let turn = if sign > 0.0 { 0.0 } else { 0.5 };
                let angle = 2.0 * PI * (f64::from(k) + turn) / f64::from(n);
                let root = Complex::from_polar(1.0, angle);
                let near = found.poles_per_s().iter().map(|pole| (pole - root).norm());
                assert!(near.fold(1.0, f64::min) < 1e-13, "{n} {k}");
            }
        }
    }
}

#[test]
fn repeated_poles_are_finite() {
    // Double poles: rounding may make the pair complex or real.
    let mut worst = 0.0f64;
    for k in 1..=400u32 {
        let (p, gain) = (0.37 * f64::from(k), 1.3 + 0.01 * f64::from(k));
        let turn = DMatrix::from_row_slice(3, 3, &[0.6, -0.8, 0.0, 0.8, 0.6, 0.0, 0.0, 0.0, 1.0]);
        let jordan = DMatrix::from_row_slice(3, 3, &[-p, gain, 0.3, 0.0, -p, 0.2, 0.0, 0.0, -9.0]);
        let found = states_of(&turn * jordan * turn.transpose());
        for pole in [-p, -9.0] {
            let near = found
                .poles_per_s()
                .iter()
                .map(|q| (q - pole).norm() / p.max(9.0));
            worst = worst.max(near.fold(1.0, f64::min));
        }
    }
    // A double pole has half the digits.
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn time_constants_of_decaying_constant_and_growing_modes() {
    let diagonal = DVector::from_vec(vec![-4.0, 0.0, 0.5, -0.25]);
    let found = states_of(DMatrix::from_diagonal(&diagonal));
    let expected = [-2.0, f64::INFINITY, 4.0, 0.25];
    for (found, expected) in found.time_constants_s().into_iter().zip(expected) {
        assert!(found == expected || (found / expected - 1.0).abs() < 1e-15);
    }
    assert!(!found.is_stable());
    assert!((found.decay_per_s() + 0.5).abs() < 1e-15);
}

#[test]
fn a_plant_without_states_is_its_direct_term() {
    let d = DMatrix::from_row_slice(2, 1, &[3.0, -4.0]);
    let none = |rows, columns| DMatrix::<f64>::zeros(rows, columns);
    let found = plant([none(0, 0), none(0, 1), none(2, 0), d.clone()]);
    assert!(found.is_stable() && found.poles_per_s().is_empty());
    assert_eq!(found.dc_gain(), Ok(d.clone()));
    assert_eq!(found.discretise(0.1).unwrap().d(), &d);
}

/// Three states with poles left of -0.5 (Gershgorin), two inputs and two outputs, in mixed units.
#[derive(Debug, Clone)]
struct Small {
    a: SMatrix<f64, 3, 3>,
    b: SMatrix<f64, 3, 2>,
    c: SMatrix<f64, 2, 3>,
    d: SMatrix<f64, 2, 2>,
    /// The size of each state.
    units: [f64; 3],
}

impl Small {
    fn plant(&self) -> Linearisation {
        let dynamic =
            |rows, columns, entries: &[f64]| DMatrix::from_column_slice(rows, columns, entries);
        plant([
            dynamic(3, 3, self.a.as_slice()),
            dynamic(3, 2, self.b.as_slice()),
            dynamic(2, 3, self.c.as_slice()),
            dynamic(2, 2, self.d.as_slice()),
        ])
    }

    /// The state after `steps` steps of RK4 with constant inputs, from rest or from `x0`.
    fn simulated(&self, x0: [f64; 3], u: [f64; 2], step_s: f64, steps: u32) -> [f64; 3] {
        let force = self.b * SMatrix::<f64, 2, 1>::from(u);
        let rates = |_: f64, x: &[f64; 3]| {
            let rate = self.a * SMatrix::<f64, 3, 1>::from(*x) + force;
            [rate[0], rate[1], rate[2]]
        };
        let mut x = x0;
        for k in 0..steps {
            x = rk4::step(rates, f64::from(k) * step_s, &x, step_s);
        }
        x
    }
}

fn small() -> impl Strategy<Value = Small> {
    (
        prop::collection::vec(-1.0..1.0f64, 9 + 6 + 6 + 4),
        prop::array::uniform3(-1.0..6.0f64),
    )
        .prop_map(|(entries, decades)| {
            let mut a = SMatrix::<f64, 3, 3>::from_column_slice(&entries[..9]);
            for i in 0..3 {
                a[(i, i)] -= 3.5;
            }
            let unit = SMatrix::<f64, 3, 3>::from_diagonal(
                &decades.map(|decade| 10f64.powf(decade)).into(),
            );
            let back = SMatrix::<f64, 3, 3>::from_diagonal(
                &decades.map(|decade| 10f64.powf(-decade)).into(),
            );
            Small {
                a: unit * a * back,
                b: unit * SMatrix::<f64, 3, 2>::from_column_slice(&entries[9..15]),
                c: SMatrix::<f64, 2, 3>::from_column_slice(&entries[15..21]) * back,
                d: SMatrix::from_column_slice(&entries[21..]),
                units: decades.map(|decade| 10f64.powf(decade)),
            }
        })
}

proptest! {
    #[test]
    fn prop_dc_gain_is_where_a_long_simulation_ends(small in small()) {
        let gain = small.plant().dc_gain().unwrap();
        for (input, u) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
            // Poles left of -0.5 1/s: after 80 s, e^-40 of the way is left.
            let x = small.simulated([0.0; 3], u, 0.1, 800);
            let y = small.c * SMatrix::<f64, 3, 1>::from(x) + small.d.column(input);
            for output in 0..2 {
                let error = (y[output] - gain[(output, input)]).abs();
                prop_assert!(error < 1e-12, "{error}");
            }
        }
    }

    /// Columns of the discrete matrices are runs over one sample, each from one unit state or input.
    #[test]
    fn prop_zero_order_hold_agrees_with_fine_integration(
        small in small(), sample_time_s in 0.01..1.0f64,
    ) {
        let model = small.plant().discretise(sample_time_s).unwrap();
        let steps = 400;
        let step_s = sample_time_s / f64::from(steps);
        // RK4 leaves Ts h^4 |A|^5 / 120 = 1e-12 (1 s, 1/400 s, 5 1/s).
        let close = |found: f64, expected: f64, unit: f64| (found - expected).abs() < 1e-9 * unit;
        for state in 0..3 {
            let mut x0 = [0.0; 3];
            x0[state] = 1.0;
            let x = small.simulated(x0, [0.0; 2], step_s, steps);
            for (row, expected) in x.into_iter().enumerate() {
                let unit = small.units[row] / small.units[state];
                prop_assert!(close(model.a()[(row, state)], expected, unit));
            }
        }
        for (input, u) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
            let x = small.simulated([0.0; 3], u, step_s, steps);
            for (row, expected) in x.into_iter().enumerate() {
                prop_assert!(close(model.b()[(row, input)], expected, small.units[row]));
            }
        }
        prop_assert_eq!(model.sample_time_s(), sample_time_s);
    }

    /// A hold does not change what constant inputs lead to: C (I - A)^-1 B + D.
    #[test]
    fn prop_hold_keeps_the_dc_gain(small in small(), sample_time_s in 1e-3..100.0f64) {
        let plant = small.plant();
        let model = plant.discretise(sample_time_s).unwrap();
        let identity = DMatrix::identity(3, 3);
        let held = (identity - model.a()).try_inverse().unwrap() * model.b();
        let gain = model.c() * held + model.d();
        // I - A has entries of 1e-3 for the shortest sample time.
        prop_assert!((gain - plant.dc_gain().unwrap()).amax() < 1e-9);
    }

    /// A discrete pole is e^(p Ts).
    #[test]
    fn prop_hold_maps_poles_by_the_exponential(roots in roots(), sample_time_s in 0.01..0.5f64) {
        let plant = states_of(companion(&polynomial(&roots)));
        let model = plant.discretise(sample_time_s).unwrap();
        // The trace is the sum of the poles, and better conditioned than each.
        let expected: Complex<f64> = roots.iter().map(|root| (root * sample_time_s).exp()).sum();
        prop_assert!((model.a().trace() - expected.re).abs() < 1e-10);
    }

    #[test]
    fn prop_frequency_response_at_zero_is_the_dc_gain(small in small()) {
        let plant = small.plant();
        let response = plant.frequency_response(0.0).unwrap();
        prop_assert_eq!(response.map(|gain| gain.re), plant.dc_gain().unwrap());
        prop_assert!(response.iter().all(|gain| gain.im == 0.0));
    }

    /// A sum of first-order lags, from 0.1 ms to 3 h, mixed by a rotation.
    #[test]
    fn prop_frequency_response_of_parallel_lags(
        decades in prop::array::uniform2(-4.0..4.0f64),
        gains in prop::array::uniform2(0.1..1.0f64),
        angle in 0.0..1.5f64,
        omega_decade in -5.0..5.0f64,
    ) {
        let time_constants_s = decades.map(|decade| 10f64.powf(decade));
        let omega_rad_s = 10f64.powf(omega_decade);
        // x_i' = (u - x_i) / T_i: C holds the gains.
        let (sine, cosine) = angle.sin_cos();
        let turn = DMatrix::from_row_slice(2, 2, &[cosine, -sine, sine, cosine]);
        let rates = time_constants_s.map(|time_s| 1.0 / time_s);
        let a = -(&turn * DMatrix::from_diagonal(&DVector::from_row_slice(&rates)))
            * turn.transpose();
        let b = &turn * DMatrix::from_column_slice(2, 1, &rates);
        let c = DMatrix::from_row_slice(1, 2, &gains) * turn.transpose();
        let found = plant([a, b, c, DMatrix::zeros(1, 1)]).frequency_response(omega_rad_s);
        let lag = |i: usize| gains[i] / Complex::new(1.0, omega_rad_s * time_constants_s[i]);
        let expected = lag(0) + lag(1);
        // Storing A rounds the slow rate by 1e-16 of the fast one, 1e8 times as large at most.
        let ratio = (time_constants_s[0] / time_constants_s[1]).max(
            time_constants_s[1] / time_constants_s[0]);
        let error = (found.unwrap()[(0, 0)] - expected).norm();
        prop_assert!(error < 1e-14 * ratio.max(10.0), "{error}");
    }
}

#[test]
fn published_hold_of_the_double_integrator() {
    // Franklin, Powell and Workman, chapter 4: [[1, T], [0, 1]] and [T^2/2, T] for 1/s^2.
    let t = 0.3;
    let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
    let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
    let found = plant([a, b, DMatrix::identity(2, 2), DMatrix::zeros(2, 1)])
        .discretise(t)
        .unwrap();
    let expected = DMatrix::from_row_slice(2, 2, &[1.0, t, 0.0, 1.0]);
    assert!((found.a() - expected).amax() < 1e-15);
    let expected = DMatrix::from_row_slice(2, 1, &[0.5 * t * t, t]);
    assert!((found.b() - expected).amax() < 1e-15);
}

#[test]
fn hold_of_an_undamped_oscillator_is_a_rotation() {
    // x'' = w^2 (u - x), in the units of a pressure (1e6) over a flow (0.1).
    let (w, t, unit) = (50.0, 0.08, 1e7);
    let a = DMatrix::from_row_slice(2, 2, &[0.0, w * unit, -w / unit, 0.0]);
    let b = DMatrix::from_row_slice(2, 1, &[0.0, w / unit]);
    let found = plant([a, b, DMatrix::identity(2, 2), DMatrix::zeros(2, 1)])
        .discretise(t)
        .unwrap();
    let (sine, cosine) = (w * t).sin_cos();
    let expected = [
        (found.a()[(0, 0)], cosine, 1.0),
        (found.a()[(0, 1)], sine * unit, unit),
        (found.a()[(1, 0)], -sine / unit, 1.0 / unit),
        (found.a()[(1, 1)], cosine, 1.0),
        (found.b()[(0, 0)], 1.0 - cosine, 1.0),
        (found.b()[(1, 0)], sine / unit, 1.0 / unit),
    ];
    for (found, expected, unit) in expected {
        // Four doublings of the rounding error.
        assert!(
            (found - expected).abs() < 1e-14 * unit,
            "{found} {expected}"
        );
    }
}

#[test]
fn very_long_and_very_short_holds() {
    let a = DMatrix::from_row_slice(2, 2, &[-700.0, 3e6, 1e-5, -0.2]);
    let stable = states_of(a.clone());
    let settled = stable.discretise(1e300).unwrap();
    assert_eq!(settled.a().amax(), 0.0);
    let gain = stable.dc_gain().unwrap();
    assert!((settled.b() - &gain).component_div(&gain).amax() < 1e-12);
    let short = stable.discretise(1e-300).unwrap();
    assert!((short.a()[(0, 0)] - 1.0).abs() == 0.0 && short.a()[(0, 1)] > 0.0);
    let growing = states_of(-a).discretise(1e300).unwrap_err();
    assert!(
        matches!(
            growing,
            PlantError::Model(ModelError::NotFinite { matrix: 'A', .. })
        ),
        "{growing}"
    );
}

#[test]
fn an_integrator_has_no_dc_gain_but_others_do() {
    let integrator = states_of(DMatrix::from_row_slice(2, 2, &[-1.0, 0.0, 5.0, 0.0]));
    let singular = |omega_rad_s| PlantError::Singular {
        omega_rad_s,
        least: 2.0 * f64::EPSILON,
        found: 0.0,
    };
    assert_eq!(integrator.dc_gain(), Err(singular(0.0)));
    let resonant = states_of(DMatrix::from_row_slice(2, 2, &[0.0, 3.0, -3.0, 0.0]));
    assert_eq!(resonant.frequency_response(3.0), Err(singular(3.0)));
    assert!(resonant.frequency_response(3.1).is_ok());
    assert_eq!(
        integrator.dc_gain().unwrap_err().to_string(),
        "gain at 0 rad/s: expected j w I - A with a reciprocal condition of at least \
         0.0000000000000004440892098500626, found 0"
    );
}

#[test]
fn dependent_rates_are_singular_up_to_rounding() {
    // The third row is 0.1 times the first and 0.3 times the second, in other units.
    let mut a = DMatrix::from_row_slice(3, 3, &[-1.0, 0.7, 0.3, 0.2, -1.1, 0.9, 0.0, 0.0, 0.0]);
    let row = a.row(0) * 0.1 + a.row(1) * 0.3;
    a.set_row(2, &row);
    let error = states_of(in_units(&a, &[0.0, 6.0, -1.0]))
        .dc_gain()
        .unwrap_err();
    assert!(
        matches!(error, PlantError::Singular { found, .. } if found < 3.0 * f64::EPSILON),
        "{error}"
    );
}

#[test]
fn far_apart_rates_are_not_singular() {
    let rates = [-1e-12, -1e6, -1e-200, -1e200];
    let found = states_of(DMatrix::from_diagonal(&DVector::from_row_slice(&rates)));
    let gain = found.dc_gain().unwrap();
    for (i, rate) in rates.into_iter().enumerate() {
        assert!((gain[(i, i)] * -rate - 1.0).abs() < 1e-15);
    }
    // A fast state and a slow one that drive each other: diag(1e9, 1e-9) [[-1, 1], [0.1, -1]].
    let found = states_of(DMatrix::from_row_slice(2, 2, &[-1e9, 1e9, 1e-10, -1e-9]));
    let expected = DMatrix::from_row_slice(2, 2, &[1e-9, 1e9, 1e-10, 1e9]) / 0.9;
    let error = (found.dc_gain().unwrap() - &expected).component_div(&expected);
    assert!(error.amax() < 1e-14, "{error}");
}

#[test]
fn a_frequency_that_is_no_number_is_refused() {
    let plant = states_of(DMatrix::from_row_slice(1, 1, &[-1.0]));
    for omega_rad_s in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = plant.frequency_response(omega_rad_s).unwrap_err();
        assert!(matches!(error, PlantError::Singular { found, .. } if found.is_nan()));
    }
}

#[test]
fn sample_times_that_mean_nothing_are_refused() {
    let plant = states_of(DMatrix::from_row_slice(1, 1, &[-1.0]));
    for found in [0.0, -0.1, f64::INFINITY] {
        let error = PlantError::Model(ModelError::SampleTime { found });
        assert_eq!(plant.discretise(found), Err(error));
    }
    assert!(plant.discretise(f64::NAN).is_err());
}

#[test]
fn sizes_that_disagree_are_named() {
    type Sizes = [(usize, usize); 4];
    // Two states, three inputs, one output.
    let fits: Sizes = [(2, 2), (2, 3), (1, 2), (1, 3)];
    let build = |sizes: Sizes| {
        Linearisation::new(
            sizes.map(|(rows, columns)| DMatrix::zeros(rows, columns)),
            names("x", 2),
            Signal::named(&names("u", 3)),
            Signal::named(&names("y", 1)),
        )
    };
    assert!(build(fits).is_ok());
    let cases = [
        (0, (3, 2), "rows of A (states)", 2, 3),
        (0, (2, 1), "columns of A (states)", 2, 1),
        (1, (1, 3), "rows of B (states)", 2, 1),
        (1, (2, 2), "columns of B (inputs)", 3, 2),
        (2, (2, 2), "rows of C (outputs)", 1, 2),
        (2, (1, 3), "columns of C (states)", 2, 3),
        (3, (0, 3), "rows of D (outputs)", 1, 0),
        (3, (1, 4), "columns of D (inputs)", 3, 4),
    ];
    for (matrix, size, what, expected, found) in cases {
        let mut sizes = fits;
        sizes[matrix] = size;
        let what = what.to_owned();
        let error = DimensionError {
            what,
            expected,
            found,
        };
        assert_eq!(
            build(sizes),
            Err(PlantError::Model(ModelError::Dimension(error)))
        );
    }
}

#[test]
fn entries_that_are_not_finite_are_named() {
    let mut a = DMatrix::zeros(2, 2);
    a[(1, 0)] = f64::INFINITY;
    let none = |rows, columns| DMatrix::zeros(rows, columns);
    let error = Linearisation::new(
        [a, none(2, 0), none(0, 2), none(0, 0)],
        names("x", 2),
        Vec::new(),
        Vec::new(),
    );
    let expected = ModelError::NotFinite {
        matrix: 'A',
        row: 1,
        column: 0,
        found: f64::INFINITY,
    };
    assert_eq!(error, Err(PlantError::Model(expected)));
}

#[test]
fn huge_and_tiny_rates_have_poles() {
    // Their squares overflow and underflow.
    for size in [1e300, 1e-300] {
        let a = DMatrix::from_row_slice(3, 3, &[-3.0, 1.0, 0.0, 0.0, -2.0, 1.0, 0.0, 0.0, -1.0]);
        let found = states_of(a * size);
        let expected = [-1.0, -2.0, -3.0].map(|re| Complex::new(re * size, 0.0));
        assert!(largest_distance(found.poles_per_s(), &expected) < 1e-14 * size);
    }
}
