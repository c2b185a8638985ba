//! Which tags look like inputs and which like outputs.
//!
//! | evidence | for an input | for an output |
//! |---|---|---|
//! | the name | 3 | 3 |
//! | the tag's share of leading, see [`lead`] | 2 from 0.95 on, 1 from 0.75 on | 2 up to 0.3 |
//! | it holds its values and jumps | 1 | |
//! | it is renewed every n samples, like an analyser | | 1 |
//!
//! The difference makes a role: likely from 3 on, possible below. A lead counts only beyond chance,
//! not for a tag that is renewed (what is held between looks as if it led) and not for one that
//! moves as one with another. In a closed loop the record alone cannot tell: the controller makes
//! what is set follow what is measured.

mod lead;
mod motion;
mod name;

use std::fmt;

use serde::Serialize;

pub use lead::{Comparison, NotCompared};
use lead::{Lead, compare};
use motion::Motion;

/// Evidence from which a role is likely.
const LIKELY: i32 = 3;
/// Shares of leading.
const LEADS_CLEARLY: f64 = 0.95;
const LEADS: f64 = 0.75;
const FOLLOWS: f64 = 0.3;

/// What a tag is to the plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// It is set from outside.
    Input,
    /// It is what the plant answers.
    Output,
}

/// A tag that looks like an input or like an output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suggestion {
    /// The tag.
    pub tag: String,
    /// How sure that is.
    pub confidence: Confidence,
    /// What the tag explains of the others, as a share of that and of what they explain of it: 1
    /// leads, 0 follows. None where tags were not compared.
    pub lead_share: Option<f64>,
    /// Why, also what speaks against it.
    pub reasons: Vec<Reason>,
}

/// How sure a suggestion is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Confidence {
    /// The name tells it, or several things do.
    Likely,
    /// One thing speaks for it, or others speak against it.
    Possible,
}

/// What speaks for a role, or against it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Reason {
    /// A word of its name.
    Name {
        /// The word.
        word: String,
    },
    /// Its past explains others.
    Leads {
        /// The one that it explains best.
        tag: String,
    },
    /// The pasts of others explain it.
    Follows {
        /// The one that explains it best.
        tag: String,
    },
    /// It moves in steps and holds between them.
    Held {
        /// Share of the samples that repeat the one before.
        share: f64,
    },
    /// It gets a new value at regular times only.
    Renewed {
        /// Every so many samples.
        samples: usize,
    },
    /// It moves as one with another, so that neither leads.
    MovesAsOne {
        /// The other.
        tag: String,
    },
}

/// The suggestions for a table.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Suggestions {
    pub(super) inputs: Vec<Suggestion>,
    pub(super) outputs: Vec<Suggestion>,
    pub(super) comparison: Option<Comparison>,
    pub(super) not_compared: Option<NotCompared>,
}

impl fmt::Display for Confidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Likely => "likely",
            Self::Possible => "possible",
        })
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name { word } => write!(f, "named `{word}`"),
            Self::Leads { tag } => write!(f, "leads `{tag}`"),
            Self::Follows { tag } => write!(f, "follows `{tag}`"),
            Self::Held { share } => write!(f, "steps, held for {:.0} %", 100.0 * share),
            Self::Renewed { samples } => write!(f, "renewed every {samples} samples"),
            Self::MovesAsOne { tag } => write!(f, "moves as one with `{tag}`"),
        }
    }
}

/// Suggests roles for tags that move, of name and values each; NaN is a missing value. Values of
/// several tags belong together where the tags are `aligned`.
pub(super) fn suggest(moving: &[(&str, &[f64])], aligned: bool) -> Suggestions {
    let values: Vec<&[f64]> = moving.iter().map(|(_, values)| *values).collect();
    let compared = if aligned {
        compare(&values)
    } else {
        Err(NotCompared::OwnTimes)
    };
    let mut found = Suggestions::default();
    let leads = match compared {
        Ok((comparison, leads)) => {
            found.comparison = Some(comparison);
            Some(leads)
        }
        Err(cause) => {
            found.not_compared = Some(cause);
            None
        }
    };
    for (index, (tag, values)) in moving.iter().enumerate() {
        let lead = leads.as_ref().map(|leads| &leads[index]);
        let (evidence, reasons) = evidence(tag, Motion::of(values), lead, moving);
        let suggestion = Suggestion {
            tag: (*tag).to_owned(),
            confidence: if evidence.abs() >= LIKELY {
                Confidence::Likely
            } else {
                Confidence::Possible
            },
            lead_share: lead.map(Lead::share),
            reasons,
        };
        match evidence {
            1.. => found.inputs.push(suggestion),
            0 => {}
            _ => found.outputs.push(suggestion),
        }
    }
    found
}

/// What speaks for an input (positive) or an output (negative), and what it is.
fn evidence(
    tag: &str,
    motion: Motion,
    lead: Option<&Lead>,
    moving: &[(&str, &[f64])],
) -> (i32, Vec<Reason>) {
    let mut evidence = 0;
    let mut reasons = Vec::new();
    if let Some((role, word)) = name::hint(tag) {
        evidence += if role == Role::Input { 3 } else { -3 };
        reasons.push(Reason::Name { word });
    }
    let named = |index: usize| moving[index].0.to_owned();
    if let Some(lead) = lead {
        let share = lead.share();
        let may_lead = !matches!(motion, Motion::Renewed(_)) && lead.twin.is_none();
        if let Some(led) = lead.led.filter(|_| may_lead && share >= LEADS) {
            evidence += if share >= LEADS_CLEARLY { 2 } else { 1 };
            reasons.push(Reason::Leads { tag: named(led) });
        }
        if let Some(leader) = lead.leader.filter(|_| share <= FOLLOWS) {
            evidence -= 2;
            reasons.push(Reason::Follows { tag: named(leader) });
        }
        if let Some(twin) = lead.twin {
            reasons.push(Reason::MovesAsOne { tag: named(twin) });
        }
    }
    match motion {
        Motion::Free => {}
        Motion::Held(share) => {
            evidence += 1;
            reasons.push(Reason::Held { share });
        }
        Motion::Renewed(samples) => {
            evidence -= 1;
            reasons.push(Reason::Renewed { samples });
        }
    }
    (evidence, reasons)
}
