//! CSV files as historians and spreadsheets export them.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write as _;
use std::fs;

use gt_log::{Decimal, Imported, Reading, Selection, Warning, read_dataset};
use gtfdi::ident::Missing;
use proptest::prelude::*;
use tempfile::tempdir;

/// The record of `y` in a file, or what is said of it without its name.
fn read_as(bytes: &[u8], selection: Selection) -> Result<Imported, String> {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.csv");
    fs::write(&path, bytes).unwrap();
    let selection = Selection {
        outputs: vec!["y".to_owned()],
        ..selection
    };
    read_dataset(&path, &selection).map_err(|error| {
        let (text, name) = (error.to_string(), format!("{}: ", path.display()));
        text.strip_prefix(&name).unwrap_or(&text).to_owned()
    })
}

fn with(reading: Reading) -> Selection {
    Selection {
        reading,
        ..Selection::default()
    }
}

fn read(text: &str, reading: Reading) -> Result<Imported, String> {
    read_as(text.as_bytes(), with(reading))
}

fn y(imported: &Imported) -> &[f64] {
    imported.dataset.y().as_slice()
}

fn wide_text(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    text.encode_utf16().flat_map(bytes).collect()
}

const TEXT: &str = "time,y,T in \u{b0}C\n0,1.5,20\n1,2.5,21\n";

#[test]
fn encodings_are_told_by_mark_or_option() {
    let encoding = |label: &str| {
        with(Reading {
            encoding: Some(label.to_owned()),
            ..Reading::default()
        })
    };
    let latin: Vec<u8> = TEXT
        .chars()
        .map(|c| u8::try_from(u32::from(c)).unwrap())
        .collect();
    let cases = [
        (TEXT.as_bytes().to_vec(), Selection::default()),
        (format!("\u{feff}{TEXT}").into_bytes(), Selection::default()),
        (format!("\u{feff}{TEXT}").into_bytes(), encoding("UTF-8")),
        (
            wide_text(&format!("\u{feff}{TEXT}"), u16::to_le_bytes),
            Selection::default(),
        ),
        (
            wide_text(&format!("\u{feff}{TEXT}"), u16::to_be_bytes),
            Selection::default(),
        ),
        (wide_text(TEXT, u16::to_le_bytes), encoding("utf-16le")),
        (
            wide_text(&format!("\u{feff}{TEXT}"), u16::to_be_bytes),
            encoding("utf-16be"),
        ),
        (latin.clone(), encoding("Windows-1252")),
        (latin.clone(), encoding("latin1")),
    ];
    for (bytes, selection) in cases {
        let imported = read_as(&bytes, selection.clone()).unwrap();
        assert_eq!(y(&imported), [1.5, 2.5], "{selection:?}");
        assert_eq!(imported.sha256, gt_log::sha256_hex(&bytes));
    }
    let refused = [
        (
            latin,
            Selection::default(),
            "line 1: expected UTF-8 text, found the byte 0xb0 at offset 12 (a binary file, or text \
             in another encoding: --encoding windows-1252, --encoding utf-16le)",
        ),
        (
            TEXT.as_bytes().to_vec(),
            encoding("klingon"),
            "--encoding: expected a label of the Encoding standard such as utf-8, utf-16le or \
             windows-1252, found `klingon`",
        ),
        (
            b"y\n1\n\xff2\n".to_vec(),
            encoding("shift_jis"),
            "line 3: expected text in Shift_JIS, found bytes that are none; give the encoding the \
             file was written in, for example --encoding windows-1252",
        ),
    ];
    for (bytes, selection, expected) in refused {
        assert_eq!(read_as(&bytes, selection).unwrap_err(), expected);
    }
}

#[test]
fn decimal_commas_are_recognised_where_commas_do_not_separate() {
    for text in [
        "time;y\n0,0;1,5\n0,5;-2,25e1\n",
        "time\ty\n0\t1,5\n0,5\t-2,25e1\n",
    ] {
        let imported = read(text, Reading::default()).unwrap();
        assert_eq!(y(&imported), [1.5, -22.5]);
        assert_eq!(
            imported.dataset.sample_time_s().to_bits(),
            0.5_f64.to_bits()
        );
        assert_eq!(imported.warnings, [Warning::DecimalComma]);
    }
    let comma = Reading {
        decimal: Some(Decimal::Comma),
        ..Reading::default()
    };
    let imported = read("y\n1,5\n2,5\n", comma.clone()).unwrap();
    assert_eq!(y(&imported), [1.5, 2.5]);
    assert_eq!(
        read("n;y\n1;1.5\n", comma.clone()).unwrap_err(),
        "line 2, column `y`: expected a finite number, found `1.5`"
    );
    let point = Reading {
        decimal: Some(Decimal::Point),
        ..Reading::default()
    };
    assert_eq!(
        read("n;y\n1;1,5\n", point).unwrap_err(),
        "line 2, column `y`: expected a number with a decimal point, found `1,5`; if the comma is \
         the decimal sign, give --decimal comma"
    );
    let thousands = |found: &str| {
        format!(
            "line 2, column `y`: expected a number without separators of thousands, found \
             `{found}`; export it without them"
        )
    };
    assert_eq!(
        read("n,y\n1,\"1,234.5\"\n", Reading::default()).unwrap_err(),
        thousands("1,234.5")
    );
    assert_eq!(
        read("n;y\n1;1.234,5\n", comma).unwrap_err(),
        thousands("1.234,5")
    );
    // Spreadsheets say their separator first.
    let imported = read("sep=;\r\nn;y\r\n1;1,5\r\n", Reading::default()).unwrap();
    assert_eq!(y(&imported), [1.5]);
}

