//! Faults as text, and which are refused.

use gt_plant::{
    ActuatorId, Channel, Exponential, Fault, FaultCase, Intermittent, Mode, Ramp, Scenario, Shape,
    Target, Variant,
};
use proptest::prelude::*;

use super::{channel, scenario, step};

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

#[test]
fn a_fault_is_asked_before_it_is_checked() {
    for limit in [f64::NAN, -1.0] {
        let fault = Fault::growing(FaultCase::ThermocoupleDrift, 0.0, 5.0, Some(limit));
        let _ = fault.magnitude(10.0);
        assert!(fault.validate().is_err());
    }
}
