//! Fault, model and bank files that cannot be used.

use serde_json::{Value, json};

use crate::place::Place;
use crate::signal::{second_order_csv, two_outputs_csv};

/// A folder with a record, its model and its bank.
fn place() -> Place {
    let place = Place::new();
    place.write("one.csv", second_order_csv(400, 1));
    let head = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];
    let tail = [
        "--order",
        "2",
        "--sample-time",
        "0.5",
        "--out",
        "model.json",
    ];
    place.done(&[&head[..], &tail].concat());
    place.done(
        &[
            &DESIGN[..],
            &["--model", "model.json", "--out", "bank.json"],
        ]
        .concat(),
    );
    place
}

/// A change of a JSON file and what is said of it.
type Change<'a> = (&'a dyn Fn(&mut Value), &'a str);

const DESIGN: [&str; 5] = ["design", "--healthy", "one.csv", "--poles", "0.4"];

#[test]
fn fault_files() {
    let place = Place::new();
    let drift = "[[fault]]\ncase = \"thermocouple_drift\"\nonset_s = 1.0\n";
    let rate = "rate_percent_per_h = 5.0\n";
    let stuck = "[[fault]]\nsensor = \"t3\"\nmode = \"stuck\"\nonset_s = 1.0\n";
    let cases = [
        (format!("{drift}{rate}spead = 3.0\n"), "spead"),
        (drift.to_owned(), "rate_percent_per_h"),
        (format!("{drift}{rate}\n[[falt]]\n"), "falt"),
        ("[[fault]]\ncase = \"rust\"\n".to_owned(), "rust"),
        ("[[fault]\n".to_owned(), "line 1"),
        (
            String::new(),
            "expected at least one [[fault]] table, found none",
        ),
        (
            format!("{}{rate}", drift.replace("1.0", "-1.0")),
            "onset of a fault [s]: expected a finite number of at least 0, found -1",
        ),
        (
            format!("{drift}rate_percent_per_h = 1e308\n"),
            "size of thermocouple_drift at the end [%]: expected a size below 100 %",
        ),
        (
            "[[fault]]\nsensor = \"t33\"\nmode = \"stuck\"\n".to_owned(),
            "channel: expected one of a_v, M_f, w_ref, p_a, T_a, LHV, IGV, p1,",
        ),
        (
            format!("{stuck}{stuck}"),
            "expected at most one that holds sensor t3, found t3_stuck and t3_stuck",
        ),
        (
            format!("{stuck}step = {{ size = 2.0 }}\n"),
            "mode stuck of a fault: expected a step or intermittent of size 1, found step of size 2",
        ),
        (
            "[[fault]]\nactuator = \"IGV\"\nmode = \"stuck\"\n".to_owned(),
            "actuator of a fault: expected in the variant prototype a channel of its records, \
             found IGV",
        ),
    ];
    for (text, message) in cases {
        place.write("faults.toml", text);
        let args = ["simulate", "--faults", "faults.toml", "--out", "run.mcap"];
        place.refused(&args, &["faults.toml", message]);
    }
    let args = ["simulate", "--faults", "none.toml", "--out", "run.mcap"];
    place.refused(&args, &["none.toml"]);
}

/// The JSON file `name` changed by `change`, written to `bad.json`.
fn changed(place: &Place, name: &str, change: &dyn Fn(&mut Value)) {
    let mut value: Value = serde_json::from_slice(&place.read(name)).expect("JSON");
    change(&mut value);
    place.write("bad.json", serde_json::to_vec_pretty(&value).expect("JSON"));
}

#[test]
fn model_files() {
    let place = place();
    let args = [&DESIGN[..], &["--model", "bad.json", "--out", "new.json"]].concat();
    let refused = |message: &str| place.refused(&args, &["bad.json: ", message]);
    let cases: [Change; 5] = [
        (
            &|file| file["model"]["extra"] = json!(1),
            "unknown field `extra`",
        ),
        (&|file| file["extra"] = json!(1), "unknown field `extra`"),
        (
            &|file| file["kind"] = json!("magic"),
            "unknown variant `magic`",
        ),
        (
            &|file| file["model"]["rows"][0]["terms"][0]["coefficient"] = json!(null),
            "invalid type: null",
        ),
        (
            &|file| {
                let terms = file["model"]["rows"][0]["terms"].as_array_mut();
                terms.expect("terms").pop();
            },
            "expected",
        ),
    ];
    for (change, message) in cases {
        changed(&place, "model.json", change);
        refused(message);
    }
    let whole = place.read("model.json");
    place.write("bad.json", &whole[..whole.len() / 2]);
    refused("line ");
    place.write("bad.json", b"");
    refused("EOF");
    place.write("bad.json", b"\x00\xff\x00");
    refused("line 1");
    place.write("bad.json", b"[1, 2]");
    refused("line 1");
    let args = [&DESIGN[..], &["--model", "none.json", "--out", "new.json"]].concat();
    place.refused(&args, &["none.json: there is no such file"]);
    let args = [&DESIGN[..], &["--model", "one.csv", "--out", "new.json"]].concat();
    place.refused(&args, &["one.csv: line 1"]);
}

