//! Options that make no sense.

use crate::place::Place;
use crate::signal::{csv, second_order, second_order_csv, two_outputs_csv};

/// A folder with records of one and of two outputs and a model of the first.
fn place() -> Place {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    place.write("two.csv", two_outputs_csv(200, 1));
    let head = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];
    place.done(&[&head[..], &["--order", "2", "--out", "model.json"]].concat());
    place
}

#[test]
fn structures() {
    let place = place();
    let one = ["identify", "one.csv", "--inputs", "u", "--outputs", "y"];
    let two = ["identify", "two.csv", "--inputs", "u*", "--outputs", "y*"];
    let cases: [(&[&str], &[&str], &str); 19] = [
        (&one, &["--order", "0"], "--order: expected a number from 1"),
        (&one, &["--order", "3..2"], "found `3..2`"),
        (&one, &["--order", "few"], "found `few`"),
        (
            &one,
            &["--order", "500"],
            "one.csv: samples: expected at least",
        ),
        (
            &one,
            &["--na", "0", "--nb", "0"],
            "expected na >= 1 or some nb >= 1",
        ),
        (&one, &["--na", "-1", "--nb", "1"], "'-1'"),
        (&one, &["--na", "18446744073709551615", "--nb", "1"], "--na"),
        (&one, &["--na", "2"], "--nb: required"),
        (&one, &["--nb", "2"], "--na: required"),
        (&one, &[], "--order, or --na and --nb: required"),
        (
            &one,
            &["--na", "1", "--nb", "1,1"],
            "option nb: expected 1 entry or 1",
        ),
        (
            &one,
            &["--na", "1", "--nb", "1", "--order", "2"],
            "found --order and --na",
        ),
        (
            &one,
            &["--indices", "2", "--structure", "diag"],
            "--indices: expected with",
        ),
        (
            &two,
            &["--indices", "0,2"],
            "indices, output 0: expected an index of at least 1, found 0",
        ),
        (
            &two,
            &["--indices", "2"],
            "option indices: expected 2 (one per output), found 1",
        ),
        (
            &two,
            &["--order", "1"],
            "--order: expected at least 2, one for each output, found 1",
        ),
        (
            &two,
            &["--order", "1..1"],
            "--order: expected at least 2, one for each output, found 1",
        ),
        (
            &two,
            &["--order", "4", "--nk", "3"],
            "expected 1 or 0, found 3",
        ),
        (
            &two,
            &["--structure", "canonical", "--na", "2"],
            "found --na or --nb",
        ),
    ];
    for (head, tail, text) in cases {
        let out = ["--out", "new.json", "--json"];
        place.refused(&[head, tail, &out].concat(), &[text]);
    }
}

#[test]
fn rows_name_their_option() {
    let place = place();
    let head = [
        "identify",
        "one.csv",
        "--inputs",
        "u",
        "--outputs",
        "y",
        "--order",
        "2",
    ];
    let cases: [(&[&str], &str); 7] = [
        (
            &["--train", "50:20"],
            "expected rows A:B with A < B, such as 0:500, found `50:20`",
        ),
        (&["--train", "5:5"], "found `5:5`"),
        (&["--train", "all"], "found `all`"),
        (
            &["--train", "0:900"],
            "one.csv: --train: expected rows A:B with B at most 200, found 0:900",
        ),
        (
            &["--train", "0:100", "--validate", "100:900"],
            "one.csv: --validate: expected rows A:B with B at most 200, found 100:900",
        ),
        (
            &["--validate", "300:900"],
            "one.csv: --validate: expected rows A:B",
        ),
        (
            &["--train", "0:100", "--validate", "100:102"],
            "one.csv: --validate 100:102: samples: expected at least 4",
        ),
    ];
    for (tail, text) in cases {
        place.refused(&[&head[..], tail, &["--out", "new.json"]].concat(), &[text]);
    }
}

