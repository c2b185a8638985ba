//! `gtfdi config`: files that are written, checked and described.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::json_schema::errors;
use crate::place::{Place, array};

/// Every kind with a sound file of it.
const KINDS: [(&str, &str, &str); 8] = [
    (
        "config",
        "a configuration file (--config)",
        "[simulate]\nseconds = 2.0\n\n[log-export]\ntags = [\"t*\"]\n",
    ),
    (
        "scenario",
        "a scenario (simulate --scenario)",
        "variant = \"cogeneration\"\nduration_s = 8.0\nnoise = \"low\"\n\
         [[faults]]\nactuator = \"IGV\"\nmode = \"stuck\"\nonset_s = 1.0\nstep = { size = 1.0 }\n",
    ),
    (
        "faults",
        "a file of simulated faults (simulate --faults)",
        "[[fault]]\ncase = \"thermocouple_drift\"\nonset_s = 60.0\nrate_percent_per_h = 5.0\n",
    ),
    (
        "fault-descriptions",
        "a file of described faults (design --faults)",
        "[[fault]]\nname = \"thermocouple\"\nunit = \"K\"\nboth_signs = true\nchanges = { t3 = 1.0 }\n",
    ),
    (
        "map",
        "a table of speed lines (simulate --compressor-map, --turbine-map)",
        MAP,
    ),
    (
        "tags",
        "a map of tags (--tags)",
        "[tags.\"10FT1234.PV\"]\nname = \"fuel_flow\"\nunit = \"kg/h\"\nto = \"kg/s\"\n",
    ),
    (
        "campaign",
        "a campaign",
        "seed = 1\nruns = 10\n[record]\nduration_s = 60.0\nonset_s = [20.0, 30.0]\n\
         [[faults]]\ncase = 2\nsize = { uniform = [0.1, 0.2] }\n",
    ),
    (
        "serve",
        "a monitoring service (serve --config)",
        "state_dir = \"state\"\n[http]\nlisten = \"127.0.0.1:8471\"\n[[machine]]\nname = \"gt1\"\n\
         detector = \"bank.json\"\n[mqtt]\nhost = \"localhost\"\n",
    ),
];

const MAP: &str = "kind = \"compressor\"
[[line]]
speed = 0.94
pressure_ratio = [7.26, 8.825, 10.39]
flow = [15.39, 14.75, 13.98]
efficiency = [0.829, 0.837, 0.829]
[[line]]
speed = 1.0
pressure_ratio = [8.173, 9.966, 11.759]
flow = [16.99, 16.29, 15.43]
efficiency = [0.831, 0.839, 0.831]
";

fn schema(place: &Place, kind: &str) -> Value {
    serde_json::from_str(&place.done(&["config", "schema", kind])).expect("JSON")
}

fn value(text: &str) -> Value {
    let table: toml::Table = toml::from_str(text).expect("TOML");
    serde_json::to_value(table).expect("JSON")
}

fn sections(place: &Place) -> Vec<String> {
    // Not as other reports are read: its text says what a NaN does.
    let report: Value =
        serde_json::from_str(&place.done(&["config", "init", "--json"])).expect("JSON");
    let names = array(&report, "/sections").iter();
    names
        .map(|name| name.as_str().expect("a name").to_owned())
        .collect()
}

/// The file that is written changes nothing: with it each verb has the options that it has without.
#[test]
fn the_written_file_has_the_defaults() {
    let place = Place::new();
    let written = place.done(&["config", "init", "--out", "c.toml"]);
    let sections = sections(&place);
    assert_eq!(written, format!("c.toml: {}\n", sections.join(", ")));
    assert_eq!(sections.len(), 10);
    for section in &sections {
        let words: Vec<&str> = section.split('-').collect();
        let bare = place.done(&[&words[..], &["--print-config"]].concat());
        let with = place.done(&[&words[..], &["--print-config", "--config", "c.toml"]].concat());
        assert_eq!(with, bare, "{section}");
        let alone = place.done(&["config", "init", section]);
        assert!(alone.contains(&format!("\n[{section}]\n")), "{alone}");
        assert_eq!(alone.matches("\n[").count(), 1, "{alone}");
    }
    let sound = "c.toml: a configuration file (--config), sound\n";
    assert_eq!(place.done(&["config", "check", "c.toml"]), sound);
    // What is there is not overwritten.
    place.refused_exactly(
        &["config", "init", "detect", "--out", "c.toml"],
        "--out: expected a file that is not there yet, found c.toml",
    );
    place.refused(
        &["config", "init", "fly"],
        &["invalid value 'fly'", "simulate"],
    );
}

