//! Readings of any order, time and value, through a whole machine: samples come in order, one for
//! each place of the grid.

#![no_main]

use std::sync::LazyLock;

use gt_log::DetectorFile;
use gt_serve::pipeline::{Machine, MachineOptions, Quality, Reading};
use gtfdi_fuzz::{Bytes, with_file};
use libfuzzer_sys::fuzz_target;

static BANK: LazyLock<DetectorFile> = LazyLock::new(|| {
    let bank = include_bytes!("../seeds/document/bank30.json");
    with_file("bank.json", bank, DetectorFile::read).expect("a bank")
});

const EPOCH_NS: i64 = 1_700_000_000_000_000_000;

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let mut machine = Machine::new("gt1", &BANK, MachineOptions::default()).expect("a machine");
    let tags = machine.tags().count();
    let mut now_ns = EPOCH_NS;
    let mut time_ns = EPOCH_NS;
    let mut last: Option<(i64, u64)> = None;
    while !bytes.is_empty() {
        let step = i64::from(bytes.byte()) * 1_000_000;
        match bytes.byte() % 16 {
            0 => now_ns = now_ns.wrapping_add(step * 1000),
            1 => now_ns = now_ns.saturating_sub(step * 1000),
            2 => time_ns = bytes.bits().cast_signed(),
            3 => time_ns = now_ns,
            4 => time_ns = time_ns.saturating_sub(step),
            _ => {
                time_ns = time_ns.saturating_add(step);
                now_ns = now_ns.saturating_add(step);
            }
        }
        let reading = Reading {
            tag: usize::from(bytes.byte()) % tags,
            time_ns,
            value: bytes.number(),
            quality: if bytes.byte() < 200 {
                Quality::Good
            } else {
                Quality::Bad
            },
        };
        machine.offer(&reading, now_ns, |_, sample| {
            match last {
                Some((before_ns, before)) if !sample.restart => {
                    assert_eq!(sample.index, before + 1);
                    assert!(sample.time_ns > before_ns);
                }
                _ => assert_eq!((sample.index, sample.restart), (0, true)),
            }
            last = Some((sample.time_ns, sample.index));
        });
        machine.tick(now_ns / 1_000_000);
        machine.take_events();
    }
    machine.drain(|_, _| {});
    let _ = machine.snapshot();
});
