//! Exports of historians on the way through the verbs, and what `data check` says of them.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::place::Place;
use crate::signal::second_order_csv;

/// The record of a second-order system as a German spreadsheet would save it: semicolons, decimal
/// commas, local times, units, a preamble and Windows-1252.
fn spreadsheet() -> Vec<u8> {
    let mut text = "Anlage 3\r\n\r\nZeit;10FT1;10TT1\r\n;kg/h;\u{b0}C\r\n".to_owned();
    for (k, line) in second_order_csv(400, 1).lines().skip(1).enumerate() {
        let (u, y) = line.split_once(',').expect("two cells");
        let (minute, second) = (k / 60, k % 60);
        let time = format!("01.07.2026 10:{minute:02}:{second:02}");
        writeln!(text, "{time};{u};{y}\r").expect("text");
    }
    let text = text.replace('.', ",").replace("01,07,2026", "01.07.2026");
    text.chars()
        .map(|c| u8::try_from(u32::from(c)).expect("Latin"))
        .collect()
}

const READING: [&str; 8] = [
    "--encoding",
    "windows-1252",
    "--header-line",
    "3",
    "--time",
    "Zeit",
    "--time-zone",
    "Europe/Berlin",
];
const LAGS: [&str; 4] = ["--na", "2", "--nb", "2"];

#[test]
fn a_spreadsheet_gives_the_same_model_as_the_plain_record() {
    let place = Place::new();
    place.write("plain.csv", second_order_csv(400, 1));
    place.write("export.csv", spreadsheet());
    place.write(
        "tags.toml",
        "[tags.10FT1]\nname = \"u\"\n[tags.10TT1]\nname = \"y\"\n",
    );
    let head = |name| ["identify", name, "--inputs", "u", "--outputs", "y"];
    let plain = place.json(&[&head("plain.csv")[..], &LAGS, &["--sample-time", "1"]].concat());
    let tags = ["--tags", "tags.toml"];
    let export = place.json(&[&head("export.csv")[..], &LAGS, &READING, &tags].concat());
    assert_eq!(
        export["outputs"][0]["regression"],
        plain["outputs"][0]["regression"]
    );
    // At its own period the record is not changed by resampling, and the report says so.
    let same = ["--resample", "1"];
    let resampled = place.json(&[&head("export.csv")[..], &LAGS, &READING, &tags, &same].concat());
    assert_eq!(
        resampled["outputs"][0]["regression"],
        plain["outputs"][0]["regression"]
    );
    let report = &resampled["records"][0]["resampled"];
    assert_eq!(report["method"], "mean", "{resampled}");
    assert_eq!(report["tags"][0]["original"], json!(400));
}

#[test]
fn options_of_reading_that_do_not_fit_are_refused() {
    let place = Place::new();
    place.write("a.csv", second_order_csv(50, 1));
    place.write("tags.toml", "[tags.U]\nname = \"v\"\n");
    let head = ["identify", "a.csv", "--inputs", "u", "--outputs", "y"];
    let cases: [(&[&str], &str); 9] = [
        (
            &["--encoding", "klingon"],
            "--encoding: expected a label of the Encoding standard such as utf-8, utf-16le or \
             windows-1252, found `klingon`",
        ),
        (
            &["--time-zone", "Rome"],
            "--time-zone: expected a name of the IANA database such as Europe/Rome, found `Rome`",
        ),
        (
            &["--header-line", "60"],
            "a.csv: --header-line: expected a line of the file, which has 51, found 60",
        ),
        (
            &["--layout", "long"],
            "a.csv: --layout long: expected columns tag, time and value, found u, y",
        ),
        (
            &["--resample", "1"],
            "a.csv: --resample: expected a time column, found none; name it (--time)",
        ),
        (
            &["--resample", "-1"],
            "--resample: expected a positive, finite number of seconds, found -1",
        ),
        (
            &["--resample-method", "hold"],
            "--resample-method: expected with --resample, found without",
        ),
        (
            &["--hold-at-most", "3"],
            "--hold-at-most: expected with --resample, found without",
        ),
        (
            &["--tags", "tags.toml"],
            "tags.toml: tag `U`: expected a tag of a.csv, found none of that name; near are u, y",
        ),
    ];
    for (options, text) in cases {
        let tail = ["--out", "model.json"];
        place.refused(&[&head[..], &LAGS, options, &tail].concat(), &[text]);
    }
    let record = second_order_csv(50, 1);
    place.write("words.csv", format!("{record}Bad,1\n"));
    let head = ["identify", "words.csv", "--inputs", "u", "--outputs", "y"];
    place.refused(
        &[&head[..], &LAGS].concat(),
        &["line 52, column `u`: expected a finite number, found `Bad`, a word for none; --missing \
           break fits around it"],
    );
    place.done(&[&head[..], &LAGS, &["--missing", "break"]].concat());
}

