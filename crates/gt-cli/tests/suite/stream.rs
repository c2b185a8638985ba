//! Standard output is the result, standard error the rest.

use std::process::Stdio;

use crate::place::{Place, Ran, object};
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

fn place() -> Place {
    let place = Place::new();
    place.write("one.csv", second_order_csv(200, 1));
    place
}

#[test]
fn json_is_one_object_and_warnings_go_to_standard_error() {
    let place = place();
    let ran = place.run(&[&IDENTIFY[..], &["--json"]].concat());
    let report = object(&ran.stdout);
    assert_eq!(report["warnings"].as_array().map(Vec::len), Some(1));
    assert!(
        ran.stderr.starts_with("gtfdi: warning: one.csv: "),
        "{}",
        ran.stderr
    );
    let ran = Ran::of(place.command(&IDENTIFY).env("GTFDI_JSON", "1"));
    assert_eq!(object(&ran.stdout), report);
    let ran = Ran::of(place.command(&IDENTIFY).env("GTFDI_JSON", "0"));
    assert!(ran.stdout.contains("fit prediction %"), "{}", ran.stdout);
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let place = place();
    place.done(&["simulate", "--seconds", "1", "--out", "s.mcap"]);
    let verbs: [&[&str]; 5] = [
        &IDENTIFY,
        &["log", "info", "s.mcap", "--json"],
        &["simulate", "--print-config"],
        &["identify", "--help"],
        &["simulate", "--seconds", "1", "--out", "t.mcap"],
    ];
    for verb in verbs {
        let mut command = place.command(verb);
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let child = command.stdout(writer).stderr(Stdio::piped()).spawn();
        let ended = child.expect("a child").wait_with_output().expect("an end");
        let stderr = String::from_utf8_lossy(&ended.stderr);
        assert!(!stderr.contains("panicked"), "{verb:?}: {stderr}");
        assert_eq!(ended.status.code(), Some(0), "{verb:?}: {stderr}");
    }
    // A refusal keeps its exit code where nobody reads standard error.
    for (verb, code) in [
        (&IDENTIFY[..], 0),
        (&["detect"], 2),
        (&["identify", "--order"], 2),
    ] {
        let mut command = place.command(verb);
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let child = command.stdout(Stdio::null()).stderr(writer).spawn();
        let ended = child.expect("a child").wait().expect("an end");
        assert_eq!(ended.code(), Some(code), "{verb:?}");
    }
}

#[test]
fn nothing_is_coloured_without_a_terminal_or_with_no_color() {
    let place = place();
    for args in [
        &["identify", "--help"][..],
        &["identify", "--ordre"],
        &["--version"],
    ] {
        for (name, value) in [("NO_COLOR", "1"), ("CLICOLOR", "0")] {
            let ran = Ran::of(place.command(args).env(name, value));
            assert!(
                !format!("{}{}", ran.stdout, ran.stderr).contains('\u{1b}'),
                "{args:?}"
            );
        }
    }
    // NO_COLOR wins over a wish for colours, which alone is granted.
    let coloured = |environment: &[(&str, &str)]| {
        let mut command = place.command(&["identify", "--ordre"]);
        command
            .env_remove("NO_COLOR")
            .envs(environment.iter().copied());
        Ran::of(&mut command).stderr.contains('\u{1b}')
    };
    assert!(coloured(&[("CLICOLOR_FORCE", "1")]));
    assert!(!coloured(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]));
}

/// Every verb there is, found by walking through the help texts.
fn verbs(place: &Place) -> Vec<Vec<String>> {
    let mut open = vec![Vec::new()];
    let mut found = Vec::new();
    while let Some(verb) = open.pop() {
        let args: Vec<&str> = verb.iter().map(String::as_str).chain(["--help"]).collect();
        let help = place.done(&args);
        let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1);
        let inner: Vec<&str> = lines
            .take_while(|line| !line.trim().is_empty())
            .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
            .filter_map(|line| line.split_whitespace().next())
            .filter(|name| *name != "help")
            .collect();
        if inner.is_empty() {
            found.push(verb);
        } else {
            let below = |name: &&str| [&verb[..], &[(*name).to_owned()]].concat();
            open.extend(inner.iter().map(below));
        }
    }
    found
}

#[test]
fn help_of_each_verb_shows_an_example() {
    let place = place();
    let verbs = verbs(&place);
    assert!(verbs.len() >= 14, "{verbs:?}");
    for verb in &verbs {
        let args: Vec<&str> = verb.iter().map(String::as_str).chain(["--help"]).collect();
        let help = place.done(&args);
        let example = format!("Example: gtfdi {}", verb.join(" "));
        assert!(help.contains(&example), "{help}");
    }
    let help = place.done(&["--help"]);
    assert!(
        help.contains("Exit codes: 0 done; 1 failed; 2 usage"),
        "{help}"
    );
    let ran = place.run(&["foresee"]);
    assert_eq!((ran.code, ran.stdout.as_str()), (2, ""));
    assert!(
        ran.stderr.contains("unrecognized subcommand"),
        "{}",
        ran.stderr
    );
}

#[test]
fn progress_is_hidden_without_a_terminal() {
    let place = place();
    for mode in ["bar", "none", "json"] {
        let args = [&IDENTIFY[..], &["--sample-time", "1", "--progress", mode]].concat();
        let ran = place.run(&args);
        assert_eq!((ran.code, ran.stderr.as_str()), (0, ""), "{mode}");
    }
}
