//! `gtfdi campaign`: rows that are the same however the work was cut, and files that are whole.

use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use gt_campaign::campaign::{Row, Spec, Status, finished_rows};
use serde_json::Value;

use crate::document::{Document, Step, commands};
use crate::place::{Place, Ran};

/// 200 runs of 40 s of four faults, limits for one false alarm in an hour: some seconds of work.
pub const SPEC: &str = "\
seed = 5
runs = 200
healthy_share = 0.2

[plant]
profile = \"lively\"
noise = \"table8\"

[record]
duration_s = 40.0
onset_s = [15.0, 20.0]
horizon_s = 20.0

[[faults]]
case = 1
size = { uniform = [0.5, 3.0] }
shape = { ramp = { rise_s = 5.0 } }

[[faults]]
case = 2
size = { log_uniform = [0.1, 1.0] }
sign = \"both\"

[[faults]]
case = \"turbine_damage\"
size = { uniform = [0.5, 3.0] }
shape = { exponential = { time_constant_s = 4.0 } }

[model]
record_s = 300.0

[bank]
arl0_h = 1.0
calibration_h = 1.0
";

/// How the name of a file under construction ends.
const PART: &str = ".part";

/// Longer than any of these campaigns takes.
const PATIENCE: Duration = Duration::from_secs(300);

pub fn place(spec: &str) -> Place {
    let place = Place::new();
    place.write("spec.toml", spec);
    place
}

fn started(place: &Place, args: &[&str], threads: &str) -> Child {
    let mut command = place.command(args);
    command.env("RAYON_NUM_THREADS", threads);
    let command = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("the binary starts")
}

/// The files of a folder whose names hold `text`.
fn files(folder: &Path, text: &str) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let names = entries.map(|entry| {
        entry
            .expect("a file")
            .file_name()
            .to_string_lossy()
            .into_owned()
    });
    let mut names: Vec<String> = names.filter(|name| name.contains(text)).collect();
    names.sort();
    names
}

