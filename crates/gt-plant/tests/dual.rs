//! Dual numbers against analytic derivatives, central differences and the chain rule.

#![allow(clippy::float_cmp, reason = "values and these derivatives are exact")]

use gt_plant::dual::Dual;
use gt_plant::linearise::{jacobian, jacobian_exact};
use gt_plant::real::Real;
use proptest::prelude::*;

/// Rounding of a few operations.
const ROUNDING: f64 = 1e-14;

fn close(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance * expected.abs().max(1.0)
}

type Pair = Dual<2>;

/// Every operation of two numbers, as duals, with the value and the two derivatives from a table
/// of derivatives. `a` and `b` are positive and apart.
fn table(a: f64, b: f64) -> Vec<(&'static str, Pair, [f64; 3])> {
    let [x, y] = Dual::variables(&[a, b]);
    let inverse = 1.0 / b;
    vec![
        ("-", -x, [-a, -1.0, 0.0]),
        ("+", x + y, [a + b, 1.0, 1.0]),
        ("-", x - y, [a - b, 1.0, -1.0]),
        ("*", x * y, [a * b, b, a]),
        ("/", x / y, [a / b, inverse, -a * inverse * inverse]),
        ("+ f64", x + 0.7, [a + 0.7, 1.0, 0.0]),
        ("- f64", y - 0.7, [b - 0.7, 0.0, 1.0]),
        ("* f64", x * 0.7, [a * 0.7, 0.7, 0.0]),
        ("/ f64", y / 0.7, [b / 0.7, 0.0, 1.0 / 0.7]),
        ("like", x.like(0.7), [0.7, 0.0, 0.0]),
        ("mul_add", x.mul_add(y, x), [a * b + a, b + 1.0, a]),
        ("sqrt", x.sqrt(), [a.sqrt(), 0.5 / a.sqrt(), 0.0]),
        ("exp", y.exp(), [b.exp(), 0.0, b.exp()]),
        ("exp_m1", x.exp_m1(), [a.exp_m1(), a.exp(), 0.0]),
        ("ln", y.ln(), [b.ln(), 0.0, 1.0 / b]),
        ("abs", x.abs(), [a, 1.0, 0.0]),
        ("abs", (-x).abs(), [a, 1.0, 0.0]),
        ("sin", x.sin(), [a.sin(), a.cos(), 0.0]),
        ("cos", y.cos(), [b.cos(), 0.0, -b.sin()]),
        ("squared", x.squared(), [a * a, 2.0 * a, 0.0]),
        (
            "look_up",
            (x * 2.0).look_up(y, |u, v| [u * v * v, v * v, 2.0 * u * v]),
            [2.0 * a * b * b, 2.0 * b * b, 4.0 * a * b],
        ),
    ]
}

proptest! {
    #[test]
    fn prop_every_operation_has_its_analytic_derivatives(a in 0.1..5.0f64, b in 0.1..5.0f64) {
        for (name, found, [value, by_a, by_b]) in table(a, b) {
            prop_assert_eq!(found.value, value, "{}", name);
            prop_assert!(close(found.partials[0], by_a, ROUNDING), "{} {:?} {}", name, found, by_a);
            prop_assert!(close(found.partials[1], by_b, ROUNDING), "{} {:?} {}", name, found, by_b);
        }
    }

    #[test]
    fn prop_selection_follows_the_branch_taken(a in -5.0..5.0f64, b in -5.0..5.0f64) {
        prop_assume!(a != b);
        let [x, y] = Dual::<2>::variables(&[a, b]);
        let (small, large) = if a < b { (x, y) } else { (y, x) };
        prop_assert_eq!(x.at_most(y), small);
        prop_assert_eq!(x.at_least(y), large);
        prop_assert_eq!(x.where_less(y, || x * 3.0, || y * 5.0), if a < b { x * 3.0 } else { y * 5.0 });
    }

    /// Values of a whole program are those of `f64`, to the last bit.
    #[test]
    fn prop_value_is_that_of_plain_numbers((program, point) in (program(), point())) {
        let dual = run(&program, Dual::variables(&point));
        prop_assert_eq!(dual.value, run(&program, point));
    }

    #[test]
    fn prop_random_expressions_agree_with_differences((program, point) in (program(), point())) {
        let found = run(&program, Dual::variables(&point)).partials;
        for i in 0..3 {
            let expected = difference(|t| {
                let mut moved = point;
                moved[i] += t;
                run(&program, moved)
            });
            // Richardson's extrapolation leaves (1e-3)^4 of the fifth derivative.
            prop_assert!(close(found[i], expected, 1e-6), "{} {:?} {}", i, found, expected);
        }
    }

    /// df/dt = sum df/dx_i dx_i/dt for x(t) made of dual numbers themselves.
    #[test]
    fn prop_chain_rule_on_random_expressions(
        (program, point, inner) in (program(), point(), [program(), program(), program()])
    ) {
        let outer_point: [f64; 3] = std::array::from_fn(|i| run(&inner[i], point));
        let by_inner = run(&program, Dual::variables(&outer_point)).partials;
        let inside: [Dual<3>; 3] =
            std::array::from_fn(|i| run(&inner[i], Dual::variables(&point)));
        let through = run(&program, inside).partials;
        for (k, found) in through.into_iter().enumerate() {
            let terms = [0, 1, 2].map(|i| by_inner[i] * inside[i].partials[k]);
            let size: f64 = terms.iter().map(|term| term.abs()).sum();
            let error = (found - terms.iter().sum::<f64>()).abs();
            // The terms may cancel in another order; 1e-11 allows derivatives of 1e3 in between.
            prop_assert!(error <= 1e-11 * size.max(1.0), "{k}: {error}");
        }
    }
}

