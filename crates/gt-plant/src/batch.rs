//! Many runs at once: one plant in each lane of a register.

use pulp::{Arch, Simd, WithSimd};

use crate::dynamics::derivative;
use crate::faults::{ActuatorFault, FaultSizes};
use crate::inputs::Inputs;
use crate::lanes::Pack;
use crate::recorder::{Path, Recorder};
use crate::scenario::Scenario;
use crate::simulate::{Job, Run, finish};
use crate::state::STATES;
use crate::{PlantError, PlantParameters, rk4};

/// Runs scenarios of one plant, several at once on one core, and gives their records in the order
/// of the scenarios.
///
/// A record does not depend on what else is in the list: a lane's numbers are its own, and runs
/// that leave the plant's range end alone. It differs from the record of [`crate::simulate_with`]
/// by rounding (about 1e-13), because lanes have their own exponential and logarithm and may fuse
/// multiplications. Instruction sets are chosen at run time; AVX-512 and AVX2 give the same bits.
/// Threads are the caller's: one call on each part of a list gives what one call gives.
///
/// # Errors
/// As [`crate::simulate_with`], for each run by itself.
pub fn simulate_batch(
    parameters: &PlantParameters,
    scenarios: &[Scenario],
) -> Vec<Result<Run, PlantError>> {
    // A run whose noise is scaled by its healthy record takes two places.
    let mut healthy: Vec<Option<usize>> = Vec::with_capacity(scenarios.len());
    let mut jobs: Vec<Job> = Vec::with_capacity(scenarios.len());
    for scenario in scenarios {
        jobs.push(Job::faulty(scenario));
    }
    for scenario in scenarios {
        healthy.push(scenario.needs_healthy_record().then(|| {
            jobs.push(Job::healthy(scenario));
            jobs.len() - 1
        }));
    }
    let mut paths = integrate_all(parameters, &jobs);
    let references: Vec<Option<Result<Path, PlantError>>> = {
        let mut later = paths.split_off(scenarios.len()).into_iter();
        healthy
            .iter()
            .map(|reference| reference.and_then(|_| later.next()))
            .collect()
    };
    scenarios
        .iter()
        .zip(paths)
        .zip(references)
        .map(|((scenario, path), reference)| {
            finish(parameters, scenario, path?, reference.transpose()?.as_ref())
        })
        .collect()
}

/// The paths of all jobs, in their order.
fn integrate_all(parameters: &PlantParameters, jobs: &[Job]) -> Vec<Result<Path, PlantError>> {
    let mut paths: Vec<Option<Result<Path, PlantError>>> = jobs.iter().map(|_| None).collect();
    let mut ready: Vec<Member> = Vec::new();
    for (index, job) in jobs.iter().enumerate() {
        match job.start(parameters) {
            Ok((recorder, x)) => ready.push((index, recorder, x)),
            Err(error) => paths[index] = Some(Err(error)),
        }
    }
    // Lanes share their steps, are busy as long as the longest of them, and ask for faults if one
    // of them has any.
    ready.sort_by_key(|(index, recorder, _)| {
        let substeps = jobs[*index].scenario.substeps;
        (substeps, recorder.samples(), recorder.is_faulty(), *index)
    });
    let lanes = lanes_at_once();
    let mut rest = ready.as_mut_slice();
    while let Some((first, _, _)) = rest.first() {
        let substeps = jobs[*first].scenario.substeps;
        let alike = rest
            .iter()
            .take(lanes)
            .take_while(|(index, _, _)| jobs[*index].scenario.substeps == substeps)
            .count();
        let (group, others) = rest.split_at_mut(alike);
        Arch::new().dispatch(Group {
            parameters,
            substeps,
            step_s: jobs[group[0].0].scenario.step_s(),
            members: group,
        });
        rest = others;
    }
    for (index, recorder, _) in ready {
        paths[index] = Some(Ok(recorder.finish()));
    }
    // Every job has started or been refused.
    paths.into_iter().flatten().collect()
}

/// Runs that the widest instruction set of this machine takes at once.
pub fn lanes_at_once() -> usize {
    struct Width;
    impl WithSimd for Width {
        type Output = usize;
        fn with_simd<S: Simd>(self, _: S) -> usize {
            Pack::<S>::LANES
        }
    }
    Arch::new().dispatch(Width)
}

/// A run on its way: its place in the list, its recorder, its state at the last sample.
type Member<'p> = (usize, Recorder<'p>, [f64; STATES]);

/// Runs that are integrated together; no more than there are lanes.
struct Group<'a, 'r> {
    parameters: &'a PlantParameters,
    substeps: usize,
    step_s: f64,
    members: &'a mut [Member<'r>],
}

