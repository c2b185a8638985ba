//! A diagnosis with names and times.

use serde::Serialize;

use super::isolator::Isolator;
use super::run::IsolationAlarm;
use crate::runtime::{Diagnosis, Finding};

/// What is known of one fault.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedHypothesis {
    /// Its name.
    pub fault: String,
    /// Unit of its size.
    pub unit: String,
    /// Its probability, given that there is a fault.
    pub probability: f64,
    /// Its size at the time of the diagnosis, if it is this one.
    pub magnitude: f64,
    /// 95 % interval of the size.
    pub magnitude_interval: [f64; 2],
    /// The likeliest onset (the median) in seconds, if it is this one.
    pub onset_s: f64,
    /// 95 % interval of the onset in seconds.
    pub onset_interval_s: [f64; 2],
}

/// What is known of two faults at once.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedPair {
    /// Their names.
    pub faults: [String; 2],
    /// The probability of this pair, given that there is a fault.
    pub probability: f64,
    /// Their sizes, each in its unit.
    pub magnitudes: [f64; 2],
    /// Their onsets in seconds.
    pub onsets_s: [f64; 2],
}

/// A diagnosis in words: keys that are null say that there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedDiagnosis {
    /// When it was made, in seconds.
    pub diagnosed_s: f64,
    /// `undecided`, `named`, `both` or `none_of_these`.
    pub finding: &'static str,
    /// The fault's name; of two at once both, with `and`.
    pub fault: Option<String>,
    /// Unit of its size.
    pub unit: Option<String>,
    /// The probability of what was found.
    pub probability: Option<f64>,
    /// The named fault's onset in seconds.
    pub onset_s: Option<f64>,
    /// The named fault's size.
    pub magnitude: Option<f64>,
    /// All hypotheses, in their order.
    pub hypotheses: Vec<NamedHypothesis>,
    /// The probability that it is none of them.
    pub none_of_these: f64,
    /// The likeliest pair, where there is one.
    pub pair: Option<NamedPair>,
}

/// An alarm of an isolator in words.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedAlarm {
    /// When it came up, in seconds.
    pub time_s: f64,
    /// When it ended, in seconds; null while it is up.
    pub end_s: Option<f64>,
    /// The statistic that was furthest above its limit: the name of a fault, or
    /// [`Isolator::ANY_DIRECTION`].
    pub tag: String,
    /// That statistic.
    pub statistic: f64,
    /// Its limit.
    pub threshold: f64,
    /// When the name that stands was given, in seconds.
    pub named_s: Option<f64>,
    /// The last diagnosis, under the name that stands.
    #[serde(flatten)]
    pub diagnosis: NamedDiagnosis,
}

impl Isolator {
    /// The name of the last statistic, for a change in any direction.
    pub const ANY_DIRECTION: &'static str = "any direction";

    /// Names of the statistics: of the hypotheses, then [`Isolator::ANY_DIRECTION`].
    pub fn statistic_names(&self) -> Vec<&str> {
        let faults = self.hypotheses().iter().map(|own| own.name.as_str());
        faults.chain([Self::ANY_DIRECTION]).collect()
    }

    fn statistic_name(&self, place: usize) -> &str {
        let hypothesis = self.hypotheses().get(place);
        hypothesis.map_or(Self::ANY_DIRECTION, |own| &own.name)
    }

    /// A diagnosis of this isolator, made at `time_s` seconds, in words. `standing` is the name that
    /// stands, which a single diagnosis may contradict.
    pub fn named(&self, time_s: f64, standing: Finding, diagnosis: &Diagnosis) -> NamedDiagnosis {
        let at = |age: f64| time_s - age * self.sample_time_s();
        let faults = self.hypotheses().iter().zip(&diagnosis.hypotheses);
        let hypotheses: Vec<NamedHypothesis> = faults
            .map(|(fault, own)| NamedHypothesis {
                fault: fault.name.clone(),
                unit: fault.unit.clone(),
                probability: own.probability,
                magnitude: own.magnitude,
                magnitude_interval: [own.magnitude_low, own.magnitude_high],
                onset_s: at(own.age),
                onset_interval_s: [at(own.age_high), at(own.age_low)],
            })
            .collect();
        let name = |place: usize| self.statistic_name(place).to_owned();
        let pair = diagnosis.pair.map(|pair| NamedPair {
            faults: pair.faults.map(name),
            probability: pair.probability,
            magnitudes: pair.magnitudes,
            onsets_s: pair.ages.map(at),
        });
        let mut named = NamedDiagnosis {
            diagnosed_s: time_s,
            finding: "undecided",
            fault: None,
            unit: None,
            probability: None,
            onset_s: None,
            magnitude: None,
            hypotheses,
            none_of_these: diagnosis.none_of_these,
            pair,
        };
        match standing {
            Finding::Undecided => {}
            Finding::Named(place) => {
                named.finding = "named";
                named.fault = Some(name(place));
                if let Some(own) = named.hypotheses.get(place) {
                    named.unit = Some(own.unit.clone());
                    named.probability = Some(own.probability);
                    (named.onset_s, named.magnitude) = (Some(own.onset_s), Some(own.magnitude));
                }
            }
            Finding::Both(one, two) => {
                named.finding = "both";
                named.fault = Some(format!("{} and {}", name(one), name(two)));
                named.probability = named.pair.as_ref().map(|own| own.probability);
            }
            Finding::NoneOfThese => {
                named.finding = "none_of_these";
                named.probability = Some(diagnosis.none_of_these);
            }
        }
        named
    }

    /// An alarm of this isolator in words.
    pub fn named_alarm(&self, alarm: &IsolationAlarm) -> NamedAlarm {
        NamedAlarm {
            time_s: alarm.time_s,
            end_s: alarm.end_s,
            tag: self.statistic_name(alarm.leading).to_owned(),
            statistic: alarm.statistic,
            threshold: alarm.limit,
            named_s: alarm.named_s,
            diagnosis: self.named(alarm.diagnosed_s, alarm.finding, &alarm.diagnosis),
        }
    }
}
