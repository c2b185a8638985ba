//! The plant's derivative on every instruction set.

use gt_plant::dynamics::derivative;
use gt_plant::lanes::{self, Pack};
use gt_plant::state::STATES;
use gt_plant::{
    ActuatorFault, FaultSizes, Inputs, MapSet, PlantParameters, Variant, lanes_at_once, rk4,
    steady_state,
};
use pulp::{Arch, Simd, WithSimd};

/// Plants that start apart from each other.
const PLANTS: usize = 8;
const STEPS: usize = 500;
const STEP_S: f64 = 2e-3;

/// The ends of some plants under held inputs and faults.
struct Ends<'a> {
    parameters: &'a PlantParameters,
    faults: FaultSizes,
    starts: &'a [[f64; STATES]; PLANTS],
}

impl WithSimd for Ends<'_> {
    type Output = Vec<[f64; STATES]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; STATES]> {
        let zero = Pack::splat(simd, 0.0);
        let inputs = Inputs::design(self.parameters).like(zero);
        let faults = self.faults.like(zero);
        let mut ends = Vec::new();
        for group in self.starts.chunks(Pack::<S>::LANES) {
            let mut x = [zero; STATES];
            for (state, x) in x.iter_mut().enumerate() {
                for (lane, start) in group.iter().enumerate() {
                    x.set(lane, start[state]);
                }
            }
            for _ in 0..STEPS {
                x = rk4::step(
                    #[inline(always)]
                    |_, x: &[Pack<S>; STATES]| derivative(self.parameters, &inputs, &faults, x),
                    0.0,
                    &x,
                    STEP_S,
                );
            }
            ends.extend((0..group.len()).map(|lane| x.map(|state| state.lanes()[lane])));
        }
        ends
    }
}

/// The instruction sets with fused multiplication that the machine has, narrow ones first.
fn fused() -> Vec<Arch> {
    #[cfg(target_arch = "x86_64")]
    {
        let narrow = pulp::x86::V3::try_new().map(Arch::V3);
        let wide = pulp::x86::V4::try_new().map(Arch::V4);
        narrow.into_iter().chain(wide).collect()
    }
    #[cfg(not(target_arch = "x86_64"))]
    vec![]
}

#[test]
fn instruction_sets_agree() {
    let lagging = FaultSizes {
        compressor_flow_loss: 0.01,
        fuel: ActuatorFault {
            gain_error: 0.01,
            lag_s: 0.3,
            ..ActuatorFault::HEALTHY
        },
        ..FaultSizes::HEALTHY
    };
    for variant in [Variant::Prototype, Variant::Cogeneration] {
        for (map_set, faults) in [
            (MapSet::Paper, FaultSizes::HEALTHY),
            (MapSet::Axial, lagging),
        ] {
            let parameters = PlantParameters::new(variant, map_set);
            let state = steady_state(&parameters).unwrap().state.to_array();
            let mut starts = [state; PLANTS];
            for (plant, start) in starts.iter_mut().enumerate() {
                // None at the equilibrium, where the vanes' controller stands on the corner of its
                // stop and rounding decides whether it integrates.
                start[3] *= 1.0 + 1e-3 * (plant + 1) as f64;
                start[10] *= 1.0 - 1e-3 * (plant + 1) as f64;
            }
            let ends = |arch: Arch| {
                arch.dispatch(Ends {
                    parameters: &parameters,
                    faults,
                    starts: &starts,
                })
            };
            let plain = ends(Arch::Scalar);
            let fused: Vec<_> = fused().into_iter().map(ends).collect();
            for fused in &fused {
                for (found, expected) in fused.iter().flatten().zip(plain.iter().flatten()) {
                    // Fused multiplications round less often; the integral of a speed error has
                    // the rounding errors of the speed.
                    let close = (found - expected).abs() <= 1e-11 * expected.abs().max(0.1);
                    assert!(close, "{variant}: {found} {expected}");
                }
            }
            let bits = |ends: &[[f64; STATES]]| -> Vec<u64> {
                ends.iter().flatten().map(|x| x.to_bits()).collect()
            };
            if let [narrow, wide] = fused.as_slice() {
                assert!(bits(narrow) == bits(wide), "{variant}: AVX2 and AVX-512");
            }
        }
    }
}

#[test]
fn as_many_runs_at_once_as_the_widest_register_has_lanes() {
    struct Width;
    impl WithSimd for Width {
        type Output = usize;
        fn with_simd<S: Simd>(self, _: S) -> usize {
            lanes::Pack::<S>::LANES
        }
    }
    assert_eq!(lanes_at_once(), Arch::new().dispatch(Width));
}
