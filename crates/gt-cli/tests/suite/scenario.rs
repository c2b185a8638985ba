//! `gtfdi simulate` with scenario files and variants.

use gt_log::{Selection, read_attachment, read_dataset};
use serde_json::Value;

use crate::document::{Document, Step, commands};
use crate::maps::MAP;
use crate::place::{Place, Ran, array, object};

/// A short scenario that uses everything.
const EVERYTHING: &str = r#"
variant = "cogeneration"
map_set = "axial"
duration_s = 8.0
substeps = 44
seed = 7
run_index = 2

[profile]
fuel_amplitude_fraction = 0.02
fuel_schedule = [[0.0, 0.9], [4.0, 0.88]]

[boundary.temperature_k]
offset = -10.0
rate_per_h = -3.0
sine = { amplitude = 0.3, period_s = 7.0 }
random = { deviation = 0.1, time_constant_s = 3.0 }

[boundary.heating_value_fraction]
offset = 0.01

[disturbance]
heat_release_fraction = { deviation = 0.001, time_constant_s = 1.0 }
torque_n_m = { deviation = 1.0, time_constant_s = 1.0 }

[noise]
level = "table8"

[noise.channels.T_ot]
deviation = 0.7
pole = 0.9
resolution = 0.1

[[faults]]
case = "compressor_fouling"
rate_percent_per_h = 5.0
onset_s = 1.0

[[faults]]
sensor = "P_e"
mode = "spike"
spikes_per_h = 3600.0
onset_s = 2.0
intermittent = { size = 1e4, period_s = 2.0, on_s = 0.8 }

[[faults]]
actuator = "IGV"
mode = "stuck"
onset_s = 3.0
end_s = 5.0
"#;

/// The verb, its output and what else is given.
pub fn simulate<'a>(tail: &[&'a str]) -> Vec<&'a str> {
    [&["simulate", "--out", "run.mcap"], tail].concat()
}

/// The warnings of a report.
pub fn warnings(report: &Value) -> Vec<&str> {
    let texts = array(report, "/warnings").iter();
    texts.map(|text| text.as_str().expect("text")).collect()
}

#[test]
fn the_attached_scenario_gives_the_log_again() {
    let place = Place::new();
    place.write("everything.toml", EVERYTHING);
    place.write("map.toml", MAP);
    let lines: [&[&str]; 4] = [
        &["--seconds", "4"],
        &["--seconds", "4", "--variant", "cogeneration"],
        &["--scenario", "everything.toml"],
        &["--seconds", "4", "--compressor-map", "map.toml"],
    ];
    for line in lines {
        place.done(&simulate(line));
        let log = place.read("run.mcap");
        let config = read_attachment(&place.path("run.mcap"), "config.toml").expect("a log");
        place.write("again.toml", config);
        place.done(&simulate(&["--scenario", "again.toml"]));
        assert!(place.read("run.mcap") == log, "{line:?}");
    }
}

#[test]
fn options_beside_a_scenario_replace_its_fields() {
    let place = Place::new();
    place.write(
        "s.toml",
        "duration_s = 4.0\nseed = 9\nprofile = \"lively\"\n",
    );
    let report = place.json(&simulate(&["--scenario", "s.toml"]));
    assert_eq!(report["samples"], 50);
    assert_eq!(
        (&report["variant"], &report["profile"], &report["ended"]),
        (&"prototype".into(), &"lively".into(), &Value::Null)
    );
    // The defaults of the command line do not: this one is without noise.
    let select = Selection {
        outputs: vec!["*".to_owned()],
        ..Selection::default()
    };
    let read = |topic: &str| {
        let topic = Some(topic.to_owned());
        let select = Selection {
            topic,
            ..select.clone()
        };
        let imported = read_dataset(&place.path("run.mcap"), &select).expect("a log");
        imported.dataset.y().clone()
    };
    assert_eq!(read("/plant/truth").rows(0, 34), read("/plant/measured"));

    let others = ["--seconds", "0.8", "--profile", "wide", "--seed", "3"];
    let report = place.json(&simulate(
        &[&["--scenario", "s.toml"], &others[..]].concat(),
    ));
    assert_eq!(
        (&report["samples"], &report["profile"]),
        (&10.into(), &"wide".into())
    );
    let other = ["--scenario", "s.toml", "--variant", "cogeneration"];
    let report = place.json(&simulate(&other));
    assert_eq!(
        (&report["variant"], &report["profile"]),
        (&"cogeneration".into(), &"standard".into())
    );

    // A scenario that a file or the environment names counts as much.
    place.write("c.toml", "[simulate]\nscenario = \"s.toml\"\n");
    for ran in [
        place.run(&simulate(&["--config", "c.toml", "--json"])),
        Ran::of(
            place
                .command(&simulate(&["--json"]))
                .env("GTFDI_SCENARIO", "s.toml"),
        ),
    ] {
        assert_eq!(object(&ran.stdout)["samples"], 50, "{}", ran.stderr);
    }
    let printed = place.done(&simulate(&["--config", "c.toml", "--print-config"]));
    assert!(!printed.contains("seconds"), "{printed}");
}

