//! The drive of a run: levels, schedules, courses and fluctuations, and their independence.
#![expect(
    clippy::unwrap_used,
    reason = "the helpers stand outside the test functions"
)]

use gt_plant::drive::{Deviation, Drive};
use gt_plant::excitation::schedule::{share_at, varies};
use gt_plant::{
    Boundary, Course, Disturbance, Fluctuation, Profile, SAMPLE_TIME_S, Scenario, Sine, Variant,
    simulate,
};
use proptest::prelude::*;

fn drive(scenario: &Scenario) -> Drive {
    Drive::new(
        &scenario.profile,
        &scenario.boundary,
        &scenario.disturbance,
        scenario.seed,
        scenario.run_index,
    )
}

fn steps(scenario: &Scenario, count: usize) -> Vec<Deviation> {
    let mut drive = drive(scenario);
    (0..count).map(|_| drive.step()).collect()
}

/// The quantities of a sample by name.
fn quantities(deviation: &Deviation) -> [(&'static str, f64); 9] {
    [
        ("valve", deviation.valve_deg),
        ("speed", deviation.speed_fraction),
        ("fuel", deviation.fuel_fraction),
        ("dither", deviation.dither_fraction),
        ("temperature", deviation.ambient_k),
        ("pressure", deviation.ambient_pa),
        ("heating value", deviation.heating_value_fraction),
        ("heat release", deviation.heat_release_fraction),
        ("torque", deviation.torque_n_m),
    ]
}

/// Names of the quantities that differ in any bit of any sample.
fn changed(a: &[Deviation], b: &[Deviation]) -> Vec<&'static str> {
    let mut names = Vec::new();
    for (a, b) in a.iter().zip(b) {
        for ((name, a), (_, b)) in quantities(a).into_iter().zip(quantities(b)) {
            if a.to_bits() != b.to_bits() && !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

fn random(deviation: f64, time_constant_s: f64) -> Fluctuation {
    Fluctuation {
        deviation,
        time_constant_s,
    }
}

/// One setting put elsewhere.
type Change = fn(&mut Scenario);

/// A scenario in which everything moves.
fn lively() -> Scenario {
    let course = |size: f64| Course {
        offset: 3.0 * size,
        rate_per_h: 2.0 * size,
        sine: Some(Sine {
            amplitude: size,
            period_s: 40.0,
        }),
        random: Some(random(size, 5.0)),
    };
    let mut scenario = Scenario {
        boundary: Boundary {
            temperature_k: course(1.0),
            pressure_pa: course(100.0),
            heating_value_fraction: course(0.003),
        },
        disturbance: Disturbance {
            heat_release_fraction: Some(random(0.002, 0.5)),
            torque_n_m: Some(random(10.0, 2.0)),
        },
        seed: 7,
        ..Scenario::of(Variant::Cogeneration)
    };
    scenario.profile.valve_amplitude_deg = 0.5;
    scenario.profile.fuel_schedule = vec![[5.0, 0.9], [30.0, 0.8]];
    scenario.validate().unwrap();
    scenario
}

#[test]
fn regress_streams_of_the_prototype_keep_their_bits() {
    // Sample 10000 as it was before there were courses, fuel levels and a second variant.
    for (name, valve, speed, dither) in [
        (
            "gentle",
            0xbfc0_d1d2_4482_44a0,
            0xbf34_2c3e_b62f_a6cd,
            0xbf68_3b3e_ea1f_eb2c,
        ),
        (
            "standard",
            0xbfc6_6d18_5b58_5b80,
            0xbf3b_0816_97f8_2c50,
            0xbf68_3b3e_ea1f_eb2c,
        ),
        (
            "lively",
            0xbfd0_d1d2_4482_44a0,
            0xbf44_2c3e_b62f_a6cd,
            0xbf68_3b3e_ea1f_eb2c,
        ),
        (
            "wide",
            0xbfdc_085e_722e_7260_u64,
            0xbf44_2c3e_b62f_a6cd_u64,
            0xbf68_3b3e_ea1f_eb2c_u64,
        ),
    ] {
        let scenario = Scenario {
            profile: Profile::named(Variant::Prototype, name).unwrap(),
            seed: 7,
            ..Scenario::default()
        };
        let expected = Deviation {
            valve_deg: f64::from_bits(valve),
            speed_fraction: f64::from_bits(speed),
            dither_fraction: f64::from_bits(dither),
            ..Deviation::default()
        };
        assert_eq!(steps(&scenario, 10_001)[10_000], expected, "{name}");
    }
}

#[test]
fn a_setting_changes_its_own_quantity_only() {
    let base = steps(&lively(), 1000);
    let changes: [(&str, Change); 12] = [
        ("valve", |s| s.profile.valve_amplitude_deg = 0.7),
        ("valve", |s| s.profile.valve_hold_s = [2.0, 5.0]),
        ("speed", |s| s.profile.speed_slew_fraction_s = 1e-4),
        ("fuel", |s| s.profile.fuel_hold_s = [1.0, 2.0]),
        ("fuel", |s| s.profile.fuel_schedule.clear()),
        ("dither", |s| s.profile.dither_pole = 0.5),
        ("temperature", |s| s.boundary.temperature_k.random = None),
        ("temperature", |s| s.boundary.temperature_k.offset = -1.0),
        ("pressure", |s| s.boundary.pressure_pa = Course::default()),
        ("heating value", |s| {
            s.boundary.heating_value_fraction.random = Some(random(0.003, 50.0));
        }),
        ("heat release", |s| {
            s.disturbance.heat_release_fraction = None;
        }),
        ("torque", |s| {
            s.disturbance.torque_n_m = Some(random(5.0, 1.0));
        }),
    ];
    for (name, change) in changes {
        let mut scenario = lively();
        change(&mut scenario);
        assert_eq!(changed(&base, &steps(&scenario, 1000)), [name]);
    }
    let names = quantities(&base[0]).map(|(name, _)| name);
    for (seed, run_index) in [(8, 0), (7, 1)] {
        let mut scenario = lively();
        (scenario.seed, scenario.run_index) = (seed, run_index);
        let mut all = changed(&base, &steps(&scenario, 1000));
        all.sort_by_key(|name| names.iter().position(|other| other == name));
        assert_eq!(all, names, "{seed}, {run_index}");
    }
}

#[test]
fn streams_are_uncorrelated() {
    let mut scenario = lively();
    let white = Some(random(1.0, SAMPLE_TIME_S));
    let course = Course {
        random: white,
        ..Course::default()
    };
    scenario.boundary = Boundary {
        temperature_k: course,
        pressure_pa: course,
        heating_value_fraction: course,
    };
    scenario.disturbance = Disturbance {
        heat_release_fraction: white,
        torque_n_m: white,
    };
    let samples = steps(&scenario, 50_000);
    let row = |index: usize| {
        samples
            .iter()
            .map(move |sample| quantities(sample)[index].1)
    };
    for (first, second) in [
        (4, 5),
        (4, 6),
        (4, 7),
        (4, 8),
        (5, 6),
        (5, 7),
        (6, 7),
        (7, 8),
    ] {
        let products: f64 = row(first).zip(row(second)).map(|(a, b)| a * b).sum();
        // Correlation 1/e from sample to sample: variance (1 + e^-2) / (1 - e^-2) / N, five of them.
        let bound = 5.0 * (1.313f64 / 50_000.0).sqrt();
        assert!((products / 50_000.0).abs() < bound, "{first}, {second}");
    }
}

#[test]
fn the_start_is_the_first_sample_without_levels() {
    let drive = &mut drive(&lively());
    let start = drive.start();
    let first = drive.step();
    assert_eq!(
        changed(&[start], &[first]),
        ["valve", "speed", "fuel", "dither"]
    );
    assert_eq!(
        (start.valve_deg, start.speed_fraction, start.dither_fraction),
        (0.0, 0.0, 0.0)
    );
    assert!(
        (start.fuel_fraction + 0.1).abs() < 1e-15,
        "the schedule begins at 0.9"
    );
    drive.step();
    assert_eq!(drive.start(), start, "whatever was stepped since");
    let plain = Drive::new(
        &Profile::default(),
        &Boundary::default(),
        &Disturbance::default(),
        7,
        0,
    );
    assert_eq!(plain.start(), Deviation::default());
}

#[test]
fn courses_without_a_random_part_are_their_formula() {
    let mut scenario = lively();
    let course = &mut scenario.boundary.temperature_k;
    (course.random, course.sine) = (None, None);
    for (k, sample) in steps(&scenario, 5000).iter().enumerate() {
        let hours = k as f64 * SAMPLE_TIME_S / 3600.0;
        assert!(
            (sample.ambient_k - (3.0 + 2.0 * hours)).abs() < 1e-12,
            "{k}"
        );
    }
    scenario.boundary.temperature_k = Course {
        sine: Some(Sine {
            amplitude: 2.0,
            period_s: 40.0,
        }),
        ..Course::default()
    };
    let samples = steps(&scenario, 1001);
    // 500 samples are a period: quarters of it are at 0, 2, 0, -2.
    for (k, expected) in [(0, 0.0), (125, 2.0), (250, 0.0), (375, -2.0), (625, 2.0)] {
        assert!((samples[k].ambient_k - expected).abs() < 1e-12, "{k}");
    }
}

#[test]
fn a_fluctuation_has_its_deviation_and_time_constant() {
    let (deviation, time_constant_s) = (10.0, 2.0);
    let disturbance = Disturbance {
        torque_n_m: Some(random(deviation, time_constant_s)),
        ..Disturbance::default()
    };
    let run = |run_index| {
        let (profile, boundary) = (Profile::default(), Boundary::default());
        Drive::new(&profile, &boundary, &disturbance, 11, run_index)
    };
    let count = 1_000_000_u32;
    let mut one = run(0);
    let values: Vec<f64> = (0..count).map(|_| one.step().torque_n_m).collect();
    let n = f64::from(count);
    let decay = (-SAMPLE_TIME_S / time_constant_s).exp();
    let square = decay * decay;
    // Mean: variance (1 + a) / (1 - a) / N; five standard errors.
    let mean = values.iter().sum::<f64>() / n;
    let mean_error = deviation * ((1.0 + decay) / (1.0 - decay) / n).sqrt();
    assert!(mean.abs() < 5.0 * mean_error, "{mean}");
    // Deviation: N (1 - a^2) / (1 + a^2) = 4 10^4 values count, 0.35 %; five standard errors.
    let variance = values.iter().map(|value| value * value).sum::<f64>() / n;
    let independent = n * (1.0 - square) / (1.0 + square);
    let error = 1.0 / (2.0 * independent).sqrt();
    let ratio = variance.sqrt() / deviation;
    assert!((ratio - 1.0).abs() < 5.0 * error, "{ratio}, {error}");
    // Correlation after the time constant, 25 samples: 1/e; Bartlett's formula says 0.004.
    let lag = 25;
    let products: f64 = values.windows(lag + 1).map(|w| w[0] * w[lag]).sum();
    let correlation = products / n / variance;
    let faded = decay.powi(50);
    let bartlett = (1.0 + square) * (1.0 - faded) / (1.0 - square) - 50.0 * faded;
    let error = (bartlett / n).sqrt();
    assert!(
        (correlation - (-1.0f64).exp()).abs() < 5.0 * error,
        "{correlation}, {error}"
    );
    // Stationary from the first sample on, and recorded as the start.
    let runs = 20_000_u32;
    let squares: f64 = (0..runs)
        .map(|index| run(u64::from(index)).start().torque_n_m.powi(2))
        .sum();
    let ratio = (squares / f64::from(runs)).sqrt() / deviation;
    // Standard error 1 / sqrt(2 N) = 0.5 %; five of them.
    assert!((ratio - 1.0).abs() < 0.025, "{ratio}");
}

#[test]
fn named_profiles_of_the_machine_on_the_mains() {
    let named = |name| Profile::named(Variant::Cogeneration, name).unwrap();
    let share = |name, time_s| share_at(&named(name).fuel_schedule, time_s);
    for (name, points) in [
        ("steady", [1.0, 1.0, 1.0]),
        ("standard", [0.92, 0.92, 0.92]),
        ("load_reduction_igv", [0.98, 0.91, 0.84]),
        ("load_reduction_fuel", [0.70, 0.65, 0.60]),
    ] {
        for (times_s, expected) in [[0.0, 20.0], [50.0, 50.0], [80.0, 1e6]].iter().zip(points) {
            for &time_s in times_s {
                assert!(
                    (share(name, time_s) - expected).abs() < 1e-12,
                    "{name}, {time_s}"
                );
            }
        }
        let profile = named(name);
        assert_eq!(profile.validate_for(Variant::Cogeneration), Ok(()));
        assert_eq!(profile.excites(), name != "steady");
        assert_eq!(varies(&profile.fuel_schedule), name.starts_with("load"));
        let levels = profile.fuel_amplitude_fraction != 0.0;
        assert_eq!(levels, name == "standard");
    }
    let names = Profile::names(Variant::Cogeneration);
    assert_eq!(
        names,
        [
            "steady",
            "standard",
            "load_reduction_igv",
            "load_reduction_fuel"
        ]
    );
}

#[test]
fn a_short_disturbed_record_is_the_beginning_of_a_longer_one() {
    let run = |duration_s| {
        let boundary = lively().boundary;
        simulate(&Scenario {
            boundary,
            duration_s,
            seed: 7,
            ..Scenario::default()
        })
        .unwrap()
    };
    let (short, long) = (run(10.0), run(20.0));
    let head = long.truth.rows(0..125).unwrap();
    assert!(short.truth.y() == head.y() && short.truth.u() == head.u());
}

#[test]
fn a_run_begins_in_equilibrium_with_the_first_ambient_conditions() {
    let mut warm = Scenario {
        duration_s: 40.0,
        seed: 7,
        profile: Profile::named(Variant::Prototype, "steady").unwrap(),
        ..Scenario::default()
    };
    for (offset_k, offset_pa) in [(-50.0, -20e3), (-20.0, 8e3), (15.0, 0.0), (44.0, -5e3)] {
        warm.boundary.temperature_k.offset = offset_k;
        warm.boundary.pressure_pa.offset = offset_pa;
        assert!(!warm.excites());
        let run = simulate(&warm).unwrap();
        for (signal, row) in run.truth.outputs().iter().zip(run.truth.y().row_iter()) {
            let drift = (row.max() - row.min()) / row[0];
            assert!(drift < 1e-6, "{}: {drift}", signal.name);
        }
        let inputs = run.truth.u().column(0);
        assert!((inputs[3] - (101325.0 + offset_pa)).abs() < 1e-9);
        assert!((inputs[4] - (288.16 + offset_k)).abs() < 1e-9);
    }
    // The recorded ambient conditions are those held from the sample on.
    warm.boundary = lively().boundary;
    let run = simulate(&warm).unwrap();
    for (column, sample) in run.truth.u().column_iter().zip(steps(&warm, 500)) {
        assert!((column[3] - (101325.0 + sample.ambient_pa)).abs() < 1e-9);
        assert!((column[4] - (288.16 + sample.ambient_k)).abs() < 1e-9);
    }
}

/// Points of a schedule from gaps and shares.
fn points(gaps: &[(f64, f64)]) -> Vec<[f64; 2]> {
    let mut time_s = 0.0;
    gaps.iter()
        .map(|&(gap_s, share)| {
            time_s += gap_s;
            [time_s, share]
        })
        .collect()
}

proptest! {
    #[test]
    fn prop_schedule_is_linear_between_its_points(
        gaps in prop::collection::vec((0.1..100.0f64, 0.25..1.25f64), 1..8),
        weight in 0.0..1.0f64,
    ) {
        let points = points(&gaps);
        for &[time_s, share] in &points {
            prop_assert_eq!(share_at(&points, time_s).to_bits(), share.to_bits());
        }
        for pair in points.windows(2) {
            let mix = |i: usize| pair[0][i] + weight * (pair[1][i] - pair[0][i]);
            let found = share_at(&points, mix(0));
            // Slope up to 10 1/s times the rounding of a time below 700 s.
            prop_assert!((found - mix(1)).abs() < 1e-11, "{} {}", found, mix(1));
            // A point on the line changes nothing.
            let mut refined = points.clone();
            refined.push([mix(0), mix(1)]);
            refined.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let time_s = 0.5 * (pair[0][0] + pair[1][0]);
            let (with, without) = (share_at(&refined, time_s), share_at(&points, time_s));
            prop_assert!((with - without).abs() < 1e-9);
        }
        let (first, last) = (points[0], points[points.len() - 1]);
        prop_assert_eq!(share_at(&points, first[0] - 1.0).to_bits(), first[1].to_bits());
        prop_assert_eq!(share_at(&points, last[0] + 1.0).to_bits(), last[1].to_bits());
        prop_assert_eq!(share_at(&points, f64::INFINITY).to_bits(), last[1].to_bits());
        prop_assert_eq!(share_at(&[], weight).to_bits(), 1.0f64.to_bits());
    }

    #[test]
    fn prop_levels_keep_their_limits_slews_and_holds(
        amplitude in 0.0..0.04f64,
        shortest in 0.08..3.0f64,
        longer in 0.0..3.0f64,
        slew in 1e-4..1.0f64,
        seed: u64,
    ) {
        let hold_s = [shortest, shortest + longer];
        let scenario = Scenario {
            profile: Profile {
                valve_amplitude_deg: amplitude,
                valve_hold_s: hold_s,
                valve_slew_deg_s: slew,
                speed_amplitude_fraction: amplitude / 2.0,
                speed_hold_s: hold_s,
                speed_slew_fraction_s: slew,
                fuel_amplitude_fraction: amplitude,
                fuel_hold_s: hold_s,
                fuel_slew_fraction_s: slew,
                fuel_schedule: Vec::new(),
                dither_fraction: 0.0,
                dither_pole: 0.0,
            },
            seed,
            ..Scenario::of(Variant::Cogeneration)
        };
        prop_assert_eq!(scenario.validate(), Ok(()));
        let samples = steps(&scenario, 2000);
        for (index, limit) in [(0, amplitude), (1, amplitude / 2.0), (2, amplitude)] {
            let values: Vec<f64> = samples.iter().map(|s| quantities(s)[index].1).collect();
            prop_assert!(values.iter().all(|value| value.abs() <= limit));
            let most = slew * SAMPLE_TIME_S;
            let moves: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
            prop_assert!(moves.iter().all(|by| by.abs() <= most + 1e-15));
            // Within a hold the signal moves one way, but for rounding: reversals are a shortest
            // hold apart at least.
            let turns: Vec<usize> = (1..moves.len())
                .filter(|&k| moves[k] * moves[k - 1] < 0.0)
                .filter(|&k| moves[k].abs().min(moves[k - 1].abs()) > 1e-15)
                .collect();
            let least = (shortest / SAMPLE_TIME_S).round().max(1.0);
            prop_assert!(turns.windows(2).all(|w| (w[1] - w[0]) as f64 >= least));
        }
    }
}
