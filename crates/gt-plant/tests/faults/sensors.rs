//! Faults of sensors: every mode against its definition.

use gt_plant::{
    Exponential, Fault, FaultCase, Intermittent, Mode, Noise, NoiseLevel, Profile, SAMPLE_TIME_S,
    Scenario, Shape, Variant, simulate,
};

use super::{bits, channel, ramp, read_with, row, scenario, sensor, step};

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
