//! One text integrates plain numbers and lanes.

use gt_plant::lanes::Pack;
use gt_plant::real::Real;
use pulp::{Simd, WithSimd};

use crate::sets;

/// A system `dx/dt = rates(x)`, written once for plain numbers and lanes.
trait Flow<const N: usize> {
    fn rates<R: Real>(&self, x: &[R; N]) -> [R; N];
}

/// `x'' = stiffness (1 - x^2) x' - x`.
struct VanDerPol {
    stiffness: f64,
}

impl Flow<2> for VanDerPol {
    #[inline(always)]
    fn rates<R: Real>(&self, &[x, v]: &[R; 2]) -> [R; 2] {
        [v, (-x.squared() + 1.0) * v * self.stiffness - x]
    }
}

/// Lotka and Volterra in the logarithms of the populations.
struct Prey;

impl Flow<2> for Prey {
    #[inline(always)]
    fn rates<R: Real>(&self, &[prey, hunters]: &[R; 2]) -> [R; 2] {
        [-hunters.exp() + 1.0, prey.exp_m1() * 0.7]
    }
}

#[inline(always)]
fn rk4<R: Real, const N: usize>(flow: &impl Flow<N>, x: [R; N], step: f64) -> [R; N] {
    let mut slope = flow.rates(&x);
    let mut sum = slope;
    for (reach, weight) in [(0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        let middle = std::array::from_fn(|i| x[i] + slope[i] * (step * reach));
        slope = flow.rates(&middle);
        sum = std::array::from_fn(|i| sum[i] + slope[i] * weight);
    }
    std::array::from_fn(|i| x[i] + sum[i] * (step / 6.0))
}

/// Systems from many starts (one after another), integrated over 2000 steps.
struct Runs<'a, F>(&'a F, &'a [[f64; 2]]);

const STEPS: u32 = 2000;
const STEP: f64 = 0.005;

impl<F: Flow<2>> WithSimd for Runs<'_, F> {
    type Output = Vec<[f64; 2]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; 2]> {
        let mut ends = Vec::new();
        for group in self.1.chunks(Pack::<S>::LANES) {
            let last = group.len() - 1;
            let mut x: [Pack<S>; 2] = std::array::from_fn(|state| {
                Pack::from_fn(simd, |lane| group[lane.min(last)][state])
            });
            for _ in 0..STEPS {
                x = rk4(self.0, x, STEP);
            }
            ends.extend((0..group.len()).map(|lane| x.map(|state| state.lanes()[lane])));
        }
        ends
    }
}

fn lanes_integrate_like_plain_numbers(flow: &impl Flow<2>) {
    let starts: Vec<[f64; 2]> = (0..21_u8)
        .map(|k| [0.1 * f64::from(k) - 1.0, 0.5 - 0.02 * f64::from(k)])
        .collect();
    for (set, arch) in sets() {
        for (&start, end) in starts.iter().zip(arch.dispatch(Runs(flow, &starts))) {
            let mut x = start;
            for _ in 0..STEPS {
                x = rk4(flow, x, STEP);
            }
            for (lane, plain) in end.into_iter().zip(x) {
                // Rounding errors of 2000 steps on an orbit that amplifies them little.
                let bound = 1e-12 * (1.0 + plain.abs());
                assert!((lane - plain).abs() < bound, "{set}: {lane} and {plain}");
            }
        }
    }
}

#[test]
fn prop_lanes_integrate_van_der_pol_like_plain_numbers() {
    lanes_integrate_like_plain_numbers(&VanDerPol { stiffness: 1.5 });
}

#[test]
fn prop_lanes_integrate_lotka_volterra_like_plain_numbers() {
    lanes_integrate_like_plain_numbers(&Prey);
}
