//! Records that cannot be used.

use crate::place::Place;
use crate::signal::{Noise, arx, csv, second_order, second_order_csv};

const LAGS: [&str; 4] = ["--na", "2", "--nb", "2"];

/// Identification of `name` is refused with `texts`, and leaves no file behind.
fn refused(place: &Place, name: &str, texts: &[&str]) {
    let head = ["identify", name, "--inputs", "u", "--outputs", "y"];
    let tail = ["--out", "model.json", "--json"];
    let texts = [&[name], texts].concat();
    place.refused(&[&head[..], &LAGS, &tail].concat(), &texts);
}

/// The record with its line `line` (from 1) replaced.
fn with_line(line: usize, text: &str) -> String {
    let record = second_order_csv(50, 1);
    let lines: Vec<&str> = record.lines().collect();
    let mut lines = lines;
    lines[line - 1] = text;
    lines.join("\n") + "\n"
}

#[test]
fn cells_and_rows_are_named_by_line_and_column() {
    let place = Place::new();
    let cases = [
        (
            "1,abc",
            "line 7, column `y`: expected a finite number, found `abc`",
        ),
        (
            "NaN,2",
            "line 7, column `u`: expected a finite number, found `NaN`",
        ),
        (
            "1,inf",
            "line 7, column `y`: expected a finite number, found `inf`",
        ),
        (
            "1,",
            "line 7, column `y`: expected a finite number, found an empty cell",
        ),
        ("1,2,3", "line 7: expected 2 fields, found 3"),
        ("1", "line 7: expected 2 fields, found 1"),
        ("", "line 7: expected 2 fields, found 0"),
    ];
    for (text, message) in cases {
        place.write("bad.csv", with_line(7, text));
        refused(&place, "bad.csv", &[message]);
    }
    // Only the rows that are asked for have to be sound.
    place.write("bad.csv", with_line(7, "1,abc"));
    let head = ["identify", "bad.csv", "--inputs", "u", "--outputs", "y"];
    let args = [&head[..], &LAGS, &["--train", "10:40"]].concat();
    place.json(&args);
}

#[test]
fn files_without_data_are_refused() {
    let place = Place::new();
    let cases: [(&str, &[u8], &str); 6] = [
        (
            "empty.csv",
            b"",
            "expected a header row of tags, found an empty file",
        ),
        (
            "head.csv",
            b"u,y\n",
            "expected data rows below the header, found none",
        ),
        (
            "bare.csv",
            b"1.5,2.5\n2,3\n",
            "line 1: expected a header row of tags",
        ),
        (
            "binary.csv",
            b"u,y\n\xff\xfe\x00\x01",
            "line 2: expected UTF-8 text, found the byte 0xff",
        ),
        (
            "twice.csv",
            b"u,y,u\n1,2,3\n",
            "expected every tag once, found `u` twice",
        ),
        ("text.mcap", b"u,y\n1,2\n", "expected an MCAP file"),
    ];
    for (name, bytes, message) in cases {
        place.write(name, bytes);
        refused(&place, name, &[message]);
    }
    refused(&place, "none.csv", &["there is no such file"]);
    place.write("record.txt", "u,y\n1,2\n");
    refused(
        &place,
        "record.txt",
        &["expected a file that ends in .csv, .parquet or .mcap, found `.txt`"],
    );
    std::fs::create_dir(place.path("folder.csv")).expect("a folder");
    refused(
        &place,
        "folder.csv",
        &["expected a file, found a directory"],
    );
}

#[test]
fn records_that_cannot_be_fitted_are_refused() {
    let place = Place::new();
    place.write("short.csv", second_order_csv(6, 1));
    // Two lags, four parameters and one row to spare.
    refused(
        &place,
        "short.csv",
        &["samples: expected at least 7", "found 6"],
    );
    for (column, tag) in ["u", "y"].into_iter().enumerate() {
        let mut rows = second_order(50, 1);
        for row in &mut rows {
            row[column] = 4.5;
        }
        place.write("flat.csv", csv("u,y", &rows));
        let message = format!("channel `{tag}`: expected a signal that varies, found 4.5");
        refused(&place, "flat.csv", &[&message]);
    }
    let head = ["identify", "short.csv", "--inputs", "u"];
    let args = [&head[..], &["--outputs", "z"], &LAGS].concat();
    place.refused(
        &args,
        &["short.csv: expected a column `z`, found", "u", "y"],
    );
    let args = [&head[..], &["--outputs", "z*"], &LAGS].concat();
    place.refused(&args, &["short.csv: expected a column that matches `z*`"]);
    let args = [&head[..], &["--outputs", "y,u"], &LAGS].concat();
    place.refused(
        &args,
        &["short.csv: `u` is selected as input and as output"],
    );
    let args = [&head[..], &["--outputs", "y,y"], &LAGS].concat();
    place.refused(&args, &["short.csv: `y` is selected twice as output"]);
}

