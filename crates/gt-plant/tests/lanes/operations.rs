//! What must be the same in lanes and plain numbers, bit for bit.

use gt_plant::lanes::Pack;
use gt_plant::real::Real;
use pulp::{Simd, WithSimd};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::sets;

/// What the functions of two numbers give for every pair: see `pairwise`.
struct Pairs<'a>(&'a [(f64, f64)]);

/// Every function of [`Real`] that must be the same, bit for bit, in lanes and plain numbers.
#[inline(always)]
fn pairwise<R: Real>(a: R, b: R) -> [R; 20] {
    [
        a + b,
        a - b,
        a * b,
        a / b,
        a + 1.5,
        a - 1.5,
        a * 1.5,
        a / 1.5,
        -a,
        a.like(2.5),
        a.sqrt(),
        a.abs(),
        a.squared(),
        a.at_most(b),
        a.at_least(b),
        a.where_less(
            b,
            #[inline(always)]
            || a + 1.0,
            #[inline(always)]
            || b * 2.0,
        ),
        b.where_less(
            a,
            || b,
            #[inline(always)]
            || a / 4.0,
        ),
        a.look_up(b, |a, b| [a - 2.0 * b, 1.0, -2.0]),
        // The products are exact, so that fused and separate rounding agree.
        a.like(3.0).mul_add(b.like(0.5), a),
        a.where_less(b, || b.like(f64::NAN), || a),
    ]
}

impl WithSimd for Pairs<'_> {
    type Output = Vec<[f64; 20]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; 20]> {
        let mut results = Vec::new();
        for pairs in self.0.chunks(Pack::<S>::LANES) {
            let a: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
            let b: Vec<f64> = pairs.iter().map(|pair| pair.1).collect();
            let packs = pairwise(Pack::load(simd, &a), Pack::load(simd, &b));
            for lane in 0..pairs.len() {
                results.push(packs.map(|pack| pack.lanes()[lane]));
            }
        }
        results
    }
}

#[test]
fn prop_operations_are_those_of_plain_numbers() {
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f64::NAN,
        f64::INFINITY,
        -f64::INFINITY,
        f64::MIN_POSITIVE,
        1e-310,
        f64::MAX,
    ];
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let mut pairs: Vec<(f64, f64)> = (0..1000)
        .map(|_| {
            (
                random.random_range(-5.0..5.0),
                random.random_range(-5.0..5.0),
            )
        })
        .collect();
    pairs.extend(special.iter().flat_map(|&a| special.map(|b| (a, b))));
    for (set, arch) in sets() {
        let results = arch.dispatch(Pairs(&pairs));
        assert_eq!(results.len(), pairs.len());
        for (&(a, b), result) in pairs.iter().zip(results) {
            for (at, (lane, plain)) in result.into_iter().zip(pairwise(a, b)).enumerate() {
                let same = lane.to_bits() == plain.to_bits() || lane.is_nan() && plain.is_nan();
                assert!(
                    same,
                    "{set}, {at}: of {a:e} and {b:e}: {lane:e}, not {plain:e}"
                );
            }
        }
    }
}

#[test]
fn loads_and_stores_reach_no_further_than_the_slice() {
    struct Short;
    impl WithSimd for Short {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let lanes = Pack::<S>::LANES;
            let numbers: Vec<f64> = (0..20_u8).map(f64::from).collect();
            for count in 0..numbers.len() {
                let pack = Pack::load(simd, &numbers[..count]);
                for (lane, &number) in pack.lanes().iter().enumerate() {
                    let last = count.saturating_sub(1);
                    assert_eq!(number.to_bits(), numbers[lane.min(last)].to_bits());
                }
                let mut stored = vec![-1.0; count];
                (pack + 1.0).store(&mut stored);
                for (index, &number) in stored.iter().enumerate() {
                    let expected = if index < lanes {
                        numbers[index] + 1.0
                    } else {
                        -1.0
                    };
                    assert_eq!(number.to_bits(), f64::to_bits(expected));
                }
            }
        }
    }
    for (_, arch) in sets() {
        arch.dispatch(Short);
    }
}
