//! Campaigns that are refused: files that make no sense, folders of others.

use crate::campaign::{SPEC, place};

/// What is replaced by what, and what is said of it.
const MISTAKES: &[(&str, &str, &[&str])] = &[
    (
        "runs = 200",
        "runs = 0",
        &["spec.toml: runs: expected from 1 to 1000000000, found 0"],
    ),
    (
        "runs = 200",
        "runs = -3",
        &["spec.toml: ", "runs", "invalid value: integer `-3`"],
    ),
    (
        "runs = 200",
        "runs = 200\nrun = 3",
        &["spec.toml: ", "unknown field `run`", "line 3"],
    ),
    ("seed = 5\n", "", &["spec.toml: ", "missing field `seed`"]),
    (
        "0.2",
        "1.2",
        &["healthy_share: expected a share from 0 to 1, found 1.2"],
    ),
    (
        "\"lively\"",
        "\"wild\"",
        &[
            "plant.profile: ",
            "expected one of steady, gentle",
            "found `wild`",
        ],
    ),
    (
        "table8",
        "table9",
        &[
            "spec.toml: ",
            "noise: expected one of none, low",
            "found `table9`",
        ],
    ),
    (
        "duration_s = 40.0",
        "duration_s = -40.0",
        &[
            "record.duration_s: expected at least a sample time",
            "found -40",
        ],
    ),
    (
        "table8\"",
        "table8\"\nnoise_record_s = 1.0",
        &["plant.noise_record_s: expected at least 10 and finite, found 1"],
    ),
    (
        "duration_s = 40.0",
        "duration_s = nan",
        &["record.duration_s: ", "found NaN"],
    ),
    (
        "[15.0, 20.0]",
        "[20.0, 15.0]",
        &["record.onset_s[1]: expected from 20 to the duration of 40, found 15"],
    ),
    (
        "[15.0, 20.0]",
        "[15.0, 45.0]",
        &["record.onset_s[1]: ", "found 45"],
    ),
    (
        "horizon_s = 20.0",
        "horizon_s = 21.0",
        &[
            "record.horizon_s: expected above 0 and at most 20",
            "found 21",
        ],
    ),
    (
        "case = 1",
        "case = 7",
        &[
            "spec.toml: ",
            "invalid value: integer `7`, expected a case from 1 to 4 or one of compressor_fouling",
        ],
    ),
    (
        "\"turbine_damage\"",
        "\"rust\"",
        &["invalid value: string \"rust\", expected a case from 1 to 4"],
    ),
    (
        "[0.1, 1.0]",
        "[1.0, 0.1]",
        &["faults[1].size: expected a largest size of at least the smallest, 1, found 0.1"],
    ),
    (
        "log_uniform = [0.1, 1.0]",
        "log_uniform = [0.0, 1.0]",
        &["faults[1].size: expected a finite number above 0, found 0"],
    ),
    (
        "[0.1, 1.0]",
        "[0.1, 120.0]",
        &["faults[1].size: ", "between -100 and 100, found 120"],
    ),
    (
        "shape = { ramp = { rise_s = 5.0 } }",
        "sign = \"negative\"",
        &["faults[0].sign: ", "at least 0, found -3"],
    ),
    (
        "rise_s = 5.0",
        "rise_s = 0.0",
        &["faults[0].shape.ramp.rise_s: expected a finite number above 0, found 0"],
    ),
    (
        "ramp = { rise_s",
        "ramp = { rise_h",
        &[
            "spec.toml: ",
            "unexpected keys in table: rise_h, available keys: rise_s",
        ],
    ),
    (
        "ramp =",
        "hill =",
        &[
            "spec.toml: ",
            "unknown variant `hill`, expected one of `step`, `ramp`",
        ],
    ),
    (
        "record_s = 300.0",
        "record_s = 1.0",
        &["model.record_s: expected at least 10 and finite, found 1"],
    ),
    (
        "record_s = 300.0",
        "order = 0",
        &["model.order: expected at least 1, found 0"],
    ),
    (
        "record_s = 300.0",
        "outputs = [\"t9\"]",
        &["model.outputs: expected a channel of the prototype, found `t9`"],
    ),
    (
        "record_s = 300.0",
        "outputs = [\"t3\", \"t3\"]",
        &["model.outputs: expected every tag once, found `t3` twice"],
    ),
    (
        "record_s = 300.0",
        "nk = [0]",
        &["model.nk: expected 2 lags, one an input, found 1"],
    ),
    (
        "arl0_h = 1.0",
        "arl0_h = 0.0",
        &["bank.arl0_h: expected a finite number above 0, found 0"],
    ),
    (
        "arl0_h = 1.0",
        "arl0 = 1.0",
        &["spec.toml: ", "unknown field `arl0`"],
    ),
    (
        "arl0_h = 1.0",
        "tests = []",
        &["bank.tests: expected at least one, found none"],
    ),
    (
        "arl0_h = 1.0",
        "tests = [{ statistic = \"sum\" }]",
        &[
            "bank.tests[0].statistic: expected one of threshold",
            "found `sum`",
        ],
    ),
    (
        "arl0_h = 1.0",
        "tests = [{ statistic = \"cusum\", window = 5 }]",
        &["bank.tests[0].window: expected with the statistic"],
    ),
    (
        "arl0_h = 1.0",
        "tests = [{ statistic = \"cusum\", watch = \"joint\" }]",
        &["bank.tests[0].watch: expected outputs"],
    ),
    (
        "arl0_h = 1.0",
        "isolator = true\ntests = []",
        &["bank.tests: expected none with `isolator = true`, which has its own, found some"],
    ),
    (
        "calibration_h = 1.0",
        "isolator = true\ncalibration_h = 0.0",
        &["bank.calibration_h: expected a finite number above 0, found 0"],
    ),
];

