//! Scenarios as text: names, defaults, and what is refused.

use gt_plant::drive::Drive;
use gt_plant::maps::Tables;
use gt_plant::{
    ActuatorId, Boundary, Course, Disturbance, Fault, FaultCase, Fluctuation, MapSet, Mode,
    NoiseLevel, PlantError, Profile, Scenario, Shape, Sine, Step, Variant, simulate, simulate_with,
};
use proptest::prelude::*;

/// Why a scenario is refused, by `simulate` as well as by `validate`.
fn refusal(scenario: &Scenario) -> String {
    let reason = |error: Option<PlantError>| error.map(|error| error.to_string());
    let refused = reason(scenario.validate().err());
    assert_eq!(reason(simulate(scenario).err()), refused);
    refused.unwrap_or_default()
}

#[test]
fn text_and_scenario_agree() {
    let scenario: Scenario = toml::from_str(
        r#"
        map_set = "axial"
        duration_s = 60.0
        profile = "lively"
        noise = "table8"
        seed = 4

        [[faults]]
        case = "turbine_damage"
        onset_s = 15.0
        rate_percent_per_h = 5.0
        limit_percent = 5.0

        [[faults]]
        case = "fuel_actuator_lag"
        onset_s = 20.0
        rate_s_per_h = 5.0
        "#,
    )
    .unwrap();
    let expected = Scenario {
        variant: Variant::Prototype,
        map_set: MapSet::Axial,
        maps: Tables::default(),
        duration_s: 60.0,
        substeps: 28,
        profile: Profile::named(Variant::Prototype, "lively").unwrap(),
        boundary: Boundary::default(),
        disturbance: Disturbance::default(),
        noise: NoiseLevel::Table8.into(),
        faults: vec![
            Fault::nominal(FaultCase::TurbineDamage, 15.0),
            Fault::nominal(FaultCase::FuelActuatorLag, 20.0),
        ],
        seed: 4,
        run_index: 0,
    };
    assert_eq!(scenario, expected);
    assert_eq!(
        toml::from_str::<Scenario>(&toml::to_string(&expected).unwrap()),
        Ok(expected)
    );
    assert_eq!(toml::from_str::<Scenario>(""), Ok(Scenario::default()));
}

#[test]
fn a_profile_is_a_name_or_a_table() {
    let scenario: Scenario = toml::from_str("[profile]\nvalve_amplitude_deg = 2.0").unwrap();
    assert_eq!(
        scenario.profile,
        Profile {
            valve_amplitude_deg: 2.0,
            ..Profile::default()
        }
    );
    for name in Profile::names(Variant::Prototype) {
        let profile = Profile::named(Variant::Prototype, name).unwrap();
        assert_eq!(profile.validate_for(Variant::Prototype), Ok(()));
        assert_eq!(profile.excites(), *name != "steady");
    }
    assert_eq!(
        Profile::named(Variant::Prototype, "standard"),
        Ok(Profile::default())
    );
}

#[test]
fn a_profile_is_read_for_the_variant_before_or_after_it() {
    let cogeneration = |profile| Scenario {
        profile,
        ..Scenario::of(Variant::Cogeneration)
    };
    let standard = Profile::standard(Variant::Cogeneration);
    let reduction = Profile::named(Variant::Cogeneration, "load_reduction_fuel").unwrap();
    let wider = Profile {
        fuel_amplitude_fraction: 0.05,
        ..standard.clone()
    };
    let scheduled = Profile {
        fuel_schedule: vec![[0.0, 0.9], [10.0, 0.8]],
        ..standard.clone()
    };
    for (text, expected) in [
        ("variant = 'cogeneration'", standard.clone()),
        ("variant = 'cogeneration'\nprofile = 'standard'", standard),
        (
            "variant = 'cogeneration'\nprofile = 'load_reduction_fuel'",
            reduction.clone(),
        ),
        (
            "profile = 'load_reduction_fuel'\nvariant = 'cogeneration'",
            reduction,
        ),
        (
            "profile = { fuel_amplitude_fraction = 0.05 }\nvariant = 'cogeneration'",
            wider,
        ),
        (
            "variant = 'cogeneration'\n[profile]\nfuel_schedule = [[0.0, 0.9], [10.0, 0.8]]",
            scheduled,
        ),
    ] {
        let expected = cogeneration(expected);
        assert_eq!(toml::from_str::<Scenario>(text).as_ref(), Ok(&expected));
        assert_eq!(expected.validate(), Ok(()));
        let again = toml::to_string(&expected).unwrap();
        assert_eq!(toml::from_str::<Scenario>(&again).as_ref(), Ok(&expected));
        let json = serde_json::to_string(&expected).unwrap();
        assert_eq!(serde_json::from_str::<Scenario>(&json).unwrap(), expected);
    }
    let null = r#"{"profile": {"dither_pole": null}}"#;
    assert!(serde_json::from_str::<Scenario>(null).is_err());
}