/// Columns `u`, then what `more` makes of it and of other noise, then a first-order `y`.
fn dependent(place: &Place, header: &str, more: &dyn Fn(usize, f64, f64) -> Vec<f64>) {
    let mut other = Noise::new(77);
    let rows = arx(&[0.5], &[1.0], 0.1, 200, 3);
    let rows = rows.iter().enumerate();
    let rows: Vec<Vec<f64>> = rows
        .map(|(t, row)| {
            let mut cells = more(t, row[0], other.next());
            cells.push(row[1]);
            cells
        })
        .collect();
    place.write("bad.csv", csv(header, &rows));
}

#[test]
fn regressors_that_depend_on_each_other_are_named() {
    let place = Place::new();
    let refused = |inputs: &str, options: &[&str], texts: &[&str]| {
        let head = ["identify", "bad.csv", "--inputs", inputs, "--outputs", "y"];
        let out = ["--out", "model.json", "--json"];
        let texts = [
            &[
                "bad.csv: output `y`: expected independent regressors (condition at most \
                        1e12), found condition ",
            ],
            texts,
        ]
        .concat();
        place.refused(&[&head[..], options, &out].concat(), &texts);
    };
    let ridge = "; leave one of them out, or hold them with --ridge\n";
    dependent(&place, "u,v,y", &|_, u, _| vec![u, 2.0 * u + 1.0]);
    let twice = ": `v` at lag 1 is 2.000000 times `u` at lag 1";
    let with_ridge = format!("{twice}{ridge}");
    refused("u,v", &["--order", "1"], &[&with_ridge]);
    refused("u,v", &["--order", "1..4"], &[&with_ridge]);
    // No ridge where there is none to be had.
    refused(
        "u,v",
        &["--order", "1", "--stable"],
        &[&format!("{twice}; leave one of them out\n")],
    );
    // Equal but for rounding: beyond 1e12, though not to the last digit.
    dependent(&place, "u,v,y", &|_, u, v| vec![u, u + 1e-13 * v]);
    refused(
        "u,v",
        &["--order", "1"],
        &[&format!(
            ": `v` at lag 1 is 1.000000 times `u` at lag 1{ridge}"
        )],
    );
    // 1e-9 apart is accepted: the condition is near 1e9.
    dependent(&place, "u,v,y", &|_, u, v| vec![u, u + 1e-9 * v]);
    let head = [
        "identify",
        "bad.csv",
        "--inputs",
        "u,v",
        "--outputs",
        "y",
        "--order",
        "1",
    ];
    place.done(&head);
    dependent(&place, "u,v,w,y", &|_, u, v| vec![u, v, u + v]);
    refused(
        "u,v,w",
        &["--order", "1"],
        &[&format!(
            ": `w` at lag 1 follows from `u` at lag 1, `v` at lag 1{ridge}"
        )],
    );
    // A square wave of period 2: u(t - 2) = -u(t - 1).
    dependent(&place, "u,y", &|t, _, _| {
        vec![if t % 2 == 0 { 1.0 } else { -1.0 }]
    });
    refused(
        "u",
        &["--order", "2"],
        &[
            "`u` at lag 2 follows from its own other lags or stands still in the rows used: the \
           channel does not excite so many lags; use fewer lags, rows in which it moves (--train), \
           or hold it with --ridge\n",
        ],
    );
}