#[test]
fn detect_reads_words_and_gaps_as_missing_samples() {
    let place = Place::new();
    place.write("healthy.csv", second_order_csv(1500, 1));
    let head = ["identify", "healthy.csv", "--inputs", "u", "--outputs", "y"];
    let model = ["--sample-time", "1", "--out", "model.json"];
    place.json(&[&head[..], &LAGS, &model].concat());
    place.json(&[
        "design",
        "--model",
        "model.json",
        "--healthy",
        "healthy.csv",
        "--sample-time",
        "1",
        "--out",
        "bank.json",
    ]);
    // A bank is designed from what is before and after a missing sample.
    let holed =
        second_order_csv(1500, 1)
            .lines()
            .enumerate()
            .fold(String::new(), |text, (k, line)| {
                let (u, _) = line.split_once(',').expect("two cells");
                let line = if k == 700 {
                    format!("{u},Bad")
                } else {
                    line.to_owned()
                };
                text + &line + "\n"
            });
    place.write("holed.csv", holed);
    let design = ["design", "--model", "model.json", "--healthy", "holed.csv"];
    let more = [
        "--sample-time",
        "1",
        "--missing",
        "break",
        "--out",
        "holed.json",
        "--json",
    ];
    let text = place.done(&[&design[..], &more].concat());
    let report: Value = serde_json::from_str(&text).expect("one object");
    assert_eq!(report["healthy_records"], 2);
    let mut text = "time,u,y\n".to_owned();
    for (k, line) in second_order_csv(300, 2).lines().skip(1).enumerate() {
        let time = if k < 200 { k } else { k + 30 };
        let (u, y) = line.split_once(',').expect("two cells");
        let y = if k == 100 { "I/O Timeout" } else { y };
        writeln!(text, "{time},{u},{y}").expect("text");
    }
    place.write("today.csv", text);
    let detect = ["detect", "--bank", "bank.json", "today.csv"];
    place.refused(
        &detect,
        &[
            "line 102, column `y`: expected a finite number, found `I/O Timeout`, a word for none; \
           --missing break fits around it",
        ],
    );
    // The warnings tell of NaN, which `json` takes for a number that is none.
    let text = place.done(&[&detect[..], &["--missing", "break", "--json"]].concat());
    let report: Value = serde_json::from_str(&text).expect("one object");
    assert_eq!(report["samples"], 330);
    let judged = report["outputs"][0]["judged_samples"]
        .as_u64()
        .expect("a number");
    assert!(judged < 299 && judged > 200, "{judged}");
}

