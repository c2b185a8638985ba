//! The handlers of the API.

use std::sync::Arc;

use axum::Json;
use axum::extract::rejection::{JsonRejection, QueryRejection};
use axum::extract::{Extension, Path, Query, State};
use axum::http::StatusCode;
use gtfdi::plant::{Fault, FaultCase, Ramp, Shape, Step, Target};
use serde::Deserialize;
use serde_json::{Value, json};

use super::Service;
use super::auth::{Caller, Role};
use super::failure::ApiError;
use super::view::{AlarmsView, MachineView, TrendView};
use crate::clock::{now_ms, now_ns};
use crate::pipeline::{Alarm, AlarmError, AlarmList};

type Reply<T> = Result<Json<T>, ApiError>;
type Body<T> = Result<Json<T>, JsonRejection>;
type Asked<T> = Result<Query<T>, QueryRejection>;

/// The longest text of an operator, in characters.
const LONGEST_TEXT: usize = 2000;
/// Points of a trend and alarms of a list at most.
const MOST_POINTS: usize = 5000;
const MOST_ALARMS: usize = 10_000;

fn allow(caller: &Caller, role: Role) -> Result<(), ApiError> {
    if caller.role >= role {
        return Ok(());
    }
    let needed = if role == Role::Administer {
        "administer"
    } else {
        "operate"
    };
    Err(ApiError::new(
        StatusCode::FORBIDDEN,
        "forbidden",
        format!("expected a token with the role `{needed}`"),
    ))
}

/// How long a thread that judges may be silent, in milliseconds.
const SILENCE_MS: i64 = 30_000;

/// `GET /healthz`.
pub async fn healthz(State(service): State<Arc<Service>>) -> (StatusCode, &'static str) {
    if service.hub.is_alive(SILENCE_MS) {
        (StatusCode::OK, "ok\n")
    } else {
        (
            StatusCode::SERVICE_UNAVAILABLE,
            "a thread that judges hangs\n",
        )
    }
}

/// `GET /readyz`.
pub async fn readyz(State(service): State<Arc<Service>>) -> (StatusCode, &'static str) {
    if service.hub.is_ready() && !service.hub.is_stopping() {
        (StatusCode::OK, "ready\n")
    } else {
        (
            StatusCode::SERVICE_UNAVAILABLE,
            "not ready: a machine has had no data, or the service stops\n",
        )
    }
}

/// `GET /api/v1/info`.
pub async fn info(
    State(service): State<Arc<Service>>,
    Extension(caller): Extension<Caller>,
) -> Json<Value> {
    Json(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "role": caller.role,
        "name": caller.name,
        "token_required": service.access.needs_token(),
        "embedded_plant": service.plant.is_some(),
        "started_ms": service.hub.started_ms,
        "now_ms": now_ms(),
    }))
}

/// `GET /api/v1/machines`.
pub async fn machines(State(service): State<Arc<Service>>) -> Json<Value> {
    let now_ns = now_ns();
    let cells = service.hub.cells.iter();
    let machines: Vec<_> = cells
        .map(|cell| MachineView::of(cell, &cell.lock(), now_ns))
        .collect();
    Json(json!({ "machines": machines }))
}

fn place(service: &Service, name: &str) -> Result<usize, ApiError> {
    service.hub.machine(name).ok_or_else(|| {
        ApiError::not_found(format!(
            "machine `{name}`: expected one of /api/v1/machines"
        ))
    })
}

/// `GET /api/v1/machines/{name}`.
pub async fn machine(
    State(service): State<Arc<Service>>,
    Path(name): Path<String>,
) -> Reply<MachineView> {
    let cell = &service.hub.cells[place(&service, &name)?];
    Ok(Json(MachineView::of(cell, &cell.lock(), now_ns())))
}

/// What is asked of a trend.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrendQuery {
    seconds: Option<f64>,
    points: Option<usize>,
}

/// `GET /api/v1/machines/{name}/trend`.
pub async fn trend(
    State(service): State<Arc<Service>>,
    Path(name): Path<String>,
    query: Asked<TrendQuery>,
) -> Reply<TrendView> {
    let Query(query) = query?;
    let (seconds, points) = (query.seconds.unwrap_or(600.0), query.points.unwrap_or(600));
    if !(seconds > 0.0 && seconds <= 86_400.0) {
        return Err(ApiError::invalid(format!(
            "seconds: expected above 0, at most 86400, found {seconds}"
        )));
    }
    if !(1..=MOST_POINTS).contains(&points) {
        return Err(ApiError::invalid(format!(
            "points: expected 1 to {MOST_POINTS}, found {points}"
        )));
    }
    let cell = &service.hub.cells[place(&service, &name)?];
    let view = TrendView::of(&cell.lock(), seconds, points);
    Ok(Json(view))
}

