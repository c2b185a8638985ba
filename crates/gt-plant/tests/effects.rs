//! What the paper's four faults do to the outputs, and where the speed loop loses its stability.
#![expect(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "helpers stand outside the test functions; what is exact is compared exactly"
)]

use gt_plant::dynamics::derivative;
use gt_plant::effects::MONITORED;
use gt_plant::state::STATES;
use gt_plant::{
    ActuatorFault, EffectSettings, Fault, FaultCase, FaultEffects, FaultSizes, Inputs, MapSet,
    PlantError, PlantParameters, Profile, Scenario, Variant, lag_limit, local_model, rk4, simulate,
    steady_state,
};
use nalgebra::DMatrix;

const MAP_SETS: [MapSet; 2] = [MapSet::Paper, MapSet::Axial];

fn plant(map_set: MapSet) -> PlantParameters {
    PlantParameters::for_maps(map_set)
}

fn profile(name: &str) -> Profile {
    Profile::named(Variant::Prototype, name).unwrap()
}

/// Settings over a window that is long enough for an identity.
fn short() -> EffectSettings {
    EffectSettings {
        window_s: 20.0,
        settle_s: 5.0,
        ..EffectSettings::default()
    }
}

fn measured(map_set: MapSet, settings: &EffectSettings) -> FaultEffects {
    FaultEffects::measure(&plant(map_set), settings).unwrap()
}

fn largest(matrix: &DMatrix<f64>) -> f64 {
    matrix.amax()
}

/// Effects of the first prototype in percent (spec section 6): output; static effect of cases 1
/// and 3 in the closed loop and with inputs held; root mean square of case 4 in the closed loop.
const TABLE: [(&str, [f64; 5]); 27] = [
    ("p1", [0.07, 0.06, -0.00, 0.22, 0.04]),
    ("p2", [0.08, 0.06, -0.00, 0.25, 0.05]),
    ("p3", [-2.81, 1.38, 0.05, -5.01, 1.38]),
    ("p4", [-2.78, 1.54, 0.05, -4.81, 1.42]),
    ("p5", [-2.73, 1.84, 0.05, -4.47, 1.51]),
    ("p7", [-2.84, 3.18, 0.04, -3.55, 1.72]),
    ("p8", [-0.12, -0.07, 0.00, -0.33, 0.07]),
    ("m1", [-1.91, -1.41, 0.06, -5.37, 1.03]),
    ("m3", [-1.91, -1.41, 0.06, -5.37, 1.03]),
    ("m4", [-1.91, -1.41, 0.06, -5.37, 1.07]),
    ("m5", [-1.80, -2.13, 0.07, -5.74, 1.43]),
    ("m6", [-2.36, 1.34, 0.05, -3.96, 1.21]),
    ("m10", [-2.36, 1.34, 0.05, -3.96, 1.21]),
    ("m8", [-1.91, -1.48, 0.06, -5.43, 1.20]),
    ("m9", [-1.84, -1.89, 0.06, -5.64, 1.33]),
    ("t1", [0.0, 0.0, 0.0, 0.0, 0.0]),
    ("t2", [0.0, 0.0, 0.0, 0.0, 0.0]),
    ("t3", [-0.86, 0.39, -0.00, -1.76, 0.42]),
    ("t4", [-0.86, 0.39, -0.00, -1.76, 0.42]),
    ("t5", [-1.66, 6.69, -0.03, 1.93, 3.76]),
    ("t6", [-1.66, 6.69, -0.03, 1.93, 3.76]),
    ("t7", [-1.73, 8.66, -0.05, 3.54, 3.82]),
    ("q_c", [-3.57, -0.65, -3.27, -1.64, 0.35]),
    ("q_t", [-3.55, -0.65, -3.23, -1.69, 2.84]),
    ("P_c", [-3.57, -0.65, 0.06, -8.59, 1.48]),
    ("P_t", [-3.55, -0.65, 0.09, -8.64, 3.20]),
    ("w_t", [0.0, 0.0, 3.44, -7.07, 1.32]),
];

