//! What an isolator said of a fault that is known.

use gtfdi::fdi::{Finding, IsolationEvent, IsolationRun};

/// Seconds after the alarm in which a name counts as in time.
const IN_TIME_S: f64 = 5.0;
/// Relative error of a size that counts as right.
pub(crate) const SIZE_TOLERANCE: f64 = 0.15;

/// A number that was found, with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// The number.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// What an isolator said of a record with a fault that is known.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FaultVerdict {
    /// Alarms before the onset.
    pub false_alarms: u64,
    /// The first alarm from the onset on: its time in seconds, and the position of the statistic
    /// furthest above its limit.
    pub alarm: Option<(f64, usize)>,
    /// The name that stood five seconds after that alarm, and when it was given; `None`: undecided.
    pub named: Option<(Finding, f64)>,
    /// Whether another name than the right one was ever given from the onset on.
    pub ever_wrong: bool,
    /// The size at the end of the record, under the fault's own hypothesis.
    pub size: Option<Found>,
    /// The onset in seconds, under the same at the same time.
    pub onset_s: Option<Found>,
}

impl FaultVerdict {
    /// What a run says of a fault with an onset; `case` is the position of its hypothesis, `None` of
    /// a fault that the isolator does not know, whose right name is *none of these*. Names of an
    /// alarm that was up before the onset do not count.
    pub fn of(run: &IsolationRun, case: Option<usize>, onset_s: f64, sample_time_s: f64) -> Self {
        let right = case.map_or(Finding::NoneOfThese, Finding::Named);
        let mut verdict = Self::default();
        let mut up_before = false;
        for event in &run.events {
            match *event {
                IsolationEvent::Alarm { time_s, .. } if time_s < onset_s => {
                    verdict.false_alarms += 1;
                    up_before = true;
                }
                IsolationEvent::Alarm {
                    time_s, leading, ..
                } => {
                    verdict.alarm.get_or_insert((time_s, leading));
                }
                IsolationEvent::End { .. } => up_before = false,
                IsolationEvent::Name { time_s, finding } if time_s >= onset_s && !up_before => {
                    verdict.ever_wrong |= finding != right;
                    let in_time = verdict
                        .alarm
                        .is_some_and(|(alarm_s, _)| time_s <= alarm_s + IN_TIME_S);
                    if in_time {
                        verdict.named = Some((finding, time_s));
                    }
                }
                IsolationEvent::Name { .. } => {}
            }
        }
        if let (Some(_), Some(last), Some(case)) = (verdict.alarm, run.alarms.last(), case)
            && let Some(own) = last.diagnosis.hypotheses.get(case)
        {
            let at = |age: f64| last.diagnosed_s - age * sample_time_s;
            verdict.size = Some(Found {
                value: own.magnitude,
                low: own.magnitude_low,
                high: own.magnitude_high,
            });
            verdict.onset_s = Some(Found {
                value: at(own.age),
                low: at(own.age_high),
                high: at(own.age_low),
            });
        }
        verdict
    }

    /// Whether the name in time is the right one.
    pub fn is_right(&self, case: Option<usize>) -> bool {
        let right = case.map_or(Finding::NoneOfThese, Finding::Named);
        self.named.is_some_and(|(finding, _)| finding == right)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alarm(time_s: f64) -> IsolationEvent {
        IsolationEvent::Alarm {
            time_s,
            leading: 2,
            statistic: 3.0,
            limit: 1.0,
        }
    }

    fn name(time_s: f64, finding: Finding) -> IsolationEvent {
        IsolationEvent::Name { time_s, finding }
    }

    fn verdict(case: Option<usize>, events: Vec<IsolationEvent>) -> FaultVerdict {
        let run = IsolationRun {
            events,
            alarms: Vec::new(),
            judged: 0,
            peaks: Vec::new(),
        };
        FaultVerdict::of(&run, case, 100.0, 1.0)
    }

    #[test]
    fn the_name_that_stands_after_five_seconds_counts() {
        let events = vec![
            alarm(110.0),
            name(112.0, Finding::NoneOfThese),
            name(115.0, Finding::Named(1)),
            name(116.0, Finding::Named(3)),
        ];
        let found = verdict(Some(1), events.clone());
        assert_eq!(found.alarm, Some((110.0, 2)));
        assert_eq!(found.named, Some((Finding::Named(1), 115.0)));
        assert!(found.is_right(Some(1)) && found.ever_wrong);
        // Of a fault that is unknown, none of these is the right name.
        let found = verdict(None, events[..2].to_vec());
        assert!(found.is_right(None) && !found.ever_wrong);
        // Without a name it is neither right nor wrong.
        let found = verdict(Some(1), events[..1].to_vec());
        assert!(found.named.is_none() && !found.is_right(Some(1)) && !found.ever_wrong);
    }

    #[test]
    fn an_alarm_from_before_the_onset_is_false_and_gives_no_name() {
        let end = IsolationEvent::End { time_s: 120.0 };
        let events = vec![
            alarm(90.0),
            name(91.0, Finding::Named(0)),
            name(101.0, Finding::Named(3)),
            end,
            alarm(130.0),
            name(131.0, Finding::Named(1)),
        ];
        let found = verdict(Some(1), events);
        assert_eq!((found.false_alarms, found.alarm), (1, Some((130.0, 2))));
        assert!(found.is_right(Some(1)) && !found.ever_wrong);
        // At the very onset an alarm is one of the fault.
        let found = verdict(Some(1), vec![alarm(100.0)]);
        assert_eq!((found.false_alarms, found.alarm), (0, Some((100.0, 2))));
    }
}
