//! The elementary functions: accuracy, special numbers, independence of the lanes, identities.

use gt_plant::lanes::{LARGEST_ANGLE, Pack};
use gt_plant::real::Real;
use pulp::{Arch, Simd, WithSimd};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::sets;

/// Units in the last place by which a function of lanes and that of the standard library, whose
/// own error is below 1, may differ.
const BOUND_ULP: u64 = 2;

/// Relative difference of the instruction sets' results: 2 * `BOUND_ULP` * 2^-52, rounded up.
const BOUND_BETWEEN_SETS: f64 = 1e-15;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Function {
    Exp,
    ExpM1,
    Ln,
    Sin,
    Cos,
}

use Function::{Cos, Exp, ExpM1, Ln, Sin};

const FUNCTIONS: [Function; 5] = [Exp, ExpM1, Ln, Sin, Cos];

impl Function {
    #[inline(always)]
    fn of<R: Real>(self, x: R) -> R {
        match self {
            Exp => x.exp(),
            ExpM1 => x.exp_m1(),
            Ln => x.ln(),
            Sin => x.sin(),
            Cos => x.cos(),
        }
    }

    /// Arguments over the domain of which the bound is stated, dense where it is delicate.
    fn arguments(self) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut draw = |count: u32, from: f64, to: f64| -> Vec<f64> {
            (0..count).map(|_| random.random_range(from..to)).collect()
        };
        let turn = std::f64::consts::TAU;
        let small = |exponents: Vec<f64>| -> Vec<f64> {
            let signed = |e: f64| [e.exp2(), -e.exp2()];
            exponents.into_iter().flat_map(signed).collect()
        };
        let beside = |centres: Vec<f64>| -> Vec<f64> {
            let around = |x: f64| [x.next_down().next_down(), x.next_down(), x, x.next_up()];
            centres.into_iter().flat_map(around).collect()
        };
        match self {
            Exp | ExpM1 => [
                draw(100_000, -700.0, 700.0),
                draw(100_000, -2.0, 2.0),
                small(draw(50_000, -1022.0, 0.0)),
                beside((-2000..=2000).map(|k| f64::from(k) * 0.34657359).collect()),
                vec![-700.0, 700.0, 709.78, 709.782712893384, -708.3964185322641],
            ]
            .concat(),
            Ln => [
                draw(100_000, -1022.0, 1024.0)
                    .into_iter()
                    .map(f64::exp2)
                    .collect(),
                draw(100_000, 0.5, 2.0),
                small(draw(50_000, -53.0, -1.0))
                    .into_iter()
                    .map(|x| 1.0 + x)
                    .collect(),
                beside((-1021..1023).map(|k| f64::from(k).exp2()).collect()),
                beside((-1021..1023).map(|k| (f64::from(k) + 0.5).exp2()).collect()),
                vec![f64::MIN_POSITIVE, f64::MAX],
            ]
            .concat(),
            Sin | Cos => [
                draw(100_000, -turn, turn),
                draw(50_000, -1000.0, 1000.0),
                draw(50_000, -LARGEST_ANGLE, LARGEST_ANGLE),
                small(draw(50_000, -1022.0, 0.0)),
                // Zeros, extremes and the seams of the reduction.
                beside((-667_000..667_000).step_by(61).map(eighth).collect()),
                beside((-5000..5000).map(eighth).collect()),
                vec![LARGEST_ANGLE, -LARGEST_ANGLE],
            ]
            .concat(),
        }
    }
}

/// `k` eighths of a turn.
fn eighth(k: i32) -> f64 {
    f64::from(k) * std::f64::consts::FRAC_PI_4
}

/// A function of every number, a pack at a time.
struct Each<'a>(Function, &'a [f64]);

impl WithSimd for Each<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
        let mut results = vec![0.0; self.1.len()];
        let lanes = Pack::<S>::LANES;
        for (from, to) in self.1.chunks(lanes).zip(results.chunks_mut(lanes)) {
            self.0.of(Pack::load(simd, from)).store(to);
        }
        results
    }
}

/// Numbers that order as the doubles do.
fn place(x: f64) -> i64 {
    let bits = x.to_bits().cast_signed();
    if bits < 0 { i64::MIN - bits } else { bits }
}

#[test]
fn prop_functions_are_within_two_ulp() {
    for (set, arch) in sets() {
        for function in FUNCTIONS {
            let x = function.arguments();
            let y = arch.dispatch(Each(function, &x));
            let errors = x.iter().zip(&y).map(|(&x, &y)| {
                let expected = function.of(x);
                (place(y).abs_diff(place(expected)), x, y, expected)
            });
            let worst = errors.max_by_key(|error| error.0);
            let (error, x, y, expected) = worst.unwrap();
            println!("{set} {function:?}: {error} ulp at {x:e}");
            assert!(
                error <= BOUND_ULP,
                "{set}: {function:?}({x:e}) = {y:e}, not {expected:e}: {error} ulp"
            );
        }
    }
}

