//! The whole road through the facade: turbine -> record -> ARX -> state space -> observer -> bank
//! -> online detector.

#![allow(clippy::expect_used, reason = "helpers of tests")]

use std::sync::OnceLock;
use std::thread;

use gtfdi::core::Dataset;
use gtfdi::fdi::{Bank, Detector, ResidualGenerator, ResidualTest, StatisticKind, ThresholdRule};
use gtfdi::ident::{Arx, ArxModel, ArxStructure, validate};
use gtfdi::plant::{Fault, FaultCase, NoiseLevel, Profile, Run, Scenario, Variant, simulate};
use nalgebra::{DMatrix, DVector};

const INPUTS: [&str; 2] = ["a_v", "M_f"];
/// The monitored outputs and the poles of their observers (sections 5.3 to 5.6 of the paper).
const MONITORED: [(&str, f64); 4] = [("q_c", 0.7), ("t3", 0.3), ("p7", 0.4), ("m9", 0.4)];

/// A run of ten minutes on the `standard` profile, without noise.
fn standard(run_index: u64, faults: Vec<Fault>) -> Dataset {
    let scenario = Scenario {
        profile: Profile::named(Variant::Prototype, "standard").expect("a profile"),
        run_index,
        faults,
        ..Scenario::default()
    };
    simulate(&scenario).expect("a run").measured
}

/// The record that all models here are fitted to.
fn training() -> &'static Dataset {
    static RECORD: OnceLock<Dataset> = OnceLock::new();
    RECORD.get_or_init(|| standard(0, vec![]))
}

/// A healthy record that no model saw.
fn fresh() -> &'static Dataset {
    static RECORD: OnceLock<Dataset> = OnceLock::new();
    RECORD.get_or_init(|| standard(1, vec![]))
}

/// The inputs of all models and one output.
fn one(data: &Dataset, tag: &str) -> Dataset {
    data.select(&INPUTS, &[tag]).expect("the channels")
}

/// The paper's model of an output: order 8; the demanded fuel acts within the sample.
fn model(tag: &str) -> ArxModel {
    let (na, nb, nk) = (8, vec![8, 9], vec![1, 0]);
    let arx = Arx::new(ArxStructure::Diagonal { na, nb, nk });
    arx.fit(&one(training(), tag)).expect("a fit")
}

fn observer(tag: &str, pole: f64) -> ResidualGenerator {
    let part = model(tag).output_model(0).expect("a realisation");
    let poles = vec![pole; part.model.nx()];
    ResidualGenerator::observer(part.model, part.point, &poles).expect("an observer")
}

/// The four observers, limits at twice the largest healthy residual.
fn bank() -> Bank {
    let parts = MONITORED.map(|(tag, pole)| {
        let rule = ThresholdRule::Margin {
            factor: 2.0,
            consecutive: 1,
        };
        let healthy = [one(training(), tag), one(fresh(), tag)];
        let (generator, statistic) = (observer(tag, pole), StatisticKind::Modulus);
        let test = ResidualTest::calibrate(tag, &[&generator], &healthy, statistic, rule);
        (generator, test.expect("a limit"))
    });
    let (generators, tests) = parts.into_iter().unzip();
    Bank::new("road", generators, tests).expect("a bank")
}

/// The record after `quiet` samples at the model's operating point: the past that an observer
/// assumes when it starts from the state 0.
fn after_rest(data: &Dataset, model: &ArxModel, quiet: usize) -> Dataset {
    let point = model.operating_point();
    let led = |values: &DVector<f64>, matrix: &DMatrix<f64>| {
        DMatrix::from_fn(matrix.nrows(), quiet + matrix.ncols(), |row, k| {
            if k < quiet {
                values[row]
            } else {
                matrix[(row, k - quiet)]
            }
        })
    };
    let (u, y) = (led(&point.u, data.u()), led(&point.y, data.y()));
    let (inputs, outputs) = (data.inputs().to_vec(), data.outputs().to_vec());
    Dataset::new(inputs, outputs, u, y, data.sample_time_s()).expect("a record")
}

