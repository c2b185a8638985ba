//! Suggested roles of tags against plants whose inputs and outputs are known, with the tags' names
//! and without: hits and misses are counted, not hoped for.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use gt_log::{Confidence, DataCheck, NotCompared, Reason, Selection, Suggestion, check};
use gtfdi::plant::{NoiseLevel, Scenario, Variant, simulate};
use tempfile::tempdir;

/// A record as text, and which of its columns are inputs.
struct Truth {
    header: Vec<String>,
    rows: String,
    is_input: fn(&str) -> bool,
}

/// What became of the suggestions.
#[derive(Debug, PartialEq, Eq)]
struct Hits {
    inputs: usize,
    inputs_right: usize,
    outputs: usize,
    outputs_right: usize,
}

fn check_text(text: &str) -> DataCheck {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.csv");
    fs::write(&path, text).unwrap();
    check(&path, &Selection::default()).unwrap()
}

impl Truth {
    fn public(test: &str, name: &str, is_input: fn(&str) -> bool) -> Option<Self> {
        let Some(folder) = std::env::var_os("GTFDI_REFERENCE_DATA").map(PathBuf::from) else {
            println!("skipped: {test}: GTFDI_REFERENCE_DATA is not set");
            return None;
        };
        let text = fs::read_to_string(folder.join(name)).unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        Some(Self {
            header: header.trim().split(',').map(str::to_owned).collect(),
            rows: rows.to_owned(),
            is_input,
        })
    }

    /// Five minutes of the turbine under its standard excitation, with the sensors' noise.
    fn turbine(variant: Variant) -> Self {
        let scenario = Scenario {
            duration_s: 300.0,
            seed: 1,
            noise: NoiseLevel::Low.into(),
            ..Scenario::of(variant)
        };
        let run = simulate(&scenario).unwrap();
        let data = &run.measured;
        let signals = data.inputs().iter().chain(data.outputs());
        let mut rows = String::new();
        for (u, y) in data.u().column_iter().zip(data.y().column_iter()) {
            let cells: Vec<String> = u.iter().chain(&y).map(ToString::to_string).collect();
            writeln!(rows, "{}", cells.join(",")).unwrap();
        }
        Self {
            header: signals.map(|signal| signal.name.clone()).collect(),
            rows,
            is_input: |name| ["a_v", "M_f", "w_ref", "p_a", "T_a", "LHV"].contains(&name),
        }
    }

    fn named(&self) -> DataCheck {
        check_text(&format!("{}\n{}", self.header.join(","), self.rows))
    }

    /// The same record under names that tell nothing.
    fn nameless(&self) -> DataCheck {
        let names: Vec<String> = (0..self.header.len()).map(|k| format!("tag{k}")).collect();
        check_text(&format!("{}\n{}", names.join(","), self.rows))
    }

    /// The name in the file of a tag, also of one whose name was taken.
    fn name<'a>(&'a self, tag: &'a str) -> &'a str {
        let column = tag
            .strip_prefix("tag")
            .and_then(|k| k.parse::<usize>().ok());
        column.map_or(tag, |column| &self.header[column])
    }

    fn hits(&self, found: &DataCheck) -> Hits {
        let right = |side: &[Suggestion], wanted: bool| {
            let is_right = |own: &&Suggestion| (self.is_input)(self.name(&own.tag)) == wanted;
            side.iter().filter(is_right).count()
        };
        Hits {
            inputs: found.suggested_inputs.len(),
            inputs_right: right(&found.suggested_inputs, true),
            outputs: found.suggested_outputs.len(),
            outputs_right: right(&found.suggested_outputs, false),
        }
    }
}

fn hits([inputs, inputs_right, outputs, outputs_right]: [usize; 4]) -> Hits {
    Hits {
        inputs,
        inputs_right,
        outputs,
        outputs_right,
    }
}

fn own<'a>(side: &'a [Suggestion], tag: &str) -> &'a Suggestion {
    side.iter().find(|own| own.tag == tag).unwrap()
}

