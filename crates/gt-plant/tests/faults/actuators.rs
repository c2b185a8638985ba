//! Faults of actuators: between demand and plant, within the stops.

use gt_plant::{ActuatorId, Fault, FaultCase, Mode, Profile, Run, Scenario, Variant, simulate};

use super::{bits, channel, ramp, row, scenario, step};

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
