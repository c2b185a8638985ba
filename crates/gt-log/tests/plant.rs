//! The log of a simulated run.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use gt_core::Dataset;
use gt_log::{RunMetadata, Selection, info, read_dataset, write_run};
use gtfdi::plant::{
    ActuatorId, Channel, Fault, FaultCase, Intermittent, Mode, Run, Scenario, Shape, Step, Variant,
    simulate,
};
use tempfile::TempDir;

/// A log in a folder of its own.
struct Log(TempDir);

impl Log {
    fn of(run: &Run) -> Self {
        let folder = TempDir::new().unwrap();
        write_run(
            &folder.path().join("run.mcap"),
            run,
            &RunMetadata::default(),
        )
        .unwrap();
        Self(folder)
    }

    fn topic(&self, topic: &str) -> Dataset {
        let select = Selection {
            outputs: vec!["*".to_owned()],
            topic: Some(topic.to_owned()),
            ..Selection::default()
        };
        read_dataset(&self.0.path().join("run.mcap"), &select)
            .unwrap()
            .dataset
    }
}

fn short(variant: Variant, faults: Vec<Fault>) -> Scenario {
    Scenario {
        duration_s: 2.0,
        faults,
        ..Scenario::of(variant)
    }
}

fn step(size: f64) -> Shape {
    Shape::Step(Step { size })
}

#[test]
fn topics_hold_inputs_outputs_and_what_no_sensor_measures() {
    for (variant, nu, ny) in [(Variant::Prototype, 6, 28), (Variant::Cogeneration, 7, 31)] {
        let run = simulate(&short(variant, vec![])).unwrap();
        let log = Log::of(&run);
        let measured = log.topic("/plant/measured");
        let truth = log.topic("/plant/truth");
        assert_eq!((measured.ny(), truth.ny()), (nu + ny, nu + ny + 3));
        let signals = [run.truth.inputs(), run.truth.outputs(), &run.hidden_signals].concat();
        assert_eq!(truth.outputs(), signals);
        assert_eq!(measured.outputs(), &signals[..nu + ny]);
        assert_eq!(truth.y().rows(0, nu), *run.truth.u());
        assert_eq!(truth.y().rows(nu, ny), *run.truth.y());
        assert_eq!(truth.y().rows(nu + ny, 3), run.hidden);
        assert_eq!(measured.y().rows(nu, ny), *run.measured.y());
        let info = info(&log.0.path().join("run.mcap")).unwrap();
        assert_eq!(info.topics.len(), 3);
    }
}

/// Every mode of a sensor and an actuator and every case: magnitude and activity, under names of
/// their own.
#[test]
fn every_kind_of_fault_is_logged_with_a_name_of_its_own() {
    let modes = Mode::NAMES.iter().map(|name| name.parse::<Mode>().unwrap());
    let t3 = Channel::named("t3").unwrap();
    let size = |mode: Mode| step(if mode.is_switch() { 1.0 } else { 1e-3 });
    let mut faults: Vec<Fault> = FaultCase::ALL
        .map(|case| Fault::nominal(case, 0.8))
        .to_vec();
    for mode in modes.clone() {
        faults.push(Fault::sensor(t3, mode, 0.8, size(mode)));
        if mode != Mode::Dropout {
            faults.push(Fault::actuator(
                ActuatorId::GuideVanes,
                mode,
                0.8,
                size(mode),
            ));
        }
    }
    faults.push(Fault::actuator(
        ActuatorId::GuideVanes,
        Mode::Bias,
        0.8,
        step(1e-3),
    ));
    let run = simulate(&short(Variant::Cogeneration, faults.clone())).unwrap();
    let logged = Log::of(&run).topic("/plant/faults");
    assert_eq!(logged.ny(), 2 * faults.len());
    let mut names: Vec<&str> = logged.outputs().iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names[faults.len() - 1], "IGV_actuator_bias_2");
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 2 * faults.len());
    assert_eq!(logged.y().rows(0, faults.len()), run.fault_magnitudes);
    for (row, fault) in faults.iter().enumerate() {
        assert_eq!(logged.outputs()[row].unit, fault.unit());
        // At the onset itself a ramp is still zero.
        let first = if fault.case().is_some() { 11 } else { 10 };
        for k in 0..logged.len() {
            let active = f64::from(u8::from(k >= first));
            let found = logged.y()[(faults.len() + row, k)];
            assert_eq!(found.to_bits(), active.to_bits(), "{fault:?} {k}");
        }
    }
}

#[test]
fn activity_follows_intermittent_falling_and_ended_faults() {
    let t3 = Channel::named("t3").unwrap();
    let shape = Shape::Intermittent(Intermittent {
        size: -2.0,
        period_s: 0.4,
        on_s: 0.16,
    });
    let faults = vec![
        Fault::sensor(t3, Mode::Bias, 0.4, shape).until(1.6),
        Fault::growing(FaultCase::ThermocoupleDrift, 0.4, -360.0, None),
    ];
    let run = simulate(&short(Variant::Prototype, faults)).unwrap();
    let logged = Log::of(&run).topic("/plant/faults");
    for k in 0..logged.len() {
        let on = (5..20).contains(&k) && k % 5 < 2;
        let expected = [
            if on { -2.0 } else { 0.0 },
            f64::from(u8::from(on)),
            f64::from(u8::from(k > 5)),
        ];
        let found = [(0, k), (2, k), (3, k)].map(|place| logged.y()[place]);
        assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits), "{k}");
    }
}

#[test]
fn a_run_that_ended_says_so_in_its_log() {
    let fault = Fault::growing(FaultCase::TurbineDamage, 1.0, 36e3, Some(99.0));
    let scenario = Scenario {
        duration_s: 60.0,
        ..short(Variant::Prototype, vec![fault])
    };
    let run = simulate(&scenario).unwrap();
    let reason = run.ended.as_ref().unwrap().to_string();
    let log = Log::of(&run);
    assert_eq!(log.topic("/plant/measured").len(), run.truth.len());
    assert!(run.truth.len() < 750);
    let metadata = info(&log.0.path().join("run.mcap")).unwrap().metadata;
    let names: Vec<&str> = metadata.iter().map(|record| record.name.as_str()).collect();
    assert_eq!(names, ["gtfdi.run", "gtfdi.config", "gtfdi.remarks"]);
    let remarks = &metadata[2].values;
    assert_eq!(remarks["ended"], reason);
    assert_eq!(remarks.len(), 1 + run.warnings.len());
    for (index, warning) in run.warnings.iter().enumerate() {
        assert_eq!(
            remarks[&format!("warning_{}", index + 1)],
            warning.to_string()
        );
    }
}