/// Waits until a folder has as many chunks of rows; false when the process ends before.
fn wait_for_chunks(child: &mut Child, folder: &Path, count: usize) -> bool {
    let begun = Instant::now();
    loop {
        let chunks = files(folder, "rows-")
            .into_iter()
            .filter(|name| !name.ends_with(PART));
        if chunks.count() >= count {
            return true;
        }
        if child.try_wait().expect("a child").is_some() {
            return false;
        }
        assert!(begun.elapsed() < PATIENCE, "no chunk of rows");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn rows(place: &Place, folder: &str) -> Vec<Row> {
    finished_rows(&place.path(folder)).expect("rows")
}

/// What the columns of a row say of each other: a sample above a limit is an alarm.
fn consistent(rows: &[Row]) {
    for row in rows {
        let alarms = row.false_alarms.expect("a count");
        let before = row.peak_before.expect("a peak");
        assert_eq!(alarms > 0, before > 1.0, "{row:?}");
        let detected = row.delay_s.is_some_and(|delay_s| delay_s <= 20.0);
        assert_eq!(row.detected, row.case.map(|_| detected), "{row:?}");
        let above = row.peak_after.is_some_and(|peak| peak > 1.0);
        // An alarm that is up at the onset is no new one.
        assert!(above || !detected, "{row:?}");
        assert!(detected || !above || alarms > 0, "{row:?}");
        if let (Some(onset_s), Some(alarm_s)) = (row.onset_s, row.alarm_s) {
            assert!((15.0..=20.0).contains(&onset_s), "{row:?}");
            // A difference of two times below 40 s.
            assert!(
                (alarm_s - onset_s - row.delay_s.expect("a delay")).abs() < 1e-12,
                "{row:?}"
            );
        }
    }
}

#[test]
fn killed_campaigns_have_the_rows_of_one_that_was_left_alone() {
    let place = place(SPEC);
    // One thread, from beginning to end.
    let whole = started(
        &place,
        &["campaign", "spec.toml", "--out", "whole", "--json"],
        "1",
    );
    let whole = whole.wait_with_output().expect("an end");
    let text = String::from_utf8_lossy(&whole.stderr);
    assert_eq!(whole.status.code(), Some(0), "{text}");
    let summary: Value = serde_json::from_slice(&whole.stdout).expect("one JSON object");

    // Two threads, killed at two places, with a half-written file and a broken one left over.
    let args = ["campaign", "spec.toml", "--out", "cut"];
    let folder = place.path("cut");
    for chunks in [1, 3] {
        let mut child = started(&place, &args, "2");
        assert!(
            wait_for_chunks(&mut child, &folder, chunks),
            "it ended before it was killed"
        );
        child.kill().expect("killed");
        child.wait().expect("an end");
    }
    let kept = files(&folder, "rows-")
        .into_iter()
        .filter(|name| !name.ends_with(PART));
    let kept = kept.count();
    assert!((3..7).contains(&kept), "{kept} of 7 chunks");
    place.write("cut/rows-00006-0123456789abcdef.parquet.part", "half");
    place.write("cut/rows-00006-0123456789abcdef.parquet", "broken");
    let first = &files(&folder, "rows-00")[0];
    let mut bytes = place.read(&format!("cut/{first}"));
    bytes[100] ^= 1;
    place.write(&format!("cut/{first}"), bytes);
    let summary_cut = place.json(&args);
    assert_eq!(files(&folder, ".part"), [""; 0]);
    assert_eq!(files(&folder, "rows-"), [""; 0]);

    let (expected, found) = (rows(&place, "whole"), rows(&place, "cut"));
    assert!(expected.iter().map(|row| row.run).eq(0..200));
    assert_eq!(found, expected);
    consistent(&expected);
    let bytes = |name: &str| place.read(&format!("{name}/rows.parquet"));
    assert!(bytes("cut") == bytes("whole"), "the same rows, other bytes");
    assert_eq!(summary_cut, summary);
    assert_eq!(summary["failed"], 0);
    let detected = |fault: usize| &summary["faults"][fault]["detected"];
    let share = detected(0)["share"].as_f64().expect("a share");
    assert!((0.8..=1.0).contains(&share), "{}", detected(0));
    let of: u64 = (0..3)
        .map(|fault| detected(fault)["of"].as_u64().expect("a count"))
        .sum();
    assert_eq!(of + summary["healthy"].as_u64().expect("a count"), 200);

    // Once more changes nothing, and any row is made alone: with the folder's bank and with its own.
    let before = bytes("whole");
    assert_eq!(
        place.json(&["campaign", "spec.toml", "--out", "whole"]),
        summary
    );
    assert!(bytes("whole") == before, "finished rows changed");
    for (index, folder) in [("0", None), ("77", Some("whole")), ("199", Some("cut"))] {
        let out: Vec<&str> = folder
            .into_iter()
            .flat_map(|name| ["--out", name])
            .collect();
        let args = [&["campaign", "spec.toml", "--only", index], &out[..]].concat();
        let alone: Value = serde_json::from_str(&place.done(&args)).expect("one JSON object");
        let place: usize = index.parse().expect("an index");
        let stored = serde_json::to_value(&expected[place]).expect("a row");
        assert_eq!(alone, stored);
    }
    for name in [
        "report.html",
        "summary.json",
        "figures/roc.svg",
        "campaign.toml",
        "bank.json",
    ] {
        assert!(place.path("cut").join(name).exists(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_campaign_that_goes_on() {
    let place = place(SPEC);
    let args = ["campaign", "spec.toml", "--out", "out"];
    let mut child = started(&place, &args, "2");
    assert!(
        wait_for_chunks(&mut child, &place.path("out"), 1),
        "it ended too soon"
    );
    // A second process has no business there.
    // The first one goes on writing meanwhile.
    let second = place.run(&args);
    assert_eq!((second.code, second.stdout.as_str()), (1, ""));
    let text = "another process at work";
    assert!(second.stderr.contains(text), "{}", second.stderr);
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(sent.expect("kill").success());
    let ended = child.wait_with_output().expect("an end");
    let text = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{text}");
    let hint = "of 200 runs; `gtfdi campaign spec.toml --out out` goes on from there";
    assert!(
        text.contains("stopped after ") && text.contains(hint),
        "{text}"
    );
    assert_eq!(files(&place.path("out"), ".part"), [""; 0]);
    assert!(!files(&place.path("out"), "rows-").is_empty());
    place.done(&args);
    assert!(rows(&place, "out").iter().map(|row| row.run).eq(0..200));
}

/// Files that may not grow stand for a disk that is full.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_a_campaign_that_goes_on() {
    let place = place(SPEC);
    let args = ["campaign", "spec.toml", "--out", "out"];
    let mut child = started(&place, &args, "2");
    assert!(
        wait_for_chunks(&mut child, &place.path("out"), 1),
        "it ended too soon"
    );
    child.kill().expect("killed");
    child.wait().expect("an end");
    // A file that was under construction when it was killed goes when the folder is opened.
    let before = files(&place.path("out"), "rows-");
    let before = before.iter().filter(|name| !name.ends_with(PART)).count();
    let mut shell = std::process::Command::new("sh");
    let script = "trap '' XFSZ; ulimit -f 2; exec \"$0\" campaign spec.toml --out out";
    shell.args(["-c", script, env!("CARGO_BIN_EXE_gtfdi")]);
    shell.current_dir(place.path("out").parent().expect("a folder"));
    let ran = Ran::of(&mut shell);
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    for text in [
        "rows-",
        "too large",
        "of 200 runs are kept in out, and the same command goes on",
    ] {
        assert!(
            ran.stderr.contains(text),
            "expected `{text}` in\n{}",
            ran.stderr
        );
    }
    assert_eq!(files(&place.path("out"), ".part"), [""; 0]);
    assert_eq!(files(&place.path("out"), "rows-").len(), before);
    place.done(&args);
    assert!(rows(&place, "out").iter().map(|row| row.run).eq(0..200));
}

/// A loss of flow that the plant does not bear: the run is a row, and the summary says why.
#[test]
fn runs_that_leave_the_plants_range_are_rows_that_say_so() {
    let head = SPEC.split("[[faults]]").next().expect("a head");
    let tail = SPEC.split_once("[model]").expect("a tail").1;
    let fault = "[[faults]]\ncase = 1\nsize = { uniform = [75.0, 90.0] }\n\n[model]";
    let spec = format!("{head}{fault}{tail}").replace("runs = 200", "runs = 24");
    let place = place(&spec);
    let summary = place.json(&["campaign", "spec.toml", "--out", "out"]);
    let rows = rows(&place, "out");
    assert_eq!(rows.len(), 24);
    let failed: Vec<&Row> = rows
        .iter()
        .filter(|row| row.status == Status::Failed)
        .collect();
    let faulty = rows.iter().filter(|row| row.case.is_some()).count();
    assert!(
        faulty >= 12 && failed.len() == faulty,
        "{} of {faulty}",
        failed.len()
    );
    for row in &failed {
        let (onset_s, failed_s) = (
            row.onset_s.expect("an onset"),
            row.failed_s.expect("a time"),
        );
        assert!((0.0..3.0).contains(&(failed_s - onset_s)), "{row:?}");
        assert!(
            row.reason
                .as_ref()
                .is_some_and(|reason| reason.contains(": left ")),
            "{row:?}"
        );
        assert_eq!(
            (row.detected, row.false_alarms, row.alarm_s),
            (None, None, None)
        );
    }
    assert_eq!(summary["failed"], failed.len());
    let counted = summary["failures"].as_array().expect("a list").iter();
    let counted: u64 = counted
        .map(|failure| failure["runs"].as_u64().expect("a count"))
        .sum();
    assert_eq!(counted, failed.len() as u64);
    assert_eq!(summary["faults"][0]["detected"]["of"], 0);
}

#[test]
fn a_bank_of_a_file_judges_without_a_model() {
    let made = SPEC.replace("runs = 200", "runs = 40");
    let place = place(&made);
    place.done(&["campaign", "spec.toml", "--out", "made"]);
    std::fs::copy(
        place.path("made").join("bank.json"),
        place.path("bank.json"),
    )
    .expect("a copy");
    let head = made.split("[model]").next().expect("a head");
    place.write("given.toml", format!("bank = \"bank.json\"\n{head}"));
    place.done(&["campaign", "given.toml", "--out", "given"]);
    assert_eq!(rows(&place, "given"), rows(&place, "made"));
    // With another bank it is another campaign.
    let bank = place.read("bank.json");
    place.write("bank.json", [&bank[..], b" "].concat());
    let args = ["campaign", "given.toml", "--out", "given"];
    place.refused(&args, &["given/campaign.toml: bank_sha256: expected "]);
    place.write("given.toml", format!("bank = \"bank.json\"\n{made}"));
    place.refused(
        &["campaign", "given.toml", "--out", "more"],
        &["given.toml: ", "duplicate key"],
    );
    place.write("given.toml", format!("bank = \"none.json\"\n{head}"));
    place.refused(
        &["campaign", "given.toml", "--out", "more"],
        &["none.json: cannot read"],
    );
}

#[test]
fn the_campaign_of_the_readme_runs_as_printed() {
    let readme = Document::read("README.md");
    let place = place("");
    let files = readme.files("toml").into_iter();
    let mut files = files.filter(|(name, _)| *name == "drift_campaign.toml");
    let (name, text) = files.next().expect("the campaign");
    place.write(name, text);
    let commands = commands(readme.block_with("sh", "gtfdi campaign drift_campaign"));
    assert_eq!(commands.len(), 2);
    let summary = Step::run(&place, commands[0].clone()).report();
    assert_eq!(
        (&summary["runs"], &summary["failed"]),
        (&Value::from(200), &Value::from(0))
    );
    let fault = &summary["faults"][0];
    let share = |bin: usize| {
        fault["sizes"][bin]["detected"]["share"]
            .as_f64()
            .expect("a share")
    };
    // From a fiftieth of a percent to half a percent.
    assert!(share(0) < 0.3 && share(7) > 0.9, "{fault}");
    let row: Value = serde_json::from_str(&Step::run(&place, commands[1].clone()).stdout)
        .expect("one JSON object");
    let stored = serde_json::to_value(&rows(&place, "drift")[17]).expect("a row");
    assert_eq!(row, stored);
}

/// Nothing of them is run: they take minutes.
#[test]
fn the_examples_are_read() {
    let folder = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/campaigns"
    ));
    for (name, runs) in [("four_faults.toml", 1000), ("named_faults.toml", 10_000)] {
        let spec = Spec::read(&folder.join(name)).expect("a campaign");
        assert_eq!((spec.runs, spec.faults.len()), (runs, 4), "{name}");
    }
}

/// 64 runs whose faults an isolator names, with limits for one false alarm in an hour. The thermocouple's
/// come at once: the first answer of a filter to a jump is like that of other faults.
const NAMED: &str = "\
seed = 7
runs = 64
healthy_share = 0.1

[plant]
profile = \"lively\"
noise = \"table8\"

[record]
duration_s = 120.0
onset_s = [60.0, 70.0]
horizon_s = 50.0

[[faults]]
case = 1
size = { log_uniform = [0.3, 2.0] }
shape = { ramp = { rise_s = 30.0 } }

[[faults]]
case = 2
size = { log_uniform = [0.3, 2.0] }
sign = \"both\"

[bank]
isolator = true
arl0_h = 1.0
calibration_h = 4.0
";

/// An isolator's campaign has names in its rows, the same alone as among others, and stands beside a
/// bank's.
#[test]
fn campaigns_of_isolators_name_faults_and_are_compared() {
    let place = place(NAMED);
    let summary = place.json(&["campaign", "spec.toml", "--out", "named"]);
    let naming = &summary["naming"];
    // Faults many times the limit: an isolator that tells them apart at all names nearly all.
    let count = |key: &str| naming[key]["count"].as_u64().expect("a count");
    let of = |key: &str| naming[key]["of"].as_u64().expect("a number");
    assert!(
        of("right") >= 40 && 10 * count("right") >= 9 * of("right"),
        "{naming}"
    );
    assert!(
        10 * count("onset_in_interval") >= 8 * of("onset_in_interval"),
        "{naming}"
    );
    let runs = summary["confusion"]["runs"]
        .as_array()
        .expect("rows")
        .iter();
    let all: u64 = runs
        .flat_map(|row| row.as_array().expect("a row"))
        .map(|count| count.as_u64().expect("a count"))
        .sum();
    assert_eq!(all + summary["healthy"].as_u64().expect("a count"), 64);
    let kept = rows(&place, "named");
    for row in &kept {
        assert_eq!(row.right.is_some(), row.case.is_some(), "{row:?}");
        assert!(row.right != Some(true) || row.named == row.fault, "{row:?}");
        assert!(
            row.right != Some(true) || row.found_size.is_some(),
            "{row:?}"
        );
    }
    let page = std::fs::read_to_string(place.path("named/report.html")).expect("a page");
    assert!(
        page.contains("Which fault was named as which"),
        "no confusion matrix"
    );

    let named = kept.iter().find(|row| row.named.is_some()).expect("a name");
    let run = named.run.to_string();
    let args = ["campaign", "spec.toml", "--out", "named", "--only", &run];
    let alone: Value = serde_json::from_str(&place.done(&args)).expect("JSON");
    assert_eq!(alone, serde_json::to_value(named).expect("JSON"));

    place.write("bank.toml", NAMED.replace("isolator = true", ""));
    place.json(&["campaign", "bank.toml", "--out", "tests"]);
    let both = place.json(&["campaign", "--compare", "named,tests", "--out", "both"]);
    assert_eq!(both["campaigns"][0]["name"], "named");
    assert!(both["campaigns"][1]["summary"]["naming"].is_null());
    let keys = both["differences"].as_array().expect("keys").iter();
    let keys: Vec<&str> = keys.filter_map(|own| own["key"].as_str()).collect();
    assert_eq!(keys, ["bank.isolator", "bank.tests[0].statistic"]);
    assert!(place.path("both/comparison.html").exists());
}
