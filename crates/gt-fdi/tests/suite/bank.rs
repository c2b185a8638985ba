//! The bank: checks, batch run against online steps, alarm records, files.

use gt_core::{Dataset, OperatingPoint, Signal, StateSpace};
use gt_fdi::FdiError;
use gt_fdi::design::{
    Alarm, Bank, ResidualGenerator, ResidualTest, SCHEMA_VERSION, ThresholdRule, calibrate,
};
use gt_fdi::runtime::Detector;
use nalgebra::DMatrix;

use crate::fixtures::{TS, bank, bank_of, limit_on, noise, plain_generator, plain_model, record};

fn bits(matrix: &DMatrix<f64>) -> Vec<u64> {
    matrix.iter().map(|value| value.to_bits()).collect()
}

/// A generator without states: the residual is the output itself.
fn output_itself(output: &str, inputs: &[&str], sample_time_s: f64) -> ResidualGenerator {
    let nu = inputs.len();
    let model = StateSpace::new(
        [
            DMatrix::zeros(0, 0),
            DMatrix::zeros(0, nu),
            DMatrix::zeros(1, 0),
            DMatrix::zeros(1, nu),
        ],
        sample_time_s,
        Signal::named(inputs),
        Signal::named(&[output]),
    );
    ResidualGenerator::observer(model.unwrap(), OperatingPoint::zero(nu, 1), &[]).unwrap()
}

/// A threshold at 1 after `consecutive` samples.
fn at_one(generator: ResidualGenerator, consecutive: usize) -> (ResidualGenerator, ResidualTest) {
    let rule = ThresholdRule::Margin {
        factor: 1.0,
        consecutive,
    };
    let calibration = calibrate(&[&[1.0; 20]], generator.sample_time_s(), rule).unwrap();
    let test = ResidualTest::modulus(&generator, &calibration);
    (generator, test)
}

#[test]
fn channels_are_the_union_of_the_generators() {
    let detectors = vec![
        at_one(output_itself("a", &["v", "w"], TS), 1),
        at_one(output_itself("b", &["x", "v", "a"], TS), 1),
    ];
    let bank = bank_of("union", detectors).unwrap();
    // `a` is read among the outputs.
    assert_eq!(bank.inputs(), ["v", "w", "x"]);
    assert_eq!(bank.outputs(), ["a", "b"]);
    assert_eq!(bank.tests()[1].name, "b");
    assert_eq!(bank.test_names(), ["a", "b"]);
}

/// The batch run is the online detector: the same bits, and those of each generator alone.
#[test]
fn batch_and_online_agree_bit_for_bit() {
    let (bank, data) = (bank(), record(20));
    let run = bank.run(&data).unwrap();
    let ordered = data.select(&bank.inputs(), &bank.outputs()).unwrap();
    let mut detector = Detector::new(&bank);
    let mut online = DMatrix::zeros(2, data.len());
    let mut raised = Vec::new();
    for k in 0..data.len() {
        let (u, y) = (ordered.u().column(k), ordered.y().column(k));
        let verdict = detector
            .step(data.time_s(k), u.as_slice(), y.as_slice())
            .unwrap();
        for (row, channel) in verdict.channels.iter().enumerate() {
            online[(row, k)] = channel.residual;
            if channel.new_alarm {
                raised.push((verdict.time_s, bank.outputs()[row].clone()));
            }
        }
    }
    assert_eq!(bits(&run.residuals), bits(&online));
    let alarms: Vec<(f64, String)> = run
        .alarms
        .iter()
        .map(|alarm| (alarm.time_s, alarm.tag.clone()))
        .collect();
    assert_eq!(alarms, raised);
    assert!(!alarms.is_empty(), "the record should raise alarms");
    for (row, generator) in bank.generators().iter().enumerate() {
        let alone = generator.residuals(&data).unwrap();
        assert_eq!(bits(&run.residuals.rows(row, 1).into_owned()), bits(&alone));
    }
}

/// The first alarm of the biased sensor comes up on the second sample of its fault, with the first
/// as the onset; nothing came before it.
#[test]
fn a_bias_is_found_on_its_own_output() {
    let (bank, data) = (bank(), record(20));
    let run = bank.run(&data).unwrap();
    let first = run.alarms.iter().find(|alarm| alarm.tag == "q").unwrap();
    assert_eq!(first.first_exceedance_s, data.time_s(300));
    assert_eq!(first.time_s, data.time_s(301));
    assert!(first.residual.abs() > first.threshold);
    assert_eq!(first.threshold, bank.tests()[1].threshold.limit);
}

