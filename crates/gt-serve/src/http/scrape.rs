//! What Prometheus reads.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;

use super::Service;
use crate::clock::now_ns;
use crate::hub::Hub;
use crate::metrics::Exposition;
use crate::pipeline::{HygieneCounts, MachineState};

/// `GET /metrics`.
pub async fn metrics(State(service): State<Arc<Service>>) -> impl IntoResponse {
    let mut text = Exposition::default();
    totals(&mut text, &service.hub);
    by_machine(&mut text, &service.hub);
    let media_type = [(header::CONTENT_TYPE, "text/plain; version=0.0.4")];
    (media_type, text.finish())
}

/// Of all machines together.
fn totals(text: &mut Exposition, hub: &Hub) {
    let all = &hub.metrics;
    for (name, help, counter) in [
        ("readings_total", "Readings that came.", &all.readings),
        (
            "malformed_total",
            "Messages that could not be read.",
            &all.malformed,
        ),
        (
            "unknown_total",
            "Values of tags that no machine has.",
            &all.unknown,
        ),
        (
            "unauthorized_total",
            "Requests with a missing or wrong token.",
            &all.unauthorized,
        ),
        (
            "frames_dropped_total",
            "Frames that slow clients missed.",
            &all.frames_dropped,
        ),
        (
            "journal_errors_total",
            "Events that were not written.",
            &all.journal_errors,
        ),
        (
            "journal_late_total",
            "Events that were told before they were written: the disk did not answer.",
            &all.journal_late,
        ),
        (
            "recorder_errors_total",
            "Records that were not written.",
            &all.recorder_errors,
        ),
        (
            "mqtt_connects_total",
            "Times the broker was reached.",
            &all.mqtt_connects,
        ),
    ] {
        text.single(
            name,
            "counter",
            help,
            counter.load(Ordering::Relaxed) as f64,
        );
    }
    text.delays(&all.delays);
    text.single(
        "journal_waiting",
        "gauge",
        "Events that wait to be written.",
        hub.outbox().unwritten() as f64,
    );
    let (mut waiting, mut dropped) = (0, 0);
    for queue in &hub.queues {
        let (now, _, lost) = queue.counts();
        waiting += now;
        dropped += lost;
    }
    let help = "Messages that wait to be judged.";
    text.single("queue_length", "gauge", help, waiting as f64);
    let help = "Messages that a full queue dropped.";
    text.single("queue_dropped_total", "counter", help, dropped as f64);
    if let Some(recorder) = &hub.recorder {
        let (waiting, _, dropped) = recorder.counts();
        let help = "Records that wait to be written.";
        text.single("recorder_queue_length", "gauge", help, waiting as f64);
        let help = "Records that were dropped because the disk was slow.";
        text.single("recorder_dropped_total", "counter", help, dropped as f64);
    }
}

/// A count of a machine.
type Count = fn(&HygieneCounts) -> u64;

fn by_machine(text: &mut Exposition, hub: &Hub) {
    let now_ns = now_ns();
    let rows: Vec<_> = hub
        .cells
        .iter()
        .map(|cell| {
            let machine = cell.lock();
            let up = !matches!(
                machine.state(now_ns),
                MachineState::Stale | MachineState::NoData | MachineState::Failed
            );
            let open = machine.alarms().open();
            let active = open.filter(|alarm| alarm.is_active()).count();
            (cell.name.as_str(), *machine.counts(), up, active)
        })
        .collect();
    let labels: Vec<_> = rows.iter().map(|row| [("machine", row.0)]).collect();
    let mut family = |name: &str, kind: &str, help: &str, values: Vec<f64>| {
        let labelled = labels.iter().map(|labels| &labels[..]);
        text.family(name, kind, help, labelled.zip(values));
    };
    let up = rows.iter().map(|row| f64::from(u8::from(row.2)));
    family("machine_up", "gauge", "Whether samples come.", up.collect());
    let active = rows.iter().map(|row| row.3 as f64);
    family("active_alarms", "gauge", "Active alarms.", active.collect());
    let counts: [(&str, &str, Count); 9] = [
        ("samples_total", "Samples judged.", |own| own.samples),
        ("missing_total", "Values missing at their sample.", |own| {
            own.missing
        }),
        ("held_total", "Values held.", |own| own.held),
        ("frozen_total", "Values the same for too long.", |own| {
            own.frozen
        }),
        ("bad_total", "Readings without a usable value.", |own| {
            own.bad
        }),
        ("duplicate_total", "Readings given twice.", |own| {
            own.duplicate
        }),
        ("late_total", "Readings that came too late.", |own| own.late),
        ("future_total", "Readings from ahead of the clock.", |own| {
            own.future
        }),
        ("restarts_total", "Gaps and clocks set back.", |own| {
            own.restarts
        }),
    ];
    for (name, help, count) in counts {
        let values = rows.iter().map(|row| count(&row.1) as f64);
        family(name, "counter", help, values.collect());
    }
}
