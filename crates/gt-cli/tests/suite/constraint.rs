//! `gtfdi identify --stable`, `--dc-gain` and `--refine`.

use serde_json::Value;

use crate::place::{Place, array, number};
use crate::signal::{Noise, arx, csv, second_order_csv};

/// The interior-point solver ends within about 1e-8 of its constraints.
const TOLERANCE: f64 = 1e-6;
const HEAD: [&str; 6] = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];

fn gain(report: &Value) -> f64 {
    let terms = array(report, "/outputs/0/regression").iter();
    let sum = |signal: &str| -> f64 {
        let own = terms.clone().filter(|term| term["signal"] == signal);
        own.map(|term| number(term, "/coefficient")).sum()
    };
    sum("u") / (1.0 - sum("y"))
}

#[test]
fn poles_are_kept_within_the_radius() {
    let place = Place::new();
    place.write("one.csv", csv("u,y", &arx(&[1.1], &[1.0], 1.0, 60, 3)));
    let args = [&HEAD[..], &["--order", "1"]].concat();
    let free = place.json(&args);
    assert!(number(&free, "/spectral_radius") > 1.0);
    assert!(free["constraints"].is_null());
    for (option, radius) in [
        ("--stable", 0.999),
        ("--stable=0.9", 0.9),
        ("--stable=1", 1.0),
    ] {
        let report = place.json(&[&args[..], &[option]].concat());
        let found = number(&report, "/spectral_radius");
        // The programme's own tolerance below the limit, nothing above it.
        assert!(
            found <= radius && found > radius - 0.01,
            "{option}: {found}"
        );
        assert_eq!(report["structure"]["diagonal"]["na"], 1);
        let row = &report["constraints"][0];
        assert_eq!(row["output"], "y");
        assert!(number(row, "/cost_ratio") > 1.0);
        let before = number(row, "/least_squares_radius") - number(&free, "/spectral_radius");
        assert!(before.abs() < 1e-10, "{before}");
        let text = place.done(&[&args[..], &[option]].concat());
        assert!(
            text.contains("`y`: stability binds; squared errors "),
            "{text}"
        );
    }
    // Where least squares is inside already, nothing changes.
    place.write("one.csv", second_order_csv(300, 1));
    let args = [&HEAD[..], &["--order", "2"]].concat();
    let (free, held) = (
        place.json(&args),
        place.json(&[&args[..], &["--stable"]].concat()),
    );
    let regression = |report: &Value| -> Vec<f64> {
        let terms = array(report, "/outputs/0/regression").iter();
        terms.map(|term| number(term, "/coefficient")).collect()
    };
    for (free, held) in regression(&free).iter().zip(regression(&held)) {
        assert!((free - held).abs() < 1e-10, "{free} {held}");
    }
    assert_eq!(held["constraints"][0]["active"], serde_json::json!([]));
    let text = place.done(&[&args[..], &["--stable"]].concat());
    assert!(
        text.contains("`y`: no constraint binds; largest pole 0.83"),
        "{text}"
    );
}

#[test]
fn gains_at_rest_are_met() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(300, 1));
    let of = |wish: &str| place.json(&[&HEAD[..], &["--order", "2", "--dc-gain", wish]].concat());
    // The system's own gain is 1.5 / 0.2 = 7.5.
    assert!((gain(&of("y:u=+")) - 7.5).abs() < 0.5);
    assert!((gain(&of("y:u=6")) - 6.0).abs() < TOLERANCE);
    assert!((gain(&of("y:u=3..5")) - 5.0).abs() < TOLERANCE);
    assert!(gain(&of("y:u=-")).abs() < TOLERANCE);
    let report = of("y:u=6");
    let active = serde_json::json!([{ "dc_gain": { "input": "u" } }]);
    assert_eq!(report["constraints"][0]["active"], active);
    let text = place.done(&[&HEAD[..], &["--order", "2", "--dc-gain", "y:u=6"]].concat());
    assert!(text.contains("`y`: the gain of `u` binds"), "{text}");
}

