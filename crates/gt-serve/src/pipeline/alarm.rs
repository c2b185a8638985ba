//! An alarm and its states, after IEC 62682 and OPC 10000-9.

use gtfdi::fdi::NamedDiagnosis;
use serde::{Deserialize, Serialize};

/// Where an alarm is between its condition and its operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlarmState {
    /// The condition holds, and nobody has acknowledged it.
    ActiveUnacknowledged,
    /// The condition holds and is acknowledged.
    ActiveAcknowledged,
    /// The condition is gone, and nobody had acknowledged it.
    ReturnedUnacknowledged,
    /// Over.
    Normal,
}

/// Who acknowledged an alarm.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Acknowledgement {
    /// The operator.
    pub by: String,
    /// When, in milliseconds since 1970.
    pub at_ms: i64,
    /// What was said.
    pub comment: String,
}

/// An alarm that is set aside for a time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shelf {
    /// Until when, in milliseconds since 1970.
    pub until_ms: i64,
    /// Why.
    pub reason: String,
    /// By whom.
    pub by: String,
}

/// What is known of one fault, in times since 1970.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its name.
    pub fault: String,
    /// Unit of its size.
    pub unit: String,
    /// Its probability, given that there is a fault.
    pub probability: f64,
    /// Its size if it is this one.
    pub magnitude: f64,
    /// 95 % interval of the size.
    pub magnitude_interval: [f64; 2],
    /// Its onset if it is this one, in milliseconds since 1970.
    pub onset_ms: i64,
    /// 95 % interval of the onset, in milliseconds since 1970.
    pub onset_interval_ms: [i64; 2],
}

/// An alarm of a machine. What is not known yet is null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alarm {
    /// A number of its own, never given twice.
    pub id: u64,
    /// The machine.
    pub machine: String,
    /// The statistic that raised it.
    pub source: String,
    /// Which of the detector's alarms it is.
    pub key: usize,
    /// The fault's name; of two at once both.
    pub fault: Option<String>,
    /// `undecided`, `named`, `both` or `none_of_these`.
    pub finding: String,
    /// Where it stands.
    pub state: AlarmState,
    /// Whether it is set aside.
    pub shelved: Option<Shelf>,
    /// 1 to 1000.
    pub severity: u16,
    /// When it came up, by the time of the samples, in milliseconds since 1970; so all times.
    pub raised_ms: i64,
    /// When the name that stands was given.
    pub named_ms: Option<i64>,
    /// When the condition was gone.
    pub ended_ms: Option<i64>,
    /// When the fault began.
    pub onset_ms: Option<i64>,
    /// 95 % interval of that.
    pub onset_interval_ms: Option<[i64; 2]>,
    /// How large it is.
    pub magnitude: Option<f64>,
    /// 95 % interval of that.
    pub magnitude_interval: Option<[f64; 2]>,
    /// Unit of the size.
    pub unit: Option<String>,
    /// How sure the name is.
    pub probability: Option<f64>,
    /// The statistic when it came up.
    pub statistic: f64,
    /// Its limit.
    pub threshold: f64,
    /// All that it could be.
    pub hypotheses: Vec<Candidate>,
    /// The probability that it is none of them.
    pub none_of_these: Option<f64>,
    /// Who acknowledged it.
    pub acknowledged: Option<Acknowledgement>,
    /// The detector's name.
    pub detector: String,
    /// Whether the detector has started afresh since and has not seen the condition again: it
    /// stands until that is decided.
    pub unconfirmed: bool,
}

impl Alarm {
    /// Whether the condition holds, as far as is known.
    pub fn is_active(&self) -> bool {
        matches!(
            self.state,
            AlarmState::ActiveUnacknowledged | AlarmState::ActiveAcknowledged
        )
    }

    /// Whether an operator has anything to do with it.
    pub fn is_open(&self) -> bool {
        self.state != AlarmState::Normal
    }

    /// Takes what a diagnosis says; `at_ms` turns seconds of the grid into milliseconds since 1970.
    /// Says whether the name is another.
    pub(super) fn learn(&mut self, diagnosis: &NamedDiagnosis, at_ms: impl Fn(f64) -> i64) -> bool {
        let renamed = self.fault != diagnosis.fault || self.finding != diagnosis.finding;
        diagnosis.finding.clone_into(&mut self.finding);
        self.fault.clone_from(&diagnosis.fault);
        self.unit.clone_from(&diagnosis.unit);
        self.probability = diagnosis.probability;
        self.magnitude = diagnosis.magnitude;
        self.onset_ms = diagnosis.onset_s.map(&at_ms);
        self.none_of_these = Some(diagnosis.none_of_these);
        let hypotheses = diagnosis.hypotheses.iter();
        self.hypotheses = hypotheses
            // JSON has no NaN: of a fault that nothing is known of there is nothing to say.
            .filter(|own| {
                let [low, high] = own.magnitude_interval;
                [own.probability, own.magnitude, low, high]
                    .iter()
                    .all(|own| own.is_finite())
            })
            .map(|own| Candidate {
                fault: own.fault.clone(),
                unit: own.unit.clone(),
                probability: own.probability,
                magnitude: own.magnitude,
                magnitude_interval: own.magnitude_interval,
                onset_ms: at_ms(own.onset_s),
                onset_interval_ms: own.onset_interval_s.map(&at_ms),
            })
            .collect();
        let named = self.hypotheses.iter();
        let named = named
            .filter(|_| self.finding == "named")
            .find(|own| Some(&own.fault) == self.fault.as_ref());
        self.magnitude_interval = named.map(|own| own.magnitude_interval);
        self.onset_interval_ms = named.map(|own| own.onset_interval_ms);
        if renamed {
            self.named_ms = self.fault.is_some().then(|| at_ms(diagnosis.diagnosed_s));
        }
        renamed
    }
}

/// What happened to an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlarmAction {
    /// It came up.
    Raised,
    /// Its fault was named, or named otherwise.
    Named,
    /// More is known of it.
    Changed,
    /// An operator acknowledged it.
    Acknowledged,
    /// An operator set it aside.
    Shelved,
    /// It is no longer set aside.
    Unshelved,
    /// The condition is gone.
    Returned,
    /// It is over.
    Cleared,
}

impl AlarmAction {
    /// Whether it belongs to the history: what is known better every few seconds does not.
    pub fn is_kept(self) -> bool {
        self != Self::Changed
    }
}

/// An event in the history of an alarm, with the alarm as it then was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AlarmEvent {
    /// When, in milliseconds since 1970: of conditions the time of the samples, of operators that of
    /// the service.
    pub time_ms: i64,
    /// What happened.
    pub event: AlarmAction,
    /// Which operator did it.
    pub by: Option<String>,
    /// What was said.
    pub text: String,
    /// The alarm after it.
    pub alarm: Alarm,
}