/// `r = eps / P(z^-1)`: the residual of the placed observer is the equation error of the ARX
/// model, filtered by the poles, whatever the realisation does in between.
#[test]
fn residual_is_the_equation_error_filtered_by_the_poles() {
    // The residual is a difference of outputs up to 1e5 times larger: 1e-16 times that, and some
    // tens of roundings a sample.
    const TOLERANCE: f64 = 1e-9;
    for (tag, pole) in MONITORED {
        let model = model(tag);
        let data = after_rest(&one(fresh(), tag), &model, model.max_lag());
        let eps = model.equation_error(&data).expect("an equation error");
        // P(z^-1) = (1 - p z^-1)^8 as eight filters of first order.
        let mut filtered: Vec<f64> = eps
            .iter()
            .map(|e| if e.is_nan() { 0.0 } else { *e })
            .collect();
        for _ in 0..8 {
            for k in 1..filtered.len() {
                filtered[k] += pole * filtered[k - 1];
            }
        }
        let expected = DVector::from_vec(filtered);
        let generator = observer(tag, pole);
        let residual = generator
            .residuals(&data)
            .expect("a residual")
            .row(0)
            .transpose();
        // The step from rest to the record may make the largest residual: once that is forgotten, the
        // others are judged by their own size.
        let settled = generator.settle_samples() + model.max_lag();
        for from in [0, settled] {
            let rows = data.len() - from;
            let (found, expected) = (residual.rows(from, rows), expected.rows(from, rows));
            let error = (found - expected).amax() / expected.amax();
            assert!(error < TOLERANCE, "{tag} from {from}: {error:e}");
        }
    }
}

/// Table 6, third column: free-run error on a validation record, over the output's variance.
#[test]
fn published_table6_bounds_hold_in_free_run() {
    const TABLE6_VALIDATION: [(&str, [f64; 2]); 4] = [
        ("q_c", [0.07, 0.1]),
        ("t3", [0.09, 0.1]),
        ("p7", [0.04, 0.01]),
        ("m9", [0.05, 0.01]),
    ];
    let second = standard(2, vec![]);
    for (tag, bounds) in TABLE6_VALIDATION {
        let model = model(tag);
        for (data, bound) in [fresh(), &second].into_iter().zip(bounds) {
            let validation = validate(&model, &one(data, tag)).expect("a validation");
            let sse = validation.outputs[0]
                .sse_simulation
                .expect("a stable model");
            assert!(sse <= bound, "{tag}: {sse} above the printed {bound}");
        }
    }
}

/// The drift touches the reading of t3 only, and no other observer reads t3.
#[test]
fn thermocouple_drift_lights_only_t3() {
    let onset_s = 60.0;
    let drift = Fault::nominal(FaultCase::ThermocoupleDrift, onset_s);
    let tags = MONITORED.map(|(tag, _)| tag);
    let data = standard(3, vec![drift])
        .select(&INPUTS, &tags)
        .expect("the channels");
    let bank = bank();
    let mut detector = Detector::new(&bank);
    let mut alarms: Vec<(f64, &str)> = Vec::new();
    for k in 0..data.len() {
        let (u, y) = (data.u().column(k), data.y().column(k));
        let verdict = detector
            .step(data.time_s(k), u.as_slice(), y.as_slice())
            .expect("a sample");
        for (channel, tag) in verdict.channels.iter().zip(tags) {
            if channel.new_alarm {
                alarms.push((verdict.time_s, tag));
            }
        }
    }
    assert!(!alarms.is_empty(), "the drift was not seen");
    assert!(alarms.iter().all(|(_, tag)| *tag == "t3"), "{alarms:?}");
    assert!(
        alarms.iter().all(|(time_s, _)| *time_s > onset_s),
        "{alarms:?}"
    );
}