/// A first-order system with noise on its output: least squares takes the noise for dynamics, and
/// the free run of what it finds is poor.
fn output_noise(seed: u64) -> String {
    let mut source = Noise::new(seed);
    let mut y = 0.0;
    let rows: Vec<Vec<f64>> = (0..800)
        .map(|_| {
            let u = source.next();
            let row = vec![u, y + 1.5 * source.next()];
            y = 0.9 * y + u;
            row
        })
        .collect();
    csv("u,y", &rows)
}

#[test]
fn a_refinement_that_fresh_rows_confirm_is_taken() {
    let place = Place::new();
    place.write("one.csv", output_noise(1));
    place.write("fresh.csv", output_noise(2));
    let rows = ["--train", "0:500", "--validate", "500:800"];
    for fresh in [&rows[..], &["--holdout", "fresh.csv"]] {
        let args = [&HEAD[..], &["--order", "1"], fresh].concat();
        let before = place.json(&args);
        let refine = [&args[..], &["--refine", "output-error"]].concat();
        let after = place.json(&refine);
        assert!(before["refinement"].is_null());
        let row = &after["refinement"][0];
        assert_eq!(row["accepted"], true);
        assert!(number(row, "/hold_out_after") < number(row, "/hold_out_before"));
        let fit = |report: &Value| number(report, "/outputs/0/fit_simulation_percent");
        assert!(
            fit(&after) > fit(&before) + 1.0,
            "{} {}",
            fit(&after),
            fit(&before)
        );
        let pole = |report: &Value| number(report, "/outputs/0/regression/0/coefficient");
        // Least squares is far off; the refined pole within some standard errors of the truth.
        assert!(pole(&before) < 0.75, "{}", pole(&before));
        assert!((pole(&after) - 0.9).abs() < 0.05, "{}", pole(&after));
        let text = place.done(&refine);
        assert!(
            text.contains("`y`: refinement accepted: free-run error"),
            "{text}"
        );
        // A radius holds for the refined model too.
        let held = place.json(&[&refine[..], &["--stable=0.8"]].concat());
        assert!(number(&held, "/spectral_radius") <= 0.8);
    }
}

/// The hold-out runs exactly as least squares says: nothing can be better there.
#[test]
fn a_refinement_that_fresh_rows_do_not_confirm_is_not_taken() {
    let place = Place::new();
    place.write("one.csv", output_noise(1));
    let args = [&HEAD[..], &["--order", "1", "--centre", "zero"]].concat();
    let model = place.json(&args);
    let term = |index: usize| {
        number(
            &model,
            &format!("/outputs/0/regression/{index}/coefficient"),
        )
    };
    let exact = arx(&[term(0)], &[term(1)], 0.0, 300, 9);
    place.write("fresh.csv", csv("u,y", &exact));
    let args = [
        &args[..],
        &["--holdout", "fresh.csv", "--refine", "output-error"],
    ]
    .concat();
    let refined = place.json(&args);
    assert_eq!(refined["refinement"][0]["accepted"], false);
    assert_eq!(
        refined["outputs"][0]["regression"],
        model["outputs"][0]["regression"]
    );
    let text = place.done(&args);
    assert!(
        text.contains("`y`: refinement not accepted, the model stays as it was"),
        "{text}"
    );
}

/// A second-order fit with the options of each case is refused with its text.
fn refused_exactly(place: &Place, cases: &[(&[&str], &str)]) {
    for (tail, text) in cases {
        let out = ["--order", "2", "--sample-time", "1", "--out", "m.json"];
        place.refused_exactly(&[&HEAD[..], &out, tail].concat(), text);
    }
}