/// One instruction: its code and the two registers it reads.
type Step = (u8, usize, usize);

fn program() -> impl Strategy<Value = Vec<Step>> {
    prop::collection::vec((0..13u8, 0..64usize, 0..64usize), 1..7)
}

/// Off the switch of instruction 9 by more than the difference step.
fn point() -> impl Strategy<Value = [f64; 3]> {
    (
        prop_oneof![-1.0..0.24f64, 0.26..1.0f64],
        -1.0..1.0f64,
        -1.0..1.0f64,
    )
        .prop_map(|(x, y, z)| [x, y, z])
}

/// Every operation of [`Real`], kept smooth and bounded so that differences of it are accurate.
fn run<T: Real>(program: &[Step], start: [T; 3]) -> T {
    let mut registers = start.to_vec();
    let mut last = start[0];
    for &(code, i, j) in program {
        // The newest register first, so that programs are deep.
        let a = registers[registers.len() - 1 - i % 2];
        let b = registers[j % registers.len()];
        last = match code {
            0 => (a + b) * 0.5,
            1 => (a - b) / 2.0,
            2 => (a * b).sin(),
            3 => a / (b.squared() + 1.0),
            4 => (a.squared() + 0.5).sqrt() - 0.5,
            5 => b.sin().exp() * 0.5,
            6 => a.cos().exp_m1(),
            7 => (a.squared() + b.squared() + 1.0).ln(),
            8 => a.mul_add(b, -a).cos(),
            9 => start[0].where_less(a.like(0.25), || a * 0.8, || (b * 0.5).sin()),
            10 => a.look_up(b, |u, v| {
                [u.sin() * v.cos(), u.cos() * v.cos(), -u.sin() * v.sin()]
            }),
            11 => (a - 8.0).abs() - 8.0,
            _ => a.at_most(a + 1.0).at_least(a - b.exp()) - 0.25,
        };
        registers.push(last);
    }
    last
}

/// Central differences of order four.
fn difference(function: impl Fn(f64) -> f64) -> f64 {
    let h = 1e-3;
    let central = |h: f64| (function(h) - function(-h)) / (2.0 * h);
    (4.0 * central(h) - central(2.0 * h)) / 3.0
}

#[test]
fn only_the_branch_taken_is_evaluated() {
    let x = Dual::<1>::variable(1.0, 0);
    let dead = || -> Dual<1> { unreachable!("this branch is not taken") };
    assert_eq!(x.where_less(x.like(2.0), || x, dead), x);
    assert_eq!(x.where_less(x.like(1.0), dead, || x), x);
    let nan = x.like(f64::NAN);
    assert_eq!(nan.where_less(x, dead, || x), x);
}

#[test]
fn where_there_is_no_derivative_the_documented_one_is_given() {
    let zero = Dual::<2>::variable(0.0, 0);
    assert_eq!(zero.abs().partials, [0.0, 0.0]);
    let [by_x, by_other] = zero.sqrt().partials;
    assert!(by_x == f64::INFINITY && by_other.is_nan());
}

#[test]
fn a_small_slope_of_exp_m1_keeps_its_digits() {
    let found = Dual::<1>::variable(-50.0, 0).exp_m1().partials[0];
    assert_eq!(found, (-50.0f64).exp());
}

#[test]
fn a_variable_beyond_the_last_is_a_constant() {
    assert_eq!(Dual::<2>::variable(3.0, 2), Dual::constant(3.0));
}

/// A function from R^2 to R^3 with a Jacobian on paper.
fn spherical<T: Real>(x: &[T; 2]) -> [T; 3] {
    let [r, phi] = *x;
    [r * phi.cos(), r * phi.sin(), r.squared() * 0.5]
}

#[test]
fn exact_jacobian_is_rectangular_rows_are_functions() {
    let (r, phi) = (2.0, 0.3f64);
    let found = jacobian_exact(spherical, &[r, phi]);
    let expected = [
        [phi.cos(), -r * phi.sin()],
        [phi.sin(), r * phi.cos()],
        [r, 0.0],
    ];
    for row in 0..3 {
        for column in 0..2 {
            assert!(close(found[(row, column)], expected[row][column], ROUNDING));
        }
    }
}

proptest! {
    #[test]
    fn prop_exact_jacobian_agrees_with_central_differences(
        (programs, point) in ([program(), program(), program()], point())
    ) {
        let exact = jacobian_exact(|x| programs.each_ref().map(|p| run(p, *x)), &point);
        let differences = jacobian(|x| programs.each_ref().map(|p| run(p, *x)), &point, &[1.0; 3]);
        // The step is 6e-6: its square times a third derivative below 1e3, and rounding 1e-16 / 6e-6.
        prop_assert!((exact - differences).amax() <= 1e-7 * exact.amax().max(1.0));
    }
}