/// Every option of the help stands in the file, and what it says of one without a default is of a
/// type that is read.
#[test]
fn the_written_file_has_every_option() {
    let place = Place::new();
    let schema = schema(&place, "config");
    for section in sections(&place) {
        let words: Vec<&str> = section.split('-').collect();
        let help = place.done(&[&words[..], &["--help"]].concat());
        let is_global = |flag: &str| {
            [
                "json",
                "progress",
                "config",
                "print-config",
                "help",
                "version",
            ]
            .contains(&flag)
        };
        let flags: BTreeSet<&str> = help
            .lines()
            .filter_map(|line| line.strip_prefix("      --"))
            .map(|line| line.split([' ', '[', '=']).next().unwrap_or_default())
            .filter(|flag| !is_global(flag))
            .collect();
        let text = place.done(&["config", "init", &section]);
        let uncommented: String = text
            .lines()
            .map(|line| match line.strip_prefix("# ") {
                Some(option) if is_option(option) => format!("{option}\n"),
                _ => format!("{line}\n"),
            })
            .collect();
        let whole = value(&uncommented);
        let keys = whole[&section].as_object().expect("a section");
        let missing: Vec<_> = flags
            .iter()
            .filter(|flag| !keys.contains_key(**flag))
            .collect();
        assert!(missing.is_empty(), "{section}: {missing:?}");
        // The flags, and arguments without a name.
        assert!(keys.len() <= flags.len() + 2, "{section}: {keys:?}");
        let errors = errors(&schema, &whole);
        assert!(errors.is_empty(), "{section}: {errors:?}");
    }
}

/// Whether a line is `key = value`.
fn is_option(line: &str) -> bool {
    line.split_once(" = ").is_some_and(|(key, _)| {
        !key.is_empty()
            && key
                .chars()
                .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
    }) && toml::from_str::<toml::Table>(line).is_ok()
}

#[test]
fn every_kind_is_recognised_and_its_schema_takes_it() {
    let place = Place::new();
    for (kind, title, text) in KINDS {
        place.write("f.toml", text);
        let sound = format!("f.toml: {title}, sound\n");
        assert_eq!(place.done(&["config", "check", "f.toml"]), sound);
        let report = place.json(&["config", "check", "f.toml"]);
        assert_eq!(
            (&report["kind"], &report["valid"]),
            (&kind.into(), &true.into())
        );
        for (other, ..) in KINDS {
            let found = errors(&schema(&place, other), &value(text));
            assert_eq!(
                found.is_empty(),
                kind == other,
                "the schema of {other} and a file of {kind}"
            );
        }
    }
}

/// All files of the repository's examples and of the README are sound, by the schema too.
#[test]
fn the_examples_are_sound() {
    let place = Place::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut files = Vec::new();
    for entry in fs::read_dir(root.join("examples/campaigns")).expect("examples") {
        files.push(fs::read_to_string(entry.expect("an entry").path()).expect("text"));
    }
    let readme = fs::read_to_string(root.join("README.md")).expect("README.md");
    for block in readme.split("```toml\n").skip(1) {
        files.push(block.split("```").next().expect("a block").to_owned());
    }
    for block in readme.split(".toml <<'EOF'\n").skip(1) {
        files.push(block.split("EOF\n").next().expect("a file").to_owned());
    }
    assert!(files.len() >= 10, "{} files", files.len());
    for text in files {
        place.write("f.toml", &text);
        let report = place.json(&["config", "check", "f.toml"]);
        let kind = report["kind"].as_str().expect("a kind");
        let errors = errors(&schema(&place, kind), &value(&text));
        assert!(errors.is_empty(), "{kind}: {errors:?}\n{text}");
    }
}

