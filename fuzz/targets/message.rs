//! Messages of readings, from a line or under a topic.

#![no_main]

use gt_serve::fuzzing::read_message;
use gtfdi_fuzz::Bytes;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let tag = match bytes.byte() % 3 {
        0 => None,
        1 => Some("t3"),
        _ => Some("none of them"),
    };
    read_message(bytes.0, tag);
});