#[test]
fn unknown_keys_and_names_are_refused() {
    for (text, expected) in [
        ("duration = 5.0", "unknown field `duration`"),
        (
            "[profile]\nvalve_amplitude = 2.0",
            "unknown field `valve_amplitude`",
        ),
        (
            "profile = 'wild'",
            "profile: expected one of steady, gentle, standard, lively, wide, found `wild`",
        ),
        (
            "profile = 'gentle'\nvariant = 'cogeneration'",
            "profile: expected one of steady, standard, load_reduction_igv, load_reduction_fuel, \
             found `gentle`",
        ),
        (
            "profile = 'load_reduction_igv'",
            "profile: expected one of steady, gentle, standard, lively, wide, found \
             `load_reduction_igv`",
        ),
        (
            "profile = 4",
            "expected the name or the fields of an excitation profile",
        ),
        ("variant = 'steam'", "unknown variant `steam`"),
        ("[boundary]\nhumidity = 1", "unknown field `humidity`"),
        ("[boundary.temperature_k]\nmean = 1", "unknown field `mean`"),
        (
            "[boundary.temperature_k.sine]\namplitude = 1",
            "missing field `period_s`",
        ),
        ("[disturbance]\nload = 1", "unknown field `load`"),
        (
            "[disturbance.torque_n_m]\ndeviation = 1",
            "missing field `time_constant_s`",
        ),
        (
            "noise = 'high'",
            "noise: expected one of none, low, table8, table8_variance, tables4_5, found `high`",
        ),
        (
            "[[faults]]\ncase = 'turbine_damage'\nonset_s = 1.0\nrate_percent_per_h = 5.0\nsize = 1",
            "unknown field `size`",
        ),
        (
            "[[faults]]\ncase = 'leak'\nonset_s = 1.0",
            "unknown variant `leak`",
        ),
    ] {
        let message = toml::from_str::<Scenario>(text).unwrap_err().to_string();
        assert!(message.contains(expected), "{text}: {message}");
    }
    let names = [
        "variant: expected one of prototype, cogeneration, found `steam`",
        "paper, axial",
        "none, low, table8",
    ];
    let errors = [
        "steam".parse::<Variant>().unwrap_err(),
        "flat".parse::<MapSet>().unwrap_err(),
        "loud".parse::<NoiseLevel>().unwrap_err(),
    ];
    for (error, names) in errors.iter().zip(names) {
        assert!(error.to_string().contains(names), "{error}");
    }
}

#[test]
fn names_come_back() {
    for (variant, name) in [Variant::Prototype, Variant::Cogeneration]
        .into_iter()
        .zip(Variant::NAMES)
    {
        assert_eq!(variant.to_string(), *name);
        assert_eq!(name.parse(), Ok(variant));
        let json = serde_json::to_string(&variant).unwrap();
        assert_eq!(json, format!("\"{variant}\""));
    }
    for map_set in [MapSet::Paper, MapSet::Axial] {
        assert_eq!(map_set.to_string().parse(), Ok(map_set));
        let json = serde_json::to_string(&map_set).unwrap();
        assert_eq!(json, format!("\"{map_set}\""));
    }
}

#[test]
fn impossible_durations_are_refused() {
    for duration_s in [-1.0, 0.0, 0.03, f64::NAN, f64::INFINITY, 1e9] {
        let message = refusal(&Scenario {
            duration_s,
            ..Scenario::default()
        });
        let expected = format!("duration: expected between 0.08 and 160000 s, found {duration_s}");
        assert_eq!(message, expected);
    }
}

