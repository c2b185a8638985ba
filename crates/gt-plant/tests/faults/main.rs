//! Faults of sensors and actuators in runs, against the truth of the simulator, and as text.
#![expect(
    clippy::unwrap_used,
    reason = "the helpers stand outside the test functions"
)]

mod actuators;
mod files;
mod sensors;

use gt_plant::{
    ActuatorId, Channel, ChannelRow, Fault, FaultCase, Mode, Noise, NoiseLevel, Profile, Ramp, Run,
    Scenario, Shape, Step, Variant, Warning, simulate,
};

fn scenario(faults: Vec<Fault>) -> Scenario {
    Scenario {
        duration_s: 40.0,
        seed: 7,
        faults,
        ..Scenario::default()
    }
}

fn channel(name: &str) -> Channel {
    Channel::named(name).unwrap()
}

fn step(size: f64) -> Shape {
    Shape::Step(Step { size })
}

fn ramp(rate_per_h: f64) -> Shape {
    Shape::Ramp(Ramp {
        rate_per_h,
        limit: None,
    })
}

fn sensor(name: &str, mode: Mode, onset_s: f64, shape: Shape) -> Fault {
    Fault::sensor(channel(name), mode, onset_s, shape)
}

/// A row of the truth or of what was measured.
fn row(run: &Run, truth: bool, channel: Channel) -> Vec<f64> {
    let data = if truth { &run.truth } else { &run.measured };
    let row = match channel.row() {
        ChannelRow::Input(row) => data.u().row(row),
        ChannelRow::Output(row) => data.y().row(row),
    };
    row.iter().copied().collect()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Runs at most one fault of a sensor, checks that it changes the reading of that sensor alone, and
/// gives the magnitude, the truth and the reading at every sample.
fn read_with(faults: &[Fault], noise: &Noise, name: &str) -> [Vec<f64>; 3] {
    let run_with = |faults: &[Fault]| {
        simulate(&Scenario {
            noise: noise.clone(),
            ..scenario(faults.to_vec())
        })
        .unwrap()
    };
    let (healthy, faulty) = (run_with(&[]), run_with(faults));
    for other in Channel::of(Variant::Prototype) {
        let same = |truth| bits(&row(&healthy, truth, other)) == bits(&row(&faulty, truth, other));
        assert!(same(true), "the plant sees nothing of {name}: {other}");
        assert!(same(false) || other.name() == name, "{other}");
    }
    // One row, or none.
    let magnitudes = faulty.fault_magnitudes.iter().copied().collect();
    let of = channel(name);
    [magnitudes, row(&faulty, true, of), row(&faulty, false, of)]
}

#[test]
fn seeds_decide_random_faults() {
    let fault = Fault::actuator(ActuatorId::Fuel, Mode::Noise, 0.0, step(0.002));
    let noisy = sensor("p3", Mode::Noise, 0.0, step(100.0));
    let run = |seed, run_index| {
        simulate(&Scenario {
            seed,
            run_index,
            profile: Profile::named(Variant::Prototype, "steady").unwrap(),
            ..scenario(vec![fault.clone(), noisy.clone()])
        })
        .unwrap()
    };
    let first = run(1, 0);
    assert_eq!(first, run(1, 0));
    for other in [run(2, 0), run(1, 1)] {
        assert_ne!(first.truth.y(), other.truth.y());
        let noise = |run: &Run| run.measured.y() - run.truth.y();
        assert_ne!(noise(&first), noise(&other));
    }
}

#[test]
fn a_fault_with_share_noise_and_no_excitation_is_still_warned_about() {
    let run = simulate(&Scenario {
        profile: Profile::named(Variant::Prototype, "steady").unwrap(),
        noise: NoiseLevel::Low.into(),
        ..scenario(vec![Fault::nominal(FaultCase::TurbineDamage, 8.0)])
    })
    .unwrap();
    assert_eq!(run.warnings, [Warning::NoNoise]);
    assert_eq!(run.truth.y(), run.measured.y());
}
