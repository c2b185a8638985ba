//! `gtfdi completions` and `gtfdi man`.

use std::process::Command;

use crate::place::{Place, array};

#[test]
fn completions_of_bash_are_a_script_of_bash() {
    let place = Place::new();
    let script = place.done(&["completions", "bash"]);
    assert!(script.contains("--exceedance"), "the options of design");
    place.write("gtfdi.bash", &script);
    match Command::new("bash")
        .arg("-n")
        .arg(place.path("gtfdi.bash"))
        .output()
    {
        Ok(ran) => assert!(
            ran.status.success(),
            "{}",
            String::from_utf8_lossy(&ran.stderr)
        ),
        Err(error) => println!("skipped: no bash: {error}"),
    }
}

#[test]
fn every_shell_has_completions() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = place.done(&["completions", shell]);
        assert!(script.contains("recover"), "{shell}");
    }
    place.refused(&["completions", "cmd"], &["invalid value 'cmd'", "bash"]);
}

#[test]
fn every_verb_has_a_page() {
    let place = Place::new();
    let page = place.done(&["man"]);
    assert!(page.contains(".TH GTFDI 1"), "{page}");
    let report = place.json(&["man", "--out", "man1"]);
    let pages: Vec<&str> = array(&report, "/pages")
        .iter()
        .filter_map(|own| own.as_str())
        .collect();
    for name in [
        "gtfdi.1",
        "gtfdi-simulate.1",
        "gtfdi-log.1",
        "gtfdi-log-recover.1",
    ] {
        assert!(pages.contains(&name), "{pages:?}");
    }
    let files = std::fs::read_dir(place.path("man1"))
        .expect("a folder")
        .count();
    assert_eq!(files, pages.len());
    let page = String::from_utf8(place.read("man1/gtfdi-log-recover.1")).expect("text");
    assert!(page.contains("Example: gtfdi log recover"), "{page}");
    assert!(page.contains("\\-\\-out"), "{page}");
    place.write("file", "");
    let ran = place.run(&["man", "--out", "file"]);
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.starts_with("gtfdi: file: "), "{}", ran.stderr);
}