#[test]
fn unstable_steps_are_refused() {
    for substeps in [0, 10_001] {
        let message = refusal(&Scenario {
            substeps,
            ..Scenario::default()
        });
        let expected = format!(
            "substeps: expected 1 to 10000 a sample (a step of at most 0.080000 s), found \
             {substeps}"
        );
        assert_eq!(message, expected);
    }
    // 0.96 of the longest stable step of the linearised plant, which is 3.542 ms.
    let short = |substeps| Scenario {
        substeps,
        duration_s: 1.0,
        ..Scenario::default()
    };
    for substeps in [1, 23] {
        let message = simulate(&short(substeps)).unwrap_err().to_string();
        let expected = format!(
            "substeps: expected 24 to 10000 a sample (a step of at most 0.003400 s), found \
             {substeps}"
        );
        assert_eq!(message, expected);
    }
    assert!(simulate(&short(24)).is_ok());
}

#[test]
fn impossible_profiles_and_faults_are_refused() {
    let with = |change: fn(&mut Profile)| {
        let mut scenario = Scenario::default();
        change(&mut scenario.profile);
        refusal(&scenario)
    };
    assert_eq!(
        with(|profile| profile.valve_amplitude_deg = -1.0),
        "valve_amplitude_deg: expected between 0 and 20, found -1"
    );
    assert_eq!(
        with(|profile| profile.speed_hold_s = [4.0, 3.0]),
        "speed_hold_s: expected at least the shortest hold and finite, found 3"
    );
    assert_eq!(
        with(|profile| profile.valve_slew_deg_s = 0.0),
        "valve_slew_deg_s: expected above 0 and finite, found 0"
    );
    assert_eq!(
        with(|profile| profile.dither_pole = f64::NAN),
        "dither_pole: expected between 0 and 0.999, found NaN"
    );
    let stuck = Fault::actuator(
        ActuatorId::Valve,
        Mode::Stuck,
        1.0,
        Shape::Step(Step { size: 1.0 }),
    );
    let scenario = Scenario {
        faults: vec![stuck; 2],
        ..Scenario::default()
    };
    let twice = PlantError::FaultConflict {
        held: "actuator a_v".to_owned(),
        first: "a_v_actuator_stuck".to_owned(),
        second: "a_v_actuator_stuck".to_owned(),
    };
    assert_eq!(scenario.validate(), Err(twice));
    assert_eq!(
        refusal(&scenario),
        "faults: expected at most one that holds actuator a_v, found a_v_actuator_stuck and \
         a_v_actuator_stuck"
    );
}

#[test]
fn impossible_schedules_and_fuel_levels_are_refused() {
    let with = |variant, change: fn(&mut Profile)| {
        let mut scenario = Scenario::of(variant);
        change(&mut scenario.profile);
        refusal(&scenario)
    };
    let on_the_mains = |change| with(Variant::Cogeneration, change);
    assert_eq!(
        on_the_mains(|profile| profile.fuel_hold_s = [-1.0, 3.0]),
        "fuel_hold_s: expected at least one sample time and finite, found -1"
    );
    assert_eq!(
        on_the_mains(|profile| profile.fuel_amplitude_fraction = 0.3),
        "fuel_amplitude_fraction: expected between 0 and 0.2, found 0.3"
    );
    assert_eq!(
        on_the_mains(|profile| profile.fuel_slew_fraction_s = f64::INFINITY),
        "fuel_slew_fraction_s: expected above 0 and finite, found inf"
    );
    for (schedule, expected) in [
        (
            vec![[0.0, 1.0], [20.0, 0.9], [10.0, 0.8]],
            "times that increase from point to point and are finite, found 10",
        ),
        (
            vec![[5.0, 1.0], [5.0, 0.9]],
            "times that increase from point to point and are finite, found 5",
        ),
        (
            vec![[5.0, 1.0], [f64::INFINITY, 0.9]],
            "times that increase from point to point and are finite, found inf",
        ),
        (
            vec![[-1.0, 1.0]],
            "times of at least 0 s that are finite, found -1",
        ),
        (
            vec![[f64::NAN, 1.0]],
            "times of at least 0 s that are finite, found NaN",
        ),
        (
            vec![[0.0, 0.2]],
            "shares of design fuel flow between 0.25 and 1.25, found 0.2",
        ),
        (
            vec![[0.0, 0.9], [1.0, f64::NAN]],
            "shares of design fuel flow between 0.25 and 1.25, found NaN",
        ),
    ] {
        let mut scenario = Scenario::of(Variant::Cogeneration);
        scenario.profile.fuel_schedule = schedule;
        assert_eq!(
            refusal(&scenario),
            format!("fuel_schedule: expected {expected}")
        );
    }
    assert_eq!(
        on_the_mains(|profile| profile.valve_amplitude_deg = 6.0),
        "valve_amplitude_deg: expected in the variant cogeneration between 0 and 5, as the valve \
         stands open, found 6"
    );
    assert_eq!(
        on_the_mains(|profile| profile.speed_amplitude_fraction = 0.03),
        "speed_amplitude_fraction: expected in the variant cogeneration between 0 and 0.02, as the \
         mains hold the speed, found 0.03"
    );
    let governed = |change| with(Variant::Prototype, change);
    assert_eq!(
        governed(|profile| profile.fuel_schedule = vec![[0.0, 1.0], [9.0, 1.0]]),
        "fuel_schedule: expected in the variant prototype none, as the governor sets the fuel, \
         found 2 points"
    );
    assert_eq!(
        governed(|profile| profile.fuel_amplitude_fraction = 0.01),
        "fuel_amplitude_fraction: expected in the variant prototype none, as the governor sets the \
         fuel, found 0.01"
    );
    let scenario = Scenario {
        profile: Profile::standard(Variant::Cogeneration),
        ..Scenario::default()
    };
    assert!(matches!(
        scenario.validate(),
        Err(PlantError::NotInVariant {
            what: "fuel_amplitude_fraction",
            variant: Variant::Prototype,
            ..
        })
    ));
}