#[test]
fn what_cannot_be_held_is_refused() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    let full = "found full na=2 nb=2 nk=1";
    let gain = "--dc-gain: expected OUTPUT:INPUT=VALUE, LOW..HIGH, + or - in the value's place, \
                such as y:u=+, found ";
    let cases: [(&[&str], &str); 12] = [
        (
            &["--stable", "--structure", "full"],
            &format!("--stable: expected --structure diag, {full}"),
        ),
        (
            &["--dc-gain", "y:u=+", "--structure", "full"],
            &format!("--dc-gain: expected --structure diag, {full}"),
        ),
        (
            &["--stable=0"],
            "--stable: expected a radius above 0 and at most 1, found 0",
        ),
        (
            &["--stable=1.5"],
            "--stable: expected a radius above 0 and at most 1, found 1.5",
        ),
        (
            &["--stable=nan"],
            "--stable: expected a radius above 0 and at most 1, found NaN",
        ),
        (&["--dc-gain", "y=3"], &format!("{gain}`y=3`")),
        (&["--dc-gain", "y:u=big"], &format!("{gain}`y:u=big`")),
        (
            &["--dc-gain", "y:u=5..3"],
            "--dc-gain: gain of `u` on `y`: expected finite limits with lower <= upper, found 5 \
             and 3",
        ),
        (
            &["--dc-gain", "z:u=+"],
            "--dc-gain: channel `z`: not found; there are: y",
        ),
        (
            &["--stable", "--ridge", "1"],
            "--ridge: expected without --stable and --dc-gain, found it beside --stable",
        ),
        (
            &["--dc-gain", "y:u=+", "--centre", "zero"],
            "--centre: expected without --stable and --dc-gain, found it beside --dc-gain",
        ),
        (
            &["--method", "eiv", "--stable"],
            "--stable: expected with --method arx only, found another method: it takes --order \
             and --nk",
        ),
    ];
    refused_exactly(&place, &cases);
}

#[test]
fn what_cannot_be_refined_is_refused() {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    place.write("grows.csv", csv("u,y", &arx(&[1.3], &[1.0], 0.0, 40, 3)));
    let fresh = ["--train", "0:100", "--validate", "100:200"];
    let seen = "--refine output-error: expected --validate with other rows than --train, or \
                --holdout, found training rows: rows that the fit has seen cannot confirm it";
    let refine = ["--refine", "output-error"];
    let cases: [(&[&str], &str); 5] = [
        (&refine, seen),
        (
            &[
                "--refine",
                "output-error",
                "--train",
                "0:100",
                "--validate",
                "50:150",
            ],
            seen,
        ),
        (
            &[&refine[..], &fresh, &["--structure", "full"]].concat(),
            "--refine output-error: expected --structure diag, found full na=2 nb=2 nk=1",
        ),
        (
            &[&refine[..], &fresh, &["--dc-gain", "y:u=+"]].concat(),
            "--refine output-error: expected without --dc-gain, found both: a refined model would \
             not keep the gain",
        ),
        (
            &[&["--method", "frisch"], &refine[..]].concat(),
            "--refine: expected with --method arx only, found another method: it takes --order \
             and --nk",
        ),
    ];
    refused_exactly(&place, &cases);
    let head = [
        "identify",
        "grows.csv",
        "--inputs",
        "u",
        "--outputs",
        "y",
        "--order",
        "1",
    ];
    place.refused(
        &[&head[..], &refine, &["--holdout", "one.csv"]].concat(),
        &[
            "--refine output-error: output `y`: expected poles within 0.9999 to start from, found 1.",
            "; fit it with --stable",
        ],
    );
    place.refused(
        &[&HEAD[..], &["--order", "2", "--refine", "more"]].concat(),
        &["[possible values: output-error]"],
    );
}

/// The examples of the help on one output are commands that work.
#[test]
fn the_examples_of_the_help_run() {
    let place = Place::new();
    for (name, seed) in [("run.csv", 1), ("noisy.csv", 2), ("a.csv", 3), ("b.csv", 4)] {
        place.write(name, second_order_csv(1000, seed));
    }
    let help = place.done(&["identify", "--help"]);
    let examples: Vec<&str> = help
        .lines()
        .map(str::trim)
        .filter(|line| line.starts_with("gtfdi identify "))
        .collect();
    assert_eq!(examples.len(), 4, "{help}");
    for example in examples {
        let args: Vec<&str> = example.split(' ').skip(1).collect();
        place.json(&args);
    }
}