#[test]
fn designs() {
    let place = place();
    let head = ["design", "--model", "model.json", "--healthy", "one.csv"];
    let cases: [(&[&str], &[&str]); 25] = [
        (
            &["--poles", "1.2"],
            &["--poles: output `y`", "modulus below 1, found 1.2"],
        ),
        (&["--poles", "-1"], &["modulus below 1, found -1"]),
        (&["--poles", "1"], &["modulus below 1, found 1"]),
        (&["--poles", "nan"], &["modulus below 1, found NaN"]),
        (&["--poles", "y=1"], &["modulus below 1, found 1"]),
        (
            &["--poles", "0.1,0.2,0.3"],
            &["`y` has 2 states: expected 1 or 2 poles, found 3"],
        ),
        (
            &["--poles", "z=0.5"],
            &["--poles: expected an output of model.json (y), found `z`"],
        ),
        (
            &["--exceedance", "0"],
            &["--exceedance: expected a share above 0 and below 1, found 0"],
        ),
        (
            &["--exceedance", "1e-6"],
            &["--exceedance 0.000001", "at least 1000000 samples"],
        ),
        (
            &["--margin", "-2"],
            &["--margin: expected a finite factor above 0, found -2"],
        ),
        (
            &["--consecutive", "0"],
            &["--consecutive: expected at least 1 sample, found 0"],
        ),
        (
            &["--consecutive", "60"],
            &["one.csv: output `y`: healthy residual 0: expected at least 300"],
        ),
        (
            &["--arl0", "24"],
            &["--arl0: expected a positive time such as 24h", "found `24`"],
        ),
        (
            &["--arl0", "-1h"],
            &["--arl0: expected a positive time", "found `-1h`"],
        ),
        (
            &["--arl0", "24h"],
            &[
                "--arl0 24h",
                "needs at least 72 h of healthy running, found 0.0",
            ],
        ),
        (
            &["--window", "20"],
            &["--window: expected with the statistic moving-average or glr or chi2 or variance or"],
        ),
        (
            &["--statistic", "cusum", "--window", "20"],
            &["or whiteness, found cusum"],
        ),
        (
            &["--statistic", "chi2", "--window", "100000"],
            &["--window: window: expected 1 to 65536 samples, found 100000"],
        ),
        (
            &["--statistic", "cusum", "--allowance", "-0.5"],
            &["--allowance: allowance: expected a finite number not below 0, found -0.5"],
        ),
        (
            &["--statistic", "glr", "--sizes", "2"],
            &["--sizes: expected two numbers such as 1e-4:1e-2, found `2`"],
        ),
        (
            &["--statistic", "glr", "--sizes", "2:1"],
            &["--sizes: sizes: expected 0 < smallest <= largest, both finite, found 2 and 1"],
        ),
        (
            &["--waveform", "step"],
            &["--waveform: expected with the statistic glr, found threshold"],
        ),
        (
            &["--generator", "kalman", "--poles", "0.5"],
            &["--poles: expected with --generator observer, found kalman"],
        ),
        (
            &["--statistic", "mean"],
            &["--statistic", "possible values"],
        ),
        (
            &["--margin", "2", "--arl0", "24h"],
            &["expected one of --exceedance or --margin or --arl0, found --margin and --arl0"],
        ),
    ];
    for (tail, texts) in cases {
        place.refused(&[&head[..], tail, &["--out", "bank.json"]].concat(), texts);
    }
}

#[test]
fn complex_poles() {
    let place = place();
    let head = ["design", "--model", "model.json", "--healthy", "one.csv"];
    let cases = [
        (
            "0.9+0.1i,0.9-0.2i",
            "--poles: output `y`: pole 0, 0.9+0.1i: expected its complex conjugate in the list too, \
             found none",
        ),
        (
            "0.5+0.1i",
            "--poles: output `y`: pole 0, 0.5+0.1i: expected its complex conjugate in the list too, \
             found none",
        ),
        (
            "0.9+0.9i,0.9-0.9i",
            "--poles: output `y`: pole 0: expected a modulus below 1, found 1.2727922061357855",
        ),
        (
            "y=0.1,y=0.2,y=0.3",
            "--poles: output `y` has 2 states: expected 1 or 2 poles, found 3",
        ),
        (
            "fast",
            "--poles: expected a number such as 0.7 or 0.9+0.1i, or TAG=NUMBER, found `fast`",
        ),
        (
            "0.9+0.1",
            "--poles: expected a number such as 0.7 or 0.9+0.1i, or TAG=NUMBER, found `0.9+0.1`",
        ),
    ];
    for (poles, text) in cases {
        let tail = ["--poles", poles, "--out", "bank.json"];
        // After the warning that the record has no times.
        let line = format!("gtfdi: {text}\n");
        place.refused(&[&head[..], &tail].concat(), &[&line]);
    }
}

