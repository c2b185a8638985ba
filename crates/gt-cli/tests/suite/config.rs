//! Flag over environment over file over default.

use crate::place::{Place, Ran, array};
use crate::signal::second_order_csv;

/// What `--print-config` says of `verb`.
fn printed(place: &Place, args: &[&str], environment: &[(&str, &str)]) -> toml::Table {
    let mut command = place.command(&[args, &["--print-config"]].concat());
    let ran = Ran::of(command.envs(environment.iter().copied()));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let whole: toml::Table = toml::from_str(&ran.stdout).expect("TOML");
    assert_eq!(whole.len(), 1);
    whole[args[0]].as_table().expect("a section").clone()
}

#[test]
fn a_flag_wins_over_environment_file_and_default() {
    let place = Place::new();
    place.write(
        "c.toml",
        "[simulate]\nseconds = 3.0\nseed = 30\n\n[detect]\ntopic = \"/x\"\n",
    );
    let base = ["simulate"];
    let file = ["simulate", "--config", "c.toml"];
    let flag = ["simulate", "--config", "c.toml", "--seed", "50"];
    let environment = [("GTFDI_SEED", "40")];
    for (args, environment, seed) in [
        (&base[..], &[][..], 1),
        (&file, &[], 30),
        (&file, &environment, 40),
        (&flag, &environment, 50),
    ] {
        let table = printed(&place, args, environment);
        assert_eq!(table["seed"].as_integer(), Some(seed));
    }
    let table = printed(&place, &flag, &environment);
    assert_eq!(table["seconds"].as_float(), Some(3.0));
    assert_eq!(table["profile"].as_str(), Some("standard"));
    // The file may be named by the environment too, and is used, not only printed.
    let mut command = place.command(&["simulate", "--out", "s.mcap", "--json"]);
    let ran = Ran::of(
        command
            .env("GTFDI_CONFIG", "c.toml")
            .env("GTFDI_SECONDS", "0.8"),
    );
    assert_eq!(crate::place::object(&ran.stdout)["samples"], 10);
    let info = place.json(&["log", "info", "s.mcap"]);
    let run = array(&info, "/metadata")
        .iter()
        .find(|m| m["name"] == "gtfdi.run");
    assert_eq!(run.expect("gtfdi.run")["values"]["seed"], "30");
}

#[test]
fn what_is_printed_gives_the_same_again() {
    let place = Place::new();
    let lines: [&[&str]; 8] = [
        &[
            "simulate",
            "--seconds",
            "2.5",
            "--noise",
            "none",
            "--faults",
            "f.toml",
        ],
        &[
            "identify",
            "d.csv",
            "--inputs",
            "u*,v",
            "--outputs",
            "y",
            "--na",
            "2",
            "--nb",
            "2,3",
            "--nk",
            "0",
            "--train",
            "0:10",
            "--time",
            "clock",
            "--sample-time",
            "0.1",
            "--topic",
            "/t",
            "--structure",
            "diag",
            "--out",
            "m.json",
        ],
        &["identify", "--order", "1..12"],
        &[
            "identify",
            "a.csv",
            "b.csv",
            "--ridge",
            "1e-3",
            "--missing",
            "break",
            "--centre",
            "zero",
            "--equation-errors",
            "correlated",
            "--solver",
            "automatic",
            "--plot",
            "o.svg",
        ],
        &[
            "identify",
            "a.csv",
            "--holdout",
            "c.csv",
            "--stable",
            "--dc-gain",
            "y:u=+,y:v=-2..3",
            "--refine",
            "output-error",
        ],
        &[
            "design",
            "--model",
            "m.json",
            "--healthy",
            "a.csv,b.csv",
            "--healthy",
            "c.csv",
            "--poles",
            "0.5,t3=0.3",
            "--arl0",
            "24h",
            "--rows",
            "5:50",
        ],
        &[
            "detect",
            "d.csv",
            "--bank",
            "b.json",
            "--fail-on",
            "alarm",
            "--sample-time",
            "180",
        ],
        &["reproduce", "--seed", "9"],
    ];
    for line in lines {
        prints_the_same_again(&place, line);
    }
}

