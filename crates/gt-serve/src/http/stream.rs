//! Events as they come, for the page.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Sse;
use axum::response::sse::{Event, KeepAlive};
use futures_util::Stream;
use futures_util::stream::unfold;
use serde::Serialize;
use serde_json::json;
use tokio::sync::OwnedSemaphorePermit;
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Interval, MissedTickBehavior, interval};

use super::Service;
use super::failure::ApiError;
use super::view::MachineView;
use crate::clock::now_ns;
use crate::hub::Frame;
use crate::pipeline::AlarmEvent;

/// How often the state of all machines is told.
const MACHINES: Duration = Duration::from_millis(500);
/// How often something comes though nothing happens.
const HEARTBEAT: Duration = Duration::from_secs(10);

struct Listener {
    service: Arc<Service>,
    alarms: Receiver<Arc<AlarmEvent>>,
    frames: Receiver<Arc<Frame>>,
    ticks: Interval,
    /// Events that wait: machines one after the other.
    waiting: Vec<Event>,
    /// What was said of each machine.
    said: Vec<String>,
    /// The place that it takes among all listeners.
    _place: OwnedSemaphorePermit,
}

/// `GET /api/v1/events`.
pub async fn events(
    State(service): State<Arc<Service>>,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, ApiError> {
    let Ok(place) = Arc::clone(&service.streams).try_acquire_owned() else {
        return Err(ApiError::new(
            StatusCode::SERVICE_UNAVAILABLE,
            "busy",
            "expected fewer streams of events than http.streams, found as many",
        ));
    };
    let mut ticks = interval(MACHINES);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let listener = Listener {
        alarms: service.hub.events(),
        frames: service.hub.frames(),
        said: vec![String::new(); service.hub.cells.len()],
        service,
        ticks,
        waiting: Vec::new(),
        _place: place,
    };
    let stream = unfold(listener, |mut own| async move {
        let event = own.next().await?;
        Some((Ok(event), own))
    });
    Ok(Sse::new(stream).keep_alive(KeepAlive::new().interval(HEARTBEAT)))
}

impl Listener {
    async fn next(&mut self) -> Option<Event> {
        loop {
            if self.service.hub.is_stopping() {
                return None;
            }
            if let Some(event) = self.waiting.pop() {
                return Some(event);
            }
            tokio::select! {
                alarm = self.alarms.recv() => match alarm {
                    Ok(event) => return said("alarm", &event.alarm),
                    Err(RecvError::Lagged(count)) => return self.dropped(count),
                    Err(RecvError::Closed) => return None,
                },
                frame = self.frames.recv() => match frame {
                    Ok(frame) => return said("sample", &*frame),
                    Err(RecvError::Lagged(count)) => return self.dropped(count),
                    Err(RecvError::Closed) => return None,
                },
                _ = self.ticks.tick() => self.look(),
            }
        }
    }

    fn dropped(&self, count: u64) -> Option<Event> {
        let dropped = &self.service.hub.metrics.frames_dropped;
        dropped.fetch_add(count, Ordering::Relaxed);
        said("dropped", &json!({ "count": count }))
    }

    /// The machines of which something else is to be said than before.
    fn look(&mut self) {
        let now_ns = now_ns();
        for (cell, said) in self.service.hub.cells.iter().zip(&mut self.said) {
            let view = MachineView::of(cell, &cell.lock(), now_ns);
            let Ok(text) = serde_json::to_string(&view) else {
                continue;
            };
            if *said != text {
                said.clone_from(&text);
                self.waiting
                    .push(Event::default().event("machine").data(text));
            }
        }
    }
}

fn said(name: &str, what: &impl Serialize) -> Option<Event> {
    let data = serde_json::to_string(what).ok()?;
    Some(Event::default().event(name).data(data))
}