/// A faulty record of [`second_order_csv`]: a step of the output at sample 100.
fn faulty_csv(seed: u64) -> String {
    let mut rows = second_order(200, seed);
    for row in &mut rows[100..] {
        row[1] += 1.0;
    }
    csv("u,y", &rows)
}

#[test]
fn searches_for_poles() {
    let place = place();
    let head = ["design", "--model", "model.json", "--healthy", "one.csv"];
    let cases: [(&[&str], &str); 14] = [
        (
            &["--generator", "kalman", "--faulty", "faulty.csv"],
            "--faulty: expected with --generator observer, found kalman, which chooses its own poles",
        ),
        (
            &["--poles", "0.5,0.4", "--faulty", "faulty.csv"],
            "--poles: expected none with --faulty, which chooses them, found 0.5,0.4",
        ),
        (
            &["--criterion", "paper"],
            "--criterion: expected with --faulty, found no faulty record",
        ),
        (
            &["--search", "evolution"],
            "--search: expected with --faulty, found no faulty record",
        ),
        (
            &["--radius", "0.9"],
            "--radius: expected with --faulty, found no faulty record",
        ),
        (
            &["--search-skip", "9"],
            "--search-skip: expected with --faulty, found no faulty record",
        ),
        (
            &["--search-seed", "9"],
            "--search-seed: expected with --faulty, found no faulty record",
        ),
        (
            &["--validate-faulty", "faulty.csv"],
            "--validate-faulty: expected with --faulty, found no faulty record",
        ),
        (
            &["--radius", "1", "--faulty", "faulty.csv"],
            "--radius: expected a radius above 0 and below 1, found 1",
        ),
        (
            &["--radius", "-0.5", "--faulty", "faulty.csv"],
            "--radius: expected a radius above 0 and below 1, found -0.5",
        ),
        (
            &["--radius", "nan", "--faulty", "faulty.csv"],
            "--radius: expected a radius above 0 and below 1, found NaN",
        ),
        (
            &["--faulty", "faulty.csv,short.csv"],
            "--faulty: expected no more records than --healthy, which pair with them, 1, found 2",
        ),
        (
            &["--faulty", "faulty.csv", "--validate-faulty", "short.csv"],
            "--validate-faulty: expected no more records than are left of --healthy after those that \
             pair with --faulty, 0, found 1",
        ),
        (
            &[
                "--healthy",
                "one.csv",
                "--criterion",
                "paper",
                "--faulty",
                "faulty.csv,faulty.csv",
            ],
            "--criterion: expected fault-energy with 2 records of --faulty, found paper, which is \
             that of 1",
        ),
    ];
    for (tail, text) in cases {
        place.refused_exactly(&[&head[..], tail, &["--out", "bank.json"]].concat(), text);
    }
    let words = [
        ("--criterion", "[possible values: fault-energy, paper]"),
        ("--search", "[possible values: descent, evolution]"),
    ];
    for (option, text) in words {
        let tail = ["--faulty", "faulty.csv", option, "best", "--out", "b.json"];
        place.refused(&[&head[..], &tail].concat(), &[text]);
    }
}