/// `POST /api/v1/machines/{name}/reload`.
pub async fn reload(
    State(service): State<Arc<Service>>,
    Extension(caller): Extension<Caller>,
    Path(name): Path<String>,
) -> Reply<Value> {
    allow(&caller, Role::Administer)?;
    let place = place(&service, &name)?;
    let own = Arc::clone(&service);
    let reloaded = tokio::task::spawn_blocking(move || own.hub.reload(place)).await;
    let reloaded = reloaded.map_err(|_| ApiError::invalid("the detector cannot be loaded"))?;
    let sha256 = reloaded.map_err(|error| ApiError::invalid(error.to_string()))?;
    tracing::info!(machine = name, sha256, by = caller.name, "detector loaded");
    Ok(Json(json!({ "sha256": sha256 })))
}

/// What is asked of the alarms.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlarmsQuery {
    open: Option<bool>,
    machine: Option<String>,
    fault: Option<String>,
    since_ms: Option<i64>,
    until_ms: Option<i64>,
    limit: Option<usize>,
}

/// `GET /api/v1/alarms`.
pub async fn alarms(
    State(service): State<Arc<Service>>,
    query: Asked<AlarmsQuery>,
) -> Reply<AlarmsView> {
    let Query(query) = query?;
    let limit = query.limit.unwrap_or(500);
    if !(1..=MOST_ALARMS).contains(&limit) {
        return Err(ApiError::invalid(format!(
            "limit: expected 1 to {MOST_ALARMS}, found {limit}"
        )));
    }
    let history = service.hub.history();
    let alarms = history.alarms().filter(|alarm| {
        query.open.is_none_or(|open| alarm.is_open() == open)
            && query
                .machine
                .as_ref()
                .is_none_or(|name| alarm.machine == *name)
            && query
                .fault
                .as_ref()
                .is_none_or(|fault| alarm.fault.as_ref() == Some(fault))
            && query
                .since_ms
                .is_none_or(|since_ms| alarm.raised_ms >= since_ms)
            && query
                .until_ms
                .is_none_or(|until_ms| alarm.raised_ms < until_ms)
    });
    let alarms = alarms.take(limit).cloned().collect();
    Ok(Json(AlarmsView { alarms }))
}

fn alarm_of(service: &Service, id: u64) -> Result<Alarm, ApiError> {
    let history = service.hub.history();
    let found = history.alarm(id).map(|(alarm, _)| alarm.clone());
    found.ok_or_else(|| ApiError::not_found(format!("alarm {id}: expected one of /api/v1/alarms")))
}

/// `GET /api/v1/alarms/{id}`.
pub async fn alarm(State(service): State<Arc<Service>>, Path(id): Path<u64>) -> Reply<Alarm> {
    alarm_of(&service, id).map(Json)
}

/// `GET /api/v1/alarms/{id}/events`.
pub async fn alarm_events(
    State(service): State<Arc<Service>>,
    Path(id): Path<u64>,
) -> Reply<Value> {
    let history = service.hub.history();
    let Some((_, events)) = history.alarm(id) else {
        return Err(ApiError::not_found(format!(
            "alarm {id}: expected one of /api/v1/alarms"
        )));
    };
    let events: Vec<Value> = events
        .iter()
        .map(|event| {
            json!({
                "time_ms": event.time_ms,
                "event": event.event,
                "by": event.by,
                "text": event.text,
            })
        })
        .collect();
    Ok(Json(json!({ "events": events })))
}

/// Lets an operator act on an alarm of its machine; the answer comes when it is on the disk, or, from
/// a disk that does not answer, when everybody has been told.
async fn act(
    service: &Service,
    id: u64,
    action: impl FnOnce(&mut AlarmList) -> Result<Alarm, AlarmError>,
) -> Reply<Alarm> {
    let name = alarm_of(service, id)?.machine;
    let place = place(service, &name)?;
    let (alarm, events) = {
        let mut machine = service.hub.cells[place].lock();
        let alarm = action(machine.alarms_mut());
        (alarm, service.hub.commit(place, &mut machine))
    };
    service.hub.outbox().until_told(events).await;
    Ok(Json(alarm?))
}

/// The operator's name: that of the token, which nobody can choose, or else what is said.
fn name_of(caller: &Caller, by: Option<String>) -> Result<String, ApiError> {
    let name = caller.name.clone().or(by).unwrap_or_default();
    text("by", &name, true)
}

fn text(field: &str, text: &str, needed: bool) -> Result<String, ApiError> {
    let text = text.trim().to_owned();
    if needed && text.is_empty() {
        return Err(ApiError::invalid(format!(
            "{field}: expected a text, found none"
        )));
    }
    let length = text.chars().count();
    if length > LONGEST_TEXT {
        let expected =
            format!("{field}: expected at most {LONGEST_TEXT} characters, found {length}");
        return Err(ApiError::invalid(expected));
    }
    Ok(text)
}

/// An acknowledgement.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AcknowledgeBody {
    by: Option<String>,
    comment: Option<String>,
}

