//! Boundary conditions and disturbances as text, and what is refused.

use gt_plant::{
    Boundary, Course, Disturbance, Fluctuation, MapSet, PlantError, PlantParameters, Scenario,
    Sine, simulate, simulate_with,
};

/// Why a scenario is refused, by `simulate` as well as by `validate`.
fn refusal(scenario: &Scenario) -> String {
    let reason = |error: Option<PlantError>| error.map(|error| error.to_string());
    let refused = reason(scenario.validate().err());
    assert_eq!(reason(simulate(scenario).err()), refused);
    refused.unwrap_or_default()
}

#[test]
fn boundary_and_disturbance_as_text() {
    let scenario: Scenario = toml::from_str(
        r"
        [boundary.temperature_k]
        offset = 5.0
        rate_per_h = 0.5
        sine = { amplitude = -2.0, period_s = 86400.0 }

        [boundary.pressure_pa.random]
        deviation = 200.0
        time_constant_s = 3600.0

        [disturbance]
        torque_n_m = { deviation = 20.0, time_constant_s = 2.0 }
        ",
    )
    .unwrap();
    let fluctuation = |deviation, time_constant_s| {
        Some(Fluctuation {
            deviation,
            time_constant_s,
        })
    };
    let expected = Scenario {
        boundary: Boundary {
            temperature_k: Course {
                offset: 5.0,
                rate_per_h: 0.5,
                sine: Some(Sine {
                    amplitude: -2.0,
                    period_s: 86400.0,
                }),
                random: None,
            },
            pressure_pa: Course {
                random: fluctuation(200.0, 3600.0),
                ..Course::default()
            },
            heating_value_fraction: Course::default(),
        },
        disturbance: Disturbance {
            heat_release_fraction: None,
            torque_n_m: fluctuation(20.0, 2.0),
        },
        ..Scenario::default()
    };
    assert_eq!(scenario, expected);
    assert_eq!(expected.validate(), Ok(()));
    let again = toml::to_string(&expected).unwrap();
    assert_eq!(toml::from_str::<Scenario>(&again), Ok(expected.clone()));
    let json = serde_json::to_string(&expected).unwrap();
    assert_eq!(serde_json::from_str::<Scenario>(&json).unwrap(), expected);
}

#[test]
fn impossible_boundaries_and_disturbances_are_refused() {
    for (text, expected) in [
        (
            "temperature_k = { offset = nan }",
            "temperature_k: expected a finite offset, found NaN",
        ),
        (
            "temperature_k = { rate_per_h = inf }",
            "temperature_k: expected a finite rate_per_h, found inf",
        ),
        (
            "pressure_pa.sine = { amplitude = nan, period_s = 5.0 }",
            "pressure_pa: expected a finite sine.amplitude, found NaN",
        ),
        (
            "pressure_pa.sine = { amplitude = 1.0, period_s = 0.1 }",
            "pressure_pa: expected a sine.period_s of at least two sample times (0.16 s) and \
             finite, found 0.1",
        ),
        (
            "pressure_pa.random = { deviation = -1.0, time_constant_s = 5.0 }",
            "pressure_pa: expected a random.deviation of at least 0 and finite, found -1",
        ),
        (
            "heating_value_fraction.random = { deviation = 0.01, time_constant_s = -5.0 }",
            "heating_value_fraction: expected a random.time_constant_s of at least one sample time \
             (0.08 s) and finite, found -5",
        ),
        (
            "temperature_k = { offset = -60.16 }",
            "temperature_k: expected between 233 and 333 K throughout, 5 standard deviations \
             included, found 228",
        ),
        (
            "temperature_k = { offset = -0.16, rate_per_h = 300.0 }",
            "temperature_k: expected between 233 and 333 K throughout, 5 standard deviations \
             included, found 338",
        ),
        (
            "temperature_k.random = { deviation = 1e308, time_constant_s = 5.0 }",
            "temperature_k: expected between 233 and 333 K throughout, 5 standard deviations \
             included, found -inf",
        ),
        (
            "pressure_pa = { offset = 675.0, sine = { amplitude = -9000.0, period_s = 1e6 } }",
            "pressure_pa: expected between 80000 and 110000 Pa throughout, 5 standard deviations \
             included, found 111000",
        ),
        (
            "heating_value_fraction.random = { deviation = 0.05, time_constant_s = 5.0 }",
            "heating_value_fraction: expected between 0.8 and 1.2 throughout, 5 standard \
             deviations included, found 0.75",
        ),
    ] {
        let scenario: Scenario = toml::from_str(&format!("[boundary]\n{text}")).unwrap();
        let expected = format!("boundary.{expected}");
        assert!(refusal(&scenario).starts_with(&expected), "{text}");
    }
    for (text, expected) in [
        (
            "torque_n_m = { deviation = 501.0, time_constant_s = 1.0 }",
            "torque_n_m: expected a deviation between 0 and 500 N m, found 501",
        ),
        (
            "heat_release_fraction = { deviation = nan, time_constant_s = 1.0 }",
            "heat_release_fraction: expected a deviation between 0 and 0.05, found NaN",
        ),
        (
            "torque_n_m = { deviation = 5.0, time_constant_s = 0.01 }",
            "torque_n_m: expected a time_constant_s of at least one sample time (0.08 s) and \
             finite, found 0.01",
        ),
    ] {
        let scenario: Scenario = toml::from_str(&format!("[disturbance]\n{text}")).unwrap();
        assert_eq!(refusal(&scenario), format!("disturbance.{expected}"));
    }
}

#[test]
fn ambient_limits_are_those_of_the_parameters_that_run() {
    let mut parameters = PlantParameters::for_maps(MapSet::Paper);
    parameters.design.ambient_k = 300.0;
    let mut scenario = Scenario {
        duration_s: 0.8,
        ..Scenario::default()
    };
    scenario.boundary.temperature_k.offset = 40.0;
    assert_eq!(scenario.validate(), Ok(()));
    assert_eq!(
        simulate_with(&parameters, &scenario).map(|_| ()),
        Err(PlantError::Scenario {
            what: "boundary.temperature_k",
            expected: "between 233 and 333 K throughout, 5 standard deviations included",
            found: 340.0,
        })
    );
}