/// The detector, fed sample by sample, and the batch generators say the same, bit for bit.
#[test]
fn online_and_batch_residuals_are_the_same_bits() {
    let bank = bank();
    let tags = MONITORED.map(|(tag, _)| tag);
    let data = fresh().select(&INPUTS, &tags).expect("the channels");
    let run = bank.run(&data).expect("a run");
    for (row, generator) in bank.generators().iter().enumerate() {
        let batch = generator.residuals(&data).expect("residuals");
        let online = run.residuals.row(row);
        let same = batch
            .iter()
            .zip(online.iter())
            .all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(same, "{}", generator.outputs()[0].name);
    }
}

/// A run is a function of its scenario: two threads give the bits of one.
#[test]
fn threads_do_not_change_a_bit() {
    let scenario = |run_index| Scenario {
        duration_s: 40.0,
        noise: NoiseLevel::Table8.into(),
        faults: vec![Fault::nominal(FaultCase::TurbineDamage, 10.0)],
        seed: 7,
        run_index,
        ..Scenario::default()
    };
    let runs = |indices: std::ops::Range<u64>| -> Vec<Run> {
        indices
            .map(|index| simulate(&scenario(index)).expect("a run"))
            .collect()
    };
    let alone = runs(0..4);
    let (first, second) = thread::scope(|scope| {
        let late = scope.spawn(|| runs(2..4));
        let early = scope.spawn(|| runs(0..2));
        (
            early.join().expect("a thread"),
            late.join().expect("a thread"),
        )
    });
    let bits = |run: &Run| -> Vec<u64> {
        let records = [
            run.measured.u(),
            run.measured.y(),
            run.truth.u(),
            run.truth.y(),
        ];
        records
            .iter()
            .flat_map(|matrix| matrix.iter().map(|value| value.to_bits()))
            .collect()
    };
    for (index, (single, threaded)) in alone.iter().zip(first.iter().chain(&second)).enumerate() {
        assert_eq!(bits(single), bits(threaded), "run {index}");
    }
    assert_ne!(
        bits(&alone[0]),
        bits(&alone[1]),
        "runs of two indices are not the same run"
    );
}

/// Eq. 13 to 21 on an identified model of all four outputs: the canonical state-space model, from
/// the state 0, answers like the input-output form.
#[test]
fn canonical_realisation_answers_like_the_arx_model() {
    // Two recursions of the same poles in double precision, all inside the unit circle.
    const TOLERANCE: f64 = 1e-9;
    let tags = MONITORED.map(|(tag, _)| tag);
    let data = training().select(&INPUTS, &tags).expect("the channels");
    let structure = ArxStructure::Canonical {
        indices: vec![2; 4],
        feedthrough: true,
    };
    let model = Arx::new(structure).fit(&data).expect("a fit");
    let form = model.canonical_form().expect("a canonical form");
    assert_eq!(
        (form.indices(), form.order(), form.feedthrough()),
        (&[2; 4][..], 8, true)
    );
    let names = (data.inputs().to_vec(), data.outputs().to_vec());
    let realised = form
        .to_state_space(data.sample_time_s(), names.0, names.1)
        .expect("a realisation");
    let radius = realised.spectral_radius().expect("poles");
    assert!(radius < 1.0, "{radius}");

    let rested = after_rest(&data, &model, model.max_lag());
    let free_run = model.simulate(&rested).expect("a free run");
    assert_eq!(free_run.diverges_at, vec![None; 4]);
    let deviations = rested
        .relative_to(model.operating_point())
        .expect("the sizes");
    let answer = realised
        .simulate(&DVector::zeros(8), deviations.u())
        .expect("the sizes");
    for (row, tag) in tags.iter().enumerate() {
        let expected = free_run
            .y
            .row(row)
            .add_scalar(-model.operating_point().y[row]);
        let error = (answer.row(row) - &expected).amax() / expected.amax();
        assert!(error < TOLERANCE, "{tag}: {error:e}");
    }
}
