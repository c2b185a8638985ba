//! `gtfdi model show`: what is printed agrees with the equations of the file.

use serde_json::Value;

use crate::place::{Place, array, number};
use crate::signal::{Noise, arx, csv, second_order_csv, two_outputs_csv};

/// Roots of a quadratic: a few operations on numbers near 1.
const TOLERANCE: f64 = 1e-12;
const HEAD: [&str; 6] = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];

/// A folder with `one.csv` and `model.json`, with a sample time of 0.1 s.
fn place(record: &str, options: &[&str]) -> Place {
    let place = Place::new();
    place.write("one.csv", record);
    let tail = ["--sample-time", "0.1", "--out", "model.json"];
    place.done(&[&HEAD[..], options, &tail].concat());
    place
}

/// The coefficients of the only equation.
fn coefficients(report: &Value) -> Vec<f64> {
    let terms = array(report, "/equations/0/regression").iter();
    terms.map(|term| number(term, "/coefficient")).collect()
}

#[test]
fn poles_zeros_and_gains_are_those_of_the_equation() {
    let place = place(&second_order_csv(400, 1), &["--order", "2"]);
    let report = place.json(&["model", "show", "model.json"]);
    let [a1, a2, b1, b2] = coefficients(&report)[..] else {
        panic!("four terms");
    };
    let poles = array(&report, "/poles");
    assert_eq!(poles.len(), 2);
    for pole in poles {
        let (re, im) = (number(pole, "/re"), number(pole, "/im"));
        // z^2 - a1 z - a2 = 0, real and imaginary part.
        assert!((re * re - im * im - a1 * re - a2).abs() < TOLERANCE);
        assert!((2.0 * re * im - a1 * im).abs() < TOLERANCE);
        assert!(im.abs() > 0.1, "a pair, not a double real root");
        let modulus = number(pole, "/modulus");
        assert!((modulus - (-a2).sqrt()).abs() < TOLERANCE);
        let (decay, angle) = (-modulus.ln(), im.atan2(re).abs());
        let damping = decay / decay.hypot(angle);
        assert!((number(pole, "/damping") - damping).abs() < TOLERANCE);
        let time_constant_s = 0.1 / decay;
        assert!((number(pole, "/time_constant_s") - time_constant_s).abs() < TOLERANCE);
        let frequency_hz = decay.hypot(angle) / (0.2 * std::f64::consts::PI);
        assert!((number(pole, "/frequency_hz") - frequency_hz).abs() < TOLERANCE);
    }
    let [zero] = array(&report, "/zeros") else {
        panic!("one zero");
    };
    assert!((number(zero, "/re") + b2 / b1).abs() < TOLERANCE);
    let distance =
        |pole: &Value| (number(pole, "/re") - number(zero, "/re")).hypot(number(pole, "/im"));
    let nearest = number(zero, "/nearest_pole_distance");
    assert!((nearest - distance(&poles[0])).abs() < TOLERANCE);
    let gain = (b1 + b2) / (1.0 - a1 - a2);
    // Relative: the gain is near 7.
    assert!((number(&report, "/dc_gains/0/value") / gain - 1.0).abs() < TOLERANCE);
    assert_eq!(report["stable"], true);
    assert!((number(&report, "/spectral_radius") - (-a2).sqrt()).abs() < TOLERANCE);
    assert_eq!(report["realisation"]["minimal_order"], 2);
    assert_eq!(report["findings"], serde_json::json!([]));
}

