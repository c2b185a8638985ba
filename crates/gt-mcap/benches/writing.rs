//! Writing and reading logs of 28 numbers a message, in messages a second.
//!
//! `cargo bench -p gt-mcap --bench writing`
//!
//! Beside each other: one `write` of the same numbers, the crate `mcap` with the numbers as they are
//! (224 bytes a message, no names) and with messages that were encoded before, and [`LogWriter`]. Files
//! are in `/dev/shm` where that is there, so that no disk is measured.

#[path = "../../../benches/timing/mod.rs"]
mod timing;

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::{self, File};
use std::hint::black_box;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use gt_core::Signal;
use gt_log::{LogCompression, LogWriter, RunMetadata, Selection, read_dataset, sample_time_ns};
use mcap::WriteOptions;
use mcap::records::MessageHeader;

/// Numbers of a message.
const WIDTH: usize = 28;
/// Messages of a file.
const MESSAGES: usize = 50_000;
/// Time between messages in seconds.
const PERIOD_S: f64 = 1e-3;
/// What files are packed with, and the name of each.
const COMPRESSIONS: [(&str, LogCompression); 3] = [
    ("none", LogCompression::None),
    ("lz4", LogCompression::Lz4),
    ("zstd", LogCompression::Zstd),
];

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Readings of a plant that moves slowly, with the noise of sensors.
fn readings() -> Vec<[f64; WIDTH]> {
    let mut state = 7_u64;
    let mut uniform = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let sample = |k: usize| {
        let phase = k as f64 * PERIOD_S;
        let mut own = [0.0; WIDTH];
        for (channel, value) in own.iter_mut().enumerate() {
            let slow = (0.3 * phase + channel as f64).sin();
            *value = 1e3 * (1.0 + channel as f64) * (1.0 + 0.05 * slow + 1e-3 * uniform());
        }
        own
    };
    (0..MESSAGES).map(sample).collect()
}

/// The numbers of a message as they are.
fn bytes_of(sample: &[f64; WIDTH], buffer: &mut Vec<u8>) {
    buffer.clear();
    for value in sample {
        buffer.extend_from_slice(&value.to_le_bytes());
    }
}

/// A message as [`LogWriter`] encodes it: keys and numbers.
fn encoded(sample: &[f64; WIDTH]) -> Vec<u8> {
    let mut buffer = Vec::new();
    for (number, value) in (1_u64..).zip(sample) {
        let mut key = number << 3 | 1;
        while key >= 128 {
            buffer.push((key & 127 | 128).to_le_bytes()[0]);
            key >>= 7;
        }
        buffer.push(key.to_le_bytes()[0]);
        buffer.extend_from_slice(&value.to_le_bytes());
    }
    buffer
}

fn with_gtfdi(path: &Path, samples: &[[f64; WIDTH]], by: LogCompression) -> Outcome<()> {
    let names: Vec<String> = (1..=WIDTH).map(|k| format!("tag_{k}")).collect();
    let mut log = LogWriter::create_with(path, &RunMetadata::default(), by)?;
    let signals = Signal::named(&names);
    let topic = log.add_topic("/plant/measured", "Measured", &signals, PERIOD_S, "GT1")?;
    for (k, sample) in samples.iter().enumerate() {
        log.write(topic, sample_time_ns(k, PERIOD_S), sample)?;
    }
    Ok(log.finish()?)
}

fn with_mcap<'a, T>(
    path: &Path,
    messages: &'a [T],
    by: LogCompression,
    mut bytes: impl FnMut(&'a T, &mut Vec<u8>),
) -> Outcome<()> {
    let options = WriteOptions::new()
        .compression(match by {
            LogCompression::None => None,
            LogCompression::Lz4 => Some(mcap::Compression::Lz4),
            LogCompression::Zstd => Some(mcap::Compression::Zstd),
        })
        .compression_threads(0);
    let mut writer = options.create(BufWriter::new(File::create(path)?))?;
    let schema = writer.add_schema("Raw", "ros1msg", b"float64[28] values")?;
    let channel = writer.add_channel(schema, "/plant/measured", "ros1", &BTreeMap::new())?;
    let mut buffer = Vec::new();
    for (k, message) in messages.iter().enumerate() {
        bytes(message, &mut buffer);
        let time_ns = sample_time_ns(k, PERIOD_S);
        let header = MessageHeader {
            channel_id: channel,
            sequence: u32::try_from(k)?,
            log_time: time_ns,
            publish_time: time_ns,
        };
        writer.write_to_known_channel(&header, &buffer)?;
    }
    writer.finish()?;
    writer.into_inner().into_inner()?.sync_all()?;
    Ok(())
}

