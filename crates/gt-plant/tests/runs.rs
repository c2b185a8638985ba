//! Runs: drift, order of the integrator, determinism, faults, noise and limits.
#![expect(
    clippy::unwrap_used,
    reason = "the helpers stand outside the test functions"
)]

use gt_plant::drive::Drive;
use gt_plant::dynamics::derivative;
use gt_plant::{
    Boundary, Disturbance, Fault, FaultCase, FaultSizes, Inputs, MapSet, Noise, NoiseLevel,
    PlantError, PlantParameters, Profile, Run, SAMPLE_TIME_S, Scenario, Seen, Variant, Warning,
    rk4, simulate, simulate_with, steady_state,
};
use nalgebra::DMatrix;

fn scenario(duration_s: f64) -> Scenario {
    Scenario {
        duration_s,
        seed: 7,
        ..Scenario::default()
    }
}

/// The drive of a run at design conditions.
fn undisturbed(profile: &Profile, seed: u64) -> Drive {
    let (boundary, disturbance) = (Boundary::default(), Disturbance::default());
    Drive::new(profile, &boundary, &disturbance, seed, 0)
}

fn row(run: &Run, truth: bool, name: &str) -> Vec<f64> {
    let data = if truth { &run.truth } else { &run.measured };
    let selected = data.select::<&str, _>(&[], &[name]).unwrap();
    selected.y().row(0).iter().copied().collect()
}