#[test]
fn what_is_printed_of_a_search_gives_the_same_again() {
    let line = "design --healthy a.csv,b.csv --faulty c.csv --validate-faulty d.csv --radius 0.9 \
                --criterion paper --search evolution --search-skip 10 --search-seed 5";
    let line: Vec<&str> = line.split_whitespace().collect();
    prints_the_same_again(&Place::new(), &line);
}

fn prints_the_same_again(place: &Place, line: &[&str]) {
    let first = place.done(&[line, &["--print-config"]].concat());
    place.write("c.toml", &first);
    let again = [line[0], "--config", "c.toml", "--print-config"];
    assert_eq!(place.done(&again), first);
}

/// `--stable` has a value only after an equals sign, so that a record may follow it.
#[test]
fn the_radius_of_stable_may_be_left_out() {
    let place = Place::new();
    place.write("c.toml", "[identify]\nstable = 0.8\n");
    let radius = |args: &[&str], environment: &[(&str, &str)]| {
        let table = printed(&place, &[&["identify"], args].concat(), environment);
        let data = table.get("data").map(ToString::to_string);
        (table["stable"].as_float(), data)
    };
    let data = Some("[\"d.csv\"]".to_owned());
    assert_eq!(
        radius(&["--stable", "d.csv"], &[]),
        (Some(0.999), data.clone())
    );
    assert_eq!(radius(&["--stable=0.9", "d.csv"], &[]), (Some(0.9), data));
    assert_eq!(radius(&["--config", "c.toml"], &[]), (Some(0.8), None));
    let environment = [("GTFDI_STABLE", "0.7")];
    assert_eq!(
        radius(&["--config", "c.toml"], &environment),
        (Some(0.7), None)
    );
}

#[test]
fn a_file_runs_a_verb() {
    let place = Place::new();
    place.write("d.csv", second_order_csv(100, 1));
    place.write(
        "c.toml",
        "[identify]\ndata = \"d.csv\"\ninputs = [\"u\"]\noutputs = [\"y\"]\norder = \"2\"\n\
         sample-time = 0.5\ntrain = \"0:60\"\nvalidate = \"60:100\"\n",
    );
    let report = place.json(&["identify", "--config", "c.toml"]);
    assert_eq!(report["sample_time_s"], 0.5);
    assert_eq!(report["validation_rows"], serde_json::json!([60, 100]));
}

#[test]
fn mistakes_in_a_file_are_named() {
    let place = Place::new();
    place.write("d.csv", second_order_csv(100, 1));
    let cases: [(&str, &[&str]); 14] = [
        ("[identify]\nordr = \"2\"\n", &["unknown field `ordr`"]),
        (
            "[identify]\nsample_time = 1.0\n",
            &["unknown field `sample_time`"],
        ),
        ("[detect]\nbnak = \"b.json\"\n", &["unknown field `bnak`"]),
        (
            "[design]\nsample-tim = 2.0\n",
            &["unknown field `sample-tim`"],
        ),
        (
            "[simulate]\n\nsed = 2\n",
            &["line 3", "unknown field `sed`"],
        ),
        ("[reproduce]\nfast = true\n", &["unknown field `fast`"]),
        ("[fly]\n", &["line 1", "unknown field `fly`", "`identify`"]),
        ("order = \"2\"\n", &["line 1", "unknown field `order`"]),
        (
            "identify = 3\n",
            &["line 1", "expected struct IdentifyArgs"],
        ),
        (
            "[identify]\nstructure = \"odd\"\n",
            &["unknown variant `odd`", "`canonical`"],
        ),
        ("[identify]\nna = -1\n", &["-1"]),
        (
            "[identify]\ntrain = \"9:2\"\n",
            &["expected rows A:B with A < B", "found `9:2`"],
        ),
        ("[identify]\nsample-time = \"fast\"\n", &["fast"]),
        ("[identify\n", &["line 1"]),
    ];
    let args = [
        "identify",
        "d.csv",
        "--outputs",
        "y",
        "--config",
        "c.toml",
        "--out",
        "m.json",
    ];
    for (text, texts) in cases {
        place.write("c.toml", text);
        place.refused(&args, &[&["c.toml: "], texts].concat());
    }
    place.write("c.toml", b"\xff\xfe");
    place.refused(&args, &["c.toml: "]);
    let args = ["simulate", "--config", "none.toml", "--out", "s.mcap"];
    place.refused(&args, &["none.toml: "]);
}