/// `FIRST|LAST`: the first line and how the last ones begin.
#[test]
fn what_is_wrong_is_said_with_its_place_and_the_nearest_key() {
    let place = Place::new();
    let parse = "TOML parse error at line";
    let cases = [
        (
            "[simulate]\nsecond = 2.0\n".to_owned(),
            format!("a configuration file (--config): {parse} 2, column 1|unknown field `second`, expected one of"),
            "nearest known key: `seconds`",
        ),
        (
            "[identify]\nsample_time = 2.0\n".to_owned(),
            format!("a configuration file (--config): {parse} 1, column 1|unknown field `sample_time`"),
            "nearest known key: `sample-time`",
        ),
        (
            "[identify]\nstructure = \"diagonal\"\n".to_owned(),
            format!("a configuration file (--config): {parse} 2, column 13|unknown variant `diagonal`"),
            "nearest known value: `diag`",
        ),
        (
            "[design]\nmargin = \"wide\"\n".to_owned(),
            format!("a configuration file (--config): {parse} 2, column 10|invalid type: string \"wide\", expected f64"),
            "",
        ),
        (
            "[design]\nmargin = 1.2\narl0 = \"24h\"\n".to_owned(),
            "a configuration file (--config): [design]: expected one of --exceedance or --margin or --arl0, found --margin and --arl0".to_owned(),
            "",
        ),
        (
            "[[fault]]\ncase = \"thermocouple_drift\"\nonset = 3.0\nrate_percent_per_h = 5.0\n".to_owned(),
            format!("a file of simulated faults (simulate --faults): {parse} 3, column 1|unknown field `onset`, expected one of"),
            "nearest known key: `onset_s`",
        ),
        (
            "[[fault]]\nname = \"t\"\nchanges = {}\n".to_owned(),
            "a file of described faults (design --faults): fault `t`: expected `changes`, `actuator` or a `pair` of records, found none of them".to_owned(),
            "",
        ),
        (
            "[tags.a]\nname = \"b\"\nscale = 0.0\n".to_owned(),
            "a map of tags (--tags): tag `a`: scale: expected another number than 0".to_owned(),
            "",
        ),
        (
            MAP.replace("0.94", "1.1"),
            "a table of speed lines (simulate --compressor-map, --turbine-map): ".to_owned(),
            "",
        ),
        (
            KINDS[6].2.replace("runs = 10", "runs = 0"),
            "a campaign: runs: expected".to_owned(),
            "",
        ),
        (
            KINDS[7].2.replace("127.0.0.1", "0.0.0.0"),
            "a monitoring service (serve --config): http.tokens_file: expected a file".to_owned(),
            "",
        ),
        (
            "variant = \"cogeneration\"\nduration_s = -1.0\n".to_owned(),
            "a scenario (simulate --scenario): duration: expected".to_owned(),
            "",
        ),
    ];
    for (text, expected, near) in cases {
        place.write("f.toml", &text);
        place.refused(&["config", "check", "f.toml"], &[near]);
        let found = place.run(&["config", "check", "f.toml"]).stderr;
        let expected = format!("gtfdi: f.toml: expected {expected}");
        let (first, last) = expected.split_once('|').unwrap_or((&expected, ""));
        assert!(
            found.starts_with(first) && found.contains(last),
            "expected `{first}` and `{last}`, found\n{found}"
        );
    }
    // A verb that reads the file says the same.
    place.write("c.toml", "[simulate]\nsed = 2\n");
    place.refused(
        &["simulate", "--config", "c.toml", "--out", "s.mcap"],
        &["c.toml: ", "line 2", "\nnearest known key: `seed`"],
    );
}

#[test]
fn files_of_no_kind_and_of_two_are_refused() {
    let place = Place::new();
    place.write("f.toml", "colour = \"red\"\n");
    place.refused(
        &["config", "check", "f.toml"],
        &[
            "f.toml: expected the keys of a configuration file (--config), a scenario",
            ", found `colour`",
        ],
    );
    place.write("f.toml", "");
    place.refused(&["config", "check", "f.toml"], &[", found none"]);
    place.write("f.toml", "[[fault]]\n");
    place.refused(
        &["config", "check", "f.toml"],
        &[
            "expected a file of one kind, found the keys of",
            "say which with --kind",
        ],
    );
    place.refused(
        &["config", "check", "f.toml", "--kind", "fault-descriptions"],
        &["line 1", "missing field `name`"],
    );
    place.write("f.toml", b"\xff\xfe");
    place.refused(
        &["config", "check", "f.toml"],
        &["f.toml: stream did not contain valid UTF-8"],
    );
    place.refused(
        &["config", "check", "none.toml"],
        &["none.toml: No such file"],
    );
    place.write("f.toml", "[simulate\n");
    place.refused(
        &["config", "check", "f.toml"],
        &["f.toml: TOML parse error at line 1"],
    );
    place.refused(
        &["config", "check", "f.toml", "--kind", "x"],
        &["invalid value 'x'", "campaign"],
    );
}

/// Files cut anywhere are an answer.
#[test]
fn a_file_that_is_cut_off_is_sound_or_refused() {
    let place = Place::new();
    for (_, _, text) in KINDS {
        for end in (0..text.len()).step_by(13) {
            place.write("f.toml", &text[..end]);
            let ran = place.run(&["config", "check", "f.toml"]);
            assert!(matches!(ran.code, 0 | 2), "{}: {}", ran.code, ran.stderr);
            assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
        }
    }
}

/// A schema says what a key is in words.
#[test]
fn schemas_have_descriptions() {
    let place = Place::new();
    for (kind, ..) in KINDS {
        let schema = schema(&place, kind);
        assert_eq!(
            schema["$schema"], "https://json-schema.org/draft/2020-12/schema",
            "{kind}"
        );
        let properties = schema["properties"].as_object().expect("properties");
        assert!(!properties.is_empty(), "{kind}");
    }
    let schema = schema(&place, "config");
    let about = schema.pointer("/$defs/IdentifyArgs/properties/ridge/description");
    let about = about.and_then(Value::as_str).expect("a description");
    assert!(about.starts_with("Weight of a penalty"), "{about}");
}