#[test]
fn what_to_do_about_a_record_is_said() {
    let place = Place::new();
    place.write("short.csv", second_order_csv(6, 1));
    refused(
        &place,
        "short.csv",
        &["found 6; use more rows or fewer lags\n"],
    );
    place.write("flat.csv", csv("u,y", &vec![vec![1.0, 2.0]; 50]));
    refused(
        &place,
        "flat.csv",
        &[
            "found 1 in every row used; leave the channel out, or choose rows in which it moves \
           (--train)\n",
        ],
    );
    // A dropout in a log is NaN.
    place.write(
        "dropout.toml",
        "[[fault]]\nsensor = \"t3\"\nmode = \"dropout\"\nonset_s = 10.0\n",
    );
    let simulate = [
        "simulate",
        "--seconds",
        "40",
        "--faults",
        "dropout.toml",
        "--out",
        "run.mcap",
    ];
    place.done(&simulate);
    let head = [
        "identify",
        "run.mcap",
        "--inputs",
        "a_v,M_f",
        "--outputs",
        "t3",
        "--order",
        "1",
    ];
    place.refused(
        &head,
        &[
            "run.mcap: ",
            "`t3`",
            "NaN",
            "; --missing break fits around it\n",
        ],
    );
    let missing = ["--missing", "break", "--nk", "1,0", "--out", "model.json"];
    place.done(&[&head[..], &missing].concat());
    let model: serde_json::Value = serde_json::from_slice(&place.read("model.json")).expect("JSON");
    // 125 samples before the dropout at 10 s, one of them without a past.
    assert_eq!(model["model"]["rows_used"], 124);
}

#[test]
fn times_are_named_by_line() {
    let place = Place::new();
    let timed = |times: &dyn Fn(usize) -> f64| {
        let rows: Vec<Vec<f64>> = second_order(50, 1)
            .iter()
            .enumerate()
            .map(|(k, row)| vec![times(k), row[0], row[1]])
            .collect();
        csv("time,u,y", &rows)
    };
    let cases: [(&dyn Fn(usize) -> f64, &str); 3] = [
        (
            &|k| if k == 4 { 3.0 } else { k as f64 },
            "line 6: expected a time after 3 s, found 3 s",
        ),
        (
            &|k| if k == 4 { 1.5 } else { k as f64 },
            "line 6: expected a time after 3 s, found 1.5 s",
        ),
        (
            &|k| if k < 20 { k as f64 } else { k as f64 + 7.0 },
            "line 22: expected a step of 1 s",
        ),
    ];
    for (times, message) in cases {
        place.write("timed.csv", timed(times));
        refused(&place, "timed.csv", &[message]);
        // The sample time in place of the times makes the record usable.
        let head = ["identify", "timed.csv", "--inputs", "u", "--outputs", "y"];
        let report = place.json(&[&head[..], &LAGS, &["--sample-time", "2"]].concat());
        assert_eq!(report["sample_time_s"], 2.0);
    }
    let head = ["identify", "timed.csv", "--inputs", "u", "--outputs", "y"];
    let args = [&head[..], &LAGS, &["--time", "clock"]].concat();
    place.refused(&args, &["timed.csv: expected a column `clock`"]);
    for bad in ["0", "-1", "NaN", "inf"] {
        let args = [&head[..], &LAGS, &["--sample-time", bad]].concat();
        place.refused(
            &args,
            &["expected a positive, finite sample time in seconds"],
        );
    }
}

#[test]
fn logs_that_are_cut_or_broken_are_refused() {
    let place = Place::new();
    place.done(&["simulate", "--seconds", "4", "--out", "run.mcap"]);
    let bytes = place.read("run.mcap");
    place.write("half.mcap", &bytes[..bytes.len() / 2]);
    let mut broken = bytes.clone();
    broken[bytes.len() / 2] ^= 0xff;
    place.write("broken.mcap", broken);
    let outputs = ["--inputs", "a_v,M_f", "--outputs", "q_c", "--order", "2"];
    for (name, message) in [
        ("half.mcap", "half.mcap: the log is cut off"),
        ("broken.mcap", "broken.mcap: expected a sound MCAP file"),
    ] {
        let args = [&["identify", name][..], &outputs, &["--out", "m.json"]].concat();
        place.refused(&args, &[message]);
        place.refused(&["log", "info", name], &[message]);
    }
    let args = [&["identify", "run.mcap"][..], &outputs].concat();
    place.refused(
        &[&args[..], &["--topic", "/none"]].concat(),
        &["run.mcap: expected a topic `/none`, found", "/plant/truth"],
    );
    place.refused(
        &[&args[..], &["--time", "t"]].concat(),
        &["run.mcap: an MCAP log carries its own time"],
    );
}
