//! No sample and no step allocates: counted by the global allocator of this test program.
#![allow(unsafe_code)] // a global allocator is an unsafe trait; this one counts and forwards

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use gt_plant::dynamics::derivative;
use gt_plant::{
    ActuatorId, Channel, Course, Disturbance, Fault, FaultCase, FaultSizes, Fluctuation, Inputs,
    Mode, NoiseLevel, PlantParameters, Scenario, Shape, Sine, Step, Variant, rk4, simulate_batch,
    simulate_with, steady_state,
};

thread_local! {
    /// Allocations and reallocations of this thread (the test harness has others).
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is forwarded to the system's allocator unchanged; the counter is a
// thread-local `Cell` with a constant initialiser and no destructor, so it allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of some work.
fn allocations<T>(work: impl FnOnce() -> T) -> (usize, T) {
    let before = COUNT.with(Cell::get);
    let result = work();
    (COUNT.with(Cell::get) - before, result)
}

/// Eleven runs, more than a register has lanes: everything that can move does, with every fault
/// that reaches the plant.
#[allow(clippy::unwrap_used)] // part of the test below
fn scenarios(variant: Variant, duration_s: f64) -> Vec<Scenario> {
    let random = |deviation| {
        Some(Fluctuation {
            deviation,
            time_constant_s: 5.0,
        })
    };
    let step = |size| Shape::Step(Step { size });
    let spikes_per_h = 9000.0;
    let faults = [
        Fault::growing(FaultCase::CompressorFouling, 1.0, 360.0, Some(1.0)),
        Fault::growing(FaultCase::TurbineDamage, 1.0, 360.0, Some(1.0)),
        Fault::growing(FaultCase::FuelActuatorLag, 1.0, 36.0, Some(0.2)),
        Fault::actuator(ActuatorId::Valve, Mode::Stuck, 2.0, step(1.0)).until(4.0),
        Fault::actuator(ActuatorId::Fuel, Mode::Noise, 2.0, step(1e-4)),
        Fault::actuator(
            ActuatorId::Fuel,
            Mode::Spike { spikes_per_h },
            2.0,
            step(1e-3),
        ),
        Fault::sensor(Channel::named("t3").unwrap(), Mode::Lag, 2.0, step(1.0)),
    ];
    (0..11)
        .map(|run_index| {
            let mut scenario = Scenario {
                duration_s,
                run_index,
                noise: NoiseLevel::Table8.into(),
                disturbance: Disturbance {
                    heat_release_fraction: random(0.002),
                    torque_n_m: random(5.0),
                },
                ..Scenario::of(variant)
            };
            scenario.boundary.temperature_k = Course {
                sine: Some(Sine {
                    amplitude: 0.5,
                    period_s: 4.0,
                }),
                random: random(0.1),
                ..Course::default()
            };
            if run_index > 0 {
                scenario.faults = faults.to_vec();
            }
            scenario
        })
        .collect()
}

#[test]
#[allow(clippy::unwrap_used)]
fn a_longer_run_allocates_no_more_often() {
    for variant in [Variant::Prototype, Variant::Cogeneration] {
        let [short, long] = [8.0, 16.0].map(|duration_s| scenarios(variant, duration_s));
        let parameters = short[0].parameters();
        for (short, long) in short.iter().zip(&long) {
            let (few, run) = allocations(|| simulate_with(&parameters, short).unwrap());
            assert_eq!((run.truth.len(), run.ended), (100, None));
            let (many, run) = allocations(|| simulate_with(&parameters, long).unwrap());
            assert_eq!((run.truth.len(), run.ended), (200, None));
            assert!(few > 0, "the counter counts");
            // The records are larger, not more.
            assert_eq!(few, many, "one run, {variant}");
        }
        let (few, runs) = allocations(|| simulate_batch(&parameters, &short));
        assert!(runs.iter().all(|run| run.as_ref().unwrap().ended.is_none()));
        let (many, runs) = allocations(|| simulate_batch(&parameters, &long));
        assert!(runs.iter().all(|run| run.as_ref().unwrap().ended.is_none()));
        assert!(few > 0, "the counter counts");
        assert_eq!(few, many, "many runs at once, {variant}");
    }
}

#[test]
#[allow(clippy::unwrap_used)]
fn no_step_allocates() {
    for variant in [Variant::Prototype, Variant::Cogeneration] {
        let parameters = PlantParameters::new(variant, gt_plant::MapSet::Paper);
        let inputs = Inputs::design(&parameters);
        let start = steady_state(&parameters).unwrap().state.to_array();
        let (count, end) = allocations(|| {
            let rates = |_, x: &[f64; _]| derivative(&parameters, &inputs, &FaultSizes::HEALTHY, x);
            (0..1000).fold(start, |x, _| rk4::step(rates, 0.0, &x, 2e-3))
        });
        assert_eq!(count, 0, "{variant}");
        assert!((end[0] / start[0] - 1.0).abs() < 1e-9);
    }
}
