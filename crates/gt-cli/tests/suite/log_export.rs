//! `gtfdi log export`: topics as tables.

use crate::place::{Place, array};

#[test]
fn a_topic_becomes_a_table_that_can_be_read_again() {
    let place = Place::new();
    place.done(&["simulate", "--seconds", "16", "--out", "s.mcap"]);
    let report = place.json(&["log", "export", "s.mcap", "--out", "s.csv"]);
    assert_eq!(report["rows"], 200);
    assert_eq!(report["topic"], "/plant/measured");
    assert_eq!(array(&report, "/columns").len(), 34);
    let text = String::from_utf8(place.read("s.csv")).expect("text");
    assert!(text.starts_with("time,"), "{}", &text[..60]);
    let line = text.lines().nth(2).expect("a row");
    assert!(
        line.starts_with("2006-01-18T00:00:00.080000000Z,"),
        "{line}"
    );
    // The model of the table is that of the log.
    let model = |data: &str| {
        let args = [
            "identify",
            data,
            "--inputs",
            "a_v",
            "--outputs",
            "p7",
            "--order",
            "2",
        ];
        place.json(&args)["outputs"].clone()
    };
    assert_eq!(model("s.mcap"), model("s.csv"));
    let args = [
        "log",
        "export",
        "s.mcap",
        "--out",
        "t.csv",
        "--topic",
        "/plant/truth",
    ];
    let some = ["--tags", "e_*,p7", "--rows", "10:12", "--time", "seconds"];
    let printed = place.done(&[&args[..], &some].concat());
    assert_eq!(
        printed,
        "t.csv: 2 rows of time and 3 columns of /plant/truth\n"
    );
    let text = String::from_utf8(place.read("t.csv")).expect("text");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time,e_c,e_t,p7"));
    assert!(
        lines
            .next()
            .is_some_and(|line| line.starts_with("0.800000000,"))
    );
    let report = place.json(&["log", "export", "s.mcap", "--out", "s.parquet"]);
    assert_eq!(report["out"], "s.parquet");
    assert_eq!(&place.read("s.parquet")[..4], b"PAR1");
}

#[test]
fn mistakes_are_named() {
    let place = Place::new();
    place.done(&["simulate", "--seconds", "1", "--out", "s.mcap"]);
    let export = |more: &[&str], text: &str| {
        place.refused_exactly(&[&["log", "export", "s.mcap"], more].concat(), text);
    };
    export(&[], "--out: required, for example --out run.csv");
    export(
        &["--out", "s.txt"],
        "s.txt: expected a file to write that ends in .csv or .parquet",
    );
    export(
        &["--out", "s.csv", "--topic", "/x"],
        "s.mcap: expected a topic `/x`, found /plant/measured, /plant/quality, /plant/truth",
    );
    export(
        &["--out", "s.csv", "--rows", "5:90"],
        "s.mcap: expected rows A:B with 0 <= A < B <= 13, found 5:90 (0-based, half open)",
    );
    export(
        &["--out", "s.mcap"],
        "--out: expected another file than those that are read, found s.mcap",
    );
    place.refused_exactly(
        &["log", "export", "--out", "s.csv"],
        "FILE.mcap: required, for example gtfdi log export run.mcap",
    );
}
