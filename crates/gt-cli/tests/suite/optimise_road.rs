//! `gtfdi design --faulty`: poles by pairs of records without and with a fault.

use std::sync::OnceLock;

use serde_json::{Value, json};

use crate::place::{Place, array, number};

const RADIUS: f64 = 0.95;
/// Without the bank's file: the tests share a folder, and each has its own.
const DESIGN: [&str; 7] = [
    "design",
    "--model",
    "model.json",
    "--healthy",
    "h1.mcap,h2.mcap",
    "--radius",
    "0.95",
];

/// Two runs of a minute, each without and with a drift of t3, another healthy one that the model is
/// of, and the model of order 2.
fn place() -> &'static Place {
    static PLACE: OnceLock<Place> = OnceLock::new();
    PLACE.get_or_init(furnished)
}

/// A folder of its own: nobody else writes while a refusal is checked.
fn furnished() -> Place {
    let place = Place::new();
    let fault = "[[fault]]\ncase = \"thermocouple_drift\"\nrate_percent_per_h = 20.0\n";
    place.write("drift.toml", format!("{fault}onset_s = 20.0\n"));
    let drift = ["--faults", "drift.toml"];
    for (out, seed, faults) in [
        ("train.mcap", "1", &[][..]),
        ("h1.mcap", "2", &[]),
        ("f1.mcap", "2", &drift),
        ("h2.mcap", "3", &[]),
        ("f2.mcap", "3", &drift),
    ] {
        let args = ["simulate", "--seconds", "60", "--out", out, "--seed", seed];
        place.done(&[&args[..], faults].concat());
    }
    let identify = ["identify", "train.mcap", "--inputs", "a_v,M_f"];
    let model = ["--outputs", "t3", "--order", "2", "--out", "model.json"];
    place.done(&[&identify[..], &model].concat());
    place
}

fn optimisation(report: &Value) -> &Value {
    assert_eq!(array(report, "/outputs").len(), 1);
    assert_eq!(report["outputs"][0]["name"], "t3");
    &report["outputs"][0]["optimisation"]
}

#[test]
fn poles_are_chosen_by_pairs_and_judged_by_others() {
    let place = place();
    let design = [&DESIGN[..], &["--out", "bank.json"]].concat();
    let pairs = ["--faulty", "f1.mcap", "--validate-faulty", "f2.mcap"];
    let args = [&design[..], &pairs].concat();
    let report = place.json(&args);
    assert_eq!(report["warnings"], json!([]));
    let found = optimisation(&report);
    assert_eq!(found["criterion"], "fault_energy");
    assert_eq!(found["radius"], RADIUS);
    let (v, bound) = (number(found, "/v"), number(found, "/bound"));
    assert!(0.0 < bound && bound <= v, "{found}");
    let held_out = number(found, "/v_validation");
    assert!(held_out > 0.0 && number(found, "/bound_validation") > 0.0);
    assert!(number(found, "/evaluations") > 0.0);
    assert!(found["start"]["kind"].is_string(), "{found}");
    let poles = array(found, "/poles");
    assert_eq!(poles.len(), 2);
    for pole in poles {
        let modulus = number(pole, "/0").hypot(number(pole, "/1"));
        // The cap is one on coefficients: a double pole is known to the root of their rounding.
        assert!(modulus <= RADIUS + 1e-7, "{found}");
    }
    // The bank has these poles, and its limits are those of all healthy records.
    assert_eq!(report["healthy_records"], 2);
    let detector = &report["detectors"][0];
    let real: Vec<f64> = poles.iter().map(|pole| number(pole, "/0")).collect();
    if poles.iter().all(|pole| pole[1] == 0.0) {
        assert_eq!(detector["poles"], json!(real));
        assert_eq!(detector["complex_poles"], json!([]));
    } else {
        assert_eq!(detector["poles"], json!([]));
        assert_eq!(&detector["complex_poles"], &found["poles"]);
    }
    let verdicts = place.json(&["detect", "f2.mcap", "--bank", "bank.json"]);
    assert!(!array(&verdicts, "/alarms").is_empty());
    // Again the same, and in words.
    assert_eq!(place.json(&args), report);
    let text = place.done(&args);
    assert!(
        text.contains("\npoles of least V' (fault-energy)"),
        "{text}"
    );
    // The validation pairs have no part in the choice.
    let alone = place.json(&[&design[..], &["--faulty", "f1.mcap"]].concat());
    let alone = optimisation(&alone);
    assert_eq!(alone["poles"], found["poles"]);
    assert!(alone["v_validation"].is_null() && alone["bound_validation"].is_null());
    // V of two pairs lies between those of each, and poles chosen by both do no worse.
    let both = place.json(&[&design[..], &["--faulty", "f1.mcap,f2.mcap"]].concat());
    let both = number(optimisation(&both), "/v");
    assert!(both <= v.max(held_out) * (1.0 + 1e-9), "{both}");
}