#[test]
fn regress_effects_of_the_first_prototype() {
    let effects = measured(
        MapSet::Paper,
        &EffectSettings {
            profile: profile("wide"),
            window_s: 300.0,
            ..EffectSettings::default()
        },
    );
    let (raw, held) = (
        &effects.raw.static_percent,
        &effects.inputs_held.static_percent,
    );
    let m9 = effects.row("m9").unwrap();
    // How hard the excitation of this seed is, against the prototype's: runs of 600 s differ by
    // a fifth.
    let strength = effects.raw.rms_percent[(m9, 3)] / 1.33;
    assert!((strength - 1.0).abs() < 0.3, "{strength}");
    for (name, published) in TABLE {
        let row = effects.row(name).unwrap();
        let found = [raw[(row, 0)], raw[(row, 2)], held[(row, 0)], held[(row, 2)]];
        for (found, published) in found.into_iter().zip(published) {
            // 1.5 % of the effect and 0.04 points, where effects cancel to little: the prototype
            // that printed it had 0.4 % smaller flows and twice the loss.
            assert!(
                (found - published).abs() < 0.04 + 0.015 * published.abs(),
                "{name}: {found} against {published}"
            );
        }
        let (found, published) = (effects.raw.rms_percent[(row, 3)] / strength, published[4]);
        // Half a unit of what is printed; another excitation has another spectrum.
        assert!(
            (found - published).abs() < 0.008 + 0.05 * published,
            "{name}, case 4: {found} against {published}"
        );
    }
}

#[test]
fn prop_without_excitation_the_rms_is_the_static_effect() {
    for map_set in MAP_SETS {
        let effects = measured(
            map_set,
            &EffectSettings {
                profile: profile("steady"),
                ..short()
            },
        );
        for reading in [&effects.raw, &effects.inputs_held] {
            let difference = &reading.rms_percent - reading.static_percent.abs();
            // Equilibria are found to 1e-10 1/s of each state.
            assert!(largest(&difference) < 1e-6, "{difference}");
            assert!(largest(&reading.static_percent) > 3.0);
        }
    }
}

/// A fault that reaches its full size within 1 ms of its onset.
fn step(case: FaultCase, onset_s: f64, size: f64) -> Fault {
    Fault::growing(case, onset_s, 3.6e6 * size, Some(size))
}

#[test]
fn prop_a_step_in_a_run_settles_at_the_static_effect() {
    let effects = measured(MapSet::Paper, &short());
    for (column, case) in FaultCase::ALL.into_iter().take(3).enumerate() {
        let run = simulate(&Scenario {
            duration_s: 60.0,
            profile: profile("steady"),
            faults: vec![step(case, 1.0, 5.0)],
            ..Scenario::default()
        })
        .unwrap();
        let y = run.measured.y();
        for (row, signal) in effects.outputs.iter().enumerate() {
            let found = 100.0 * (y[(row, y.ncols() - 1)] / y[(row, 0)] - 1.0);
            let settled = effects.raw.static_percent[(row, column)];
            // The governor's slowest mode, -1.03 1/s, is over after 59 s.
            assert!(
                (found - settled).abs() < 1e-3,
                "{}, {case}: {found} against {settled}",
                signal.name
            );
        }
    }
}

#[test]
fn prop_the_raw_rms_is_that_of_two_runs() {
    // The same excitation through the recorder, on plain numbers instead of lanes.
    let settings = EffectSettings {
        seed: 11,
        run_index: 3,
        ..short()
    };
    let effects = measured(MapSet::Axial, &settings);
    let record = |faults| {
        let run = simulate(&Scenario {
            map_set: MapSet::Axial,
            duration_s: 25.0,
            substeps: settings.substeps,
            profile: settings.profile.clone(),
            seed: 11,
            run_index: 3,
            faults,
            ..Scenario::default()
        })
        .unwrap();
        run.measured.y().columns_range(63..).into_owned()
    };
    let healthy = record(Vec::new());
    for (column, size) in [(1, 5.0), (3, 2.0)] {
        let difference = record(vec![step(FaultCase::ALL[column], 0.0, size)]) - &healthy;
        for (row, signal) in effects.outputs.iter().enumerate() {
            let mean_square = difference.row(row).norm_squared() / difference.ncols() as f64;
            let expected = 100.0 * mean_square.sqrt() / effects.steady[row];
            let found = effects.raw.rms_percent[(row, column)];
            // The lag grows within the first step, in which the fuel follows the first jump of the
            // dither by a twentieth.
            assert!(
                (found - expected).abs() < 2e-4,
                "{}, column {column}: {found} against {expected}",
                signal.name
            );
        }
    }
}

#[test]
fn case_4_shows_with_demanded_fuel_alone() {
    for map_set in MAP_SETS {
        let effects = measured(map_set, &EffectSettings::default());
        let delivered = effects.delivered_fuel_rms_percent.iter().copied();
        assert!(delivered.fold(0.0, f64::max) < 1e-6);
        for name in MONITORED {
            let row = effects.row(name).unwrap();
            // Least is q_c with the paper's maps, 0.48 % and 0.21 %.
            assert!(effects.inputs_held.rms_percent[(row, 3)] > 0.4, "{name}");
            assert!(effects.raw.rms_percent[(row, 3)] > 0.15, "{name}");
        }
        // And only while something moves.
        for reading in [&effects.raw, &effects.inputs_held] {
            assert_eq!(largest(&reading.static_percent.columns(3, 1).into()), 0.0);
        }
    }
}

