//! The page and the API.

mod api;
mod auth;
mod failure;
mod openapi;
mod page;
mod scrape;
mod stream;
mod tls;
mod view;

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::Router;
use axum::extract::{ConnectInfo, DefaultBodyLimit, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};

pub use auth::Access;
pub use tls::tls;

use crate::hub::Hub;
use crate::metrics::count;
use crate::source::plant::EmbeddedPlant;
use failure::ApiError;
use tokio::sync::Semaphore;

/// The largest body that is taken, in bytes.
const LARGEST_BODY: usize = 1 << 20;
/// What a page of this service may do: nothing but talk to it.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
                      img-src 'self' data:; connect-src 'self'; base-uri 'none'; \
                      form-action 'none'; frame-ancestors 'none'";

/// What the handlers share.
pub struct Service {
    /// The machines and all else.
    pub hub: Arc<Hub>,
    /// Who may do what.
    pub access: Access,
    /// Places for streams of events.
    pub streams: Arc<Semaphore>,
    /// The embedded turbine, where it runs.
    pub plant: Option<Arc<EmbeddedPlant>>,
}

/// All paths of the service.
pub fn router(service: Arc<Service>) -> Router {
    let api = Router::new()
        .route("/info", get(api::info))
        .route("/machines", get(api::machines))
        .route("/machines/{name}", get(api::machine))
        .route("/machines/{name}/trend", get(api::trend))
        .route("/machines/{name}/reload", post(api::reload))
        .route("/alarms", get(api::alarms))
        .route("/alarms/{id}", get(api::alarm))
        .route("/alarms/{id}/events", get(api::alarm_events))
        .route("/alarms/{id}/acknowledge", post(api::acknowledge))
        .route("/alarms/{id}/shelve", post(api::shelve))
        .route("/alarms/{id}/unshelve", post(api::unshelve))
        .route("/events", get(stream::events))
        .route(
            "/faults",
            get(api::faults).post(api::inject).delete(api::repair),
        )
        .fallback(|| async { ApiError::not_found("expected a path of /api/v1/openapi.json") })
        .layer(from_fn_with_state(Arc::clone(&service), admit));
    let metrics = Router::new()
        .route("/metrics", get(scrape::metrics))
        .layer(from_fn_with_state(Arc::clone(&service), admit));
    Router::new()
        .nest("/api/v1", api)
        .merge(metrics)
        .merge(page::routes())
        .route("/api/v1/openapi.json", get(openapi::document))
        .route("/healthz", get(api::healthz))
        .route("/readyz", get(api::readyz))
        .layer(DefaultBodyLimit::max(LARGEST_BODY))
        .layer(from_fn_with_state(Arc::clone(&service), guard))
        .with_state(service)
}

/// Lets in who has a token, where one is needed.
async fn admit(
    State(service): State<Arc<Service>>,
    ConnectInfo(peer): ConnectInfo<SocketAddr>,
    mut request: Request,
    next: Next,
) -> Response {
    let header = request.headers().get(header::AUTHORIZATION);
    let header = header.map(HeaderValue::as_bytes);
    match service.access.admit(peer.ip(), header) {
        Ok(caller) => {
            request.extensions_mut().insert(caller);
            next.run(request).await
        }
        Err(refused) => {
            count(&service.hub.metrics.unauthorized);
            ApiError::from(refused).into_response()
        }
    }
}

/// Refuses what another site made a browser send, and says what a browser may do with the answer.
async fn guard(State(service): State<Arc<Service>>, request: Request, next: Next) -> Response {
    let is_foreign = is_cross_site(request.headers())
        || (!service.access.needs_token() && !is_for_loopback(request.headers()));
    let mut response = if is_foreign {
        ApiError::new(
            StatusCode::FORBIDDEN,
            "foreign",
            "expected a request of this service's own page, or of no page at all, to a loopback name",
        )
        .into_response()
    } else {
        next.run(request).await
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Whether a browser says that a page of another origin asks.
fn is_cross_site(headers: &HeaderMap) -> bool {
    let text = |name: header::HeaderName| headers.get(name).and_then(|value| value.to_str().ok());
    let Some(origin) = text(header::ORIGIN) else {
        return false;
    };
    let own = text(header::HOST).unwrap_or_default();
    let of_origin = origin.split_once("://").map_or("", |(_, rest)| rest);
    of_origin != own
}

/// Whether the request is for a loopback name: another one that leads here is a trick on a browser.
fn is_for_loopback(headers: &HeaderMap) -> bool {
    let Some(host) = headers
        .get(header::HOST)
        .and_then(|value| value.to_str().ok())
    else {
        // HTTP/1.0, of no browser.
        return true;
    };
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split(']').next().unwrap_or_default(),
        None => host.rsplit_once(':').map_or(host, |(name, _)| name),
    };
    name == "localhost" || name.parse().is_ok_and(|ip: IpAddr| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(pairs: &[(header::HeaderName, &'static str)]) -> HeaderMap {
        let pairs = pairs.iter().cloned();
        pairs
            .map(|(name, value)| (name, HeaderValue::from_static(value)))
            .collect()
    }

    #[test]
    fn only_loopback_names_are_for_here() {
        for (host, expected) in [
            ("127.0.0.1:8471", true),
            ("localhost", true),
            ("localhost:1", true),
            ("[::1]:8471", true),
            ("evil.example:8471", false),
            ("127.0.0.1.evil.example", false),
            ("10.0.0.1:8471", false),
            ("", false),
        ] {
            let found = is_for_loopback(&headers(&[(header::HOST, host)]));
            assert_eq!(found, expected, "{host}");
        }
    }

    #[test]
    fn another_origin_is_foreign() {
        let with = |origin| headers(&[(header::HOST, "localhost:1"), (header::ORIGIN, origin)]);
        assert!(!is_cross_site(&with("http://localhost:1")));
        assert!(is_cross_site(&with("http://localhost:2")));
        assert!(is_cross_site(&with("null")));
        assert!(!is_cross_site(&headers(&[(header::HOST, "localhost:1")])));
    }
}