#[test]
fn data_check_names_what_is_there_and_what_is_wrong() {
    let place = Place::new();
    place.write("export.csv", spreadsheet());
    let report = place.json(&["data", "check", "export.csv", "--time", "Zeit"]);
    assert_eq!(report["schema_version"], 1);
    assert_eq!(
        (&report["layout"], &report["decimal"]),
        (&json!("wide"), &json!("comma"))
    );
    assert_eq!(report["encoding"], "windows-1252");
    assert_eq!(
        (&report["rows"], &report["unit_line"]),
        (&json!(400), &json!(4))
    );
    assert_eq!(report["time"]["period_s"], 1.0);
    let mended: Vec<&str> = report["damages"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|damage| damage["mended_by"].as_str().expect("an option"))
        .collect();
    assert_eq!(mended, ["--encoding", "--header-line"]);
    let text = place.done(&[&["data", "check", "export.csv"][..], &READING].concat());
    assert!(
        text.contains("nothing that identify would refuse"),
        "{text}"
    );
    place.write("none.xlsx", "x");
    place.refused(
        &["data", "check", "none.xlsx"],
        &["none.xlsx: expected a file that ends in .csv, .parquet or .mcap, found `.xlsx`"],
    );
    place.refused(
        &["data", "check"],
        &["DATA: required, for example gtfdi data check export.csv"],
    );
}

/// What a record's tags look like is printed with how sure that is and as options, and no more than
/// that; the same in a simulated log, whose governor moves the fuel.
#[test]
fn roles_are_suggested_with_how_sure_they_are() {
    let place = Place::new();
    let record = second_order_csv(400, 1).replacen("u,y", "a,b", 1);
    place.write("a.csv", record);
    let found = place.json(&["data", "check", "a.csv"]);
    let input = &found["suggested_inputs"][0];
    assert_eq!(input["tag"], "a");
    assert_eq!(input["reasons"][0]["kind"], "leads");
    assert_eq!(found["suggested_outputs"][0]["tag"], "b");
    assert_eq!(found["suggested_outputs"][0]["confidence"], "possible");
    let text = place.done(&["data", "check", "a.csv"]);
    for part in [
        "roles that tags look like: a suggestion;",
        "--inputs 'a' --outputs 'b'",
        "which tags lead: 2 tags on 398 samples with 2 lags",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    place.done(&["simulate", "--seconds", "60", "--out", "run.mcap"]);
    let text = place.done(&["data", "check", "run.mcap"]);
    assert!(
        text.starts_with("run.mcap: 750 rows of topic /plant/measured\n"),
        "{text}"
    );
    assert!(text.contains("named `ref`; leads"), "{text}");
}

/// Samples on a line between readings are interpolated, held ones stale: the log of verdicts says so.
#[test]
fn a_log_says_which_samples_resampling_made() {
    let place = Place::new();
    place.write("plain.csv", second_order_csv(400, 1));
    let head = ["identify", "plain.csv", "--inputs", "u", "--outputs", "y"];
    let model = ["--sample-time", "1", "--out", "model.json"];
    place.done(&[&head[..], &LAGS, &model].concat());
    let design = ["design", "--model", "model.json", "--healthy", "plain.csv"];
    let bank = ["--margin", "1.5", "--out", "bank.json"];
    place.done(&[&design[..], &bank].concat());
    let mut slow = "time,u,y\n".to_owned();
    for (k, row) in second_order_csv(20, 2).lines().skip(1).enumerate() {
        writeln!(slow, "{},{row}", 2 * k).expect("text");
    }
    place.write("slow.csv", slow);
    for (method, quality) in [("linear", 4.0), ("hold", 3.0)] {
        let detect = [
            "detect",
            "slow.csv",
            "--bank",
            "bank.json",
            "--out",
            "v.mcap",
        ];
        let resample = ["--resample", "1", "--resample-method", method];
        let limit = ["--hold-at-most", "2"];
        place.done(&[&detect[..], &resample, &limit].concat());
        let selection = gt_log::Selection {
            outputs: vec!["*".to_owned()],
            topic: Some("/plant/quality".to_owned()),
            ..gt_log::Selection::default()
        };
        let read = gt_log::read_dataset(&place.path("v.mcap"), &selection).expect("a log");
        let found: Vec<f64> = read.dataset.y().row(0).iter().copied().collect();
        // Readings at even seconds from 0 to 38, and what was made between them.
        let expected: Vec<f64> = (0..39)
            .map(|k| if k % 2 == 0 { 0.0 } else { quality })
            .collect();
        assert_eq!(found, expected, "{method}");
    }
}
