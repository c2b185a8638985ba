//! Parquet files, written here with every encoding and codec that is read, and broken in every byte.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::float_cmp, reason = "a number that is read is exact")]

use std::fs;
use std::sync::Arc;

use gt_log::{Imported, Reading, Resample, ResampleMethod, Selection, columns, read_dataset};
use gtfdi::ident::Missing;
use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FixedLenByteArray,
    FixedLenByteArrayType, FloatType, Int32Type, Int64Type, Int96, Int96Type,
};
use parquet::file::properties::{WriterProperties, WriterVersion};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use tempfile::tempdir;

/// Writes the next column of a group; `None` is a null.
type WriteColumn = Box<dyn Fn(&mut SerializedRowGroupWriter<'_, &mut Vec<u8>>)>;

fn column<T: DataType>(values: Vec<Option<T::T>>) -> WriteColumn
where
    T::T: Clone,
{
    Box::new(move |group| {
        let levels: Vec<i16> = values.iter().map(|v| i16::from(v.is_some())).collect();
        let values: Vec<T::T> = values.iter().flatten().cloned().collect();
        let mut writer = group.next_column().unwrap().unwrap();
        writer
            .typed::<T>()
            .write_batch(&values, Some(&levels), None)
            .unwrap();
        writer.close().unwrap();
    })
}

/// A file whose groups of rows all have the same columns.
fn file(
    schema: &str,
    groups: usize,
    columns: &[WriteColumn],
    properties: WriterProperties,
) -> Vec<u8> {
    let schema = Arc::new(parse_message_type(&format!("message m {{ {schema} }}")).unwrap());
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties)).unwrap();
    for _ in 0..groups {
        let mut group = writer.next_row_group().unwrap();
        for column in columns {
            column(&mut group);
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
    bytes
}

fn plain() -> WriterProperties {
    WriterProperties::builder().build()
}

fn doubles(values: &[f64]) -> WriteColumn {
    column::<DoubleType>(values.iter().map(|&value| Some(value)).collect())
}

fn texts(values: &[Option<&str>]) -> WriteColumn {
    let own = |value: Option<&str>| value.map(ByteArray::from);
    column::<ByteArrayType>(values.iter().copied().map(own).collect())
}

fn select(inputs: &[&str], outputs: &[&str]) -> Selection {
    let own = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    Selection {
        inputs: own(inputs),
        outputs: own(outputs),
        missing: Missing::Break,
        ..Selection::default()
    }
}

fn read(bytes: &[u8], selection: &Selection) -> Result<Imported, String> {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    fs::write(&path, bytes).unwrap();
    read_dataset(&path, selection).map_err(|error| {
        let (text, name) = (error.to_string(), format!("{}: ", path.display()));
        text.strip_prefix(&name).unwrap_or(&text).to_owned()
    })
}

fn shown(imported: &Imported) -> Vec<String> {
    imported
        .dataset
        .y()
        .iter()
        .map(ToString::to_string)
        .collect()
}

#[test]
fn every_type_of_number_is_read() {
    let schema = "
        optional double d; optional float f; optional int32 i; optional int64 l;
        optional int32 u (INTEGER(32,false)); optional boolean b;
        optional int32 c (DECIMAL(6,2)); optional int64 e (DECIMAL(12,3));
        optional binary g (DECIMAL(30,1)); optional fixed_len_byte_array(5) h (DECIMAL(10,2));
        optional binary text (UTF8);";
    let fixed = FixedLenByteArray::from(vec![0xff, 0xff, 0xff, 0xff, 0x9c]);
    let cells: [WriteColumn; 11] = [
        doubles(&[0.1, f64::NAN]),
        column::<FloatType>(vec![Some(0.5), None]),
        column::<Int32Type>(vec![Some(-7), None]),
        column::<Int64Type>(vec![Some(1 << 40), None]),
        column::<Int32Type>(vec![Some(-1), None]),
        column::<BoolType>(vec![Some(true), Some(false)]),
        column::<Int32Type>(vec![Some(-12345), None]),
        column::<Int64Type>(vec![Some(12345), None]),
        column::<ByteArrayType>(vec![Some(ByteArray::from(vec![0x01, 0x00])), None]),
        column::<FixedLenByteArrayType>(vec![Some(fixed), None]),
        texts(&[Some("2.5"), Some("I/O Timeout")]),
    ];
    let bytes = file(schema, 1, &cells, plain());
    let imported = read(&bytes, &select(&[], &["*"])).unwrap();
    assert_eq!(
        shown(&imported),
        [
            "0.1",
            "0.5",
            "-7",
            "1099511627776",
            "4294967295",
            "1",
            "-123.45",
            "12.345",
            "25.6",
            "-1",
            "2.5",
            "NaN",
            "NaN",
            "NaN",
            "NaN",
            "NaN",
            "0",
            "NaN",
            "NaN",
            "NaN",
            "NaN",
            "NaN",
        ]
    );
    assert!(
        imported
            .remarks()
            .contains(&"`text`: 1 times `I/O Timeout`, read as missing".to_owned())
    );
    assert_eq!(imported.sha256, gt_log::sha256_hex(&bytes));
    let strict = Selection {
        missing: Missing::Refuse,
        ..select(&[], &["d", "i"])
    };
    assert_eq!(
        read(&bytes, &strict).unwrap_err(),
        "row 1, column `d`: expected a finite number, found an empty cell"
    );
}

#[test]
fn every_type_of_time_is_read() {
    // date -u -d 2026-07-01T00:00:00 +%s
    let start_s: i64 = 1_782_864_000;
    let times = |per_s: i64| -> WriteColumn {
        column::<Int64Type>(vec![Some(start_s * per_s), Some((start_s + 3600) * per_s)])
    };
    let int96 = |hour: u32| {
        let ns = u64::from(hour) * 3_600_000_000_000;
        let mut value = Int96::new();
        // 2026-07-01 is the Julian day 2461223.
        let half = |ns: u64| u32::try_from(ns & u64::from(u32::MAX)).unwrap();
        value.set_data(half(ns), half(ns >> 32), 2_461_223);
        value
    };
    let cases: [(&str, WriteColumn, i64); 7] = [
        ("int64 time (TIMESTAMP(MILLIS,true))", times(1_000), 0),
        ("int64 time (TIMESTAMP(MICROS,true))", times(1_000_000), 0),
        (
            "int64 time (TIMESTAMP(NANOS,true))",
            times(1_000_000_000),
            0,
        ),
        (
            "int64 time (TIMESTAMP(MICROS,false))",
            times(1_000_000),
            2 * 3600,
        ),
        ("int64 time (TIMESTAMP_MILLIS)", times(1_000), 0),
        ("int64 time", times(1_000), 0),
        (
            "int96 time",
            column::<Int96Type>(vec![Some(int96(0)), Some(int96(1))]),
            0,
        ),
    ];
    for (schema, times, local_s) in cases {
        let schema = format!("optional {schema}; optional double y;");
        let bytes = file(&schema, 1, &[times, doubles(&[1.0, 2.0])], plain());
        let rome = Selection {
            reading: Reading {
                time_zone: Some("Europe/Rome".to_owned()),
                ..Reading::default()
            },
            ..select(&[], &["y"])
        };
        let imported = read(&bytes, &rome).unwrap();
        let start_ns = i128::from(start_s - local_s) * 1_000_000_000;
        assert_eq!(imported.start_unix_ns, Some(start_ns), "{schema}");
        assert_eq!(imported.dataset.sample_time_s(), 3600.0, "{schema}");
    }
    let days = column::<Int32Type>(vec![Some(20_635), Some(20_636)]);
    let bytes = file(
        "optional int32 time (DATE); optional double y;",
        1,
        &[days, doubles(&[1.0, 2.0])],
        plain(),
    );
    let imported = read(&bytes, &select(&[], &["y"])).unwrap();
    assert_eq!(imported.start_unix_ns, Some(1_782_864_000_000_000_000));
    assert_eq!(imported.dataset.sample_time_s(), 86_400.0);
}

#[test]
fn every_encoding_version_and_codec_is_read() {
    let values: Vec<f64> = (0..300).map(|k| f64::from(k % 7) / 8.0).collect();
    let times: Vec<Option<i64>> = (0..300).map(|k| Some(k * 2)).collect();
    let schema = "optional int64 time; optional double y;";
    for version in [WriterVersion::PARQUET_1_0, WriterVersion::PARQUET_2_0] {
        for (dictionary, encoding) in [
            (true, None),
            (false, None),
            (false, Some(Encoding::BYTE_STREAM_SPLIT)),
        ] {
            for codec in [
                Compression::UNCOMPRESSED,
                Compression::SNAPPY,
                Compression::ZSTD(ZstdLevel::default()),
            ] {
                let mut properties = WriterProperties::builder()
                    .set_writer_version(version)
                    .set_dictionary_enabled(dictionary)
                    .set_compression(codec)
                    .set_data_page_row_count_limit(64)
                    .set_write_batch_size(16);
                if let Some(encoding) = encoding {
                    properties = properties.set_column_encoding("y".into(), encoding);
                }
                let cells = [column::<Int64Type>(times.clone()), doubles(&values)];
                let bytes = file(schema, 1, &cells, properties.build());
                let imported = read(&bytes, &select(&[], &["y"])).unwrap();
                assert_eq!(imported.dataset.y().as_slice(), values);
                assert_eq!(imported.dataset.sample_time_s(), 2.0);
            }
        }
    }
}

#[test]
fn groups_of_rows_follow_each_other_and_rows_are_selected() {
    let cells = [doubles(&[1.0, 2.0, 3.0])];
    let bytes = file("optional double y;", 4, &cells, plain());
    let rows = Selection {
        rows: Some(2..7),
        ..select(&[], &["y"])
    };
    let imported = read(&bytes, &rows).unwrap();
    assert_eq!(imported.dataset.y().as_slice(), [3.0, 1.0, 2.0, 3.0, 1.0]);
    assert_eq!(imported.total_rows, 12);
}

#[test]
fn rows_of_readings_are_read() {
    let schema = "optional binary Tag (UTF8); optional int64 timestamp (TIMESTAMP(MILLIS,true));
        optional double value; optional int32 quality;";
    let times = [0, 0, 1000, 1500, 2000];
    let cells = [
        texts(&[Some("u"), Some("y"), Some("u"), Some("y"), Some("u")]),
        column::<Int64Type>(times.map(Some).to_vec()),
        doubles(&[1.0, 10.0, 2.0, 20.0, 3.0]),
        column::<Int32Type>([192, 192, 64, 192, 0].map(Some).to_vec()),
    ];
    let bytes = file(schema, 1, &cells, plain());
    let resample = Resample {
        step_s: 1.0,
        method: ResampleMethod::Hold,
        hold_at_most_s: Some(1.0),
    };
    let selection = Selection {
        reading: Reading {
            resample: Some(resample),
            ..Reading::default()
        },
        ..select(&["u"], &["y"])
    };
    let imported = read(&bytes, &selection).unwrap();
    assert_eq!(imported.dataset.u().as_slice(), [1.0, 2.0, 2.0]);
    assert_eq!(shown(&imported), ["10", "10", "20"]);
    assert_eq!(
        imported.remarks(),
        [
            "`u`: 1 readings of uncertain quality, kept",
            "`u`: 1 times `quality 0`, read as missing",
            "resampled `u`: 2 as they stand, 1 held",
            "resampled `y`: 1 as they stand, 2 held",
        ]
    );
}

#[test]
fn files_that_cannot_be_used_are_named() {
    let y = doubles(&[1.0, 2.0]);
    let schema = "optional double y; optional group pos { optional double x; }
        optional int32 clock (TIME(MILLIS,true));";
    let nested: WriteColumn = Box::new(|group| {
        let mut writer = group.next_column().unwrap().unwrap();
        let typed = writer.typed::<DoubleType>();
        typed.write_batch(&[1.0, 2.0], Some(&[2, 2]), None).unwrap();
        writer.close().unwrap();
    });
    let clocks = column::<Int32Type>(vec![Some(1), Some(2)]);
    let bytes = file(schema, 1, &[y, nested, clocks], plain());
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    fs::write(&path, &bytes).unwrap();
    let names: Vec<String> = columns(&path, None)
        .unwrap()
        .into_iter()
        .map(|s| s.name)
        .collect();
    assert_eq!(names, ["y", "pos", "clock"]);
    let cases = [
        (
            "pos",
            "column `pos`: expected numbers, texts or times, found a nested column (flatten it)",
        ),
        ("x", "expected a column `x`, found y, pos, clock"),
    ];
    for (name, expected) in cases {
        assert_eq!(read(&bytes, &select(&[], &[name])).unwrap_err(), expected);
    }
    assert_eq!(
        read(&bytes, &select(&["clock"], &["y"])).unwrap_err(),
        "column `clock`: expected numbers, texts or times, found times of day without a date"
    );
    let decimal = Selection {
        reading: Reading {
            encoding: Some("utf-8".to_owned()),
            ..Reading::default()
        },
        ..select(&[], &["y"])
    };
    assert_eq!(
        read(&bytes, &decimal).unwrap_err(),
        "--encoding: expected with a CSV file, found a Parquet file"
    );
    assert!(
        read(b"", &select(&[], &["y"]))
            .unwrap_err()
            .starts_with("expected a sound Parquet file")
    );
    // The codec stands in the footer as a compact varint: 2 (zigzag of 1) for Snappy, 8 for Brotli.
    let snappy = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false)
        .build();
    let bytes = file("optional double y;", 1, &[doubles(&[1.0, 2.0])], snappy);
    let found: Vec<String> = (0..bytes.len())
        .filter(|&place| bytes[place] == 2)
        .filter_map(|place| {
            let mut other = bytes.clone();
            other[place] = 8;
            read(&other, &select(&[], &["y"])).err()
        })
        .collect();
    let brotli = found.iter().find(|text| text.contains("BROTLI")).unwrap();
    assert!(
        brotli
            .starts_with("column `y`: expected no compression, Snappy, gzip or zstd, found BROTLI"),
        "{brotli}"
    );
}

