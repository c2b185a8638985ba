//! `gtfdi identify --method eiv` and `--method frisch`: noise on the inputs too.

use serde_json::Value;

use crate::place::{Place, array, number};
use crate::signal::{Noise, csv};

const HEAD: [&str; 6] = ["identify", "noisy.csv", "--inputs", "u", "--outputs", "y"];
/// Variances of the noise that is put on, uniform in `-d .. d`: `d^2 / 3`.
const NOISE: [(&str, f64, f64); 2] = [("u", 0.3, 0.03), ("y", 2.0, 4.0 / 3.0)];

/// A second-order system with a coloured input, white noise on both channels.
fn place(rows: usize) -> Place {
    let mut source = Noise::new(7);
    let (mut u, mut y): (Vec<f64>, Vec<f64>) = (vec![0.0; 2], vec![0.0; 2]);
    for t in 2..rows + 2 {
        u.push(0.6 * u[t - 1] + 2.0 * source.next());
        y.push(1.5 * y[t - 1] - 0.7 * y[t - 2] + u[t - 1] + 0.5 * u[t - 2]);
    }
    let measured = (2..rows + 2)
        .map(|t| {
            vec![
                u[t] + NOISE[0].1 * source.next(),
                y[t] + NOISE[1].1 * source.next(),
            ]
        })
        .collect::<Vec<_>>();
    let place = Place::new();
    place.write("noisy.csv", csv("u,y", &measured));
    place
}

fn coefficients(report: &Value) -> Vec<f64> {
    let terms = array(report, "/outputs/0/regression").iter();
    terms.map(|term| number(term, "/coefficient")).collect()
}

/// The largest distance to the true coefficients.
fn error(report: &Value) -> f64 {
    let pairs = coefficients(report).into_iter().zip([1.5, -0.7, 1.0, 0.5]);
    pairs
        .map(|(found, truth)| (found - truth).abs())
        .fold(0.0, f64::max)
}

#[test]
fn the_noise_of_every_channel_is_found_and_the_bias_is_gone() {
    let place = place(4000);
    let of = |method: &str, more: &[&str]| {
        place.json(&[&HEAD[..], &["--method", method, "--order", "2"], more].concat())
    };
    let plain = of("arx", &[]);
    let biased = error(&plain);
    assert_eq!(plain["free_run_start"], "measured");
    // 100 to 200 standard deviations of the best estimate.
    assert!(biased > 0.1, "{biased}");
    let report = of("eiv", &["--out", "eiv.json"]);
    assert_eq!(report["free_run_start"], "fitted");
    // Five standard errors, as the report has them.
    let errors = array(&report, "/standard_errors/y");
    for (index, truth) in [1.5, -0.7, 1.0, 0.5].into_iter().enumerate() {
        let limit = 5.0 * errors[index].as_f64().expect("a number");
        assert!(limit > 0.0 && limit < 0.2, "{limit}");
        let found = coefficients(&report)[index];
        assert!((found - truth).abs() < limit, "{found} {truth} {limit}");
    }
    for (signal, _, truth) in NOISE {
        let noise = array(&report, "/noise").iter();
        let noise = noise
            .clone()
            .find(|row| row["signal"] == signal)
            .expect("a channel");
        let limit = 5.0 * number(noise, "/standard_error");
        assert!(
            (number(noise, "/variance") - truth).abs() < limit,
            "{noise}"
        );
        assert_eq!(noise["identifiable"], true);
        assert_eq!(noise["variance"], report["noise_variances"][signal]);
    }
    assert_eq!(report["stable"], true);
    assert!(report["diverges_at"].is_null());
    for criterion in ["shift", "covariance", "yule-walker"] {
        // Up to five times the bound, for the criteria.
        let found = error(&of("frisch", &["--criterion", criterion]));
        assert!(found < 0.25 * biased, "{criterion}: {found} of {biased}");
    }
    let file: Value = serde_json::from_slice(&place.read("eiv.json")).expect("JSON");
    assert_eq!(file["kind"], "eiv");
    assert_eq!(
        file["noise"]["inputs"][0]["variance"],
        report["noise_variances"]["u"]
    );
    // What is identified is designed for: the file is a model like any other.
    place.json(&[
        "design",
        "--model",
        "eiv.json",
        "--healthy",
        "noisy.csv",
        "--poles",
        "0.3",
        "--margin",
        "1.2",
        "--consecutive",
        "2",
        "--out",
        "bank.json",
    ]);
}

#[test]
fn the_order_is_found_by_the_likelihood() {
    let place = place(2000);
    for wish in ["auto", "1..4"] {
        let args = [&HEAD[..], &["--method", "eiv", "--order", wish]].concat();
        let report = place.json(&args);
        assert_eq!(report["structure"]["diagonal"]["na"], 2, "--order {wish}");
        assert_eq!(report["order_table"]["best_bic"], 2);
        let text = place.done(&args);
        assert!(
            text.contains("chosen by the likelihood's BIC: order 2"),
            "{text}"
        );
        assert!(text.contains("told by the record"), "{text}");
    }
}

#[test]
fn options_of_the_other_method_are_refused() {
    let place = place(100);
    let with = |method: &str, more: &[&str], text: &str| {
        place.refused(&[&HEAD[..], &["--method", method], more].concat(), &[text]);
    };
    with(
        "eiv",
        &["--na", "2", "--nb", "2"],
        "--na: expected with --method arx only",
    );
    with(
        "frisch",
        &["--indices", "2"],
        "--indices: expected with --method arx only",
    );
    with("eiv", &[], "--order: required");
    let criterion = "--criterion: expected with --method frisch only";
    with("eiv", &["--order", "2", "--criterion", "shift"], criterion);
    with("arx", &["--order", "2", "--criterion", "shift"], criterion);
    let prior = "--pole-prior: expected with --method eiv only";
    with("frisch", &["--order", "2", "--pole-prior", "1"], prior);
    with("arx", &["--order", "2", "--pole-prior", "1"], prior);
    with(
        "eiv",
        &["--order", "2", "--pole-prior", "-1"],
        "--pole-prior: expected a finite number of at least 0, found -1",
    );
    with(
        "eiv",
        &["--order", "2", "--nk", "3"],
        "expected at most the order, 2, found 3",
    );
    with("eiv", &["--order", "90"], "samples: expected at least");
    with("frisch", &["--order", "90"], "samples: expected at least");
}
