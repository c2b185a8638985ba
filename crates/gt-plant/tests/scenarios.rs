//! Scenarios as text: names, defaults, and what is refused.

use gt_plant::{Fault, FaultCase, MapSet, NoiseLevel, PlantError, Profile, Scenario, simulate};
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
        map_set: MapSet::Axial,
        duration_s: 60.0,
        substeps: 40,
        profile: Profile::named("lively").unwrap(),
        noise: NoiseLevel::Table8,
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
    for name in Profile::NAMES {
        let profile = Profile::named(name).unwrap();
        assert_eq!(profile.validate(), Ok(()));
        assert_eq!(profile.excites(), *name != "steady");
    }
    assert_eq!(Profile::named("standard"), Ok(Profile::default()));
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
        ("noise = 'high'", "unknown variant `high`"),
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
    let names = ["paper, axial", "none, low, table8"];
    let errors = [
        "flat".parse::<MapSet>().unwrap_err(),
        "loud".parse::<NoiseLevel>().unwrap_err(),
    ];
    for (error, names) in errors.iter().zip(names) {
        assert!(error.to_string().contains(names), "{error}");
    }
}

#[test]
fn names_come_back() {
    for level in [NoiseLevel::None, NoiseLevel::Low, NoiseLevel::Table8] {
        assert_eq!(level.to_string().parse(), Ok(level));
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
    for substeps in [0, 1, 23, 10_001] {
        let message = refusal(&Scenario {
            substeps,
            ..Scenario::default()
        });
        let expected = format!(
            "substeps: expected 24 to 10000 a sample (RK4 is stable up to a step of 0.0034 s), \
             found {substeps}"
        );
        assert_eq!(message, expected);
    }
    assert_eq!(
        Scenario {
            substeps: 24,
            ..Scenario::default()
        }
        .validate(),
        Ok(())
    );
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
    let twice = vec![Fault::nominal(FaultCase::TurbineDamage, 1.0); 2];
    let scenario = Scenario {
        faults: twice,
        ..Scenario::default()
    };
    let case = FaultCase::TurbineDamage;
    assert_eq!(scenario.validate(), Err(PlantError::RepeatedFault { case }));
    assert_eq!(
        refusal(&scenario),
        "faults: expected each case once, found turbine_damage twice"
    );
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
    fn prop_no_text_panics(text in "(duration_s|substeps|seed|noise|profile|\\[\\[faults\\]\\]|case|onset_s| |=|\n|[0-9.e-]{1,8}|'[a-z_]{1,20}'){0,12}") {
        if let Ok(scenario) = toml::from_str::<Scenario>(&text) {
            let _ = scenario.validate();
        }
    }
}