/// By hand, limit 1, two samples in a row: above at samples 1, 2 (alarm), 4 (too short), 6, 7
/// (alarm) and 8, ended by a missing sample, and 10, 11 (alarm) until the end.
#[test]
fn alarm_records_by_hand() {
    let nan = f64::NAN;
    let y = [
        0.0, 2.0, -3.0, 1.0, 4.0, 0.0, -2.0, -2.5, 9.0, nan, 2.0, 3.0,
    ];
    let data = Dataset::new(
        vec![],
        Signal::named(&["a"]),
        DMatrix::zeros(0, 12),
        DMatrix::from_row_slice(1, 12, &y),
        1.0,
    )
    .unwrap()
    .starting_at(100.0);
    let bank = bank_of("hand", vec![at_one(output_itself("a", &[], 1.0), 2)]).unwrap();
    let run = bank.run(&data).unwrap();
    let alarm = |time_s, first_exceedance_s, residual: f64, end_s| Alarm {
        time_s,
        first_exceedance_s,
        onset_s: None,
        tag: "a".to_owned(),
        residual,
        statistic: residual.abs(),
        threshold: 1.0,
        deviation: None,
        end_s,
    };
    let expected = [
        alarm(102.0, 101.0, -3.0, Some(103.0)),
        alarm(107.0, 106.0, -2.5, Some(109.0)),
        alarm(111.0, 110.0, 3.0, None),
    ];
    assert_eq!(run.alarms, expected);
    assert_eq!(run.share_above_limit, [8.0 / 11.0]);
    assert_eq!(run.outputs, ["a"]);
    assert_eq!((run.time_s[0], run.time_s[11]), (100.0, 111.0));
}

#[test]
fn files_detect_bit_for_bit_alike() {
    let bank = bank();
    let json = serde_json::to_string(&bank).unwrap();
    let back: Bank = serde_json::from_str(&json).unwrap();
    assert_eq!(back, bank);
    let (one, two) = (
        bank.run(&record(20)).unwrap(),
        back.run(&record(20)).unwrap(),
    );
    assert_eq!(bits(&one.residuals), bits(&two.residuals));
    assert_eq!(one.alarms, two.alarms);
    assert_eq!(bank.schema_version, SCHEMA_VERSION);
}

#[test]
fn files_are_checked() {
    let json = serde_json::to_value(bank()).unwrap();
    let error = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut changed = json.clone();
        change(&mut changed);
        serde_json::from_value::<Bank>(changed)
            .unwrap_err()
            .to_string()
    };
    let version = error(&|v| v["schema_version"] = 3.into());
    assert_eq!(version, "bank: expected schema_version 2, found 3");
    // The keys of version 1: it is the version that is told.
    let old = serde_json::json!({
        "schema_version": 1, "name": "old", "sample_time_s": TS, "detectors": []
    });
    let old = serde_json::from_value::<Bank>(old).unwrap_err().to_string();
    assert_eq!(old, "bank: expected schema_version 2, found 1");
    let limit = error(&|v| v["tests"][0]["threshold"]["limit"] = (-1.0).into());
    assert_eq!(
        limit,
        "threshold limit: expected a finite number not below 0, found -1"
    );
    let consecutive = error(&|v| v["tests"][0]["threshold"]["consecutive"] = 0.into());
    assert_eq!(
        consecutive,
        "option `consecutive`: expected at least 1 sample, found 0"
    );
    let time = error(&|v| v["sample_time_s"] = 0.1.into());
    assert_eq!(
        time,
        "sample time of the bank: expected 0.08 s, found 0.1 s"
    );
    let twice = error(&|v| v["generators"][1] = v["generators"][0].clone());
    assert_eq!(
        twice,
        "outputs of the bank: expected unique tags, found `p` twice"
    );
    let twice = error(&|v| v["tests"][1] = v["tests"][0].clone());
    assert_eq!(
        twice,
        "tests of the bank: expected unique tags, found `p` twice"
    );
    let none = error(&|v| v["tests"] = serde_json::json!([]));
    assert_eq!(
        none,
        "bank `test`: expected at least one generator and one test, found none"
    );
    let absent = error(&|v| v["tests"][1]["outputs"] = serde_json::json!(["z"]));
    assert!(absent.contains("expected the channels z"), "{absent}");
    let two = error(&|v| v["tests"][1]["outputs"] = serde_json::json!(["p", "q"]));
    assert_eq!(two, "outputs of the test `q`: expected 1, found 2");
    let unknown = error(&|v| v["colour"] = 1.into());
    assert!(unknown.starts_with("unknown field `colour`"), "{unknown}");
}

