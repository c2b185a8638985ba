//! What the instruction sets do with the plant's derivative, without drive, faults and records.

use std::hint::black_box;

use gtfdi::plant::dynamics::derivative;
use gtfdi::plant::lanes::Pack;
use gtfdi::plant::state::STATES;
use gtfdi::plant::{FaultSizes, Inputs, PlantParameters, rk4};
use pulp::{Arch, Simd, WithSimd};

/// Steps of some plants with held inputs, as many plants at once as there are lanes.
#[derive(Clone, Copy)]
pub struct Steps<'a> {
    /// The plant.
    pub parameters: &'a PlantParameters,
    /// Where every plant starts.
    pub start: &'a [f64; STATES],
    /// Number of plants.
    pub plants: usize,
    /// Steps of each plant.
    pub count: usize,
    /// Length of a step, s.
    pub step_s: f64,
}

/// An instruction set of the machine, and the names of its rows.
pub struct Set {
    pub arch: Arch,
    pub floor: &'static str,
    pub limit: &'static str,
}

/// The instruction sets with lanes that the machine has, the widest first.
pub fn sets() -> Vec<Set> {
    #[cfg(target_arch = "x86_64")]
    {
        let wide = pulp::x86::V4::try_new().map(|simd| Set {
            arch: Arch::V4(simd),
            floor: "floor, AVX-512: derivative alone, 4 a step",
            limit: "limit, AVX-512: bare RK4, inputs held",
        });
        let narrow = pulp::x86::V3::try_new().map(|simd| Set {
            arch: Arch::V3(simd),
            floor: "floor, AVX2: derivative alone, 4 a step",
            limit: "limit, AVX2: bare RK4, inputs held",
        });
        wide.into_iter().chain(narrow).collect()
    }
    #[cfg(not(target_arch = "x86_64"))]
    vec![Set {
        arch: Arch::new(),
        floor: "floor, lanes: derivative alone, 4 a step",
        limit: "limit, lanes: bare RK4, inputs held",
    }]
}

/// The floor: four derivatives a step and nothing else.
pub struct Derivatives<'a>(pub Steps<'a>);

impl WithSimd for Derivatives<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(of) = self;
        let (x, inputs, healthy) = of.lanes(simd);
        for _ in 0..4 * of.count * of.plants.div_ceil(Pack::<S>::LANES) {
            black_box(derivative(of.parameters, &inputs, &healthy, black_box(&x)));
        }
    }
}

/// The limit: RK4 and nothing else. Gives the state of the last plant.
pub struct Integrated<'a>(pub Steps<'a>);

impl WithSimd for Integrated<'_> {
    type Output = [f64; STATES];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; STATES] {
        let Self(of) = self;
        let (start, inputs, healthy) = of.lanes(simd);
        let mut x = start;
        for _ in 0..of.plants.div_ceil(Pack::<S>::LANES) {
            x = *black_box(&start);
            for _ in 0..of.count {
                x = rk4::step(
                    #[inline(always)]
                    |_, x: &[Pack<S>; STATES]| derivative(of.parameters, &inputs, &healthy, x),
                    0.0,
                    &x,
                    of.step_s,
                );
            }
        }
        x.map(|state| state.lanes()[0])
    }
}

type Start<S> = ([Pack<S>; STATES], Inputs<Pack<S>>, FaultSizes<Pack<S>>);

impl Steps<'_> {
    /// Those of the design point with a little more heat, so that the plants move.
    pub fn inputs(&self) -> Inputs {
        Inputs {
            heat_release_fraction: 0.01,
            ..Inputs::design(self.parameters)
        }
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S) -> Start<S> {
        let zero = Pack::splat(simd, 0.0);
        let mut x = [zero; STATES];
        for (to, from) in x.iter_mut().zip(self.start) {
            *to = Pack::splat(simd, *from);
        }
        (x, self.inputs().like(zero), FaultSizes::HEALTHY.like(zero))
    }
}
