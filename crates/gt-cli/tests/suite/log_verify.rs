//! `gtfdi log verify`: sound logs pass, damage is named and ends with exit code 1.

use crate::place::{Place, array};

#[test]
fn sound_logs_pass_and_damaged_ones_do_not() {
    let place = Place::new();
    place.done(&["simulate", "--seconds", "8", "--out", "s.mcap"]);
    let report = place.json(&["log", "verify", "s.mcap"]);
    assert_eq!(report["sound"], true);
    assert_eq!(report["messages"], 201);
    assert_eq!(report["decoded_messages"], 201);
    assert!(array(&report, "/problems").is_empty());
    let text = place.done(&["log", "verify", "s.mcap"]);
    assert!(text.ends_with("no problem\n"), "{text}");

    let whole = place.read("s.mcap");
    let mut bytes = whole.clone();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    place.write("d.mcap", bytes);
    let ran = place.run(&["log", "verify", "d.mcap", "--json"]);
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    let report = crate::place::object(&ran.stdout);
    assert_eq!(report["sound"], false);
    let problem = &array(&report, "/problems")[0];
    assert_eq!(problem["severity"], "damage");
    assert_eq!(problem["kind"], "chunk");
    assert!(problem["offset"].as_u64().is_some_and(|own| own > 0));
    assert!(
        ran.stderr
            .starts_with("gtfdi: d.mcap: the log is damaged: "),
        "{}",
        ran.stderr
    );
    let text = place.run(&["log", "verify", "d.mcap"]);
    assert_eq!(text.code, 1);
    assert!(text.stdout.contains("damage"), "{}", text.stdout);

    // What was mended is sound.
    place.done(&["log", "recover", "d.mcap", "--out", "r.mcap"]);
    place.done(&["log", "verify", "r.mcap"]);
    place.refused_exactly(
        &["log", "verify", "none.mcap"],
        "none.mcap: there is no such file",
    );
}
