//! `gtfdi simulate` on tabulated maps.

use crate::place::{Place, array, number, object};
use crate::scenario::{simulate, warnings};

/// The axial compressor as a table of three lines.
pub const MAP: &str = r#"
kind = "compressor"
extrapolation = "flag"

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

[[line]]
speed = 1.06
pressure_ratio = [9.154, 11.192, 13.231]
flow = [18.65, 17.88, 16.94]
efficiency = [0.829, 0.837, 0.829]
"#;

#[test]
fn leaving_a_map_is_said_and_ends_the_run_where_the_map_wants_that() {
    let place = Place::new();
    // Ten percent of speed: the most that a profile may ask for.
    place.write(
        "far.toml",
        "duration_s = 60.0\n[profile]\nspeed_amplitude_fraction = 0.1\nvalve_amplitude_deg = 4.0\n",
    );
    let report = place.json(&simulate(&["--scenario", "far.toml"]));
    let warned = warnings(&report);
    assert!(
        warned
            .iter()
            .any(|text| text.starts_with("the compressor ran outside its map in ")),
        "{warned:?}"
    );

    place.write("map.toml", MAP.replace("flag", "refuse"));
    let args = [
        "--scenario",
        "far.toml",
        "--compressor-map",
        "map.toml",
        "--json",
    ];
    let ran = place.run(&simulate(&args));
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    let report = object(&ran.stdout);
    let samples = report["samples"].as_u64().expect("a number");
    assert!((1..750).contains(&samples), "{samples}");
    let ended = report["ended"].as_str().expect("a reason");
    assert!(
        ended.starts_with("compressor map at ") && ended.contains("line: expected a speed between"),
        "{ended}"
    );
    assert!(
        ran.stderr.ends_with(&format!(
            "gtfdi: the run ended after {samples} of 750 samples, because the plant left the range \
             in which the model means something: {ended}; run.mcap holds what there is\n"
        )),
        "{}",
        ran.stderr
    );
    // The log is whole, and says so itself.
    let info = place.json(&["log", "info", "run.mcap"]);
    let messages = |name: &str| {
        let mut topics = array(&info, "/topics").iter();
        let topic = topics.find(|topic| topic["topic"] == name).expect(name);
        topic["messages"].as_u64().expect("a number")
    };
    assert_eq!(messages("/plant/measured"), samples);
    // Why it ended is told on a topic too.
    let told = warnings(&report).len() + 1;
    assert_eq!(messages("/log"), u64::try_from(told).expect("a number"));
    assert!((number(&info, "/duration_s") - 0.08 * (samples - 1) as f64).abs() < 1e-9);
    let remarks = array(&info, "/metadata")
        .iter()
        .find(|record| record["name"] == "gtfdi.remarks");
    assert_eq!(remarks.expect("remarks")["values"]["ended"], ended);
    let identify = ["identify", "run.mcap", "--inputs", "a_v", "--outputs", "p7"];
    place.done(
        &[
            &identify[..],
            &["--order", "2", "--nk", "0", "--out", "m.json"],
        ]
        .concat(),
    );
}

#[test]
fn maps_that_are_none_name_their_file() {
    let place = Place::new();
    place.write("turbine.toml", MAP.replace("\"compressor\"", "\"turbine\""));
    place.write("kind.toml", MAP);
    place.write("flow.toml", MAP.replace("16.99", "16.2"));
    place.write("speed.toml", MAP.replace("speed = 1.06", "speed = 0.9"));
    place.write("number.toml", MAP.replace("0.839", "8.39"));
    place.write("text.toml", MAP.replace("0.839", "\"good\""));
    place.write(
        "key.toml",
        MAP.replace("efficiency = [0.831", "efficency = [0.831"),
    );
    place.write(
        "one.toml",
        &MAP[..MAP.find("[[line]]\nspeed = 1.0\n").expect("a line")],
    );
    let cases = [
        (
            "--turbine-map",
            "kind.toml",
            "map of the turbine: expected one of that kind, found one of kind compressor",
        ),
        (
            "--compressor-map",
            "turbine.toml",
            "map line 1 (speed 0.94), flow[1]: expected at least 15.39 (flow does not fall as the \
             expansion ratio rises), found 14.75",
        ),
        (
            "--compressor-map",
            "flow.toml",
            "map line 2 (speed 1), flow[1]: expected below 16.2 (flow falls as the pressure ratio \
             rises; give a choked, upright part a slight slope), found 16.29",
        ),
        (
            "--compressor-map",
            "speed.toml",
            "map line 3, speed: expected above 1 (speeds rise from line to line), found 0.9",
        ),
        (
            "--compressor-map",
            "number.toml",
            "map line 2 (speed 1), efficiency[1]: expected above 0 and at most 1, found 8.39",
        ),
        (
            "--compressor-map",
            "text.toml",
            "TOML parse error at line 15, column 22|invalid type: string \"good\", expected f64",
        ),
        (
            "--compressor-map",
            "key.toml",
            "TOML parse error at line 15, column 1|unknown field `efficency`, expected one of \
             `speed`, `pressure_ratio`, ",
        ),
        (
            "--compressor-map",
            "one.toml",
            "map: expected 2 to 64 speed lines, found 1",
        ),
        (
            "--compressor-map",
            "none.toml",
            "No such file or directory (os error 2)",
        ),
    ];
    for (option, file, text) in cases {
        place.refused_exactly(&simulate(&[option, file]), &format!("{file}: {text}"));
    }
}

#[test]
fn maps_on_which_the_plant_cannot_run_name_their_file() {
    let place = Place::new();
    let fast = MAP
        .replace("speed = 0.94", "speed = 1.04")
        .replace("speed = 1.0\n", "speed = 1.05\n")
        .replace("flag", "refuse");
    place.write("fast.toml", fast);
    let rest = "fast.toml: compressor map at 0 s, slowest line: expected a speed between 1.04 and \
                1.06, found 1";
    place.refused_exactly(&simulate(&["--compressor-map", "fast.toml"]), rest);
    // A machine ten times as large.
    let large = MAP
        .replace("[15.39, 14.75, 13.98]", "[153.9, 147.5, 139.8]")
        .replace("[16.99, 16.29, 15.43]", "[169.9, 162.9, 154.3]")
        .replace("[18.65, 17.88, 16.94]", "[186.5, 178.8, 169.4]");
    place.write("large.toml", large);
    place.refused(
        &simulate(&["--compressor-map", "large.toml"]),
        &["gtfdi: large.toml: trim: expected a largest relative rate below"],
    );
}