#[test]
fn campaigns_that_make_no_sense_are_refused_before_any_work() {
    for (from, to, texts) in MISTAKES {
        assert!(SPEC.contains(from), "{from}");
        let place = place(&SPEC.replacen(from, to, 1));
        place.refused(&["campaign", "spec.toml", "--out", "out"], texts);
    }
    let place = place(SPEC);
    place.refused(
        &["campaign", "spec.toml", "--only", "200"],
        &["--only 200: expected below the number of runs, 200, found 200"],
    );
}

#[test]
fn another_campaign_is_not_continued() {
    let small = SPEC.replace("runs = 200", "runs = 9");
    let place = place(&small);
    let args = ["campaign", "spec.toml", "--out", "out"];
    place.done(&args);
    for (from, to, message) in [
        (
            "seed = 5",
            "seed = 6",
            "seed: expected 5, with which the campaign began, found 6",
        ),
        ("runs = 9", "runs = 10", "runs: expected 9"),
        (
            "table8",
            "low",
            "plant.noise: expected \"table8\", with which the campaign began, found \"low\"",
        ),
        (
            "[0.1, 1.0]",
            "[0.2, 1.0]",
            "faults[1].size.log_uniform[0]: expected 0.1",
        ),
        (
            "horizon_s = 20.0\n",
            "",
            "record.horizon_s: expected 20.0, with which the campaign began, found nothing",
        ),
    ] {
        place.write("other.toml", small.replace(from, to));
        let args = ["campaign", "other.toml", "--out", "out"];
        place.refused(
            &args,
            &["out/campaign.toml: ", message, "take another folder"],
        );
        place.refused(&[&args[..], &["--only", "1"]].concat(), &[message]);
    }
    // The bank is part of it.
    let bank = place.read("out/bank.json");
    place.write("out/bank.json", [&bank[..], b"\n"].concat());
    place.refused(&args, &["out/campaign.toml: bank_sha256: expected "]);
    place.write("out/bank.json", &bank);
    place.done(&args);
}

#[test]
fn folders_with_other_things_are_refused() {
    let place = place(SPEC);
    std::fs::create_dir(place.path("full")).expect("a folder");
    place.write("full/notes.txt", "mine");
    let args = ["campaign", "spec.toml", "--out", "full"];
    place.refused(
        &args,
        &["full: expected an empty folder or one of this campaign, found `notes.txt`"],
    );
    place.write("file", "");
    let args = ["campaign", "spec.toml", "--out", "file"];
    place.ends_badly(
        1,
        &mut place.command(&args),
        &["file: cannot make the folder"],
    );
    place.refused(&["campaign", "spec.toml"], &["--out: required"]);
    place.refused(
        &["campaign", "--compare", "full", "--out", "out"],
        &["--compare: expected two folders or more, separated by commas, found 1"],
    );
    place.refused(
        &["campaign", "--compare", "full,out", "--out", "out"],
        &["--out: expected another folder than those that are compared, found out"],
    );
    place.refused(
        &["campaign", "--compare", "full,file", "--out", "out"],
        &["full/campaign.toml: cannot read"],
    );
    place.refused(
        &["campaign", "nothing.toml", "--out", "out"],
        &["nothing.toml: cannot read"],
    );
}