#[test]
fn functions_of_special_numbers() {
    let (inf, nan, tiny) = (f64::INFINITY, f64::NAN, f64::from_bits(1));
    let cases: [(Function, &[(f64, f64)]); 5] = [
        (
            Exp,
            &[
                (0.0, 1.0),
                (-0.0, 1.0),
                (tiny, 1.0),
                (709.783, inf),
                (f64::MAX, inf),
                (inf, inf),
                (-708.397, 0.0),
                (-745.0, 0.0),
                (-f64::MAX, 0.0),
                (-inf, 0.0),
                (nan, nan),
            ],
        ),
        (
            ExpM1,
            &[
                (0.0, 0.0),
                (-0.0, -0.0),
                (tiny, tiny),
                (-tiny, -tiny),
                (709.783, inf),
                (f64::MAX, inf),
                (inf, inf),
                (-40.1, -1.0),
                (-1e5, -1.0),
                (-f64::MAX, -1.0),
                (-inf, -1.0),
                (nan, nan),
            ],
        ),
        (
            Ln,
            &[
                (1.0, 0.0),
                (0.0, -inf),
                (-0.0, -inf),
                (tiny, -inf),
                (-tiny, -inf),
                (-f64::MIN_POSITIVE, nan),
                (-1.0, nan),
                (-inf, nan),
                (inf, inf),
                (nan, nan),
            ],
        ),
        (
            Sin,
            &[
                (0.0, 0.0),
                (-0.0, -0.0),
                (tiny, tiny),
                (LARGEST_ANGLE.next_up(), nan),
                (-1e300, nan),
                (inf, nan),
                (nan, nan),
            ],
        ),
        (
            Cos,
            &[
                (0.0, 1.0),
                (-0.0, 1.0),
                (tiny, 1.0),
                (LARGEST_ANGLE.next_up(), nan),
                (-1e300, nan),
                (-inf, nan),
                (nan, nan),
            ],
        ),
    ];
    for (set, arch) in sets() {
        for (function, cases) in cases {
            let x: Vec<f64> = cases.iter().map(|case| case.0).collect();
            let results = arch.dispatch(Each(function, &x));
            for (&(x, expected), y) in cases.iter().zip(results) {
                let same = y.to_bits() == expected.to_bits() || y.is_nan() && expected.is_nan();
                assert!(same, "{set}: {function:?}({x:e}) = {y:e}, not {expected:e}");
            }
        }
    }
}

#[test]
fn prop_instruction_sets_agree() {
    for function in FUNCTIONS {
        let x = function.arguments();
        let plain = Arch::Scalar.dispatch(Each(function, &x));
        for (set, arch) in sets() {
            let other = arch.dispatch(Each(function, &x));
            for ((x, a), b) in x.iter().zip(&plain).zip(other) {
                // A subnormal result has no relative precision to speak of.
                let bound = BOUND_BETWEEN_SETS * a.abs().max(f64::MIN_POSITIVE);
                assert!((a - b).abs() <= bound, "{set}: {function:?}({x:e})");
            }
        }
    }
}

/// The results of a number in every lane, beside every neighbour.
struct InEveryLane<'a>(Function, f64, &'a [f64]);

impl WithSimd for InEveryLane<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
        let mut results = Vec::new();
        for lane in 0..Pack::<S>::LANES {
            for shift in 0..self.2.len() {
                let neighbour = |other: usize| self.2[(other + shift) % self.2.len()];
                let number = |other| {
                    if other == lane {
                        self.1
                    } else {
                        neighbour(other)
                    }
                };
                let pack = self.0.of(Pack::from_fn(simd, number));
                results.push(pack.lanes()[lane]);
            }
        }
        results
    }
}

#[test]
fn prop_lanes_are_independent() {
    let neighbours = [
        f64::NAN,
        f64::INFINITY,
        -1e3,
        0.0,
        0.3,
        -f64::INFINITY,
        1e-310,
        700.0,
        5.0,
        -0.7,
        1e5,
    ];
    for (set, arch) in sets() {
        for function in FUNCTIONS {
            for x in [0.1, 0.9, 3.7, -2.2, 42.0, 300.0] {
                let alone = arch.dispatch(Each(function, &[x]))[0];
                for result in arch.dispatch(InEveryLane(function, x, &neighbours)) {
                    let same = result.to_bits() == alone.to_bits();
                    assert!(
                        same || result.is_nan() && alone.is_nan(),
                        "{set} {function:?}({x})"
                    );
                }
            }
        }
    }
}

/// `ln(exp(x)) - x`, `exp(ln(exp_m1(x) + 1)) - exp(x)` and `sin^2 + cos^2 - 1` of every number.
struct Identities<'a>(&'a [f64]);

impl WithSimd for Identities<'_> {
    type Output = Vec<[f64; 3]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut results = Vec::new();
        for group in self.0.chunks(Pack::<S>::LANES) {
            let x = Pack::load(simd, group);
            let packs = [
                x.exp().ln() - x,
                ((x.exp_m1() + 1.0).ln().exp() - x.exp()) / x.exp(),
                x.sin().squared() + x.cos().squared() - 1.0,
            ];
            results.extend((0..group.len()).map(|lane| packs.map(|pack| pack.lanes()[lane])));
        }
        results
    }
}

#[test]
fn prop_identities_hold() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let x: Vec<f64> = (0..10_000)
        .map(|_| random.random_range(-8.0..8.0))
        .collect();
    for (set, arch) in sets() {
        for (x, [log, power, circle]) in x.iter().zip(arch.dispatch(Identities(&x))) {
            // A result of 2 ulp moves the logarithm by 2^-51, rounding at 8 adds as much.
            assert!(log.abs() < 3e-15, "{set}: ln(exp({x})) is off by {log:e}");
            // The 1 is added to a number that may be near -1: exp(8) units of 2^-53.
            let bound = 2e-15 * (1.0 + (-x).exp());
            assert!(power.abs() < bound, "{set}: at {x}: {power:e}");
            assert!(circle.abs() < 1e-15, "{set}: at {x}: {circle:e}");
        }
    }
}