/// `POST /api/v1/alarms/{id}/acknowledge`.
pub async fn acknowledge(
    State(service): State<Arc<Service>>,
    Extension(caller): Extension<Caller>,
    Path(id): Path<u64>,
    body: Body<AcknowledgeBody>,
) -> Reply<Alarm> {
    allow(&caller, Role::Operate)?;
    let Json(body) = body?;
    let by = name_of(&caller, body.by)?;
    let comment = text("comment", &body.comment.unwrap_or_default(), false)?;
    let alarm = alarm_of(&service, id)?;
    if alarm.acknowledged.is_some() {
        // Sent again, or by a second operator: who was first stays, although it may be over by now.
        return Ok(Json(alarm));
    }
    act(&service, id, |alarms| {
        alarms.acknowledge(id, &by, &comment, now_ms())
    })
    .await
}

/// What sets an alarm aside.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShelveBody {
    by: Option<String>,
    reason: String,
    minutes: f64,
}

/// `POST /api/v1/alarms/{id}/shelve`.
pub async fn shelve(
    State(service): State<Arc<Service>>,
    Extension(caller): Extension<Caller>,
    Path(id): Path<u64>,
    body: Body<ShelveBody>,
) -> Reply<Alarm> {
    allow(&caller, Role::Operate)?;
    let Json(body) = body?;
    let by = name_of(&caller, body.by)?;
    let reason = text("reason", &body.reason, true)?;
    let seconds = body.minutes * 60.0;
    act(&service, id, |alarms| {
        alarms.shelve(id, &by, &reason, seconds, now_ms())
    })
    .await
}

/// What takes an alarm from the shelf.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnshelveBody {
    by: Option<String>,
}

/// `POST /api/v1/alarms/{id}/unshelve`.
pub async fn unshelve(
    State(service): State<Arc<Service>>,
    Extension(caller): Extension<Caller>,
    Path(id): Path<u64>,
    body: Body<UnshelveBody>,
) -> Reply<Alarm> {
    allow(&caller, Role::Operate)?;
    let Json(body) = body?;
    let by = name_of(&caller, body.by)?;
    act(&service, id, |alarms| alarms.unshelve(id, &by, now_ms())).await
}

/// `GET /api/v1/faults`.
pub async fn faults(State(service): State<Arc<Service>>) -> Reply<Value> {
    let plant = service.plant.as_ref().ok_or_else(no_plant)?;
    Ok(Json(json!({ "faults": plant.faults() })))
}

fn no_plant() -> ApiError {
    ApiError::not_found("faults: expected a service with the embedded turbine")
}

/// A fault of the embedded turbine: a ramp where there is a rate, else a step.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultBody {
    case: String,
    /// Growth an hour, in the case's unit.
    rate_per_h: Option<f64>,
    /// The size at which it stops growing, or of the step.
    limit: Option<f64>,
    /// Seconds from now to its onset.
    onset_in_s: Option<f64>,
}

/// `POST /api/v1/faults`.
pub async fn inject(
    State(service): State<Arc<Service>>,
    Extension(caller): Extension<Caller>,
    body: Body<FaultBody>,
) -> Result<(StatusCode, Json<Value>), ApiError> {
    allow(&caller, Role::Administer)?;
    let plant = service.plant.as_ref().ok_or_else(no_plant)?;
    let Json(body) = body?;
    let case = FaultCase::ALL
        .into_iter()
        .find(|case| case.name() == body.case);
    let case = case.ok_or_else(|| {
        let names = FaultCase::ALL.map(FaultCase::name).join(", ");
        ApiError::invalid(format!(
            "case: expected one of {names}, found `{}`",
            body.case
        ))
    })?;
    let shape = match (body.rate_per_h, body.limit) {
        (Some(rate_per_h), limit) => Shape::Ramp(Ramp { rate_per_h, limit }),
        (None, Some(size)) => Shape::Step(Step { size }),
        (None, None) => {
            return Err(ApiError::invalid(
                "rate_per_h or limit: expected at least one, found neither",
            ));
        }
    };
    let fault = Fault::new(Target::Case(case), body.onset_in_s.unwrap_or(0.0), shape);
    plant
        .inject(fault)
        .map_err(|error| ApiError::invalid(error.to_string()))?;
    tracing::info!(case = body.case, by = caller.name, "fault injected");
    Ok((
        StatusCode::CREATED,
        Json(json!({ "faults": plant.faults() })),
    ))
}

/// `DELETE /api/v1/faults`.
pub async fn repair(
    State(service): State<Arc<Service>>,
    Extension(caller): Extension<Caller>,
) -> Reply<Value> {
    allow(&caller, Role::Administer)?;
    let plant = service.plant.as_ref().ok_or_else(no_plant)?;
    plant
        .repair()
        .map_err(|error| ApiError::invalid(error.to_string()))?;
    tracing::info!(by = caller.name, "faults taken away");
    Ok(Json(json!({ "faults": [] })))
}
