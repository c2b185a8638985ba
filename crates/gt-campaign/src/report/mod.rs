//! What a person reads: charts, tables and the self-contained page.

mod axis;
pub mod chart;
pub mod page;
pub mod text;

pub use axis::Scale;

/// Text made safe for HTML and SVG.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
