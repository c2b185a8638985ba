//! What the service finds on the disk: the journal of alarms, snapshots, tokens.

#![no_main]

use std::sync::LazyLock;

use gt_log::DetectorFile;
use gt_serve::fuzzing::{open_journal, read_tokens};
use gt_serve::pipeline::{Machine, MachineOptions, Quality, Reading};
use gtfdi_fuzz::{Bytes, with_file};
use libfuzzer_sys::fuzz_target;

static BANK: LazyLock<DetectorFile> = LazyLock::new(|| {
    let bank = include_bytes!("../seeds/document/bank30.json");
    with_file("bank.json", bank, DetectorFile::read).expect("a bank")
});

const NOW_NS: i64 = 1_700_000_000_000_000_000;

/// Resumes a machine from a snapshot and steps it.
fn resume(bytes: &[u8]) {
    let Ok(snapshot) = serde_json::from_slice(bytes) else {
        return;
    };
    let made = Machine::new("gt1", &BANK, MachineOptions::default());
    let mut machine = made.expect("a machine");
    let _ = machine.resume(Vec::new(), Some(snapshot), NOW_NS / 1_000_000);
    for tag in 0..machine.tags().count() {
        let reading = Reading {
            tag,
            time_ns: NOW_NS,
            value: 1.0,
            quality: Quality::Good,
        };
        machine.offer(&reading, NOW_NS, |_, _| {});
    }
    machine.tick(NOW_NS / 1_000_000 + 1000);
    machine.drain(|_, _| {});
    let _ = machine.snapshot();
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    match bytes.byte() % 3 {
        0 => with_file("alarms.jsonl", bytes.0, open_journal),
        1 => resume(bytes.0),
        _ => with_file("tokens.toml", bytes.0, |path| {
            #[cfg(unix)]
            {
                use std::os::unix::fs::PermissionsExt as _;
                let mode = std::fs::Permissions::from_mode(0o600);
                std::fs::set_permissions(path, mode).expect("a mode");
            }
            read_tokens(path);
        }),
    }
});