fn bits(matrix: &DMatrix<f64>) -> Vec<u64> {
    matrix.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn unexcited_healthy_run_stays_at_its_equilibrium() {
    let profile = Profile::named(Variant::Prototype, "steady").unwrap();
    let run = simulate(&Scenario {
        profile,
        ..scenario(600.0)
    })
    .unwrap();
    assert_eq!(run.truth.len(), 7500);
    for (signal, row) in run.truth.outputs().iter().zip(run.truth.y().row_iter()) {
        let drift = (row.max() - row.min()) / row[0];
        assert!(drift < 1e-6, "{}: {drift}", signal.name);
    }
    assert!(run.warnings.is_empty());
}

#[test]
fn rk4_is_of_fourth_order_on_the_plant() {
    let parameters = PlantParameters::for_maps(MapSet::Paper);
    let mut inputs = Inputs::design(&parameters);
    inputs.valve_deg += 1.0;
    let start = steady_state(&parameters).unwrap().state.to_array();
    let end = |steps: u32| {
        let step_s = 0.02 / f64::from(steps);
        let mut x = start;
        for _ in 0..steps {
            let rates = |_, x: &[f64; _]| derivative(&parameters, &inputs, &FaultSizes::HEALTHY, x);
            x = rk4::step(rates, 0.0, &x, step_s);
        }
        x
    };
    let states = [40, 80, 160].map(end);
    let distance = |a: &[f64; 18], b: &[f64; 18]| {
        (0..11)
            .map(|i| ((a[i] - b[i]) / start[i]).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let ratio = distance(&states[0], &states[1]) / distance(&states[1], &states[2]);
    // The next term is of relative order (760 1/s x 0.5 ms) / 4 = 10 %.
    assert!((ratio / 16.0 - 1.0).abs() < 0.12, "{ratio}");
}

#[test]
fn default_step_is_fine_enough() {
    // Steps of 2 and 1 ms: the spec measured 2e-7 for the former.
    let coarse = simulate(&scenario(40.0)).unwrap();
    let fine = simulate(&Scenario {
        substeps: 80,
        ..scenario(40.0)
    })
    .unwrap();
    for (a, b) in coarse.truth.y().iter().zip(fine.truth.y().iter()) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
    let least = simulate(&Scenario {
        substeps: 24,
        ..scenario(40.0)
    })
    .unwrap();
    for (a, b) in least.truth.y().iter().zip(fine.truth.y().iter()) {
        assert!(
            (a / b - 1.0).abs() < 1e-4,
            "at the longest accepted step: {a} {b}"
        );
    }
}

#[test]
fn seed_and_run_index_alone_determine_a_run() {
    let noisy = Scenario {
        noise: NoiseLevel::Table8.into(),
        ..scenario(20.0)
    };
    let first = simulate(&noisy).unwrap();
    let again = simulate(&noisy).unwrap();
    assert!(bits(first.measured.y()) == bits(again.measured.y()));
    assert!(bits(first.measured.u()) == bits(again.measured.u()));
    for (seed, run_index) in [(7, 1), (8, 0), (0, 7)] {
        let other = simulate(&Scenario {
            seed,
            run_index,
            ..noisy.clone()
        })
        .unwrap();
        assert_ne!(
            first.truth.u().row(0),
            other.truth.u().row(0),
            "{seed}, {run_index}"
        );
        let noise = |run: &Run| run.measured.y() - run.truth.y();
        assert!(noise(&first) != noise(&other), "{seed}, {run_index}");
    }
}

#[test]
fn a_short_record_is_the_beginning_of_a_longer_one() {
    let short = simulate(&scenario(10.0)).unwrap();
    let long = simulate(&scenario(20.0)).unwrap();
    let head = long.truth.rows(0..125).unwrap();
    assert!(bits(short.truth.y()) == bits(head.y()));
    assert!(bits(short.truth.u()) == bits(head.u()));
}

#[test]
fn excitation_depends_on_nothing_but_profile_and_seed() {
    let base = simulate(&scenario(30.0)).unwrap();
    let exciting = |run: &Run| run.truth.u().select_rows(&[0, 2]);
    assert!(exciting(&base).row(0).variance() > 0.01, "the valve moves");
    let fault = Fault::nominal(FaultCase::TurbineDamage, 5.0);
    for (what, changed) in [
        (
            "noise",
            Scenario {
                noise: NoiseLevel::Table8.into(),
                ..scenario(30.0)
            },
        ),
        (
            "maps",
            Scenario {
                map_set: MapSet::Axial,
                ..scenario(30.0)
            },
        ),
        (
            "faults",
            Scenario {
                faults: vec![fault],
                ..scenario(30.0)
            },
        ),
        (
            "substeps",
            Scenario {
                substeps: 80,
                ..scenario(30.0)
            },
        ),
    ] {
        let run = simulate(&changed).unwrap();
        assert!(bits(&exciting(&run)) == bits(&exciting(&base)), "{what}");
        if what == "noise" {
            assert_eq!(
                bits(run.truth.y()),
                bits(base.truth.y()),
                "the plant receives no noise"
            );
        } else {
            assert!(run.truth.y() != base.truth.y(), "{what} reach the plant");
        }
    }
}

#[test]
fn recorded_inputs_are_what_the_outputs_saw() {
    // m9 = m5 + M_f holds sample by sample when demand and sensors are read together.
    let run = simulate(&scenario(20.0)).unwrap();
    let (m5, m9) = (row(&run, true, "m5"), row(&run, true, "m9"));
    for k in 0..run.truth.len() {
        let fuel = run.truth.u()[(1, k)];
        assert!((m9[k] - m5[k] - fuel).abs() < 1e-14, "sample {k}");
    }
    // Valve and reference are recorded as they are held from the sample on.
    let parameters = PlantParameters::for_maps(MapSet::Paper);
    let mut drive = undisturbed(&Profile::default(), 7);
    for column in run.truth.u().column_iter() {
        let deviation = drive.step();
        let valve_deg = parameters.design.valve_deg + deviation.valve_deg;
        let speed_rad_s = parameters.design.speed_rad_s * (1.0 + deviation.speed_fraction);
        assert!((column[0] - valve_deg).abs() < 1e-12);
        assert!((column[2] - speed_rad_s).abs() < 1e-9);
    }
    let before = steady_state(&parameters).unwrap();
    assert_eq!(
        run.truth.y().column(0).as_slice(),
        &before.outputs[..28],
        "no step at once"
    );
    // Efficiencies and the fuel in the combustor, which is the demand in a healthy plant.
    assert_eq!(run.hidden.column(0).as_slice(), &before.outputs[31..]);
    assert_eq!(run.hidden.row(2), run.truth.u().row(1));
    assert_eq!(run.truth.time_s(0).to_bits(), 0.0f64.to_bits());
}

#[test]
fn excitation_keeps_its_limits() {
    let profile = Profile::named(Variant::Prototype, "wide").unwrap();
    let mut drive = undisturbed(&profile, 3);
    let (mut valve, mut speed) = (Vec::new(), Vec::new());
    let (mut dither_sum, mut dither_squares) = (0.0, 0.0);
    let n = 1_000_000;
    for _ in 0..n {
        let deviation = drive.step();
        valve.push(deviation.valve_deg);
        speed.push(deviation.speed_fraction);
        dither_sum += deviation.dither_fraction;
        dither_squares += deviation.dither_fraction.powi(2);
    }
    let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let fastest = |values: &[f64]| {
        values
            .windows(2)
            .map(|w| (w[1] - w[0]).abs())
            .fold(0.0, f64::max)
    };
    // A level near the end of the range is certain among 10^4 uniform ones.
    assert!(largest(&valve) <= 2.5 && largest(&valve) > 2.49);
    assert!(largest(&speed) <= 0.01 && largest(&speed) > 0.0099);
    let slack = 1.0 + 1e-12;
    assert!(fastest(&valve) <= 5.0 * SAMPLE_TIME_S * slack && fastest(&valve) > 0.39);
    assert!(fastest(&speed) <= 0.01 * SAMPLE_TIME_S * slack && fastest(&speed) > 0.00079);
    let changes = valve
        .windows(2)
        .filter(|w| w[0].to_bits() != w[1].to_bits())
        .count();
    // A hold is 7.5 s on average, 94 samples, of which a move takes at most 13.
    assert!(changes < n / 7, "{changes}");
    let count = n as f64;
    let deviation = (dither_squares / count - (dither_sum / count).powi(2)).sqrt();
    // Two poles at 0.97 leave about 10^4 independent values: 0.7 % of standard error.
    assert!((deviation / 0.02 - 1.0).abs() < 0.03, "{deviation}");
}

#[test]
fn published_table_8_noise() {
    let run = simulate(&Scenario {
        noise: NoiseLevel::Table8.into(),
        ..scenario(600.0)
    })
    .unwrap();
    let n = run.truth.len() as f64;
    let mut noises = Vec::new();
    for (name, fraction) in [
        ("p1", 0.2497),
        ("p7", 0.2497),
        ("m9", 0.2345),
        ("m10", 0.2345),
        ("t3", 0.0941),
        ("t7", 0.0941),
        ("q_c", 0.2909),
        ("P_t", 0.2909),
        ("w_t", 0.0941),
        ("N_t", 0.0941),
    ] {
        let (clean, noisy) = (row(&run, true, name), row(&run, false, name));
        let noise: Vec<f64> = noisy.iter().zip(&clean).map(|(a, b)| a - b).collect();
        noises.push((name, noise, fraction * deviation(&clean)));
    }
    for (channel, (name, fraction)) in [("a_v", 0.1417), ("M_f", 0.2623)].into_iter().enumerate() {
        let clean: Vec<f64> = run.truth.u().row(channel).iter().copied().collect();
        let noise = run.measured.u().row(channel) - run.truth.u().row(channel);
        noises.push((
            name,
            noise.iter().copied().collect(),
            fraction * deviation(&clean),
        ));
    }
    for (index, (name, noise, expected)) in noises.iter().enumerate() {
        let found = deviation(noise);
        // Standard error of a deviation: 1 / sqrt(2 N) = 0.8 %; five of them.
        assert!(
            (found / expected - 1.0).abs() < 0.041,
            "{name}: {found} against {expected}"
        );
        // White and independent: correlations have the standard error 1 / sqrt(N) = 1.2 %.
        let lag_one = correlation(&noise[1..], &noise[..noise.len() - 1]);
        assert!(lag_one.abs() < 5.0 / n.sqrt(), "{name}: {lag_one}");
        for (other, second, _) in &noises[..index] {
            let shared = correlation(noise, second);
            assert!(shared.abs() < 5.0 / n.sqrt(), "{name}, {other}: {shared}");
        }
    }
    for constant in ["t1", "t2"] {
        assert!(
            row(&run, true, constant) == row(&run, false, constant),
            "{constant}"
        );
    }
    for known in 2..5 {
        assert!(
            run.truth.u().row(known) == run.measured.u().row(known),
            "input {known}"
        );
    }
}

#[test]
fn low_noise_is_one_percent_of_each_signal() {
    let run = simulate(&Scenario {
        noise: NoiseLevel::Low.into(),
        ..scenario(600.0)
    })
    .unwrap();
    for name in ["p3", "m5", "t5", "q_t", "P_c", "w_t"] {
        let (clean, noisy) = (row(&run, true, name), row(&run, false, name));
        let noise: Vec<f64> = noisy.iter().zip(&clean).map(|(a, b)| a - b).collect();
        let ratio = deviation(&noise) / deviation(&clean);
        assert!((ratio / 0.01 - 1.0).abs() < 0.041, "{name}: {ratio}");
    }
}

#[test]
fn a_fault_changes_no_sensor() {
    let healthy = simulate(&Scenario {
        noise: NoiseLevel::Table8.into(),
        ..scenario(60.0)
    })
    .unwrap();
    let fault = Fault::growing(FaultCase::TurbineDamage, 10.0, 360.0, None);
    let noise = Noise::from(NoiseLevel::Table8);
    let faulty = simulate(&Scenario {
        noise,
        faults: vec![fault],
        ..scenario(60.0)
    })
    .unwrap();
    assert!((row(&faulty, true, "t5")[749] / row(&healthy, true, "t5")[749] - 1.0).abs() > 0.05);
    let noise = |run: &Run| run.measured.y() - run.truth.y();
    for (k, (a, b)) in noise(&healthy)
        .iter()
        .zip(noise(&faulty).iter())
        .enumerate()
    {
        let size = healthy.truth.y()[k].abs();
        // Rounding of (truth + noise) - truth.
        assert!((a - b).abs() < 1e-15 * size, "{a} {b} of {size}");
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (mean_a, mean_b) = (mean(a), mean(b));
    let products = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a - mean_a) * (b - mean_b))
        .sum::<f64>();
    products / a.len() as f64 / deviation(a) / deviation(b)
}

#[test]
fn thermocouple_drift_touches_only_its_reading() {
    let healthy = simulate(&scenario(30.0)).unwrap();
    let fault = Fault::growing(FaultCase::ThermocoupleDrift, 12.0, -720.0, Some(3.0));
    let faulty = simulate(&Scenario {
        faults: vec![fault.clone()],
        ..scenario(30.0)
    })
    .unwrap();
    assert!(bits(healthy.truth.y()) == bits(faulty.truth.y()));
    assert!(bits(healthy.measured.u()) == bits(faulty.measured.u()));
    for (index, signal) in healthy.measured.outputs().iter().enumerate() {
        for k in 0..healthy.measured.len() {
            let (reading, clean) = (
                faulty.measured.y()[(index, k)],
                healthy.truth.y()[(index, k)],
            );
            let factor = if signal.name == "t3" {
                1.0 + fault.magnitude(healthy.truth.time_s(k)) / 100.0
            } else {
                1.0
            };
            assert_eq!(
                reading.to_bits(),
                (clean * factor).to_bits(),
                "{}, {k}",
                signal.name
            );
        }
    }
    assert!((row(&faulty, false, "t3")[374] / row(&faulty, true, "t3")[374] - 0.97).abs() < 1e-12);
}

#[test]
fn nothing_happens_before_the_onset_and_ramps_are_recorded_exactly() {
    let healthy = simulate(&scenario(30.0)).unwrap();
    for case in FaultCase::ALL {
        let faults = vec![Fault::nominal(case, 16.0)];
        let faulty = simulate(&Scenario {
            faults,
            ..scenario(30.0)
        })
        .unwrap();
        assert_eq!(faulty.fault_signals.len(), 1);
        assert_eq!(faulty.fault_signals[0].name, case.name());
        let first = 201;
        for k in 0..faulty.measured.len() {
            let same = faulty.measured.y().column(k) == healthy.measured.y().column(k);
            // Sample 200 is at 16 s: the magnitude is still zero.
            assert_eq!(same, k < first, "{case}, sample {k}");
            let magnitude = 5.0 * (k as f64 * SAMPLE_TIME_S - 16.0).max(0.0) / 3600.0;
            assert_eq!(
                faulty.fault_magnitudes[(0, k)].to_bits(),
                magnitude.to_bits(),
                "{k}"
            );
        }
    }
}

#[test]
fn a_ramp_that_ends_reaches_the_static_effect() {
    // 5 % within 0.1 s, no excitation: after 40 s of a loop with poles at -1.03 and -1.64 1/s,
    // exp(-40) remains. Case 1, q_c: -3.57 % (spec section 6).
    let profile = Profile::named(Variant::Prototype, "steady").unwrap();
    let fault = Fault::growing(FaultCase::CompressorFouling, 1.0, 180e3, Some(5.0));
    let run = simulate(&Scenario {
        profile,
        faults: vec![fault],
        ..scenario(41.0)
    })
    .unwrap();
    let torque = row(&run, true, "q_c");
    let effect = 100.0 * (torque[torque.len() - 1] / torque[0] - 1.0);
    assert!((effect + 3.57).abs() < 0.006, "{effect}");
}

#[test]
fn a_growing_fuel_lag_starts_without_a_jump() {
    // The lag passes 0.01 s, where it begins to be integrated as such, 10 s after onset.
    let fault = Fault::growing(FaultCase::FuelActuatorLag, 0.0, 3.6, None);
    let healthy = simulate(&scenario(20.0)).unwrap();
    let faulty = simulate(&Scenario {
        faults: vec![fault],
        ..scenario(20.0)
    })
    .unwrap();
    let (a, b) = (row(&faulty, true, "m9"), row(&healthy, true, "m9"));
    let difference: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
    let spread = |range: std::ops::Range<usize>| deviation(&difference[range]);
    // Fuel times rate of demand: the effect grows with the lag, by no more than its ratio here.
    let (before, after) = (spread(100..124), spread(126..150));
    assert!(before > 0.0 && after < 3.0 * before, "{before} {after}");
    let jump = (difference[125] - difference[124]).abs();
    assert!(jump < 5.0 * before, "{jump} against {before}");
}

#[test]
fn an_unstable_speed_loop_reaches_the_fuel_limits() {
    let fault = Fault::growing(FaultCase::FuelActuatorLag, 0.0, 3.6e4, Some(6.0));
    let lagging = Scenario {
        faults: vec![fault],
        ..scenario(300.0)
    };
    match simulate(&lagging) {
        Ok(run) => {
            run.truth.check_finite().unwrap();
            assert!(
                run.warnings.iter().any(|w| matches!(
                    w,
                    Warning::FuelAtMaximum { .. } | Warning::FuelAtMinimum { .. }
                )),
                "{:?}",
                run.warnings
            );
        }
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn a_plant_that_leaves_its_range_says_when_and_what() {
    let fault = Fault::growing(FaultCase::TurbineDamage, 5.0, 36e3, Some(99.0));
    let run = simulate(&Scenario {
        faults: vec![fault],
        ..scenario(60.0)
    })
    .unwrap();
    let Some(PlantError::OutOfRange {
        time_s,
        found,
        low,
        high,
        ..
    }) = run.ended
    else {
        panic!("expected a plant out of range, found {:?}", run.ended);
    };
    assert!(time_s > 5.0 && time_s < 15.0, "{time_s}");
    assert!(!(low < found && found < high));
    // It ends with what it has: every sample before that time, all of them finite.
    assert!((run.truth.time_s(run.truth.len()) - time_s).abs() < 1e-9);
    assert_eq!(run.measured.len(), run.truth.len());
    assert_eq!(run.fault_magnitudes.ncols(), run.truth.len());
    assert_eq!(run.hidden.ncols(), run.truth.len());
    run.truth.check_finite().unwrap();
}

#[test]
fn an_unstable_step_is_no_silent_nan() {
    // A tenth of the volume behind the compressor needs a third of the step.
    let mut parameters = PlantParameters::for_maps(MapSet::Paper);
    parameters.compressor_exit.volume_m3 = 0.008;
    let error = simulate_with(&parameters, &scenario(20.0)).unwrap_err();
    let PlantError::Substeps { least, found, .. } = error else {
        panic!("expected a refused step, found {error}");
    };
    assert_eq!(found, Scenario::default().substeps);
    let enough = Scenario {
        substeps: least,
        ..scenario(20.0)
    };
    assert_eq!(simulate_with(&parameters, &enough).unwrap().ended, None);
}

#[test]
fn noise_without_excitation_is_warned_about() {
    let profile = Profile::named(Variant::Prototype, "steady").unwrap();
    let quiet = Scenario {
        profile,
        noise: NoiseLevel::Table8.into(),
        ..scenario(2.0)
    };
    let run = simulate(&quiet).unwrap();
    assert_eq!(run.warnings, [Warning::NoNoise]);
    let limit = Warning::FuelAtMaximum(Seen {
        first_s: 2554.2400000000002,
        samples: 3,
    });
    assert_eq!(
        limit.to_string(),
        "the fuel demand was at its upper limit in 3 samples, first at 2554.24 s"
    );
    assert!(bits(run.truth.y()) == bits(run.measured.y()));
}