/// Without its names the prototype tells two of its three inputs that move; the third, the fuel, is
/// what the governor makes of the speed, and follows. On the mains the fuel acts within a sample, and
/// a temperature looks as if it led.
#[test]
fn regress_the_turbine_without_names() {
    let prototype = Truth::turbine(Variant::Prototype);
    let found = prototype.nameless();
    assert_eq!(prototype.hits(&found), hits([2, 2, 27, 26]));
    let [valve, reference] = &found.suggested_inputs[..] else {
        panic!("{:?}", found.suggested_inputs);
    };
    assert_eq!(prototype.name(&valve.tag), "a_v");
    assert_eq!(valve.confidence, Confidence::Possible);
    assert_eq!(prototype.name(&reference.tag), "w_ref");
    assert_eq!(reference.confidence, Confidence::Likely);
    assert!(matches!(reference.reasons[1], Reason::Held { share } if share > 0.9));
    let fuel = found.suggested_outputs.iter();
    let fuel: Vec<&Suggestion> = fuel
        .filter(|own| prototype.name(&own.tag) == "M_f")
        .collect();
    assert!(
        matches!(fuel[..], [own] if own.confidence == Confidence::Possible),
        "{fuel:?}"
    );
    // Three boundary conditions and two temperatures that follow them stand still, and have no role.
    assert_eq!(found.comparison.unwrap().tags, 6 + 28 - 5);

    let cogeneration = Truth::turbine(Variant::Cogeneration);
    let found = cogeneration.nameless();
    assert_eq!(cogeneration.hits(&found), hits([2, 1, 3, 3]));
    assert_eq!(found.suggested_inputs[0].confidence, Confidence::Likely);
    assert_eq!(found.suggested_inputs[1].confidence, Confidence::Possible);
}

/// The public records without their names: `[suggested inputs, of those right, suggested outputs, of
/// those right]`. What is likely is right everywhere; of 14 possible inputs one is wrong.
#[test]
fn regress_public_records_without_names() {
    let u: fn(&str) -> bool = |name| name.starts_with('u');
    for (name, expected) in [
        ("powerplant", [5, 4, 1, 1]),
        ("dryer", [1, 1, 1, 1]),
        ("winding", [2, 2, 1, 1]),
        ("evaporator", [3, 3, 3, 3]),
        ("destill_n10", [2, 2, 1, 1]),
        ("destill_clean", [4, 4, 3, 3]),
    ] {
        let file = format!("{name}.csv");
        let Some(truth) = Truth::public("regress_public_records_without_names", &file, u) else {
            return;
        };
        let found = truth.nameless();
        assert_eq!(truth.hits(&found), hits(expected), "{name}: {found:#?}");
        let likely = |own: &&Suggestion| own.confidence == Confidence::Likely;
        for own in found.suggested_inputs.iter().filter(likely) {
            assert!(u(truth.name(&own.tag)), "{name}: {own:?}");
        }
    }
}

/// A process in closed loop: the names tell all 52 roles, the record alone none of the inputs, and
/// that it does not tell them is said.
#[test]
fn regress_the_tennessee_eastman_process() {
    let name = "regress_the_tennessee_eastman_process";
    let Some(truth) = Truth::public(name, "tep/d00.csv", |name| name.starts_with("xmv")) else {
        return;
    };
    let found = truth.named();
    assert_eq!(truth.hits(&found), hits([11, 11, 41, 41]));
    // The feed's valve is moved by the controller of a composition, which an analyser measures.
    let feed = own(&found.suggested_inputs, "xmv3");
    assert_eq!(feed.confidence, Confidence::Possible);
    let analyser = "xmeas23".to_owned();
    assert_eq!(feed.reasons[1], Reason::Follows { tag: analyser });
    let analyser = own(&found.suggested_outputs, "xmeas23");
    assert_eq!(analyser.reasons[1], Reason::Renewed { samples: 2 });
    let slow = own(&found.suggested_outputs, "xmeas37");
    assert_eq!(slow.reasons[1], Reason::Renewed { samples: 5 });
    let cooling = own(&found.suggested_inputs, "xmv11");
    let twin = "xmeas17".to_owned();
    assert_eq!(cooling.reasons[1], Reason::MovesAsOne { tag: twin });

    let found = truth.nameless();
    assert_eq!(truth.hits(&found), hits([2, 0, 30, 27]));
    let mut sides = found
        .suggested_inputs
        .iter()
        .chain(&found.suggested_outputs);
    assert!(sides.all(|own| own.confidence == Confidence::Possible));
}

/// Constant, empty and text columns have no role, whatever their names; tags with times of their own
/// are not compared.
#[test]
fn what_does_not_move_has_no_role() {
    let mut text = "time,u1,u2,y1,y2\n".to_owned();
    for k in 0..60 {
        writeln!(text, "{k},5,,stuck,{}", k * k % 7).unwrap();
    }
    let found = check_text(&text);
    assert_eq!(found.suggested_inputs, []);
    assert_eq!(found.suggested_outputs.len(), 1, "{found:?}");
    assert_eq!(found.suggested_outputs[0].tag, "y2");
    assert_eq!(found.not_compared, Some(NotCompared::FewTags { found: 1 }));
    let mut text = "tag,time,value\n".to_owned();
    for k in 0..60 {
        writeln!(text, "a,{k},{}\nb,{}.5,{}", k * k % 7, k, k * k % 5).unwrap();
    }
    let found = check_text(&text);
    assert_eq!(found.not_compared, Some(NotCompared::OwnTimes));
    let whole = serde_json::to_value(&found).unwrap();
    assert_eq!(whole["not_compared"]["kind"], "own-times");
}