#[test]
fn the_search_has_options() {
    let place = place();
    let design = |tail: &[&str]| {
        let pair = ["--faulty", "f1.mcap", "--out", "options.json"];
        let report = place.json(&[&DESIGN[..], &pair, tail].concat());
        optimisation(&report).clone()
    };
    let default = design(&[]);
    let explicit = ["--criterion", "fault-energy", "--search", "descent"];
    assert_eq!(design(&explicit), default);
    let evolution = design(&["--search", "evolution", "--search-seed", "3"]);
    assert_eq!(evolution["start"], json!({"kind": "evolution"}));
    // Two ways to the same minimum.
    let (one, other) = (number(&default, "/v"), number(&evolution, "/v"));
    assert!((one - other).abs() < 0.01 * one, "{one} and {other}");
    assert_eq!(design(&["--criterion", "paper"])["criterion"], "paper");
    let skipped = design(&["--search-skip", "100"]);
    assert!(skipped["v"] != default["v"]);
}

/// Without `--faulty` nothing is searched, and the report says so.
#[test]
fn complex_poles_are_placed_and_reported_as_pairs() {
    let place = place();
    let design = ["design", "--model", "model.json", "--healthy", "h1.mcap"];
    let report = |poles: &str| {
        let tail = ["--poles", poles, "--out", "complex.json"];
        place.json(&[&design[..], &tail].concat())
    };
    let pair = report("0.6+0.2i,0.6-0.2i");
    assert!(optimisation(&pair).is_null());
    let detector = &pair["detectors"][0];
    assert_eq!(detector["complex_poles"], json!([[0.6, 0.2], [0.6, -0.2]]));
    assert_eq!(detector["poles"], json!([]));
    let verdicts = place.json(&["detect", "h2.mcap", "--bank", "complex.json"]);
    assert_eq!(verdicts["samples"], 750);
    let real = report("t3=0.6,t3=0.2");
    assert_eq!(real["detectors"][0]["poles"], json!([0.6, 0.2]));
    assert_eq!(real["detectors"][0]["complex_poles"], json!([]));
}

/// A fault that is weak against the model's error, whatever the poles.
#[test]
fn a_fault_that_no_poles_tell_is_warned_of() {
    let place = place();
    let fault = "[[fault]]\ncase = \"compressor_fouling\"\nrate_percent_per_h = 0.1\n";
    place.write("fouling.toml", format!("{fault}onset_s = 20.0\n"));
    let simulate = ["simulate", "--seconds", "60", "--seed", "2"];
    let fouled = ["--faults", "fouling.toml", "--out", "fouled.mcap"];
    place.done(&[&simulate[..], &fouled].concat());
    let report = place.json(
        &[
            &DESIGN[..],
            &["--faulty", "fouled.mcap", "--out", "weak.json"],
        ]
        .concat(),
    );
    assert!(number(optimisation(&report), "/v") > 1.0, "{report}");
    let warnings = array(&report, "/warnings");
    let text = warnings[0].as_str().expect("a text");
    let end = "in the residual without the faults as they add to it, with the best poles found";
    assert!(text.starts_with("`t3`: ") && text.ends_with(end), "{text}");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
}

/// Two runs with other seeds are no pair, and that is said.
#[test]
fn records_that_are_no_pair_are_warned_of() {
    let report =
        place().json(&[&DESIGN[..], &["--faulty", "f2.mcap", "--out", "none.json"]].concat());
    let warnings = array(&report, "/warnings");
    let text = warnings[0].as_str().expect("a text");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let start = "f2.mcap: 0 % of its values are those of h1.mcap at the same time: ";
    assert!(text.starts_with(start), "{text}");
}

