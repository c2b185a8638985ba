//! What a person reads: charts, tables and the self-contained page.

mod axis;
pub mod chart;
mod document;
mod draw;
mod figure;
pub mod page;
mod points;
mod reduction;
pub mod text;

pub use axis::Scale;
pub use document::Document;
pub use figure::Figure;

/// Text made safe for HTML and SVG.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
