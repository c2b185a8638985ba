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
