//! Where results are written, and where not.

use crate::place::Place;
use crate::signal::second_order_csv;

const IDENTIFY: [&str; 8] = [
    "identify",
    "one.csv",
    "--inputs",
    "u",
    "--outputs",
    "y",
    "--order",
    "2",
];
const DESIGN: [&str; 5] = ["design", "--model", "model.json", "--healthy", "one.csv"];

/// A folder with a record, its model and its bank.
fn place() -> Place {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    place.done(&[&IDENTIFY[..], &["--out", "model.json"]].concat());
    place.done(&[&DESIGN[..], &["--out", "bank.json"]].concat());
    place
}

#[test]
fn outputs_that_cannot_be_written_fail_before_any_work() {
    let place = place();
    std::fs::create_dir(place.path("folder")).expect("a folder");
    place.write("file", "");
    let verbs: [&[&str]; 4] = [
        &["simulate", "--seconds", "1"],
        &IDENTIFY,
        &DESIGN,
        &["detect", "one.csv", "--bank", "bank.json"],
    ];
    for verb in verbs {
        for (out, text) in [
            (
                "none/out.json",
                "none/out.json: expected the folder none, found none",
            ),
            (
                "folder",
                "folder: expected a file to write, found a directory",
            ),
            (
                "file/out.json",
                "file/out.json: expected the folder file, found none",
            ),
        ] {
            let args = [verb, &["--out", out, "--json"]].concat();
            place.ends_badly(1, &mut place.command(&args), &[text]);
        }
    }
    let args = ["reproduce", "--out", "file"];
    place.ends_badly(
        1,
        &mut place.command(&args),
        &["file: expected a folder, found a file"],
    );
}

#[test]
fn outputs_never_replace_inputs() {
    let place = place();
    let detect = ["detect", "one.csv", "--bank", "bank.json"];
    let cases: [(&[&str], &str); 5] = [
        (&IDENTIFY, "one.csv"),
        (&DESIGN, "model.json"),
        (&DESIGN, "one.csv"),
        (&detect, "bank.json"),
        (&detect, "./one.csv"),
    ];
    for (verb, out) in cases {
        let args = [verb, &["--out", out]].concat();
        place.refused(
            &args,
            &["--out: expected another file than those that are read"],
        );
    }
}

/// Ends a verb by Ctrl-C while it writes `out`, in whose place an older file stands.
#[cfg(unix)]
fn interrupted(place: &Place, args: &[&str], out: &str) {
    use std::time::{Duration, Instant};

    place.write(out, "older");
    let mut child = place
        .command(args)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the binary starts");
    let part = place.path(&format!("{out}.part"));
    let start = Instant::now();
    while !part.exists() && start.elapsed() < Duration::from_secs(300) {
        let ended = child.try_wait().expect("a state");
        assert!(ended.is_none(), "{args:?} ended before it wrote");
        std::thread::sleep(Duration::from_millis(1));
    }
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(sent.expect("kill").success());
    let ended = child.wait().expect("an end");
    let found = place.read(out);
    if ended.success() {
        // It was quicker: then the file is whole.
        place.done(&["log", "verify", out]);
    } else {
        assert_eq!(found, b"older", "{args:?}: half of a file under its name");
    }
    // What is left goes by another name, and the same command ends well.
    place.done(args);
    place.done(&["log", "verify", out]);
    assert!(!part.exists());
}

/// Ctrl-C leaves nothing half-written under a final name.
#[cfg(unix)]
#[test]
fn ctrl_c_leaves_the_older_file() {
    let place = place();
    interrupted(
        &place,
        &["simulate", "--seconds", "800", "--out", "s.mcap"],
        "s.mcap",
    );
    place.write("long.csv", second_order_csv(60_000, 2));
    interrupted(
        &place,
        &[
            "detect",
            "long.csv",
            "--bank",
            "bank.json",
            "--sample-time",
            "1",
            "--out",
            "v.mcap",
        ],
        "v.mcap",
    );
}

/// Files that may not grow stand for a disk that is full.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_file() {
    let place = place();
    place.done(&["simulate", "--seconds", "60", "--out", "s.mcap"]);
    place.write("long.csv", second_order_csv(20_000, 2));
    for line in [
        "simulate --seconds 60 --out t.mcap",
        "detect long.csv --bank bank.json --sample-time 1 --out t.mcap",
        "log export s.mcap --out t.csv",
        "log export s.mcap --out t.parquet",
        "log recover s.mcap --out t.mcap",
    ] {
        let mut shell = std::process::Command::new("sh");
        let script = format!("trap '' XFSZ; ulimit -f 8; exec \"$0\" {line}");
        shell.args(["-c", &script, env!("CARGO_BIN_EXE_gtfdi")]);
        shell.current_dir(place.path("s.mcap").parent().expect("a folder"));
        place.ends_badly(1, &mut shell, &["gtfdi: t.", "could not write"]);
    }
}
