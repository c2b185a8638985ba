//! The description of the API.

use axum::http::header;
use axum::response::IntoResponse;

/// The document, checked by a test against the paths that there are.
pub const DOCUMENT: &str = include_str!("openapi.json");

/// `GET /api/v1/openapi.json`.
pub async fn document() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], DOCUMENT)
}