fn with_one_write(path: &Path, samples: &[[f64; WIDTH]]) -> Outcome<()> {
    let bytes: Vec<u8> = samples
        .as_flattened()
        .iter()
        .flat_map(|own| own.to_le_bytes())
        .collect();
    let mut file = File::create(path)?;
    file.write_all(&bytes)?;
    Ok(file.sync_all()?)
}

/// The sum of all numbers of a log, by the crate `mcap` alone.
fn sum_with_mcap(path: &Path) -> Outcome<f64> {
    let bytes = fs::read(path)?;
    let mut sum = 0.0;
    for message in mcap::MessageStream::new(&bytes)? {
        let message = message?;
        for value in message.data.as_chunks::<8>().0 {
            sum += f64::from_le_bytes(*value);
        }
    }
    Ok(sum)
}

fn sum_with_gtfdi(path: &Path) -> Outcome<f64> {
    let select = Selection {
        outputs: vec!["*".to_owned()],
        ..Selection::default()
    };
    Ok(read_dataset(path, &select)?.dataset.y().sum())
}

/// A folder in memory where there is one, and it is removed at the end.
fn folder() -> Outcome<tempfile::TempDir> {
    let shared = Path::new("/dev/shm");
    Ok(if shared.is_dir() {
        tempfile::tempdir_in(shared)?
    } else {
        tempfile::tempdir()?
    })
}

fn main() -> Outcome<()> {
    let samples = readings();
    let messages: Vec<Vec<u8>> = samples.iter().map(encoded).collect();
    let folder = folder()?;
    let path = |name: &str| -> PathBuf { folder.path().join(format!("{name}.mcap")) };
    let done = |outcome: Outcome<()>| {
        if let Err(error) = outcome {
            eprintln!("writing: {error}");
            std::process::exit(1);
        }
    };
    let rate = |seconds: f64| 1e-3 * MESSAGES as f64 / seconds;
    for (name, by) in COMPRESSIONS {
        let (one, raw, same, own) = (path("one"), path("raw"), path("same"), path(name));
        let times = timing::race(vec![
            (
                "mcap, numbers as they are",
                Box::new(|| done(with_mcap(&raw, &samples, by, bytes_of))),
            ),
            (
                "mcap, messages encoded before",
                Box::new(|| {
                    done(with_mcap(&same, &messages, by, |message, buffer| {
                        buffer.clear();
                        buffer.extend_from_slice(message);
                    }));
                }),
            ),
            (
                "gtfdi LogWriter::write",
                Box::new(|| done(with_gtfdi(&own, &samples, by))),
            ),
            (
                "one write of the numbers",
                Box::new(|| done(with_one_write(&one, &samples))),
            ),
        ]);
        let mut sizes = Vec::new();
        for path in [&raw, &same, &own, &one] {
            let bytes = fs::metadata(path)?.len();
            sizes.push(format!("{:.0}", bytes as f64 / MESSAGES as f64));
        }
        println!("\nwriting {MESSAGES} messages of {WIDTH} numbers, compression {name}");
        times.print("k messages/s", rate, &[0, 3], ("bytes a message", &sizes));
    }
    for (name, by) in COMPRESSIONS {
        let (raw, own) = (path("raw"), path(name));
        let sum: f64 = samples.as_flattened().iter().sum();
        let found = sum_with_gtfdi(&own)?;
        if (found - sum).abs() > 1e-9 * sum {
            return Err(format!("{name}: expected the sum {sum}, found {found}").into());
        }
        with_mcap(&raw, &samples, by, bytes_of)?;
        let times = timing::race(vec![
            (
                "mcap, numbers as they are",
                Box::new(|| {
                    black_box(sum_with_mcap(&raw).unwrap_or(f64::NAN));
                }),
            ),
            (
                "gtfdi read_dataset",
                Box::new(|| {
                    black_box(sum_with_gtfdi(&own).unwrap_or(f64::NAN));
                }),
            ),
        ]);
        println!("\nreading {MESSAGES} messages of {WIDTH} numbers, compression {name}");
        times.print("k messages/s", rate, &[0], ("", &[]));
    }
    Ok(())
}
