//! Faults of sensors and actuators in runs, against the truth of the simulator, and as text.
#![expect(
    clippy::unwrap_used,
    reason = "the helpers stand outside the test functions"
)]

use gt_plant::{
    ActuatorId, Channel, ChannelRow, Exponential, Fault, FaultCase, Intermittent, Mode, Noise,
    NoiseLevel, Profile, Ramp, Run, SAMPLE_TIME_S, Scenario, Shape, Step, Target, Variant, Warning,
    simulate,
};
use proptest::prelude::*;

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

/// What is added or multiplied is so exactly, on inputs as on outputs, for every shape.
#[test]
fn bias_drift_and_gain() {
    let shapes = [
        step(2.0),
        ramp(360.0),
        Shape::Exponential(Exponential {
            size: -3.0,
            time_constant_s: 4.0,
        }),
        Shape::Intermittent(Intermittent {
            size: 1.5,
            period_s: 2.0,
            on_s: 0.8,
        }),
    ];
    for name in ["a_v", "T_a", "t3", "N_t"] {
        for shape in shapes {
            for mode in [Mode::Bias, Mode::Drift, Mode::Gain] {
                let fault = sensor(name, mode, 8.0, shape).until(32.0);
                let [sizes, truth, reading] = read_with(&[fault], &Noise::default(), name);
                assert!(sizes[99] == 0.0 && sizes[400] == 0.0);
                assert!(sizes[105..400].iter().any(|size| *size != 0.0));
                for k in 0..sizes.len() {
                    let expected = if mode == Mode::Gain {
                        truth[k] * (1.0 + sizes[k] / 100.0)
                    } else {
                        truth[k] + sizes[k]
                    };
                    assert_eq!(
                        reading[k].to_bits(),
                        expected.to_bits(),
                        "{name} {mode} {k}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_stuck_sensor_repeats_its_reading_noise_included() {
    let fault = sensor("p3", Mode::Stuck, 8.0, step(1.0)).until(24.0);
    let noise = Noise::from(NoiseLevel::Table8);
    let healthy = read_with(&[], &noise, "p3");
    let [sizes, _, reading] = read_with(std::slice::from_ref(&fault), &noise, "p3");
    for k in 0..sizes.len() {
        let expected = healthy[2][if (100..300).contains(&k) { 100 } else { k }];
        assert_eq!(reading[k].to_bits(), expected.to_bits(), "{k}");
    }
    // Intermittently, it takes a new value each time.
    let shape = Shape::Intermittent(Intermittent {
        size: 1.0,
        period_s: 0.8,
        on_s: 0.4,
    });
    let [_, _, reading] = read_with(&[Fault { shape, ..fault }], &noise, "p3");
    for k in 100..300 {
        let expected = healthy[2][if k % 10 < 5 { k - k % 10 } else { k }];
        assert_eq!(reading[k].to_bits(), expected.to_bits(), "{k}");
    }
}

#[test]
fn a_dropout_is_nan_exactly_while_it_is_active() {
    let shape = Shape::Intermittent(Intermittent {
        size: 1.0,
        period_s: 4.0,
        on_s: 1.6,
    });
    for name in ["M_f", "t7"] {
        let fault = sensor(name, Mode::Dropout, 8.0, shape);
        let [sizes, truth, reading] = read_with(&[fault], &Noise::default(), name);
        for k in 0..sizes.len() {
            let active = k >= 100 && k % 50 < 20;
            assert_eq!(sizes[k].to_bits(), f64::from(u8::from(active)).to_bits());
            assert_eq!(reading[k].is_nan(), active, "{k}");
            assert!(active || reading[k].to_bits() == truth[k].to_bits());
        }
    }
}

/// The lagged reading of the truth, integrated: between samples the truth is taken as linear and
/// the lag is integrated in 1000 steps of the implicit midpoint rule, error (Ts / 1000)^2.
#[test]
fn a_lagging_sensor_follows_a_first_order_system() {
    let lag_s = 1.5;
    let fault = sensor("t7", Mode::Lag, 8.0, step(lag_s));
    let [_, truth, reading] = read_with(&[fault], &Noise::default(), "t7");
    let mut lagged = truth[99];
    let mut farthest = 0.0_f64;
    for k in 0..truth.len() {
        if k < 100 {
            assert_eq!(reading[k].to_bits(), truth[k].to_bits());
            continue;
        }
        let h = SAMPLE_TIME_S / 1000.0 / lag_s;
        for i in 0..1000 {
            let middle = truth[k - 1] + (truth[k] - truth[k - 1]) * (f64::from(i) + 0.5) / 1000.0;
            lagged = (lagged * (1.0 - 0.5 * h) + h * middle) / (1.0 + 0.5 * h);
        }
        assert!(
            (reading[k] - lagged).abs() < 1e-7,
            "{k}: {} {lagged}",
            reading[k]
        );
        farthest = farthest.max((reading[k] - truth[k]).abs());
    }
    assert!(farthest > 1.0, "the record moves: {farthest} K");
}

#[test]
fn spikes_are_as_many_as_asked_for() {
    let mode = Mode::Spike {
        spikes_per_h: 4500.0,
    };
    let fault = sensor("q_c", mode, 8.0, step(-50.0));
    let noise = Noise::default();
    let [_, truth, reading] = read_with(std::slice::from_ref(&fault), &noise, "q_c");
    let mut count = 0;
    for k in 0..truth.len() {
        let spike = reading[k].to_bits() != truth[k].to_bits();
        if spike {
            assert_eq!(reading[k].to_bits(), (truth[k] - 50.0).to_bits());
            assert!(k >= 100);
            count += 1;
        }
    }
    // A tenth of 400 samples: 40, standard deviation sqrt(400 0.1 0.9) = 6; five of them.
    assert!((10..=70).contains(&count), "{count}");
    // The seed decides where they are, and a second fault of the kind has others.
    let at = |faults: Vec<Fault>, seed| {
        let run = simulate(&Scenario {
            seed,
            profile: Profile::named(Variant::Prototype, "steady").unwrap(),
            ..scenario(faults)
        })
        .unwrap();
        let (truth, reading) = (
            row(&run, true, channel("q_c")),
            row(&run, false, channel("q_c")),
        );
        let share = |k: usize| ((reading[k] - truth[k]) / -50.0).round();
        (0..truth.len()).map(share).collect::<Vec<f64>>()
    };
    let first = at(vec![fault.clone()], 1);
    assert_eq!(first, at(vec![fault.clone()], 1));
    assert_ne!(first, at(vec![fault.clone()], 2));
    let both = at(vec![fault.clone(), fault], 1);
    assert!((0..500).all(|k| both[k] >= first[k]));
    assert_ne!(both, first.iter().map(|v| 2.0 * v).collect::<Vec<f64>>());
}

#[test]
fn a_noisy_sensor_has_the_deviation_asked_for() {
    let fault = sensor("w_t", Mode::Noise, 8.0, step(3.0));
    let [_, truth, reading] = read_with(std::slice::from_ref(&fault), &Noise::default(), "w_t");
    let noise: Vec<f64> = (0..500).map(|k| reading[k] - truth[k]).collect();
    assert!(noise[..100].iter().all(|value| *value == 0.0));
    let square = noise[100..].iter().map(|v| v * v).sum::<f64>() / 400.0;
    // Standard error of a deviation 1 / sqrt(2 N) = 3.5 %; five of them.
    assert!((square.sqrt() / 3.0 - 1.0).abs() < 0.18, "{square}");
    // It comes on top of the sensor's own, whose draws stay.
    let own = Noise::from(NoiseLevel::Low);
    let [_, _, healthy] = read_with(&[], &own, "w_t");
    let [_, _, both] = read_with(&[fault], &own, "w_t");
    for k in 0..500 {
        // Rounding of sums of 1500 rad/s.
        assert!((both[k] - healthy[k] - noise[k]).abs() < 1e-11, "{k}");
    }
}

#[test]
fn several_faults_add_up_in_their_order() {
    let faults = vec![
        sensor("t3", Mode::Bias, 8.0, step(2.0)),
        Fault::nominal(FaultCase::ThermocoupleDrift, 10.0),
        sensor("t3", Mode::Gain, 4.0, step(1.0)),
        sensor("t3", Mode::Drift, 8.0, ramp(3600.0)),
        sensor("t3", Mode::Dropout, 36.0, step(1.0)),
        sensor("p7", Mode::Bias, 8.0, step(100.0)),
        Fault::nominal(FaultCase::TurbineDamage, 8.0),
        Fault::nominal(FaultCase::TurbineDamage, 12.0),
    ];
    let run = simulate(&scenario(faults.clone())).unwrap();
    let names: Vec<&str> = run.fault_signals.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "t3_bias",
            "thermocouple_drift",
            "t3_gain",
            "t3_drift",
            "t3_dropout",
            "p7_bias",
            "turbine_damage",
            "turbine_damage_2"
        ]
    );
    let (truth, reading) = (
        row(&run, true, channel("t3")),
        row(&run, false, channel("t3")),
    );
    for k in 0..run.truth.len() {
        let t = k as f64 * SAMPLE_TIME_S;
        let sizes: Vec<f64> = faults.iter().map(|fault| fault.magnitude(t)).collect();
        assert_eq!(sizes, run.fault_magnitudes.column(k).as_slice());
        let expected = truth[k] * (1.0 + (sizes[1] + sizes[2]) / 100.0) + sizes[0] + sizes[3];
        if k < 450 {
            // Rounding of numbers of 600 K.
            assert!((reading[k] - expected).abs() < 1e-12, "{k}");
        } else {
            assert!(reading[k].is_nan());
        }
    }
    // The same damage twice is one of twice the rate from the second onset on.
    let once = |rate, onset_s| Fault::growing(FaultCase::TurbineDamage, onset_s, rate, None);
    let t5 = |faults| row(&simulate(&scenario(faults)).unwrap(), true, channel("t5"));
    let (twice, double) = (
        t5(vec![once(5.0, 8.0), once(5.0, 8.0)]),
        t5(vec![once(10.0, 8.0)]),
    );
    assert_eq!(bits(&twice), bits(&double));
}

/// The fuel that burns, from m9 = m5 + fuel, and the demand.
fn fuel(run: &Run) -> (Vec<f64>, Vec<f64>) {
    let (m5, m9) = (row(run, true, channel("m5")), row(run, true, channel("m9")));
    let burnt = m9.iter().zip(&m5).map(|(m9, m5)| m9 - m5).collect();
    (burnt, row(run, true, channel("M_f")))
}

#[test]
fn faults_of_the_fuel_valve_come_between_demand_and_fuel() {
    let run = |mode, shape| {
        let fault = Fault::actuator(ActuatorId::Fuel, mode, 8.0, shape).until(32.0);
        simulate(&scenario(vec![fault])).unwrap()
    };
    // Rounding of sums of about 8 kg/s.
    let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
    for (mode, shape) in [
        (Mode::Bias, step(0.02)),
        (Mode::Drift, ramp(2.0)),
        (Mode::Gain, step(5.0)),
    ] {
        let run = run(mode, shape);
        let (burnt, demand) = fuel(&run);
        for k in 0..run.truth.len() {
            let size = run.fault_magnitudes[(0, k)];
            let expected = match mode {
                Mode::Gain => demand[k] * (1.0 + size / 100.0),
                _ => demand[k] + size,
            };
            assert!(close(burnt[k], expected), "{mode} {k}");
        }
    }
    for mode in [Mode::Stuck, Mode::Dropout] {
        let (burnt, demand) = fuel(&run(mode, step(1.0)));
        for k in 0..500 {
            let expected = demand[if (100..400).contains(&k) { 100 } else { k }];
            assert!(close(burnt[k], expected), "{mode} {k}");
        }
    }
    let (burnt, demand) = fuel(&run(Mode::Noise, step(0.005)));
    let error: Vec<f64> = (0..500).map(|k| burnt[k] - demand[k]).collect();
    let square = error[100..400].iter().map(|v| v * v).sum::<f64>() / 300.0;
    // Standard error of a deviation 1 / sqrt(2 N) = 4 %; five of them.
    assert!((square.sqrt() / 0.005 - 1.0).abs() < 0.2, "{square}");
    let spikes_per_h = 4500.0;
    let (burnt, demand) = fuel(&run(Mode::Spike { spikes_per_h }, step(0.02)));
    let mut count = 0;
    for k in 0..500 {
        if !close(burnt[k], demand[k]) {
            assert!(close(burnt[k], demand[k] + 0.02) && (100..400).contains(&k));
            count += 1;
        }
    }
    // A tenth of 300: standard deviation 5.2; five of them.
    assert!((4..=56).contains(&count), "{count}");
}

#[test]
fn a_lagging_fuel_valve_is_case_4() {
    let shape = ramp(30.0);
    let case = Fault::growing(FaultCase::FuelActuatorLag, 8.0, 30.0, None);
    let lag = Fault::actuator(ActuatorId::Fuel, Mode::Lag, 8.0, shape);
    let [a, b] = [case, lag].map(|fault| simulate(&scenario(vec![fault])).unwrap().truth);
    assert_eq!(a, b);
}

#[test]
fn faults_of_the_valve_reach_the_plant_and_not_the_record_of_the_demand() {
    let healthy = simulate(&scenario(vec![])).unwrap();
    let valve = channel("a_v");
    for (mode, shape) in [
        (Mode::Bias, step(0.5)),
        (Mode::Gain, step(1.0)),
        (Mode::Stuck, step(1.0)),
        (Mode::Dropout, step(1.0)),
        (Mode::Noise, step(0.3)),
    ] {
        let fault = Fault::actuator(ActuatorId::Valve, mode, 8.0, shape);
        let faulty = simulate(&scenario(vec![fault])).unwrap();
        for truth in [true, false] {
            let [a, b] = [&healthy, &faulty].map(|run| bits(&row(run, truth, valve)));
            assert_eq!(a, b, "{mode}");
        }
        let [a, b] = [&healthy, &faulty].map(|run| bits(&row(run, true, channel("p7"))));
        assert_eq!(a[..=100], b[..=100], "{mode}");
        assert_ne!(a[101..], b[101..], "{mode}");
    }
    // A bias is a valve that is held elsewhere.
    let steady = |faults| {
        let profile = Profile::named(Variant::Prototype, "steady").unwrap();
        simulate(&Scenario {
            profile,
            ..scenario(faults)
        })
        .unwrap()
    };
    let bias = Fault::actuator(ActuatorId::Valve, Mode::Bias, 0.0, step(0.49));
    let gain = Fault::actuator(ActuatorId::Valve, Mode::Gain, 0.0, step(1.0));
    let demand = row(&steady(vec![]), true, valve)[0];
    let [a, b] = [bias, gain].map(|fault| row(&steady(vec![fault]), true, channel("p7")));
    let scale = demand / 49.0;
    assert!((scale - 1.0).abs() < 0.1, "{demand}");
    // p7 falls by some percent a degree; the two openings differ by 0.01 (demand - 49) degrees.
    let bound = 0.05 * 0.01 * (demand - 49.0).abs() + 1e-9;
    for k in 0..500 {
        assert!((a[k] / b[k] - 1.0).abs() < bound, "{k}");
    }
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

fn read(text: &str) -> Result<Fault, String> {
    toml::from_str(text).map_err(|error| error.message().to_owned())
}

#[test]
fn the_forms_of_a_file() {
    let t3 = channel("t3");
    for (text, expected) in [
        (
            "case = 'turbine_damage'\nonset_s = 60.0\nramp = { rate_per_h = 5.0, limit = 5.0 }",
            Fault::nominal(FaultCase::TurbineDamage, 60.0),
        ),
        (
            "case = 'turbine_damage'\nonset_s = 60\nrate_percent_per_h = 5\nlimit_percent = 5",
            Fault::nominal(FaultCase::TurbineDamage, 60.0),
        ),
        (
            "case = 'fuel_actuator_lag'\nrate_s_per_h = 5.0\nlimit_s = 2.0",
            Fault::growing(FaultCase::FuelActuatorLag, 0.0, 5.0, Some(2.0)),
        ),
        (
            "sensor = 't3'\nmode = 'bias'\nonset_s = 10.0\nend_s = 12.0\nstep = { size = 2.0 }",
            Fault::sensor(t3, Mode::Bias, 10.0, step(2.0)).until(12.0),
        ),
        (
            "actuator = 'a_v'\nmode = 'lag'\nstep = { size = 0.8 }",
            Fault::actuator(ActuatorId::Valve, Mode::Lag, 0.0, step(0.8)),
        ),
        (
            "sensor = 't3'\nmode = 'stuck'",
            Fault::sensor(t3, Mode::Stuck, 0.0, step(1.0)),
        ),
        (
            "sensor = 't3'\nmode = 'spike'\nstep = { size = 5.0 }",
            Fault::sensor(t3, Mode::Spike { spikes_per_h: 60.0 }, 0.0, step(5.0)),
        ),
        (
            "sensor = 't3'\nmode = 'drift'\n[exponential]\nsize = 5.0\ntime_constant_s = 3.0",
            Fault::sensor(
                t3,
                Mode::Drift,
                0.0,
                Shape::Exponential(Exponential {
                    size: 5.0,
                    time_constant_s: 3.0,
                }),
            ),
        ),
    ] {
        assert_eq!(read(text), Ok(expected), "{text}");
    }
}

#[test]
fn what_is_wrong_with_a_file_is_named() {
    let shapes = "fault: expected exactly one of step, ramp, exponential, intermittent, or for a \
                  case rate_percent_per_h (rate_s_per_h for fuel_actuator_lag), found";
    for (text, expected) in [
        (
            "onset_s = 1.0",
            "fault: expected exactly one of the keys case, sensor, actuator, found none".to_owned(),
        ),
        (
            "case = 'turbine_damage'\nsensor = 't3'\nmode = 'bias'",
            "fault: expected exactly one of the keys case, sensor, actuator, found case and sensor"
                .to_owned(),
        ),
        (
            "sensor = 't3'",
            "fault: expected a mode for a sensor or an actuator, found none".to_owned(),
        ),
        (
            "sensor = 't3'\nmode = 'leak'",
            "mode: expected one of bias, drift, gain, stuck, spike, dropout, noise, lag, found \
             `leak`"
                .to_owned(),
        ),
        (
            "actuator = 'IGW'\nmode = 'bias'",
            "actuator: expected one of M_f, a_v, IGV, found `IGW`".to_owned(),
        ),
        (
            "case = 'turbine_damage'\nmode = 'bias'",
            "fault: expected no mode beside a case, found mode".to_owned(),
        ),
        (
            "sensor = 't3'\nmode = 'bias'\nspikes_per_h = 1.0\nstep = { size = 1.0 }",
            "fault: expected spikes_per_h with mode spike only, found bias".to_owned(),
        ),
        ("sensor = 't3'\nmode = 'bias'", format!("{shapes} none")),
        ("case = 'turbine_damage'", format!("{shapes} none")),
        (
            "case = 'turbine_damage'\nstep = { size = 1.0 }\nrate_percent_per_h = 1.0",
            format!("{shapes} step and rate_percent_per_h"),
        ),
        (
            "case = 'turbine_damage'\nrate_s_per_h = 1.0",
            "fault: expected rate_percent_per_h, and limit_percent or no limit, found \
             rate_s_per_h"
                .to_owned(),
        ),
        (
            "case = 'fuel_actuator_lag'\nrate_s_per_h = 1.0\nlimit_percent = 3.0",
            "fault: expected rate_s_per_h, and limit_s or no limit, found limit_percent and \
             rate_s_per_h"
                .to_owned(),
        ),
        (
            "sensor = 't3'\nmode = 'bias'\nrate_percent_per_h = 1.0",
            "fault: expected a table step, ramp, exponential or intermittent for a sensor or an \
             actuator, found rate_percent_per_h"
                .to_owned(),
        ),
        (
            "sensor = 't3'\nmode = 'bias'\nstep = { sise = 1.0 }",
            "unknown field `sise`, expected `size`".to_owned(),
        ),
        (
            "sensor = 't3'\nmode = 'bias'\nramp = { limit = 1.0 }",
            "missing field `rate_per_h`".to_owned(),
        ),
    ] {
        assert_eq!(read(text), Err(expected), "{text}");
    }
    let message = read("sensor = 't33'\nmode = 'bias'").unwrap_err();
    assert!(
        message.starts_with("channel: expected one of a_v, M_f,") && message.ends_with("`t33`"),
        "{message}"
    );
    let message = read("sensor = 't3'\nsize = 1.0").unwrap_err();
    assert!(
        message.starts_with("unknown field `size`, expected one of `case`"),
        "{message}"
    );
}

fn shapes() -> impl Strategy<Value = Shape> {
    let size = -1e3..1e3f64;
    prop_oneof![
        size.clone().prop_map(step),
        (size.clone(), proptest::option::of(0.0..50.0f64))
            .prop_map(|(rate_per_h, limit)| Shape::Ramp(Ramp { rate_per_h, limit })),
        (size.clone(), 0.1..1e3f64).prop_map(|(size, time_constant_s)| {
            Shape::Exponential(Exponential {
                size,
                time_constant_s,
            })
        }),
        (size, 1.0..1e3f64, 0.1..1.0f64).prop_map(|(size, period_s, on_s)| {
            Shape::Intermittent(Intermittent {
                size,
                period_s,
                on_s,
            })
        }),
    ]
}

fn faults() -> impl Strategy<Value = Fault> {
    let mode = (0..Mode::NAMES.len(), 1.0..45e3f64).prop_map(|(index, spikes_per_h)| {
        match Mode::NAMES[index].parse().unwrap() {
            Mode::Spike { .. } => Mode::Spike { spikes_per_h },
            mode => mode,
        }
    });
    let channels = proptest::sample::select(Channel::of(Variant::Prototype).collect::<Vec<_>>());
    let target = prop_oneof![
        proptest::sample::select(FaultCase::ALL.to_vec()).prop_map(Target::Case),
        (channels, mode.clone()).prop_map(|(channel, mode)| Target::Sensor { channel, mode }),
        (proptest::sample::select(ActuatorId::ALL.to_vec()), mode)
            .prop_map(|(actuator, mode)| Target::Actuator { actuator, mode }),
    ];
    (
        target,
        0.0..1e3f64,
        proptest::option::of(0.0..2e3f64),
        shapes(),
    )
        .prop_map(|(target, onset_s, end_s, shape)| Fault {
            target,
            onset_s,
            end_s,
            shape,
        })
}

proptest! {
    #[test]
    fn prop_what_is_written_reads_the_same(faults in proptest::collection::vec(faults(), 0..4)) {
        let written = scenario(faults);
        let text = toml::to_string(&written).unwrap();
        prop_assert_eq!(toml::from_str::<Scenario>(&text), Ok(written.clone()), "{}", text);
        let text = serde_json::to_string(&written).unwrap();
        prop_assert_eq!(serde_json::from_str::<Scenario>(&text).unwrap(), written);
    }

    #[test]
    fn prop_a_fault_that_is_accepted_stays_finite_and_bounded(fault in faults(), t in 0.0..1e4f64) {
        if fault.validate().is_ok() && fault.validate_by(t).is_ok() {
            let size = fault.magnitude(t);
            prop_assert!(size.is_finite());
            prop_assert!(fault.case().is_none() || fault.unit() != "%" || size.abs() < 100.0);
            prop_assert!(size.abs() <= fault.shape.largest(t));
        }
    }

    #[test]
    fn prop_no_text_panics(
        text in "((case|sensor|actuator|mode|step|ramp|exponential|intermittent|onset_s|end_s|size|rate_per_h|limit|spikes_per_h|rate_percent_per_h|limit_s| = |\\{|\\}|\n|[0-9.e-]{1,8}|'(t3|a_v|stuck|spike|turbine_damage)')){0,16}"
    ) {
        if let Ok(fault) = toml::from_str::<Fault>(&text) {
            let _ = fault.validate();
            let _ = fault.validate_by(600.0);
            let _ = fault.magnitude(1.0);
        }
    }
}

/// A load reduction in which the vanes move, with one actuator fault from 30 s on.
fn load_reduction(fault: Option<Fault>) -> Run {
    let mut scenario = Scenario {
        duration_s: 60.0,
        ..Scenario::of(Variant::Cogeneration)
    };
    scenario.profile = Profile::named(Variant::Cogeneration, "load_reduction_igv").unwrap();
    scenario.faults.extend(fault);
    simulate(&scenario).unwrap()
}

#[test]
fn stuck_vanes_stay_where_they_are() {
    let vanes = channel("IGV");
    let healthy = row(&load_reduction(None), true, vanes);
    assert!(healthy[700] > healthy[375] + 2.0, "they would move");
    for mode in [Mode::Stuck, Mode::Dropout] {
        let fault = Fault::actuator(ActuatorId::GuideVanes, mode, 30.0, step(1.0));
        let faulty = row(&load_reduction(Some(fault)), true, vanes);
        assert_eq!(faulty[..=375], healthy[..=375], "{mode}");
        for angle_deg in &faulty[375..] {
            assert_eq!(angle_deg.to_bits(), faulty[375].to_bits(), "{mode}");
        }
    }
    // Whatever else is wrong: with less fuel burnt than demanded they stick where they are as well.
    let mut scenario = Scenario {
        duration_s: 40.0,
        ..Scenario::of(Variant::Cogeneration)
    };
    scenario.faults = vec![
        Fault::actuator(ActuatorId::Fuel, Mode::Gain, 2.0, step(-6.0)),
        Fault::actuator(ActuatorId::GuideVanes, Mode::Stuck, 16.0, step(1.0)),
    ];
    let angles = row(&simulate(&scenario).unwrap(), true, vanes);
    for angle_deg in &angles[200..] {
        assert_eq!(angle_deg.to_bits(), angles[200].to_bits());
    }
}

#[test]
fn actuators_do_not_pass_their_stops() {
    let vanes = channel("IGV");
    for (size, stop) in [(-60.0, 0.0), (60.0, 40.0)] {
        let fault = Fault::actuator(ActuatorId::GuideVanes, Mode::Bias, 30.0, step(size));
        let angles = row(&load_reduction(Some(fault)), true, vanes);
        assert!(
            angles
                .iter()
                .all(|angle_deg| (0.0..=40.0).contains(angle_deg))
        );
        let last = angles.last().unwrap();
        assert!((last - stop).abs() < 1e-6, "{last} against {stop}");
    }
    // A fuel valve does not pump back: the flame goes out, and the run says so.
    let fault = Fault::actuator(ActuatorId::Fuel, Mode::Bias, 10.0, step(-0.3));
    let run = simulate(&scenario(vec![fault])).unwrap();
    assert!(run.hidden.row(2).iter().all(|fuel_kg_s| *fuel_kg_s >= 0.0));
    assert!(run.ended.is_some());
    // A valve is open at 90 degrees.
    let fault = Fault::actuator(ActuatorId::Valve, Mode::Bias, 10.0, step(60.0));
    let open = Fault::actuator(ActuatorId::Valve, Mode::Bias, 10.0, step(200.0));
    let [a, b] = [fault, open].map(|fault| simulate(&scenario(vec![fault])).unwrap());
    assert_eq!(
        bits(&row(&a, true, channel("p7"))),
        bits(&row(&b, true, channel("p7")))
    );
}

#[test]
fn a_fault_is_asked_before_it_is_checked() {
    for limit in [f64::NAN, -1.0] {
        let fault = Fault::growing(FaultCase::ThermocoupleDrift, 0.0, 5.0, Some(limit));
        let _ = fault.magnitude(10.0);
        assert!(fault.validate().is_err());
    }
}
