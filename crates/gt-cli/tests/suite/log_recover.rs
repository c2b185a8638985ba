//! `gtfdi log recover`: what is left of a damaged log.

use crate::place::{Place, array, number};

fn place() -> Place {
    let place = Place::new();
    place.done(&["simulate", "--seconds", "40", "--out", "s.mcap"]);
    place
}

#[test]
fn a_log_that_was_cut_off_can_be_used_again() {
    let place = place();
    let whole = place.read("s.mcap");
    place.write("s.mcap.part", &whole[..whole.len() / 2]);
    place.refused(
        &["log", "info", "s.mcap.part"],
        &["s.mcap.part: the log is cut off"],
    );
    let args = ["log", "recover", "s.mcap.part", "--out", "r.mcap"];
    let report = place.json(&args);
    assert_eq!(report["sound"], false);
    assert_eq!(report["closed"], false);
    assert_eq!(report["cut_chunk"], true);
    assert_eq!(report["attachments"][0], "config.toml");
    let messages = number(&report, "/messages");
    // Half of the bytes hold about half of 500 samples on two topics.
    assert!(messages > 200.0 && messages < 800.0, "{messages}");
    let info = place.json(&["log", "info", "r.mcap"]);
    assert_eq!(info["messages"], report["messages"]);
    let losses = array(&report, "/losses");
    assert_eq!(losses.len(), 1);
    assert_eq!(losses[0]["kind"], "end_of_chunk");
    let text = place.done(&args);
    assert!(text.starts_with("r.mcap: "), "{text}");
    assert!(
        text.contains("the end of the file was missing\nlost: "),
        "{text}"
    );
    // In the place of the file that the crash left, and the run can be made again from it.
    place.done(&["log", "recover", "s.mcap.part", "--out", "s.mcap"]);
    place.done(&[
        "identify",
        "s.mcap",
        "--inputs",
        "a_v",
        "--outputs",
        "p7",
        "--order",
        "2",
    ]);
}

#[test]
fn a_sound_log_loses_nothing() {
    let place = place();
    let text = place.done(&["log", "recover", "s.mcap", "--out", "r.mcap"]);
    assert!(text.ends_with("nothing was lost\n"), "{text}");
    let records = |name: &str| {
        let info = place.json(&["log", "info", name]);
        (
            info["topics"].clone(),
            info["metadata"].clone(),
            info["attachments"].clone(),
        )
    };
    assert_eq!(records("s.mcap"), records("r.mcap"));
}

#[test]
fn mistakes_are_named() {
    let place = place();
    place.write("t.mcap", "no log at all");
    let out = ["--out", "r.mcap"];
    let recover = |file| [&["log", "recover", file], &out[..]].concat();
    place.refused_exactly(
        &recover("t.mcap"),
        "t.mcap: expected the records of an MCAP file, found none in 13 bytes",
    );
    place.refused_exactly(&recover("none.mcap"), "none.mcap: there is no such file");
    place.refused_exactly(
        &["log", "recover", "s.mcap", "--out", "s.mcap"],
        "--out: expected another file than those that are read, found s.mcap",
    );
    place.refused_exactly(
        &["log", "recover", "s.mcap"],
        "--out: required, for example --out run.mcap",
    );
    place.refused_exactly(
        &["log", "recover", "--out", "r.mcap"],
        "FILE.mcap: required, for example gtfdi log recover run.mcap.part",
    );
    place.write("c.toml", "[log-recover]\nuot = 3\n");
    place.refused(
        &["log", "recover", "s.mcap", "--config", "c.toml"],
        &["c.toml: ", "line 2", "unknown field `uot`"],
    );
}