#[test]
fn words_are_missing_values_where_those_may_be() {
    let text = "time,y\n0,1\n1,Bad\n2,I/O Timeout\n3,BAD\n4,Kaputt\n5,2\n";
    let reading = Reading {
        bad_values: vec!["kaputt".to_owned()],
        ..Reading::default()
    };
    assert_eq!(
        read(text, reading.clone()).unwrap_err(),
        "line 3, column `y`: expected a finite number, found `Bad`, a word for none"
    );
    let allowed = Selection {
        missing: Missing::Break,
        ..with(reading)
    };
    let imported = read_as(text.as_bytes(), allowed.clone()).unwrap();
    let invalid: Vec<bool> = y(&imported).iter().map(|value| value.is_nan()).collect();
    assert_eq!(invalid, [false, true, true, true, true, false]);
    let said: Vec<String> = imported.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "`y`: 1 times `BAD`, read as missing",
            "`y`: 1 times `Bad`, read as missing",
            "`y`: 1 times `I/O Timeout`, read as missing",
            "`y`: 1 times `Kaputt`, read as missing",
            "`y` has 4 samples that are not valid (NaN)",
        ]
    );
    let other = Selection {
        reading: Reading::default(),
        ..allowed.clone()
    };
    assert_eq!(
        read_as(text.as_bytes(), other).unwrap_err(),
        "line 6, column `y`: expected a finite number, found `Kaputt`"
    );
    let number = Selection {
        reading: Reading {
            bad_values: vec!["-9999".to_owned()],
            ..Reading::default()
        },
        ..allowed
    };
    assert_eq!(
        read_as(text.as_bytes(), number).unwrap_err(),
        "--bad-values: expected words, found the number `-9999`"
    );
}

#[test]
fn a_row_of_units_below_the_header_gives_the_units() {
    let imported = read("time;y;u\ns;degC;-\n0;1,5;3\n1;2,5;4\n", Reading::default()).unwrap();
    assert_eq!(imported.dataset.outputs()[0].unit, "degC");
    assert_eq!(y(&imported), [1.5, 2.5]);
    assert_eq!(
        imported.warnings,
        [Warning::DecimalComma, Warning::UnitRow { line: 2 }]
    );
    assert_eq!(imported.total_rows, 2);
    // A row without a number above one without is none, nor one of words for missing values.
    assert_eq!(
        read("n,y\na,b\nc,d\n", Reading::default()).unwrap_err(),
        "line 2, column `y`: expected a finite number, found `b`"
    );
    assert_eq!(
        read("n,y\nBad,Bad\n1,2\n", Reading::default()).unwrap_err(),
        "line 2, column `y`: expected a finite number, found `Bad`, a word for none"
    );
}

#[test]
fn lines_before_the_header_are_passed_over_when_asked() {
    let text = "Plant 3, unit A\n\"made, with care\"\n\ntime;y\n0;1\n1;x\n";
    let header = |line| Reading {
        header_line: Some(line),
        ..Reading::default()
    };
    assert_eq!(
        read(text, header(4)).unwrap_err(),
        "line 6, column `y`: expected a finite number, found `x`"
    );
    assert_eq!(
        y(&read(&text.replace('x', "2"), header(4)).unwrap()),
        [1.0, 2.0]
    );
    assert_eq!(
        read(text, header(9)).unwrap_err(),
        "--header-line: expected a line of the file, which has 6, found 9"
    );
    assert_eq!(
        read(text, header(0)).unwrap_err(),
        "--header-line: expected a line from 1 on, found 0"
    );
    // Commas in quotes, and decimal ones outside, do not separate.
    let text = "time;\"u, in C\";x 2,5 m;y\n0;1;1;2,5\n1;2;1;3,5\n";
    let imported = read(text, Reading::default()).unwrap();
    assert_eq!(y(&imported), [2.5, 3.5]);
    assert_eq!(imported.warnings, [Warning::DecimalComma]);
    for rows in ["0;1;2\n", "0;0,5;2\n1;1,5;2\n"] {
        let text = format!("Report of unit A\n\ntime;y;u\n{rows}");
        assert_eq!(
            read(&text, Reading::default()).unwrap_err(),
            "line 1: expected a header row of tags, found 1 field where line 3 has 3; if that is \
             the header, give --header-line 3"
        );
    }
}