#[test]
fn case_2_touches_its_sensor_only() {
    let settings = EffectSettings {
        drift_percent: -5.0,
        ..short()
    };
    let effects = measured(MapSet::Paper, &settings);
    let t3 = effects.row("t3").unwrap();
    for reading in [&effects.raw, &effects.inputs_held] {
        for row in 0..effects.outputs.len() {
            let (settled, rms) = (
                reading.static_percent[(row, 1)],
                reading.rms_percent[(row, 1)],
            );
            if row == t3 {
                assert!((settled + 5.0).abs() < 1e-12, "{settled}");
                // A share of a temperature that moves by less than 1 %.
                assert!((rms - 5.0).abs() < 0.05, "{rms}");
            } else {
                assert_eq!((settled, rms), (0.0, 0.0), "{}", effects.outputs[row].name);
            }
        }
    }
}

#[test]
fn no_fault_has_no_effect_at_all() {
    let none = EffectSettings {
        flow_loss_percent: 0.0,
        drift_percent: 0.0,
        efficiency_loss_percent: 0.0,
        lag_s: 0.0,
        ..short()
    };
    for map_set in MAP_SETS {
        let effects = measured(map_set, &none);
        for reading in [&effects.raw, &effects.inputs_held] {
            assert_eq!(largest(&reading.static_percent), 0.0);
            assert_eq!(largest(&reading.rms_percent), 0.0);
            let signature = effects.signature(&reading.rms_percent);
            assert_eq!(signature.strongest_case, [None; 4]);
            assert_eq!(signature.most_affected, [None; 4]);
        }
        assert!(
            effects
                .delivered_fuel_rms_percent
                .iter()
                .all(|rms| *rms == 0.0)
        );
    }
}

