//! From records to alarms that no error of a channel raises: `design --unknown`.

use std::sync::OnceLock;

use serde_json::Value;

use crate::place::{Place, array, number};
use crate::signal::{Noise, csv};

const SAMPLE_TIME_S: f64 = 0.1;
/// Readings are off from here on.
const ONSET_S: f64 = 100.0;
const TIME: [&str; 2] = ["--sample-time", "0.1"];

/// One tank with three sensors, all readings with noise: that of the inflow is off by `inflow`, that
/// of `b` by `level`.
fn record(seed: u64, rows: usize, inflow: f64, level: f64) -> String {
    let mut source = Noise::new(seed);
    let (mut demand, mut x) = (0.0, 0.0);
    let mut table = Vec::with_capacity(rows);
    for t in 0..rows {
        let off = if t as f64 * SAMPLE_TIME_S >= ONSET_S {
            1.0
        } else {
            0.0
        };
        demand = 0.97 * demand + source.next();
        let mut measured = |value: f64| value + 0.1 * source.next();
        table.push(vec![
            measured(demand + off * inflow),
            measured(x),
            measured(0.5 * x + off * level),
            measured(-0.8 * x),
        ]);
        x = 0.95 * x + 0.05 * demand;
    }
    csv("u,a,b,c", &table)
}

/// Records and a model with its noise, which tests that look at what changes do not share.
fn place() -> &'static Place {
    static PLACE: OnceLock<Place> = OnceLock::new();
    PLACE.get_or_init(fresh)
}

fn fresh() -> Place {
    let place = Place::new();
    for (name, rows, seed, inflow, level) in [
        ("train.csv", 4000, 1, 0.0, 0.0),
        ("calm.csv", 20_000, 2, 0.0, 0.0),
        ("inflow.csv", 3000, 3, 8.0, 0.0),
        ("level.csv", 3000, 3, 0.0, 0.5),
    ] {
        place.write(name, record(seed, rows, inflow, level));
    }
    let channels = ["--inputs", "u", "--outputs", "a,b,c"];
    let method = ["--method", "eiv", "--order", "1", "--nk", "1"];
    let files = ["identify", "train.csv", "--out", "model.json"];
    place.done(&[&files[..], &TIME, &channels, &method].concat());
    place
}

fn args<'a>(tail: &[&'a str], out: &'a str) -> Vec<&'a str> {
    let head = ["design", "--model", "model.json", "--healthy", "calm.csv"];
    let rest = ["--generator", "kalman", "--arl0", "1h", "--out", out];
    [&head[..], &TIME, &rest, tail].concat()
}

fn alarms(bank: &str, record: &str) -> Vec<Value> {
    let head = ["detect", "--bank", bank, record];
    array(&place().json(&[&head[..], &TIME].concat()), "/alarms").to_vec()
}

/// A reading of the inflow that is off by eighty times its noise alarms the filters that
/// read it and not the one that does without; a level that is off alarms both. An hour between
/// false alarms is asked for, and each record has five minutes.
#[test]
fn what_an_unknown_input_does_raises_no_alarm() {
    let all = place().json(&args(
        &["--statistic", "chi2", "--watch", "joint"],
        "all.json",
    ));
    let without = place().json(&args(
        &["--statistic", "chi2", "--unknown", "u"],
        "without.json",
    ));
    assert_eq!(array(&all, "/detectors").len(), 1);
    assert_eq!(array(&all, "/unknown"), [""; 0]);
    assert_eq!(array(&without, "/unknown"), ["u"]);
    let [detector] = array(&without, "/detectors") else {
        panic!("{without}");
    };
    // Three levels less one for the inflow, all tested together.
    assert_eq!(array(detector, "/outputs").len(), 2, "{detector}");
    assert_eq!(detector["output"], "joint");

    for (bank, record, alarmed) in [
        ("all.json", "inflow.csv", true),
        ("without.json", "inflow.csv", false),
        ("all.json", "level.csv", true),
        ("without.json", "level.csv", true),
    ] {
        let found = alarms(bank, record);
        assert_eq!(!found.is_empty(), alarmed, "{bank}, {record}: {found:?}");
        for alarm in &found {
            assert!(number(alarm, "/time_s") >= ONSET_S, "{bank}: {alarm}");
        }
    }
}

/// Where one residual is left it is tested by itself, by any statistic.
#[test]
fn one_residual_that_is_left_takes_any_statistic() {
    let tail = ["--statistic", "cusum", "--unknown", "u,c"];
    let report = place().json(&args(&tail, "one.json"));
    let [detector] = array(&report, "/detectors") else {
        panic!("{report}");
    };
    let outputs = array(detector, "/outputs");
    assert!(
        outputs.len() == 1 && (outputs[0] == "a" || outputs[0] == "b"),
        "{detector}"
    );
    assert_eq!(detector["output"], outputs[0]);
    assert_eq!(alarms("one.json", "inflow.csv"), Vec::<Value>::new());
    assert!(!alarms("one.json", "level.csv").is_empty());
}

/// None, as a configuration file says it, is as if nothing were said.
#[test]
fn no_unknown_channel_of_a_configuration_file_is_none_at_all() {
    let place = place();
    place.write("none.toml", "[design]\nunknown = []\n");
    let tail = ["--statistic", "chi2", "--watch", "joint"];
    place.done(&args(&tail, "plain.json"));
    place.done(&[&args(&tail, "empty.json")[..], &["--config", "none.toml"]].concat());
    let bank = |name: &str| std::fs::read(place.path(name)).unwrap();
    assert_eq!(bank("plain.json"), bank("empty.json"));
}

#[test]
fn refusals_name_the_option_and_what_it_takes() {
    let place = fresh();
    let channels = ["--inputs", "u", "--outputs", "a,b,c"];
    let files = ["identify", "train.csv", "--out", "arx.json"];
    let orders = ["--na", "1", "--nb", "1"];
    place.done(&[&files[..], &TIME, &channels, &orders].concat());
    let kalman = |model: &'static str, tail: &[&'static str]| {
        let head = ["design", "--model", model, "--healthy", "calm.csv"];
        let rest = ["--generator", "kalman", "--out", "refused.json"];
        [&head[..], &TIME, &rest, tail].concat()
    };
    for (args, expected) in [
        (
            kalman("model.json", &["--unknown", "v"]),
            "--unknown: expected a channel of model.json (u, a, b, c), found `v`",
        ),
        (
            kalman("arx.json", &["--unknown", "u"]),
            "arx.json: --unknown: expected an errors-in-variables model, whose noise says what is \
             left without the channels (identify --method eiv or frisch), found an ARX model",
        ),
        (
            kalman("model.json", &["--unknown", "u,a,b"]),
            "outputs: expected more than the 1 independent disturbances, found 1",
        ),
        (
            kalman("model.json", &["--unknown", "a,b,c"]),
            "outputs: expected more than the 0 independent disturbances, found 0",
        ),
        (
            kalman("model.json", &["--unknown", "u", "--statistic", "cusum"]),
            "found one of a residual with a sign",
        ),
        (
            kalman("model.json", &["--unknown", "u", "--faults", "faults.toml"]),
            "--unknown: expected without --faults",
        ),
    ] {
        place.refused(&args, &[expected]);
        assert!(!place.path("refused.json").exists());
    }
    let observer = ["design", "--model", "model.json", "--healthy", "calm.csv"];
    let tail = ["--unknown", "u", "--out", "refused.json"];
    let expected = "--unknown: expected with --generator kalman, found observer";
    place.refused(&[&observer[..], &TIME, &tail].concat(), &[expected]);
}