#[test]
fn cogeneration_records_seven_inputs_and_31_outputs() {
    let place = Place::new();
    let report = place.json(&simulate(&["--variant", "cogeneration", "--seconds", "4"]));
    assert_eq!(report["variant"], "cogeneration");
    let info = place.json(&["log", "info", "run.mcap"]);
    let fields = |name: &str| {
        let topic = array(&info, "/topics")
            .iter()
            .find(|topic| topic["topic"] == name);
        array(topic.expect(name), "/fields").len()
    };
    assert_eq!(
        (fields("/plant/measured"), fields("/plant/truth")),
        (38, 41)
    );
    let text = place.done(&["log", "info", "run.mcap"]);
    assert!(text.contains("IGV [deg], p1 [Pa], "), "{text}");
    assert!(
        text.contains(", m_ot [kg/s], e_c, e_t, M_fc [kg/s]\n"),
        "{text}"
    );
}

/// Five minutes, two seeds: what a profile is meant for, it does without a remark.
#[test]
fn default_profiles_run_without_a_warning_and_wide_unchokes_the_valve() {
    let place = Place::new();
    for (variant, seed) in [
        ("prototype", "1"),
        ("prototype", "2"),
        ("cogeneration", "1"),
        ("cogeneration", "2"),
    ] {
        let args = [
            "--variant",
            variant,
            "--seconds",
            "300",
            "--seed",
            seed,
            "--json",
        ];
        let ran = place.run(&simulate(&args));
        assert_eq!((ran.code, ran.stderr.as_str()), (0, ""), "{variant} {seed}");
        assert_eq!(warnings(&object(&ran.stdout)), [""; 0], "{variant} {seed}");
    }
    let ran = place.run(&simulate(&[
        "--profile",
        "wide",
        "--seconds",
        "300",
        "--json",
    ]));
    let report = object(&ran.stdout);
    let warned = warnings(&report);
    assert_eq!(warned.len(), 1, "{warned:?}");
    assert!(
        warned[0].starts_with("the pressurising valve was not choked in "),
        "{warned:?}"
    );
    assert_eq!(ran.stderr, format!("gtfdi: warning: {}\n", warned[0]));
    // The log says it too.
    let text = place.done(&["log", "info", "run.mcap"]);
    assert!(
        text.contains(&format!("  warning_1: {}\n", warned[0])),
        "{text}"
    );
}

#[test]
fn the_files_of_the_readme_run_as_printed() {
    let readme = Document::read("README.md");
    let place = Place::new();
    let mut names = Vec::new();
    for (name, text) in readme.files("toml") {
        if name == "drift_campaign.toml" {
            continue; // it has a test of its own
        }
        place.write(name, text);
        names.push(name);
    }
    assert_eq!(names, ["faults.toml", "winter.toml", "map.toml"]);
    let commands: Vec<String> = commands(readme.block_with("sh", "winter.toml"));
    assert_eq!(commands.len(), names.len());
    for (command, name) in commands.into_iter().zip(&names) {
        assert!(command.contains(name), "{command}");
        let report = Step::run(&place, command.clone()).report();
        assert_eq!(report["samples"], 7500, "{command}");
        assert_eq!(warnings(&report), [""; 0], "{command}");
        assert_eq!(report["ended"], Value::Null, "{command}");
    }
    let info = place.json(&["log", "info", "faulty.mcap"]);
    assert!(info.to_string().contains("a_v_actuator_stuck_active"));
}