#[test]
fn prop_half_the_size_is_half_the_effect() {
    let half = EffectSettings {
        flow_loss_percent: 2.5,
        drift_percent: 2.5,
        efficiency_loss_percent: 2.5,
        ..short()
    };
    for map_set in MAP_SETS {
        let (whole, half) = (measured(map_set, &short()), measured(map_set, &half));
        for (whole, half) in [
            (&whole.raw, &half.raw),
            (&whole.inputs_held, &half.inputs_held),
        ] {
            for (whole, half) in [
                (&whole.static_percent, &half.static_percent),
                (&whole.rms_percent, &half.rms_percent),
            ] {
                for column in 0..3 {
                    for row in 0..whole.nrows() {
                        let (whole, half) = (whole[(row, column)], half[(row, column)]);
                        // Curvature: 6.5 % at most (q_c, case 3), and where effects cancel, 0.03
                        // points (m5, case 1 with inputs held).
                        assert!(
                            (whole / 2.0 - half).abs() < 0.04 + 0.07 * half.abs(),
                            "{map_set}, row {row}, column {column}: {whole} and {half}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn regress_static_signature_of_both_map_sets() {
    let effects = measured(MapSet::Paper, &short());
    let signature = effects.signature(&effects.raw.static_percent);
    // At a fixed size m9 has no case of its own: case 4 has no static effect.
    assert_eq!(
        signature.strongest_case,
        [Some(1), Some(2), Some(3), Some(3)]
    );
    assert_eq!(
        signature.most_affected,
        [Some("q_c"), Some("t3"), Some("p7"), None]
    );
    assert!(!signature.is_diagonal());
    // Spec section 6: "f1 on p7 = 0.89 of f3".
    assert!((signature.share[(2, 0)] - 0.89).abs() < 0.01);
    let effects = measured(MapSet::Axial, &short());
    let axial = effects.signature(&effects.raw.static_percent);
    assert_eq!(axial.strongest_case[2], Some(1), "p7 shows fouling most");
}

#[test]
fn a_report_holds_rows_of_four() {
    let effects = measured(MapSet::Paper, &short());
    let report = serde_json::to_value(&effects).unwrap();
    let rows = report["raw"]["static_percent"].as_array().unwrap();
    assert_eq!((rows.len(), rows[0].as_array().unwrap().len()), (28, 4));
    let p7 = effects.row("p7").unwrap();
    assert_eq!(report["outputs"][p7]["name"], "p7");
    assert_eq!(rows[p7][2], effects.raw.static_percent[(p7, 2)]);
    assert_eq!(effects.row("p6"), None);
}

#[test]
fn impossible_settings_are_refused() {
    let refused = |settings: EffectSettings| {
        FaultEffects::measure(&plant(MapSet::Paper), &settings)
            .unwrap_err()
            .to_string()
    };
    let fouled = EffectSettings {
        flow_loss_percent: 100.0,
        ..short()
    };
    assert_eq!(
        refused(fouled),
        "flow_loss_percent: expected between 0 and 99, found 100"
    );
    let lag_s = EffectSettings {
        lag_s: f64::NAN,
        ..short()
    };
    assert_eq!(
        refused(lag_s),
        "lag_s: expected at least 0 and finite, found NaN"
    );
    let coarse = EffectSettings {
        substeps: 20,
        ..short()
    };
    assert!(refused(coarse).starts_with("substeps: expected 24 to 10000 a sample"));
    let empty = EffectSettings {
        window_s: 0.0,
        ..short()
    };
    assert!(refused(empty).starts_with("duration: expected between 0.08"));
    let on_the_mains = PlantParameters::new(Variant::Cogeneration, MapSet::Paper);
    for error in [
        FaultEffects::measure(&on_the_mains, &short()).unwrap_err(),
        lag_limit(&on_the_mains).unwrap_err(),
    ] {
        assert!(
            matches!(error, PlantError::NotInVariant { .. }),
            "expected the prototype, found {error}"
        );
    }
}

fn lagging(lag_s: f64) -> FaultSizes {
    FaultSizes {
        fuel: ActuatorFault {
            lag_s,
            ..ActuatorFault::HEALTHY
        },
        ..FaultSizes::HEALTHY
    }
}

#[test]
fn regress_lag_limit_of_the_paper_maps() {
    let limit = lag_limit(&plant(MapSet::Paper)).unwrap().unwrap();
    // Spec section 6: "~3.05 s".
    assert!((limit.lag_s - 3.05).abs() < 0.01, "{limit:?}");
    // Our own: a period of 6.8 s.
    assert!((limit.frequency_rad_s - 0.926).abs() < 0.01, "{limit:?}");
}

#[test]
fn axial_maps_have_no_lag_limit() {
    let plant = plant(MapSet::Axial);
    assert_eq!(lag_limit(&plant), Ok(None));
    let (inputs, state) = (Inputs::design(&plant), steady_state(&plant).unwrap().state);
    for exponent in -8..=40 {
        let lag_s = 10.0_f64.powf(f64::from(exponent) / 10.0);
        let model = local_model(&plant, &inputs, &lagging(lag_s), &state).unwrap();
        assert!(model.is_stable(), "{lag_s} s");
    }
}

/// Root mean square deviation of the speed from its equilibrium (rad/s) over each of `windows`
/// equal windows, after the speed was kicked by a thousandth.
fn swings(plant: &PlantParameters, lag_s: f64, windows: usize, window_s: f64) -> Vec<f64> {
    let (inputs, faults) = (Inputs::design(plant), lagging(lag_s));
    let start = steady_state(plant).unwrap().state.to_array();
    let mut x = start;
    x[0] *= 1.001;
    let rates = |_: f64, x: &[f64; STATES]| derivative(plant, &inputs, &faults, x);
    let steps = 450 * windows;
    let step_s = window_s / 2700.0;
    assert!(step_s < 3.3e-3);
    let mut found = vec![0.0; windows];
    for k in 0..steps {
        for _ in 0..6 {
            x = rk4::step(rates, 0.0, &x, step_s);
        }
        found[k / 450] += (x[0] - start[0]).powi(2) / 450.0;
    }
    found.into_iter().map(f64::sqrt).collect()
}

#[test]
fn prop_a_kick_decays_below_the_lag_limit_and_grows_above() {
    let plant = plant(MapSet::Paper);
    let limit = lag_limit(&plant).unwrap().unwrap();
    let (inputs, state) = (Inputs::design(&plant), steady_state(&plant).unwrap().state);
    for factor in [0.9, 1.1] {
        let lag_s = factor * limit.lag_s;
        let model = local_model(&plant, &inputs, &lagging(lag_s), &state).unwrap();
        let pole = model.poles_per_s()[0];
        let period_s = std::f64::consts::TAU / pole.im.abs();
        let swings = swings(&plant, lag_s, 12, period_s);
        // From the second period on only this mode is left; whole periods of it.
        let growth_per_s = (swings[11] / swings[1]).ln() / (10.0 * period_s);
        assert_eq!(growth_per_s > 0.0, factor > 1.0, "{factor}: {growth_per_s}");
        // A kick of 0.1 % leaves the linear model by as little.
        let error = (growth_per_s - pole.re) / pole.re;
        assert!(error.abs() < 0.02, "{growth_per_s} against {pole}");
    }
}