#[test]
fn detectors_at_different_sample_times_are_refused() {
    let detectors = vec![
        at_one(output_itself("a", &[], TS), 1),
        at_one(output_itself("b", &[], 0.1), 1),
    ];
    let what = "the generator of `b`".to_owned();
    let expected = FdiError::SampleTime {
        what,
        expected_s: TS,
        found_s: 0.1,
    };
    assert_eq!(bank_of("mixed", detectors), Err(expected));
}

#[test]
fn a_record_without_the_banks_tags_is_refused_with_all_of_them() {
    let data = record(1).select(&["u1"], &["q"]).unwrap();
    let expected = FdiError::MissingTags {
        missing: vec!["u0".to_owned(), "p".to_owned()],
        available: vec!["u1".to_owned(), "q".to_owned()],
    };
    assert_eq!(bank().run(&data), Err(expected));
}

/// A record whose clock has no room for its sample time cannot be run: 1e17 s plus 0.08 s is 1e17.
#[test]
fn a_clock_that_stands_still_is_refused() {
    let error = bank().run(&record(1).starting_at(1e17)).unwrap_err();
    assert!(matches!(error, FdiError::Step(_)), "{error}");
}

#[test]
fn calibration_on_records_cuts_the_settling() {
    let generator = plain_generator("p");
    let settle = generator.settle_samples();
    let healthy = [record(40), record(50)];
    let rule = ThresholdRule::Margin {
        factor: 1.0,
        consecutive: 1,
    };
    let test = limit_on(&generator, &healthy, rule).unwrap();
    let residuals = healthy
        .each_ref()
        .map(|data| generator.residuals(data).unwrap());
    let largest = residuals
        .iter()
        .map(|r| r.columns(settle, 600 - settle).amax())
        .fold(0.0, f64::max);
    assert_eq!(test.threshold.limit, largest);
    let hours = 2.0 * (600 - settle) as f64 * TS / 3600.0;
    assert!((test.false_alarms.in_sample.hours - hours).abs() < 1e-15);

    let short = record(1).rows(0..settle).unwrap();
    let error = limit_on(&generator, &[short], rule);
    let expected = FdiError::HealthySamples {
        record: 0,
        needed: settle + 1,
        found: settle,
    };
    assert_eq!(error, Err(expected));
    let error = limit_on(&generator, &[], rule);
    assert_eq!(error, Err(FdiError::NoHealthyData));
}

/// The false-alarm rate that calibration counts is that which the bank then shows on the same
/// healthy record.
#[test]
fn counted_false_alarms_are_those_of_the_run() {
    let u = DMatrix::from_vec(2, 20_000, noise(61, 40_000));
    let y = DMatrix::from_vec(1, 20_000, noise(62, 20_000));
    let (inputs, outputs) = (Signal::named(&["u0", "u1"]), Signal::named(&["p"]));
    let data = Dataset::new(inputs, outputs, u, y, TS).unwrap();
    let point = OperatingPoint::zero(2, 1);
    let generator = ResidualGenerator::observer(plain_model("p"), point, &[0.4, 0.4]).unwrap();
    let rule = ThresholdRule::Exceedance {
        share: 0.05,
        consecutive: 2,
    };
    let test = limit_on(&generator, std::slice::from_ref(&data), rule).unwrap();
    let counted = test.false_alarms.in_sample.alarms;
    let run = bank_of("one", vec![(generator, test)])
        .unwrap()
        .run(&data)
        .unwrap();
    assert_eq!(run.alarms.len(), counted);
    assert!(counted > 20, "{counted}");
    // At most 5 % of the judged samples, and less than one sample short of it.
    assert!(run.share_above_limit[0] <= 0.05 && run.share_above_limit[0] > 0.0499);
}