impl WithSimd for Group<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            parameters,
            substeps,
            step_s,
            members,
        } = self;
        let zero = Pack::splat(simd, 0.0);
        let mut x = [zero; STATES];
        for (i, x) in x.iter_mut().enumerate() {
            // The last member fills the lanes that are left.
            for lane in 0..Pack::<S>::LANES {
                x.set(lane, members[lane.min(members.len() - 1)].2[i]);
            }
        }
        let mut sample = 0;
        loop {
            let mut running = false;
            for (lane, (_, recorder, state)) in members.iter_mut().enumerate() {
                for (to, from) in state.iter_mut().zip(&x) {
                    *to = from.lanes()[lane];
                }
                running |= recorder.is_running() && recorder.sample(state);
            }
            if !running {
                return;
            }
            let start_s = crate::simulate::time_s(sample);
            sample += 1;
            let inputs = gathered_inputs(simd, members);
            let held = gathered_sizes(simd, members);
            let faulty = members.iter().any(|(_, recorder, _)| recorder.is_faulty());
            let healthy = FaultSizes::HEALTHY.like(zero);
            for substep in 0..substeps {
                let t = start_s + substep as f64 * step_s;
                x = if faulty {
                    rk4::step(
                        #[inline(always)]
                        |t, x: &[Pack<S>; STATES]| {
                            derivative(parameters, &inputs, &grown(&held, members, t), x)
                        },
                        t,
                        &x,
                        step_s,
                    )
                } else {
                    rk4::step(
                        #[inline(always)]
                        |_, x: &[Pack<S>; STATES]| derivative(parameters, &inputs, &healthy, x),
                        t,
                        &x,
                        step_s,
                    )
                };
            }
        }
    }
}

/// The inputs of every member; the last one fills the lanes that are left.
#[inline(always)]
fn gathered_inputs<S: Simd>(simd: S, members: &[Member]) -> Inputs<Pack<S>> {
    let last = members.len() - 1;
    let mut inputs = members[last].1.inputs().like(Pack::splat(simd, 0.0));
    for (lane, (_, recorder, _)) in members.iter().enumerate() {
        // Taken apart by name, so that a new field cannot be forgotten and shared by all lanes.
        let Inputs {
            valve_deg,
            speed_reference_rad_s,
            fuel_offset_kg_s,
            ambient_pa,
            ambient_k,
            heating_value_j_kg,
            heat_release_fraction,
            torque_n_m,
        } = *recorder.inputs();
        inputs.valve_deg.set(lane, valve_deg);
        inputs
            .speed_reference_rad_s
            .set(lane, speed_reference_rad_s);
        inputs.fuel_offset_kg_s.set(lane, fuel_offset_kg_s);
        inputs.ambient_pa.set(lane, ambient_pa);
        inputs.ambient_k.set(lane, ambient_k);
        inputs.heating_value_j_kg.set(lane, heating_value_j_kg);
        inputs
            .heat_release_fraction
            .set(lane, heat_release_fraction);
        inputs.torque_n_m.set(lane, torque_n_m);
    }
    inputs
}

/// The part of every member's fault sizes that holds until the next sample.
#[inline(always)]
fn gathered_sizes<S: Simd>(simd: S, members: &[Member]) -> FaultSizes<Pack<S>> {
    let mut sizes = FaultSizes::HEALTHY.like(Pack::splat(simd, 0.0));
    for (lane, (_, recorder, _)) in members.iter().enumerate() {
        let FaultSizes {
            compressor_flow_loss,
            turbine_efficiency_loss,
            fuel,
            valve,
            guide_vanes,
        } = recorder.held_sizes();
        sizes.compressor_flow_loss.set(lane, *compressor_flow_loss);
        sizes
            .turbine_efficiency_loss
            .set(lane, *turbine_efficiency_loss);
        set_actuator(&mut sizes.fuel, lane, fuel);
        set_actuator(&mut sizes.valve, lane, valve);
        set_actuator(&mut sizes.guide_vanes, lane, guide_vanes);
    }
    sizes
}

/// The sizes of every member's faults at a time; lanes without a member stay healthy.
#[inline(always)]
fn grown<S: Simd>(held: &FaultSizes<Pack<S>>, members: &[Member], t_s: f64) -> FaultSizes<Pack<S>> {
    let mut sizes = *held;
    for (lane, (_, recorder, _)) in members.iter().enumerate() {
        recorder.each_growing(
            t_s,
            #[inline(always)]
            |place, size| {
                let sum = place.of(&mut sizes);
                sum.set(lane, sum.lanes()[lane] + size);
            },
        );
    }
    sizes
}

#[inline(always)]
fn set_actuator<S: Simd>(of: &mut ActuatorFault<Pack<S>>, lane: usize, own: &ActuatorFault) {
    let ActuatorFault {
        gain_error,
        offset,
        stuck,
        stuck_at,
        lag_s,
    } = *own;
    of.gain_error.set(lane, gain_error);
    of.offset.set(lane, offset);
    of.stuck.set(lane, stuck);
    of.stuck_at.set(lane, stuck_at);
    of.lag_s.set(lane, lag_s);
}
