//! Alarms come, stand and go as they should, whatever happens.

use super::*;
use proptest::prelude::*;

/// A list with its row of numbers and a clock in seconds.
struct Desk {
    list: AlarmList,
    given: u64,
}

impl Desk {
    fn new(options: AlarmOptions) -> Self {
        Self {
            list: AlarmList::new("gt1", "bank", options),
            given: 0,
        }
    }

    fn raise(&mut self, key: usize, at_s: i64) {
        let condition = Condition {
            key,
            source: format!("test{key}"),
            statistic: 2.0,
            threshold: 1.0,
            onset_ms: None,
        };
        self.list.raise(condition, at_s * 1000);
    }

    fn advance(&mut self, at_s: i64, judged: bool) {
        let given = &mut self.given;
        self.list.advance(at_s * 1000, judged, || {
            *given += 1;
            *given
        });
    }

    fn said(&mut self) -> Vec<(AlarmAction, u64)> {
        let events = self.list.take_events().into_iter();
        let events = events.filter(|event| event.event != AlarmAction::Changed);
        events.map(|event| (event.event, event.alarm.id)).collect()
    }

    fn states(&self) -> Vec<AlarmState> {
        self.list.open().map(|alarm| alarm.state).collect()
    }
}

use AlarmAction::{Acknowledged, Cleared, Raised, Returned, Shelved, Unshelved};
use AlarmState::{ActiveAcknowledged, ActiveUnacknowledged, Normal, ReturnedUnacknowledged};

#[test]
fn an_alarm_goes_through_its_states() {
    let mut desk = Desk::new(AlarmOptions::default());
    desk.raise(0, 10);
    desk.advance(10, true);
    assert_eq!(desk.states(), [ActiveUnacknowledged]);
    let done = desk.list.acknowledge(1, "a", "seen", 11_000).unwrap();
    assert_eq!(done.state, ActiveAcknowledged);
    // Once more, by somebody else: all stays.
    assert_eq!(desk.list.acknowledge(1, "b", "too", 12_000), Ok(done));
    desk.list.end(0, 20_000);
    desk.advance(24, true);
    assert_eq!(desk.states(), [ActiveAcknowledged], "the off-delay is 5 s");
    desk.advance(25, true);
    assert!(desk.states().is_empty());
    assert_eq!(
        desk.said(),
        [(Raised, 1), (Acknowledged, 1), (Returned, 1), (Cleared, 1)]
    );
}

#[test]
fn what_nobody_saw_waits_and_comes_back_as_the_same() {
    let mut desk = Desk::new(AlarmOptions::default());
    desk.raise(0, 10);
    desk.advance(10, true);
    desk.list.end(0, 11_000);
    desk.advance(20, true);
    assert_eq!(desk.states(), [ReturnedUnacknowledged]);
    desk.raise(0, 30);
    desk.advance(30, true);
    assert_eq!(desk.states(), [ActiveUnacknowledged]);
    desk.list.end(0, 31_000);
    desk.advance(40, true);
    let done = desk.list.acknowledge(1, "a", "", 41_000).unwrap();
    assert_eq!(done.state, Normal);
    assert_eq!(
        desk.said(),
        [
            (Raised, 1),
            (Returned, 1),
            (Raised, 1),
            (Returned, 1),
            (Acknowledged, 1),
            (Cleared, 1)
        ]
    );
    assert_eq!(
        desk.list.acknowledge(1, "a", "", 42_000),
        Err(AlarmError::Unknown { id: 1 })
    );
}

#[test]
fn without_a_latch_it_ends_by_itself() {
    let mut desk = Desk::new(AlarmOptions {
        latch: false,
        off_delay_s: 0.0,
        ..AlarmOptions::default()
    });
    desk.raise(3, 10);
    desk.advance(10, true);
    desk.list.end(3, 11_000);
    desk.advance(11, true);
    assert_eq!(desk.said(), [(Raised, 1), (Returned, 1), (Cleared, 1)]);
}

#[test]
fn delays_hold_back_what_is_short() {
    let mut desk = Desk::new(AlarmOptions {
        on_delay_s: 3.0,
        ..AlarmOptions::default()
    });
    desk.raise(0, 10);
    desk.advance(12, true);
    desk.list.end(0, 12_000);
    desk.advance(13, true);
    assert!(
        desk.said().is_empty(),
        "2 s are short of the on-delay of 3 s"
    );
    desk.raise(0, 20);
    desk.advance(23, true);
    // Gone for 4 s, less than the off-delay of 5 s.
    desk.list.end(0, 24_000);
    desk.raise(0, 28);
    desk.advance(40, true);
    assert_eq!(desk.said(), [(Raised, 1)]);
    assert_eq!(desk.states(), [ActiveUnacknowledged]);
}

#[test]
fn after_a_gap_the_same_condition_is_the_same_alarm() {
    let mut desk = Desk::new(AlarmOptions::default());
    desk.raise(0, 10);
    desk.advance(10, true);
    desk.list.start_afresh("bank", 15_000);
    desk.advance(20, false);
    assert!(desk.list.get(1).unwrap().unconfirmed);
    desk.raise(0, 30);
    desk.advance(30, true);
    assert!(!desk.list.get(1).unwrap().unconfirmed);
    assert_eq!(desk.said(), [(Raised, 1)]);
    assert_eq!(desk.given, 1);
}

