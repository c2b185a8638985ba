//! `gtfdi simulate`.

use serde_json::Value;

use crate::place::{Place, Ran, array, number, object};

fn topic<'a>(info: &'a Value, name: &str) -> &'a Value {
    let mut topics = array(info, "/topics").iter();
    topics
        .find(|topic| topic["topic"] == name)
        .unwrap_or_else(|| panic!("no topic {name} in {info}"))
}

#[test]
fn a_minute_has_750_samples_on_both_topics() {
    let place = Place::new();
    let args = [
        "simulate",
        "--seconds",
        "60",
        "--seed",
        "3",
        "--out",
        "s.mcap",
    ];
    let report = place.json(&args);
    assert_eq!(report["samples"], 750);
    assert_eq!(report["sample_time_s"], 0.08);
    // 28 a sample.
    assert_eq!(report["substep_s"], 0.08 / 28.0);
    assert!(number(&report, "/real_time_factor") > 0.0);
    assert!(array(&report, "/warnings").is_empty());

    let info = place.json(&["log", "info", "s.mcap"]);
    for (name, fields) in [("/plant/truth", 6 + 28 + 3), ("/plant/measured", 6 + 28)] {
        let topic = topic(&info, name);
        assert_eq!(topic["messages"], 750);
        assert_eq!(array(topic, "/fields").len(), fields, "{topic}");
        // t = 0 .. (N - 1) Ts
        assert_eq!(topic["first_s"], 0.0);
        assert!((number(topic, "/last_s") - 749.0 * 0.08).abs() < 1e-9);
    }
    // One that says that all samples are good.
    assert_eq!(topic(&info, "/plant/quality")["messages"], 1);
    assert_eq!(info["messages"], 1501);
    let metadata = array(&info, "/metadata");
    let run = metadata.iter().find(|record| record["name"] == "gtfdi.run");
    assert_eq!(run.expect("gtfdi.run")["values"]["seed"], "3");
    assert!(!String::from_utf8_lossy(&place.read("s.mcap")).contains("s.mcap"));

    let text = place.done(&["log", "info", "s.mcap"]);
    assert!(text.contains("/plant/measured"), "{text}");
    assert!(!place.path("s.mcap.part").exists());
}

#[test]
fn the_seed_alone_decides_the_bytes() {
    let place = Place::new();
    std::fs::create_dir(place.path("folder")).expect("a folder");
    let run = |out: &str, threads: &str, tail: &[&str]| {
        let args = [
            "simulate",
            "--seconds",
            "8",
            "--noise",
            "table8",
            "--out",
            out,
        ];
        let mut command = place.command(&[&args[..], tail].concat());
        let ran = Ran::of(command.env("RAYON_NUM_THREADS", threads));
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        place.read(out)
    };
    let first = run("a.mcap", "1", &["--seed", "3"]);
    assert!(first == run("folder/other.mcap", "2", &["--seed", "3"]));
    assert!(
        first == run("a.mcap", "2", &["--seed", "3", "--json"]),
        "over an old file"
    );
    assert!(first != run("b.mcap", "1", &["--seed", "4"]));
    assert!(first != run("c.mcap", "1", &["--seed", "3", "--run-index", "1"]));
}

#[test]
fn faults_are_logged_as_truth() {
    let place = Place::new();
    place.write(
        "faults.toml",
        "[[fault]]\ncase = \"thermocouple_drift\"\nonset_s = 2.0\nrate_percent_per_h = 36.0\n\
         \n[[fault]]\ncase = \"turbine_damage\"\nonset_s = 1.0\nrate_percent_per_h = 5.0\n\
         limit_percent = 1.0\n",
    );
    let args = [
        "simulate",
        "--seconds",
        "4",
        "--faults",
        "faults.toml",
        "--out",
        "f.mcap",
    ];
    place.json(&args);
    let info = place.json(&["log", "info", "f.mcap"]);
    let faults = topic(&info, "/plant/faults");
    assert_eq!(faults["messages"], 50);
    let names: Vec<&Value> = array(faults, "/fields")
        .iter()
        .map(|f| &f["name"])
        .collect();
    let expected = ["thermocouple_drift", "turbine_damage"];
    let active = expected.map(|name| format!("{name}_active"));
    assert_eq!(names, [expected[0], expected[1], &active[0], &active[1]]);
}

#[test]
fn a_shorter_step_is_reported() {
    let place = Place::new();
    let args = [
        "simulate",
        "--seconds",
        "0.8",
        "--substeps",
        "80",
        "--out",
        "s.mcap",
    ];
    let report = place.json(&args);
    assert_eq!(
        (&report["samples"], &report["substep_s"]),
        (&10.into(), &0.001.into())
    );
    let ran = place.run(&[
        "simulate",
        "--seconds",
        "0.08",
        "--out",
        "one.mcap",
        "--json",
    ]);
    assert_eq!(object(&ran.stdout)["samples"], 1);
}

#[test]
fn faults_of_sensors_and_actuators_are_logged_with_names_of_their_own() {
    let place = Place::new();
    let bias =
        "[[fault]]\nsensor = \"t3\"\nmode = \"bias\"\nonset_s = 1.0\nstep = { size = 2.0 }\n";
    let lost = "[[fault]]\nsensor = \"a_v\"\nmode = \"dropout\"\nonset_s = 3.2\n";
    let stuck = "[[fault]]\nactuator = \"M_f\"\nmode = \"stuck\"\nonset_s = 2.0\nend_s = 3.0\n";
    place.write("faults.toml", [bias, lost, stuck, bias].concat());
    let args = [
        "simulate",
        "--seconds",
        "4",
        "--noise",
        "tables4_5",
        "--faults",
        "faults.toml",
        "--out",
        "f.mcap",
    ];
    place.json(&args);
    let info = place.json(&["log", "info", "f.mcap"]);
    let faults = topic(&info, "/plant/faults");
    let names = ["t3_bias", "a_v_dropout", "M_f_actuator_stuck", "t3_bias_2"];
    let found: Vec<&Value> = array(faults, "/fields")
        .iter()
        .map(|f| &f["name"])
        .take(names.len())
        .collect();
    assert_eq!(found, names);
    // A sample that is lost is no sample: nothing is identified from it.
    let identify = ["identify", "f.mcap", "--inputs", "a_v", "--outputs", "t3"];
    let tail = ["--order", "1", "--out", "model.json"];
    place.refused(&[&identify[..], &tail].concat(), &["f.mcap", "a_v"]);
}
