//! Scenarios that use all that a run can have.

use gt_plant::maps::{AnalyticCompressorMap, CompressorMap, MapKind, SpeedLineTable, Tables};
use gt_plant::{
    ActuatorId, Channel, Course, Disturbance, Exponential, Fault, FaultCase, Fluctuation,
    Intermittent, MapSet, Mode, Noise, NoiseLevel, PlantParameters, Profile, Ramp, Scenario, Shape,
    Sine, Step, Variant,
};

/// A run of 8 s.
pub fn plain(variant: Variant, run_index: u64) -> Scenario {
    Scenario {
        duration_s: 8.0,
        seed: 11,
        run_index,
        ..Scenario::of(variant)
    }
}

fn sensor(name: &str, mode: Mode, onset_s: f64, shape: Shape) -> Fault {
    Fault::sensor(Channel::named(name).unwrap(), mode, onset_s, shape)
}

fn step(size: f64) -> Shape {
    Shape::Step(Step { size })
}

fn ramp(rate_per_h: f64) -> Shape {
    let limit = None;
    Shape::Ramp(Ramp { rate_per_h, limit })
}

/// Faults of every kind that reaches the plant, and some of sensors.
fn faults(variant: Variant) -> Vec<Vec<Fault>> {
    let (fuel, valve) = (ActuatorId::Fuel, ActuatorId::Valve);
    let spikes = Mode::Spike {
        spikes_per_h: 9000.0,
    };
    let approach = Shape::Exponential(Exponential {
        size: 0.3,
        time_constant_s: 2.0,
    });
    let pulses = Shape::Intermittent(Intermittent {
        size: 1.0,
        period_s: 3.0,
        on_s: 1.0,
    });
    let mut faults = vec![
        vec![Fault::growing(
            FaultCase::CompressorFouling,
            2.0,
            1800.0,
            None,
        )],
        vec![Fault::growing(FaultCase::TurbineDamage, 0.0, 1800.0, Some(2.0)).until(6.0)],
        vec![Fault::growing(FaultCase::FuelActuatorLag, 1.0, 360.0, None)],
        vec![
            Fault::growing(FaultCase::ThermocoupleDrift, 1.0, 1800.0, None),
            sensor("p3", spikes, 0.0, step(5e4)),
            sensor("a_v", Mode::Lag, 2.0, step(0.5)),
            sensor("w_t", Mode::Dropout, 3.0, step(1.0)),
        ],
        vec![
            Fault::actuator(fuel, Mode::Gain, 1.0, approach),
            Fault::actuator(fuel, Mode::Noise, 2.0, step(2e-4)),
        ],
        vec![
            Fault::actuator(valve, Mode::Stuck, 1.0, pulses),
            Fault::actuator(valve, Mode::Drift, 0.0, ramp(360.0)),
        ],
        vec![Fault::actuator(fuel, spikes, 0.0, step(2e-3))],
        vec![
            Fault::actuator(valve, Mode::Lag, 1.0, approach),
            Fault::growing(FaultCase::TurbineDamage, 3.0, 900.0, None),
            Fault::growing(FaultCase::CompressorFouling, 3.0, 900.0, None),
        ],
    ];
    if variant == Variant::Cogeneration {
        let vanes = ActuatorId::GuideVanes;
        faults.push(vec![Fault::actuator(vanes, Mode::Bias, 1.0, step(2.0))]);
        faults.push(vec![Fault::actuator(vanes, Mode::Stuck, 2.0, step(1.0))]);
    }
    faults
}

/// What moves around the plant: boundary conditions and disturbances.
fn surroundings(scenario: Scenario) -> Scenario {
    let mut scenario = scenario;
    let random = |deviation| {
        Some(Fluctuation {
            deviation,
            time_constant_s: 5.0,
        })
    };
    scenario.boundary.temperature_k = Course {
        offset: 4.0,
        rate_per_h: 600.0,
        sine: Some(Sine {
            amplitude: 1.0,
            period_s: 3.0,
        }),
        random: random(0.3),
    };
    scenario.boundary.pressure_pa.offset = -800.0;
    scenario.boundary.heating_value_fraction.rate_per_h = 3.0;
    scenario.disturbance = Disturbance {
        heat_release_fraction: random(0.005),
        torque_n_m: random(10.0),
    };
    scenario
}

/// Runs of one plant: every kind of noise, fault and surroundings.
pub fn all(variant: Variant, map_set: MapSet) -> Vec<Scenario> {
    let mut scenarios: Vec<Scenario> = faults(variant)
        .into_iter()
        .zip(NoiseLevel::ALL.into_iter().cycle())
        .zip(0..)
        .map(|((faults, level), run_index)| Scenario {
            map_set,
            faults,
            noise: Noise::from(level),
            ..plain(variant, run_index)
        })
        .collect();
    scenarios.push(Scenario {
        map_set,
        noise: NoiseLevel::Table8.into(),
        ..surroundings(plain(variant, 20))
    });
    let mut shaken = surroundings(scenarios[1].clone());
    shaken.run_index = 21;
    scenarios.push(shaken);
    scenarios.push(Scenario {
        map_set,
        profile: Profile::named(variant, "steady").unwrap(),
        noise: NoiseLevel::Low.into(),
        ..plain(variant, 22)
    });
    scenarios
}

/// The analytic compressor map of a plant as a table.
fn table(map: &AnalyticCompressorMap) -> SpeedLineTable {
    let speeds: Vec<f64> = (0..9).map(|line| 0.9 + 0.025 * f64::from(line)).collect();
    let rise = |speed: f64| (map.design_pressure_ratio - 1.0) * speed.powf(map.pressure_exponent);
    let range = |speed| (1.0 + 0.6 * rise(speed), 1.0 + 1.25 * rise(speed));
    SpeedLineTable::from_function(MapKind::Compressor, &speeds, 15, range, |speed, ratio| {
        let [flow, efficiency] = map.evaluate(speed, ratio);
        (flow, efficiency)
    })
    .unwrap()
}

/// The same runs with a table in the place of the analytic compressor map.
pub fn tabulated(mut scenarios: Vec<Scenario>) -> Vec<Scenario> {
    for scenario in &mut scenarios {
        let parameters = PlantParameters::new(scenario.variant, scenario.map_set);
        let CompressorMap::Analytic(map) = parameters.compressor.map else {
            panic!("expected an analytic map");
        };
        scenario.maps = Tables {
            compressor: Some(table(&map)),
            turbine: None,
        };
    }
    scenarios
}