#[test]
fn the_commands_of_the_readme_on_pairs_run() {
    let readme = concat!(env!("CARGO_MANIFEST_DIR"), "/../../README.md");
    let readme = std::fs::read_to_string(readme).expect("the README");
    let place = Place::new();
    let between = |text: &'static str, from: &str, to: &str| -> &'static str {
        let tail = text.split_once(from).expect("a beginning").1;
        tail.split_once(to).expect("an end").0
    };
    let readme: &'static str = Box::leak(readme.replace("\\\n", "").into_boxed_str());
    place.write("drift.toml", between(readme, "<<'EOF'\n", "EOF\n"));
    // What the block stands on: the lines above it that write what it reads.
    let files = ["train.mcap", "healthy.mcap", "faulty.mcap", "model.json"];
    let earlier = between(readme, "```sh\n# Records", "```").lines();
    let earlier = earlier.filter(|line| {
        files
            .iter()
            .any(|file| line.ends_with(&format!("--out {file}")))
    });
    let block = readme
        .split("```")
        .find(|block| block.contains("--validate-faulty"))
        .expect("a block");
    let commands = earlier.chain(block.lines().skip(1));
    let reports: Vec<Value> = commands
        .map(|command| {
            let args: Vec<&str> = command.split_whitespace().skip(1).collect();
            place.json(&args)
        })
        .collect();
    assert_eq!(reports.len(), 4 + 4);
    let outputs = array(&reports[7], "/outputs");
    for output in outputs {
        // The thermocouple's drift reaches no other output's observer.
        assert_eq!(output["optimisation"].is_null(), output["name"] != "t3");
    }
    let found = &outputs[1]["optimisation"];
    assert!(number(found, "/bound") <= number(found, "/v"), "{found}");
    assert!(number(found, "/v_validation") < 0.001, "{found}");
    // Another run, by these poles and by the default ones with limits from the same records.
    let healthy = ["--healthy", "twin.mcap,other.mcap,healthy.mcap"];
    let design = ["design", "--model", "model.json", "--out", "default.json"];
    place.done(&[&design[..], &healthy].concat());
    let another = ["simulate", "--seconds", "600", "--seed", "5", "--out"];
    place.done(&[&another[..], &["calm.mcap"]].concat());
    place.done(&[&another[..], &["drift.mcap", "--faults", "drift.toml"]].concat());
    let delays = ["chosen.json", "default.json"].map(|bank| {
        let alarms = |record: &str| {
            let report = place.json(&["detect", record, "--bank", bank]);
            let alarms = array(&report, "/alarms").iter();
            alarms
                .filter(|alarm| alarm["tag"] == "t3")
                .map(|alarm| number(alarm, "/time_s") - 60.0)
                .collect::<Vec<f64>>()
        };
        assert_eq!(alarms("calm.mcap"), [0.0; 0]);
        alarms("drift.mcap")[0]
    });
    assert!((27.0..44.0).contains(&delays[0]), "{delays:?}");
    assert!((90.0..100.0).contains(&delays[1]), "{delays:?}");
}

/// A faulty record that misses samples and its partner are split together.
#[test]
fn pairs_are_split_where_samples_are_missing() {
    let place = furnished();
    place.done(&["log", "export", "f1.mcap", "--out", "f1.csv"]);
    let text = String::from_utf8(place.read("f1.csv")).expect("text");
    let lines = text.lines().enumerate();
    let cut = lines.map(|(line, text)| match line {
        300 => format!(
            "{},{}\n",
            &text[..text.find(',').expect("cells")],
            ",".repeat(33)
        ),
        _ => format!("{text}\n"),
    });
    place.write("gap.csv", cut.collect::<String>());
    let args = [&DESIGN[..], &["--out", "gap.json", "--faulty", "gap.csv"]].concat();
    place.refused(&args, &["gap.csv: line 301", "--missing break"]);
    let report = place.json_of_missing(&[&args[..], &["--missing", "break"]].concat());
    assert_eq!(report["healthy_records"], 3);
    let whole = [&DESIGN[..], &["--out", "whole.json", "--faulty", "f1.mcap"]].concat();
    let whole = place.json(&whole);
    // A sample of 750 is no other search.
    let (found, expected) = (
        number(optimisation(&report), "/v"),
        number(optimisation(&whole), "/v"),
    );
    assert!((found / expected - 1.0).abs() < 0.2, "{found} {expected}");
}