#[test]
fn what_is_not_seen_again_returns_when_it_was_looked_for_long_enough() {
    let mut desk = Desk::new(AlarmOptions::default());
    desk.raise(0, 10);
    desk.advance(10, true);
    desk.said();
    desk.list.start_afresh("bank", 15_000);
    // Settling does not count, nor does what was before it.
    desk.advance(20, true);
    desk.advance(200, false);
    desk.advance(210, true);
    desk.advance(509, true);
    assert_eq!(desk.states(), [ActiveUnacknowledged]);
    desk.advance(510, true);
    assert_eq!(desk.said(), [(Returned, 1)]);
}

#[test]
fn a_shelf_holds_the_statistic_until_its_time() {
    let mut desk = Desk::new(AlarmOptions {
        latch: false,
        off_delay_s: 0.0,
        ..AlarmOptions::default()
    });
    desk.raise(0, 10);
    desk.advance(10, true);
    desk.list.shelve(1, "a", "repair", 60.0, 10_000).unwrap();
    desk.list.end(0, 11_000);
    desk.advance(11, true);
    desk.raise(0, 20);
    desk.advance(20, true);
    assert_eq!(
        desk.list.get(2).unwrap().shelved.as_ref().unwrap().reason,
        "repair"
    );
    desk.list.tick(69_999);
    assert!(desk.list.get(2).unwrap().shelved.is_some());
    desk.list.tick(70_000);
    assert!(desk.list.get(2).unwrap().shelved.is_none());
    let said = desk.said();
    assert_eq!(said[1], (Shelved, 1));
    assert_eq!(said[said.len() - 1], (Unshelved, 2));
    let stands = desk.list.get(2).unwrap().clone();
    assert_eq!(desk.list.unshelve(2, "a", 71_000), Ok(stands));
    assert!(desk.said().is_empty(), "it was on no shelf");
    let refused = desk
        .list
        .shelve(2, "a", "x", 1e9, 0)
        .unwrap_err()
        .to_string();
    assert!(
        refused.starts_with("minutes: expected above 0, at most 1440"),
        "{refused}"
    );
    assert!(desk.list.shelve(2, "a", "x", f64::NAN, 0).is_err());
}

#[derive(Debug, Clone)]
enum Act {
    Raise(usize),
    End(usize),
    Advance(bool),
    Afresh,
    Acknowledge(u64),
    Shelve(u64),
    Restart(bool),
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        (0..3_usize).prop_map(Act::Raise),
        (0..3_usize).prop_map(Act::End),
        any::<bool>().prop_map(Act::Advance),
        Just(Act::Afresh),
        (1..6_u64).prop_map(Act::Acknowledge),
        (1..6_u64).prop_map(Act::Shelve),
        any::<bool>().prop_map(Act::Restart),
    ]
}

proptest! {
    /// Whatever happens, in whatever order, with restarts from any older state: of each
    /// statistic at most one alarm is active, its events follow each other as they can, and what
    /// the events say last is what there is.
    #[test]
    fn prop_events_are_the_whole_truth(
        acts in proptest::collection::vec((act(), 0..400_i64), 0..120), latch in any::<bool>(),
    ) {
        let options = AlarmOptions { latch, ..AlarmOptions::default() };
        let mut desk = Desk::new(options.clone());
        let mut told: BTreeMap<u64, Alarm> = BTreeMap::new();
        let mut old = desk.list.state();
        let mut now_s = 0;
        for (act, after_s) in acts {
            now_s += after_s;
            match act {
                Act::Raise(key) => desk.raise(key, now_s),
                Act::End(key) => desk.list.end(key, now_s * 1000),
                Act::Advance(judged) => desk.advance(now_s, judged),
                Act::Afresh => desk.list.start_afresh("bank", now_s * 1000),
                Act::Acknowledge(id) => { let _ = desk.list.acknowledge(id, "a", "", now_s * 1000); }
                Act::Shelve(id) => { let _ = desk.list.shelve(id, "a", "b", 60.0, now_s * 1000); }
                Act::Restart(keeps) => {
                    let open: Vec<Alarm> = told.values().filter(|own| own.is_open()).cloned().collect();
                    desk.list = AlarmList::new("gt1", "bank", options.clone());
                    desk.list.resume(open, keeps.then(|| old.clone()), now_s * 1000);
                }
            }
            desk.list.tick(now_s * 1000);
            for event in desk.list.take_events() {
                let id = event.alarm.id;
                let before = told.get(&id).map(|own| own.state);
                let follows = match event.event {
                    Raised => matches!(before, None | Some(ReturnedUnacknowledged)),
                    Acknowledged => matches!(before, Some(ActiveUnacknowledged | ReturnedUnacknowledged)),
                    Returned => matches!(before, Some(ActiveUnacknowledged | ActiveAcknowledged)),
                    Cleared => matches!(before, Some(ReturnedUnacknowledged)),
                    _ => before.is_some_and(|state| state != Normal),
                };
                prop_assert!(follows, "{:?} after {before:?}", event.event);
                told.insert(id, event.alarm);
            }
            let open: Vec<&Alarm> = desk.list.open().collect();
            let known: Vec<&Alarm> = told.values().filter(|own| own.is_open()).collect();
            prop_assert_eq!(open, known);
            for key in 0..3 {
                let active = desk.list.open().filter(|own| own.is_active() && own.key == key);
                prop_assert!(active.count() <= 1, "two alarms of test {key}");
            }
            if now_s % 3 == 0 {
                old = desk.list.state();
            }
        }
    }
}