#[test]
fn the_file_is_shown_as_it_was_identified() {
    let place = Place::new();
    place.write("two.csv", two_outputs_csv(400, 1));
    let head = ["identify", "two.csv", "--inputs", "u*", "--outputs", "y*"];
    let tail = ["--order", "4", "--out", "model.json"];
    let identified = place.json(&[&head[..], &tail].concat());
    let report = place.json(&["model", "show", "model.json"]);
    for (output, equation) in array(&report, "/equations").iter().enumerate() {
        let pointer = format!("/outputs/{output}/regression");
        assert_eq!(
            &equation["regression"],
            identified.pointer(&pointer).expect("terms")
        );
        let errors = &identified["standard_errors"][equation["output"].as_str().expect("a name")];
        for (term, error) in array(equation, "/regression")
            .iter()
            .zip(errors.as_array().expect("errors"))
        {
            assert_eq!(&term["standard_error"], error);
            assert!(error.as_f64().expect("a number") > 0.0);
        }
    }
    assert_eq!(report["input_sha256"], identified["input_sha256"]);
    assert_eq!(report["structure"], identified["structure"]);
    let file: Value = serde_json::from_slice(&place.read("model.json")).expect("JSON");
    assert_eq!(report["id"], file["id"]);
    assert_eq!(
        report["inputs"][1]["operating_point"],
        file["model"]["operating_point"]["u"][0][1]
    );
    // Four states: the poles of the whole model; zeros of four channels.
    assert_eq!(array(&report, "/poles").len(), 4);
    assert_eq!(array(&report, "/dc_gains").len(), 4);
    let text = place.done(&["model", "show", "model.json"]);
    for part in [
        "least squares (arx)",
        "y1(t) =",
        "u2(t-1)",
        "standard error",
        "operating point",
        "time constant s",
        "y2 from u1",
        "4 of them in a minimal realisation",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn units_and_the_direct_term_are_shown() {
    let place = Place::new();
    place.done(&["simulate", "--seconds", "60", "--out", "run.mcap"]);
    let head = [
        "identify",
        "run.mcap",
        "--inputs",
        "a_v,M_f",
        "--outputs",
        "t3",
    ];
    let tail = ["--order", "2", "--nk", "1,0", "--out", "model.json"];
    place.done(&[&head[..], &tail].concat());
    let report = place.json(&["model", "show", "model.json"]);
    assert_eq!(report["outputs"][0]["unit"], "K");
    assert_eq!(report["sample_time_s"], 0.08);
    let text = place.done(&["model", "show", "model.json"]);
    assert!(text.contains("M_f(t)"), "{text}");
}

#[test]
fn the_noise_of_an_errors_in_variables_model_is_shown() {
    let mut source = Noise::new(7);
    let mut rows = arx(&[1.5, -0.7], &[1.0, 0.5], 0.0, 2000, 3);
    for row in &mut rows {
        for cell in row {
            *cell += 0.1 * source.next();
        }
    }
    let place = place(&csv("u,y", &rows), &["--order", "2", "--method", "eiv"]);
    let identified = place.json(&[&HEAD[..], &["--order", "2", "--method", "eiv"]].concat());
    let report = place.json(&["model", "show", "model.json"]);
    assert_eq!(report["kind"], "eiv");
    assert_eq!(report["noise"], identified["noise"]);
    assert_eq!(array(&report, "/noise").len(), 2);
    let text = place.done(&["model", "show", "model.json"]);
    assert!(text.contains("told by the record"), "{text}");
}

#[test]
fn noise_that_the_record_does_not_tell_is_named() {
    // White noise through a gain: nothing tells input noise from output noise.
    let mut source = Noise::new(3);
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut before = 0.0;
    for _ in 0..400 {
        let u = source.next();
        rows.push(vec![
            u + 0.05 * source.next(),
            before + 0.05 * source.next(),
        ]);
        before = u;
    }
    let place = place(&csv("u,y", &rows), &["--order", "1", "--method", "eiv"]);
    let report = place.json(&["model", "show", "model.json"]);
    let untold = array(&report, "/noise")
        .iter()
        .filter(|row| row["identifiable"] == false);
    let untold = untold.count();
    assert!(untold > 0, "{}", report["noise"]);
    assert_eq!(array(&report, "/warnings").len(), untold);
    let check = place.json(&["model", "check", "model.json"]);
    assert_eq!(check["sound"], false);
    assert_eq!(check["findings"][0]["kind"], "noise_not_told");
    let text = place.done(&["model", "show", "model.json"]);
    assert!(
        text.contains("the record does not tell the noise of `"),
        "{text}"
    );
}

#[test]
fn a_model_without_working_inputs_is_not_minimal() {
    let place = place(&second_order_csv(400, 1), &["--na", "2", "--nb", "0"]);
    let report = place.json(&["model", "show", "model.json"]);
    assert_eq!(report["realisation"]["minimal_order"], 0);
    assert_eq!(report["findings"][0]["kind"], "not_minimal");
    let text = "the realisation is not minimal: 0 of 2 states count";
    assert_eq!(report["findings"][0]["text"], text);
    assert!(place.done(&["model", "show", "model.json"]).contains(text));
}

#[test]
fn an_unstable_model_is_called_that() {
    let rows = arx(&[1.3], &[1.0], 0.0, 40, 3);
    let place = place(&csv("u,y", &rows), &["--order", "1", "--centre", "zero"]);
    let report = place.json(&["model", "show", "model.json"]);
    let [pole, gain] = coefficients(&report)[..] else {
        panic!("two terms");
    };
    // Without noise and about the true rest, the equation is exact.
    assert!((pole - 1.3).abs() < 1e-9 && (gain - 1.0).abs() < 1e-9);
    assert_eq!(report["stable"], false);
    assert_eq!(report["findings"][0]["kind"], "not_stable");
    assert!(report["poles"][0]["time_constant_s"].is_null());
    let text = place.done(&["model", "show", "model.json"]);
    assert!(text.contains("not stable, spectral radius 1.300"), "{text}");
    assert!(!text.contains("NaN"), "{text}");
}

#[test]
fn files_that_are_no_models_are_refused() {
    let place = place(&second_order_csv(400, 1), &["--order", "2"]);
    let whole: Value = serde_json::from_slice(&place.read("model.json")).expect("JSON");
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut value = whole.clone();
        change(&mut value);
        place.write("bad.json", value.to_string());
    };
    for verb in ["show", "check"] {
        changed(&|value| value["model"]["rows"][0]["terms"][0]["coefficient"] = 1.51.into());
        place.refused(
            &["model", verb, "bad.json"],
            &[
                "bad.json: ",
                "id: expected `",
                "the file was changed after it was written",
            ],
        );
        changed(&|value| value["schema_version"] = 7.into());
        place.refused(
            &["model", verb, "bad.json"],
            &["bad.json: ", "schema_version: expected 1, found 7"],
        );
        place.refused(
            &["model", verb, "none.json", "--json"],
            &["none.json: there is no such file"],
        );
        place.refused(&["model", verb, "one.csv"], &["one.csv: line 1"]);
        place.refused(&["model", verb], &["MODEL.json"]);
    }
}
