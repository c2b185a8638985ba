//! `gtfdi model check`: what is wrong with a model, and what to do.

use serde_json::Value;

use crate::place::{Place, Ran, array, number, object};
use crate::signal::{Noise, arx, csv, second_order_csv, two_outputs_csv};

const HEAD: [&str; 6] = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];

/// A folder with two records of one second-order system and a model of the first.
fn place(options: &[&str]) -> Place {
    let place = Place::new();
    place.write("one.csv", second_order_csv(600, 1));
    place.write("fresh.csv", second_order_csv(600, 2));
    place.done(&[&HEAD[..], options, &["--out", "model.json"]].concat());
    place
}

fn kinds(report: &Value) -> Vec<&str> {
    let findings = array(report, "/findings").iter();
    findings
        .map(|finding| finding["kind"].as_str().expect("a kind"))
        .collect()
}

#[test]
fn a_sound_model_has_no_findings() {
    let place = place(&["--order", "2"]);
    let report = place.json(&["model", "check", "model.json"]);
    assert_eq!((&report["sound"], kinds(&report)), (&true.into(), vec![]));
    assert_eq!(report["records"], serde_json::json!([]));
    let report = place.json(&["model", "check", "model.json", "one.csv", "fresh.csv"]);
    assert_eq!((&report["sound"], kinds(&report)), (&true.into(), vec![]));
    for (index, origin) in ["fitted", "fresh"].into_iter().enumerate() {
        let record = &report["records"][index];
        assert_eq!(record["origin"], origin);
        assert_eq!(
            record["residuals"]["outputs"][0]["whiteness"],
            "not_rejected"
        );
        assert_eq!(
            record["residuals"]["outputs"][0]["independence"],
            "not_rejected"
        );
        assert!(number(record, "/residual_tests/ljung_box/0/p_value") > 0.01);
        assert!(number(record, "/residual_tests/independence/0/p_value") > 0.01);
        assert_eq!(record["residuals"]["lags"], 20);
        assert!(record["diverges_at"].is_null());
    }
    // The fits are those of identify on the same rows.
    let identified = place.json(&[&HEAD[..], &["--order", "2"]].concat());
    let fit = "fit_simulation_percent";
    assert_eq!(
        report["records"][0]["outputs"][0][fit],
        identified["outputs"][0][fit]
    );
    let text = place.done(&["model", "check", "model.json", "one.csv", "fresh.csv"]);
    for part in [
        "one.csv: 600 rows, the record of the fit",
        "fresh.csv: 600 rows, not the record of the fit",
        "p independent",
        "one-step errors (at 1 %, 20 lags): white; independent of past inputs",
        "nothing found",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// One lag of the output less than the system has: the rest of it is in the errors.
#[test]
fn a_model_of_too_low_an_order_is_told_so() {
    let place = place(&["--order", "1"]);
    for record in ["one.csv", "fresh.csv"] {
        let report = place.json(&["model", "check", "model.json", record]);
        assert_eq!(
            kinds(&report),
            ["not_white", "inputs_not_used_up"],
            "{record}"
        );
        assert_eq!(report["sound"], false);
        assert_eq!(report["findings"][0]["data"], record);
        let text = place.done(&["model", "check", "model.json", record]);
        let line =
            format!("{record}: the one-step errors of `y` are not white (at 1 %, 20 lags): ");
        assert!(text.contains(&line), "{text}");
        assert!(
            text.contains("take more lags of them (--nb, --order)"),
            "{text}"
        );
    }
}

/// Six lags where the system has two: zeros cancel four poles within their errors.
#[test]
fn a_model_of_too_high_an_order_is_told_so() {
    let place = place(&["--order", "6"]);
    let report = place.json(&["model", "check", "model.json", "fresh.csv"]);
    assert_eq!(kinds(&report), ["order_too_high"]);
    let text = report["findings"][0]["text"].as_str().expect("text");
    assert!(text.starts_with("zeros cancel 4 of 6 poles"), "{text}");
}

#[test]
fn a_free_run_that_diverges_is_found_with_its_time() {
    let place = Place::new();
    place.write("one.csv", csv("u,y", &arx(&[1.3], &[1.0], 0.0, 40, 3)));
    let options = [
        "--order",
        "1",
        "--sample-time",
        "0.5",
        "--out",
        "model.json",
    ];
    place.done(&[&HEAD[..], &options].concat());
    let mut source = Noise::new(5);
    let rows: Vec<Vec<f64>> = (0..600)
        .map(|_| vec![source.next(), source.next()])
        .collect();
    place.write("fresh.csv", csv("u,y", &rows));
    let args = ["model", "check", "model.json", "fresh.csv"];
    let report = place.json(&args);
    let found = kinds(&report);
    assert!(
        found.contains(&"not_stable") && found.contains(&"diverges"),
        "{found:?}"
    );
    let record = &report["records"][0];
    let time = number(record, "/diverges_at");
    assert_eq!(record["outputs"][0]["diverges_at_s"], time);
    assert!(record["outputs"][0]["fit_simulation_percent"].is_null());
    // The same run by hand, until it is further from rest than 1e6 times the range of the record.
    let model = place.json(&["model", "show", "model.json"]);
    let [a, b] = ["/0", "/1"].map(|term| {
        number(
            &model,
            &format!("/equations/0/regression{term}/coefficient"),
        )
    });
    let [u_rest, y_rest] =
        ["/inputs", "/outputs"].map(|side| number(&model, &format!("{side}/0/operating_point")));
    let outputs = rows.iter().map(|row| row[1]);
    let high = outputs.clone().fold(f64::MIN, f64::max);
    let limit = 1e6 * (high - outputs.fold(f64::MAX, f64::min));
    let mut y = rows[0][1] - y_rest;
    let mut sample = 0;
    while y.abs() <= limit {
        y = a * y + b * (rows[sample][0] - u_rest);
        sample += 1;
    }
    assert_eq!(record["diverges_at"], 0.5 * sample as f64);
    let text = place.done(&args);
    assert!(text.contains("the free run of `y` diverges at "), "{text}");
    assert!(text.contains("identify with --stable"), "{text}");
    assert!(!text.contains("NaN"), "{text}");
}

#[test]
fn outputs_are_tested_together_too() {
    let place = Place::new();
    place.write("two.csv", two_outputs_csv(800, 1));
    let head = ["identify", "two.csv", "--inputs", "u*", "--outputs", "y*"];
    place.done(&[&head[..], &["--order", "4", "--out", "model.json"]].concat());
    let args = ["model", "check", "model.json", "two.csv"];
    let report = place.json(&args);
    let p = number(&report, "/records/0/residual_tests/hosking/p_value");
    assert_eq!(
        report["records"][0]["residuals"]["joint_whiteness"],
        "not_rejected"
    );
    assert!(p > 0.01, "{p}");
    let text = place.done(&args);
    assert!(
        text.contains("all outputs together (Hosking): p white "),
        "{text}"
    );
}

#[test]
fn noise_on_the_inputs_leaves_the_errors_untested() {
    let place = place(&["--order", "2", "--method", "frisch"]);
    let args = ["model", "check", "model.json", "fresh.csv"];
    let report = place.json(&args);
    assert!(report["records"][0]["residual_tests"].is_null());
    let why = "the noise on the inputs colours the one-step errors of this kind of model";
    assert_eq!(report["records"][0]["untested"], why);
    assert!(place.done(&args).contains(why));
}

#[test]
fn regressors_that_nearly_depend_on_each_other_are_told() {
    let mut source = Noise::new(2);
    let place = Place::new();
    let rows = arx(&[0.5], &[1.0], 0.1, 400, 4);
    let rows: Vec<Vec<f64>> = rows
        .iter()
        // Condition about 1e10: between the warning at 1e8 and the refusal at 1e12.
        .map(|row| vec![row[0], row[0] + 1e-10 * source.next(), row[1]])
        .collect();
    place.write("near.csv", csv("u,v,y", &rows));
    let args = [
        "identify",
        "near.csv",
        "--inputs",
        "u,v",
        "--outputs",
        "y",
        "--order",
        "1",
    ];
    place.done(&[&args[..], &["--out", "model.json"]].concat());
    let report = place.json(&["model", "check", "model.json"]);
    assert_eq!(kinds(&report), ["regressors_ill_conditioned"]);
    let advice = report["findings"][0]["advice"].as_str().expect("advice");
    assert!(advice.contains("--ridge"), "{advice}");
}

#[test]
fn options_come_from_flag_environment_and_file() {
    let place = place(&["--order", "2"]);
    place.write(
        "c.toml",
        "[model-check]\nlags = 8\nsignificance = 0.05\ndata = \"one.csv\"\n",
    );
    let lags = |report: &Value| report["records"][0]["residuals"]["lags"].clone();
    let args = [
        "model",
        "check",
        "model.json",
        "--config",
        "c.toml",
        "--json",
    ];
    let run = |more: &[&str], environment: &[(&str, &str)]| {
        let mut command = place.command(&[&args[..], more].concat());
        object(&Ran::of(command.envs(environment.iter().copied())).stdout)
    };
    let report = run(&[], &[]);
    assert_eq!(lags(&report), 8);
    assert_eq!(report["records"][0]["residuals"]["significance"], 0.05);
    assert_eq!(report["records"][0]["data"], "one.csv");
    assert_eq!(lags(&run(&[], &[("GTFDI_LAGS", "9")])), 9);
    assert_eq!(lags(&run(&["--lags", "10"], &[("GTFDI_LAGS", "9")])), 10);
    let printed = place.done(&["model", "check", "--config", "c.toml", "--print-config"]);
    let table: toml::Table = toml::from_str(&printed).expect("TOML");
    assert_eq!(table["model-check"]["lags"].as_integer(), Some(8));
    place.write("c.toml", "[model-check]\nlag = 8\n");
    place.refused(&args, &["c.toml: ", "unknown field `lag`"]);
}

#[test]
fn options_and_records_that_make_no_sense_are_refused() {
    let place = place(&["--order", "2"]);
    place.write("other.csv", csv("u,x", &[vec![1.0, 2.0], vec![2.0, 1.0]]));
    let check = ["model", "check", "model.json"];
    let cases: [(&[&str], &str); 9] = [
        (
            &["one.csv", "--significance", "0"],
            "--significance: expected a number above 0 and below 1, found 0",
        ),
        (
            &["one.csv", "--significance", "1.5"],
            "--significance: expected a number above 0 and below 1, found 1.5",
        ),
        (
            &["one.csv", "--lags", "2"],
            "one.csv: --lags: expected 3 to 597, found 2",
        ),
        (
            &["one.csv", "--lags", "598"],
            "one.csv: --lags: expected 3 to 597, found 598",
        ),
        (
            &["one.csv", "--sample-time", "2"],
            "one.csv: sample time: expected 1 s (the model's), found 2 s",
        ),
        (
            &["other.csv"],
            "other.csv: expected a column `y`, found u, x",
        ),
        (&["none.csv"], "none.csv: there is no such file"),
        (
            &["one.csv", "--rows", "0:900"],
            "one.csv: expected rows A:B with 0 <= A < B <= 600, found 0:900",
        ),
        (
            &["one.csv", "--rows", "0:3"],
            "one.csv: samples: expected at least 4 for full na=2 nb=2 nk=1, found 3",
        ),
    ];
    for (tail, text) in cases {
        place.refused(&[&check[..], tail, &["--json"]].concat(), &[text]);
    }
}

/// A record that misses samples is checked in its parts where those break it.
#[test]
fn missing_samples_break_a_record_that_is_checked() {
    let place = place(&["--order", "2"]);
    let record = second_order_csv(600, 2);
    let lines = record.lines().enumerate();
    let cut = lines.map(|(line, text)| match line {
        401 => "Bad,\n".to_owned(),
        _ => format!("{text}\n"),
    });
    place.write("gap.csv", cut.collect::<String>());
    let args = ["model", "check", "model.json", "gap.csv"];
    place.refused(&args, &["gap.csv: line 402", "--missing break"]);
    let args = [&args[..], &["--missing", "break"]].concat();
    let report = place.json_of_missing(&args);
    let record = &report["records"][0];
    assert_eq!(
        (&record["rows"], &record["parts"]),
        (&599.into(), &2.into())
    );
    assert_eq!(record["origin"], "fresh");
    // The longest part has 400 samples, two of which are past only.
    assert_eq!(record["residual_tests"]["rows"], 398);
    let whole = place.json(&["model", "check", "model.json", "fresh.csv"]);
    let fit = "/outputs/0/fit_prediction_percent";
    let (found, expected) = (number(record, fit), number(&whole["records"][0], fit));
    assert!((found - expected).abs() < 0.2, "{found} {expected}");
    let text = place.done(&args);
    assert!(text.contains("gap.csv: 599 rows in 2 parts"), "{text}");
    place.write("none.csv", "u,y\nBad,1\n1,Bad\n");
    let args = [
        "model",
        "check",
        "model.json",
        "none.csv",
        "--missing",
        "break",
    ];
    place.refused(
        &args,
        &["none.csv: expected samples of all channels, found none"],
    );
}
