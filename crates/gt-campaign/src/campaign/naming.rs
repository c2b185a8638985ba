//! What a fault was called, and what was said of its onset and size.

use gtfdi::fdi::Finding;

use crate::isolation::{FaultVerdict, Found};

/// The statistic of an isolator, as in the rows: a likelihood ratio in the fault's direction.
pub(super) const ISOLATOR_STATISTIC: &str = "isolator";
/// What a fault is called that is none of those an isolator knows.
pub const NONE_OF_THESE: &str = "none of these";

/// What an isolator said of a fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Naming {
    /// The name that stood five seconds after the alarm; `None` while it is undecided.
    pub named: Option<String>,
    /// When it was given, in seconds of the record.
    pub named_s: Option<f64>,
    /// Whether it is the right one: that of the fault, or [`NONE_OF_THESE`] of a fault that the
    /// isolator does not know.
    pub right: bool,
    /// Whether another was ever given from the onset on.
    pub ever_wrong: bool,
    /// The size at the end of the record with its sign, under the fault's own hypothesis.
    pub size: Option<Found>,
    /// The onset in seconds, under the same.
    pub onset_s: Option<Found>,
}

impl Naming {
    /// That of a verdict on the fault with the hypothesis `case`; `names` are those of the
    /// hypotheses.
    pub(super) fn of(verdict: &FaultVerdict, case: Option<usize>, names: &[&str]) -> Self {
        let name = |place: usize| names.get(place).copied().unwrap_or_default();
        let text = |finding| match finding {
            Finding::Undecided => None,
            Finding::Named(place) => Some(name(place).to_owned()),
            Finding::Both(one, two) => Some(format!("{} and {}", name(one), name(two))),
            Finding::NoneOfThese => Some(NONE_OF_THESE.to_owned()),
        };
        Self {
            named: verdict.named.and_then(|(finding, _)| text(finding)),
            named_s: verdict.named.map(|(_, time_s)| time_s),
            right: verdict.is_right(case),
            ever_wrong: verdict.ever_wrong,
            size: verdict.size,
            onset_s: verdict.onset_s,
        }
    }
}