#[test]
fn times_are_read_in_the_zone_and_format_that_are_given() {
    let text = "time,y\n25/10/2026 02:00,1\n25/10/2026 02:30,2\n25/10/2026 02:00,3\n\
                25/10/2026 02:30,4\n25/10/2026 03:00,5\n";
    let rome = Reading {
        time_zone: Some("Europe/Rome".to_owned()),
        ..Reading::default()
    };
    let imported = read(text, rome.clone()).unwrap();
    assert_eq!(
        imported.dataset.sample_time_s().to_bits(),
        1800_f64.to_bits()
    );
    // date -u -d 2026-10-25T00:00:00 +%s
    assert_eq!(imported.start_unix_ns, Some(1_792_886_400_000_000_000));
    let said: Vec<String> = imported.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "the times of `time` are read as `%d/%m/%Y %H:%M`; --time-format says otherwise",
            "4 times of the hour that comes twice when clocks are put back are told apart by their \
             order",
        ]
    );
    assert_eq!(
        read(&text.replace("25/10", "29/03"), rome).unwrap_err(),
        "line 2, column `time`: expected a time that Europe/Rome has, found 2026-03-29T02:00:00, \
         which is passed over when clocks are put forward; give the zone the times were written in \
         (--time-zone)"
    );
    let zone = Reading {
        time_zone: Some("Europe/Atlantis".to_owned()),
        ..Reading::default()
    };
    assert_eq!(
        read(text, zone).unwrap_err(),
        "--time-zone: expected a name of the IANA database such as Europe/Rome, found \
         `Europe/Atlantis`"
    );
    let format = Reading {
        time_format: Some("%Y|%j %H".to_owned()),
        ..Reading::default()
    };
    let imported = read("time,y\n2026|032 01,1\n2026|032 02,2\n", format.clone()).unwrap();
    // date -u -d 2026-02-01T01:00:00 +%s
    assert_eq!(imported.start_unix_ns, Some(1_769_907_600_000_000_000));
    assert_eq!(
        read(text, format).unwrap_err(),
        "line 2, column `time`: expected a time like `%Y|%j %H`, found `25/10/2026 02:00`"
    );
    assert_eq!(
        read("time,y\n03/04/2026,1\n03/04/2026,2\n", Reading::default()).unwrap_err(),
        "column `time`: expected times that tell day from month, found none from `03/04/2026` on; \
         give --time-format \"%d/%m/%Y\" or --time-format \"%m/%d/%Y\""
    );
}

#[test]
fn large_numbers_are_times_since_1970() {
    for (first, second, unit) in [
        ("1775211630.25", "1775211630.75", "seconds"),
        ("1775211630250", "1775211630750", "milliseconds"),
    ] {
        let text = format!("time,y\n{first},1\n{second},2\n");
        let imported = read(&text, Reading::default()).unwrap();
        assert_eq!(imported.start_unix_ns, Some(1_775_211_630_250_000_000));
        assert_eq!(
            imported.dataset.sample_time_s().to_bits(),
            0.5_f64.to_bits()
        );
        let column = "time".to_owned();
        assert_eq!(imported.warnings, [Warning::EpochTimes { column, unit }]);
    }
    assert_eq!(
        read("time,y\n1775211630,1\nlater,2\n", Reading::default()).unwrap_err(),
        "line 3, column `time`: expected seconds since 1970, as before, found `later`"
    );
}

proptest! {
    /// Any numbers come back bit for bit in any dress.
    #[test]
    fn prop_numbers_survive_every_dress(
        values in prop::collection::vec(prop::num::f64::NORMAL, 2..20),
        comma in any::<bool>(),
        wide in any::<bool>(),
        units in any::<bool>(),
    ) {
        let mut text = "\u{feff}time;y\n".to_owned();
        if units {
            text += "s;kg/s\n";
        }
        for (row, value) in values.iter().enumerate() {
            writeln!(text, "{row};{value:e}").unwrap();
        }
        let text = if comma { text.replace('.', ",") } else { text };
        let bytes = if wide { wide_text(&text, u16::to_le_bytes) } else { text.into_bytes() };
        let imported = read_as(&bytes, Selection::default()).unwrap();
        prop_assert_eq!(y(&imported), &values[..]);
    }

    /// No bytes make the reader panic, whatever is asked of it.
    #[test]
    fn prop_no_bytes_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        encoding in prop::option::of(prop::sample::select(vec!["windows-1252", "utf-16le", "gbk"])),
        header_line in prop::option::of(1_u64..4),
        comma in any::<bool>(),
    ) {
        let reading = Reading {
            encoding: encoding.map(str::to_owned),
            header_line,
            decimal: comma.then_some(Decimal::Comma),
            ..Reading::default()
        };
        let _ = read_as(&bytes, with(reading));
    }

    /// Nor does any text that looks like an export.
    #[test]
    fn prop_no_text_panics(text in "(time|t|y|[;,\t\n\r\"]|[0-9]{1,14}|[./:-]|Bad|sep=|\\+|[A-Z]){0,60}") {
        let allowed = Selection { missing: Missing::Break, ..Selection::default() };
        let _ = read_as(text.as_bytes(), allowed);
    }
}