/// Cut anywhere, or with any byte changed in three ways, a file is read or refused, but nothing
/// panics through and no memory runs out.
#[test]
fn broken_bytes_are_read_or_refused() {
    let schema = "optional int64 time (TIMESTAMP(MILLIS,true)); optional double y;
        optional binary tag (UTF8);";
    for codec in [
        Compression::UNCOMPRESSED,
        Compression::ZSTD(ZstdLevel::default()),
    ] {
        let properties = WriterProperties::builder().set_compression(codec).build();
        let cells = [
            column::<Int64Type>((0..20).map(|k| (k != 7).then_some(k * 1000)).collect()),
            column::<DoubleType>((0..20).map(|k| (k != 3).then_some(f64::from(k))).collect()),
            texts(&[Some("a"), Some("Bad"), None, Some("1.5")].repeat(5)),
        ];
        let bytes = file(schema, 2, &cells, properties);
        let folder = tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        let mut refused = 0;
        let mut gave_up = 0;
        let mut attempt = |broken: &[u8]| {
            fs::write(&path, broken).unwrap();
            if let Err(error) = read_dataset(&path, &select(&["tag"], &["y"])) {
                let text = error.to_string();
                assert!(text.starts_with(&path.display().to_string()), "{text}");
                refused += 1;
                gave_up += usize::from(text.contains("gave up"));
            }
        };
        for length in 0..bytes.len() {
            attempt(&bytes[..length]);
        }
        for place in 0..bytes.len() {
            for change in [0x01, 0x55, 0xff] {
                let mut broken = bytes.clone();
                broken[place] ^= change;
                attempt(&broken);
            }
        }
        println!(
            "{codec:?}: {} bytes, {refused} refused, {gave_up} panics caught",
            bytes.len()
        );
        assert!(refused > bytes.len());
    }
}