#[test]
fn records_of_searches_for_poles() {
    let place = place();
    place.write("faulty.csv", faulty_csv(1));
    place.write("short.csv", second_order_csv(150, 1));
    let head = ["design", "--model", "model.json", "--healthy", "one.csv"];
    let cases: [(&[&str], &str); 4] = [
        (
            &["--faulty", "short.csv"],
            "short.csv: output `y`: training pair 0, samples of the faulty record: expected 200, \
             found 150",
        ),
        (
            &["--faulty", "faulty.csv", "--search-skip", "195"],
            "one.csv: output `y`: training pair 0: expected at least 206 samples, found 200",
        ),
        (
            &["--faulty", "faulty.csv", "--rows", "0:90"],
            "--faulty: expected a record in which a channel of the model differs from the healthy \
             one, found none",
        ),
        (&["--faulty", "none.csv"], "none.csv: there is no such file"),
    ];
    for (tail, text) in cases {
        let line = format!("gtfdi: {text}\n");
        place.refused(
            &[&head[..], tail, &["--out", "bank.json"]].concat(),
            &[&line],
        );
    }
    // The bank must not be written over a record that is read.
    place.refused_exactly(
        &[
            &head[..],
            &["--faulty", "faulty.csv", "--out", "faulty.csv"],
        ]
        .concat(),
        "--out: expected another file than those that are read, found faulty.csv",
    );
}

#[test]
fn simulations() {
    let place = Place::new();
    let cases: [(&str, &str, &str); 13] = [
        (
            "--seconds",
            "0",
            "--seconds: expected between 0.08 and 160000 s, found 0",
        ),
        (
            "--seconds",
            "-5",
            "--seconds: expected between 0.08 and 160000 s, found -5",
        ),
        (
            "--seconds",
            "NaN",
            "--seconds: expected between 0.08 and 160000 s, found NaN",
        ),
        (
            "--seconds",
            "1e300",
            "--seconds: expected between 0.08 and 160000 s, found 1",
        ),
        (
            "--seconds",
            "inf",
            "--seconds: expected between 0.08 and 160000 s, found inf",
        ),
        ("--seconds", "long", "--seconds"),
        (
            "--substeps",
            "23",
            "--substeps: expected 24 to 10000 a sample (a step of at most 0.003400 s), found 23",
        ),
        (
            "--substeps",
            "0",
            "--substeps: expected 1 to 10000 a sample (a step of at most 0.080000 s), found 0",
        ),
        (
            "--profile",
            "wild",
            "--profile: expected one of steady, gentle, standard, lively, wide, found `wild`",
        ),
        (
            "--map-set",
            "flat",
            "--map-set: expected one of paper, axial, found `flat`",
        ),
        (
            "--noise",
            "loud",
            "--noise: expected one of none, low, table8, table8_variance, tables4_5, found `loud`",
        ),
        (
            "--variant",
            "jet",
            "--variant: expected one of prototype, cogeneration, found `jet`",
        ),
        ("--seed", "18446744073709551615", "--seed"),
    ];
    for (option, value, text) in cases {
        let args = ["simulate", option, value, "--out", "run.mcap", "--json"];
        place.refused(&args, &[text]);
    }
    let tail = ["--profile", "wide", "--out", "run.mcap"];
    place.refused(
        &[&["simulate", "--variant", "cogeneration"], &tail[..]].concat(),
        &[
            "--profile: expected one of steady, standard, load_reduction_igv, load_reduction_fuel, \
           found `wide`",
        ],
    );
}

#[test]
fn required_options_are_named_with_an_example() {
    let place = place();
    let cases: [(&[&str], &str); 10] = [
        (&["simulate"], "--out: required, for example --out run.mcap"),
        (&["identify"], "DATA: required"),
        (&["identify", "one.csv"], "--outputs: required"),
        (&["design"], "--model: required"),
        (&["design", "--model", "model.json"], "--out: required"),
        (
            &["design", "--model", "model.json", "--out", "b.json"],
            "--healthy: required",
        ),
        (&["detect"], "DATA: required"),
        (&["detect", "one.csv"], "--bank: required"),
        (&["log", "info"], "FILE.mcap"),
        (&["reproduce", "--seed", "one"], "--seed"),
    ];
    for (args, text) in cases {
        place.refused(args, &[text]);
    }
}