#[test]
fn bank_files() {
    let place = place();
    let args = [
        "detect",
        "one.csv",
        "--bank",
        "bad.json",
        "--out",
        "verdicts.mcap",
    ];
    let refused = |message: &str| place.refused(&args, &["bad.json: ", message]);
    let (first, generator) = ("/tests/0", "/generators/0");
    let cases: [Change; 7] = [
        (
            &|bank| {
                let rate = "false_alarms/cross_validated/per_hour";
                *bank
                    .pointer_mut(&format!("{first}/{rate}"))
                    .expect("a rate") = json!(-5.0);
            },
            "false alarms, per_hour: expected ",
        ),
        (
            &|bank| {
                let poles = bank.pointer_mut(&format!("{generator}/poles"));
                poles.expect("poles")[0] = json!(0.1);
            },
            "gain: expected that of its poles, ",
        ),
        (&|bank| bank["extra"] = json!(1), "unknown field `extra`"),
        (
            &|bank| bank["schema_version"] = json!(1),
            "expected schema_version 2, found 1",
        ),
        (&|bank| bank["sample_time_s"] = json!(7.0), "7"),
        (
            &|bank| bank.pointer_mut(first).expect("one")["threshold"]["limit"] = json!(-1.0),
            "threshold limit: expected a finite number not below 0, found -1",
        ),
        (
            &|bank| bank["tests"] = json!([]),
            "expected at least one generator and one test, found none",
        ),
    ];
    for (change, message) in cases {
        changed(&place, "bank.json", change);
        refused(message);
    }
    let matrix = |bank: &mut Value, matrix: Value| {
        bank["generators"][0]["model"]["a"] = matrix;
    };
    for (stored, message) in [
        (json!([[1, 2, 3], 2, 2]), "expected 2 x 2 entries, found 3"),
        (
            json!([[], 1_u64 << 63, 2]),
            "expected 9223372036854775808 x 2 entries, found 0",
        ),
        (
            json!([[1, 2, 3], 3, 1]),
            "columns of A: expected 3, found 1",
        ),
        (json!([[1, 2, 3, null], 2, 2]), "invalid type: null"),
        (json!([[9, 2, 3, 4], 2, 2]), "expected a stable A - K C"),
    ] {
        changed(&place, "bank.json", &|bank| matrix(bank, stored.clone()));
        refused(message);
    }
    let whole = place.read("bank.json");
    place.write("bad.json", &whole[..whole.len() - 20]);
    refused("line ");
}

#[test]
fn records_that_do_not_fit_the_model_or_bank() {
    let place = place();
    place.write("two.csv", two_outputs_csv(100, 1));
    let detect = ["detect", "--bank", "bank.json", "--out", "verdicts.mcap"];
    place.refused(
        &[&detect[..], &["two.csv"]].concat(),
        &["two.csv: expected a column `u`, found", "y1"],
    );
    let design = ["design", "--model", "model.json", "--out", "new.json"];
    place.refused(
        &[&design[..], &["--healthy", "one.csv,two.csv"]].concat(),
        &["two.csv: expected a column `u`, found"],
    );
    let other = ["--sample-time", "0.25"];
    let message = "expected 0.5 s, found 0.25 s";
    place.refused(
        &[&detect[..], &["one.csv"], &other].concat(),
        &["one.csv: sample time", message],
    );
    place.refused(
        &[&design[..], &["--healthy", "one.csv"], &other].concat(),
        &["one.csv: ", "sample time", message],
    );
    place.refused(
        &[&detect[..], &["one.csv", "--rows", "300:500"]].concat(),
        &["one.csv: expected rows A:B with 0 <= A < B <= 400, found 300:500"],
    );
    let short = ["--healthy", "one.csv", "--rows", "0:10"];
    place.refused(
        &[&design[..], &short].concat(),
        &["one.csv: output `y`: healthy residual 0: expected at least"],
    );
}

#[test]
fn the_sample_time_of_the_model_stands_in() {
    let place = place();
    let detect = ["detect", "one.csv", "--bank", "bank.json", "--json"];
    let ran = place.run(&detect);
    let report = crate::place::object(&ran.stdout);
    assert_eq!(report["sample_time_s"], 0.5);
    let warning = "that of bank.json is taken, 0.5 s";
    assert!(ran.stderr.contains(warning), "{}", ran.stderr);
    assert!(
        report["warnings"][0]
            .as_str()
            .expect("text")
            .contains(warning)
    );
    // Said once, and not at all where the sample time is given.
    assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
    let ran = place.run(&[&detect[..], &["--sample-time", "0.5"]].concat());
    assert_eq!((ran.code, ran.stderr.as_str()), (0, ""));
}