#[test]
fn how_files_are_read_can_stand_in_a_file() {
    let place = Place::new();
    for verb in ["identify", "design", "detect"] {
        let text = format!("[{verb}]\ntime = \"clock\"\nsample-time = 2.0\ntopic = \"/x\"\n");
        place.write("c.toml", text);
        let table = printed(&place, &[verb, "--config", "c.toml"], &[]);
        assert_eq!(table["time"].as_str(), Some("clock"));
        assert_eq!(table["sample-time"].as_float(), Some(2.0));
        assert_eq!(table["topic"].as_str(), Some("/x"));
        let environment = [("GTFDI_SAMPLE_TIME", "3")];
        let table = printed(&place, &[verb, "--config", "c.toml"], &environment);
        assert_eq!(table["sample-time"].as_float(), Some(3.0));
    }
}

/// One of `--order`, `--indices` and `--na` with `--nb`; one of `--exceedance`, `--margin` and
/// `--arl0`: a higher layer's choice puts the lower layers' out of force.
#[test]
fn a_choice_in_a_higher_layer_replaces_the_lower_one() {
    let place = Place::new();
    place.write(
        "c.toml",
        "[identify]\nna = 2\nnb = [3]\n\n[design]\nmargin = 2.0\nconsecutive = 3\n",
    );
    let keys = |args: &[&str], environment: &[(&str, &str)]| {
        let args = [args, &["--config", "c.toml"]].concat();
        let table = printed(&place, &args, environment);
        let all = [
            "order",
            "na",
            "nb",
            "indices",
            "exceedance",
            "margin",
            "arl0",
        ];
        all.into_iter()
            .filter(|key| table.contains_key(*key))
            .collect::<Vec<_>>()
    };
    assert_eq!(keys(&["identify"], &[]), ["na", "nb"]);
    assert_eq!(keys(&["identify", "--na", "5"], &[]), ["na", "nb"]);
    assert_eq!(keys(&["identify", "--order", "5"], &[]), ["order"]);
    let environment = [("GTFDI_ORDER", "5")];
    assert_eq!(keys(&["identify"], &environment), ["order"]);
    assert_eq!(
        keys(&["identify", "--indices", "5"], &environment),
        ["indices"]
    );
    assert_eq!(keys(&["design"], &[]), ["margin"]);
    assert_eq!(keys(&["design", "--arl0", "24h"], &[]), ["arl0"]);
    let environment = [("GTFDI_MARGIN", "3")];
    assert_eq!(
        keys(&["design", "--exceedance", "0.01"], &environment),
        ["exceedance"]
    );
    // Two choices in one layer are a mistake of that layer.
    place.write("c.toml", "[design]\nmargin = 2.0\narl0 = \"1h\"\n");
    place.refused(
        &["design", "--config", "c.toml", "--exceedance", "0.1"],
        &["c.toml: expected one of", "found --margin and --arl0"],
    );
    let mut command = place.command(&["identify"]);
    command.envs([("GTFDI_ORDER", "2"), ("GTFDI_NA", "2")]);
    place.ends_badly(
        2,
        &mut command,
        &["environment: expected one of", "--order"],
    );
}

#[test]
fn the_variables_of_other_verbs_are_ignored() {
    let place = Place::new();
    place.done(&["simulate", "--seconds", "1", "--out", "s.mcap"]);
    let mut command = place.command(&["log", "info", "s.mcap", "--json"]);
    command.envs([
        ("GTFDI_OUT", "none/x.json"),
        ("GTFDI_SEED", "x"),
        ("GTFDI_ROWS", "x"),
    ]);
    let ran = Ran::of(&mut command);
    assert_eq!((ran.code, ran.stderr.as_str()), (0, ""));
    assert_eq!(crate::place::object(&ran.stdout)["messages"], 27);
}