proptest! {
    #[test]
    fn prop_samples_are_the_rounded_duration(n in 1..1_000_000u32, off in -0.49..0.49f64) {
        let duration_s = 0.08 * (f64::from(n) + off);
        let samples = Scenario { duration_s, ..Scenario::default() }.samples();
        let expected = if f64::from(n) + off < 0.5 { None } else { Some(n as usize) };
        prop_assert_eq!(samples.ok(), expected);
    }

    #[test]
    fn prop_no_text_panics(text in "(duration_s|substeps|seed|noise|profile|variant|fuel_schedule|\\[boundary.temperature_k\\]|\\[disturbance.torque_n_m\\]|offset|random|deviation|\\[\\[0, 1\\]\\]|\\[\\[faults\\]\\]|case|onset_s| |=|\n|[0-9.e-]{1,8}|'[a-z_]{1,20}'){0,12}") {
        if let Ok(scenario) = toml::from_str::<Scenario>(&text) {
            let _ = scenario.validate();
        }
    }

    #[test]
    fn prop_no_fields_panic(
        variant in prop_oneof![Just(Variant::Prototype), Just(Variant::Cogeneration)],
        numbers in prop::array::uniform32(prop_oneof![any::<f64>(), Just(0.0), 0.08..10.0f64]),
        points in prop::collection::vec(any::<[f64; 2]>(), 0..4),
    ) {
        let mut numbers = numbers.into_iter();
        let mut next = || numbers.next().unwrap_or_default();
        let mut scenario = Scenario { variant, duration_s: 0.8, ..Scenario::default() };
        scenario.profile.valve_amplitude_deg = next();
        scenario.profile.valve_hold_s = [next(), next()];
        scenario.profile.valve_slew_deg_s = next();
        scenario.profile.fuel_amplitude_fraction = next();
        scenario.profile.fuel_hold_s = [next(), next()];
        scenario.profile.fuel_slew_fraction_s = next();
        scenario.profile.fuel_schedule = points;
        let mut course = || Course {
            offset: next(),
            rate_per_h: next(),
            sine: Some(Sine { amplitude: next(), period_s: next() }),
            random: Some(Fluctuation { deviation: next(), time_constant_s: next() }),
        };
        scenario.boundary.temperature_k = course();
        scenario.boundary.pressure_pa = course();
        scenario.disturbance.torque_n_m = course().random;
        let _ = scenario.validate();
        let Scenario { profile, boundary, disturbance, .. } = &scenario;
        let mut drive = Drive::new(profile, boundary, disturbance, 1, 0);
        for _ in 0..10 {
            let _ = drive.step();
        }
    }
}

#[test]
fn a_plant_of_the_other_variant_is_refused() {
    let plant = Scenario::of(Variant::Cogeneration).parameters();
    let error = simulate_with(&plant, &Scenario::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "plant: expected in the variant prototype the parameters of that variant, found \
         cogeneration"
    );
}
