//! The page: files that are part of the program.

use std::sync::Arc;

use axum::Router;
use axum::http::header;
use axum::routing::get;

use super::Service;

macro_rules! script {
    ($name:literal) => {
        (
            concat!("/", $name),
            "text/javascript; charset=utf-8",
            include_str!(concat!("../../page/", $name)),
        )
    };
}

/// Path, media type and text of each file.
const FILES: &[(&str, &str, &str)] = &[
    (
        "/",
        "text/html; charset=utf-8",
        include_str!("../../page/index.html"),
    ),
    (
        "/style.css",
        "text/css; charset=utf-8",
        include_str!("../../page/style.css"),
    ),
    script!("alarm_details.js"),
    script!("alarms.js"),
    script!("api.js"),
    script!("chart.js"),
    script!("dialogs.js"),
    script!("dom.js"),
    script!("faults.js"),
    script!("format.js"),
    script!("machines.js"),
    script!("page.js"),
    script!("state.js"),
    script!("trend.js"),
    script!("trend_card.js"),
    script!("trend_input.js"),
    script!("trends.js"),
];

/// The paths of the page.
pub fn routes() -> Router<Arc<Service>> {
    FILES
        .iter()
        .fold(Router::new(), |routes, (path, media_type, text)| {
            let answer = move || async move { ([(header::CONTENT_TYPE, *media_type)], *text) };
            routes.route(path, get(answer))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each script and style of the folder is served, and nothing else.
    #[test]
    fn all_files_of_the_page_are_served() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/page");
        let names = std::fs::read_dir(folder).unwrap();
        let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut expected: Vec<String> = names
            .filter(|name| [".js", ".css"].iter().any(|end| name.ends_with(end)))
            .map(|name| format!("/{name}"))
            .chain(["/".to_owned()])
            .collect();
        expected.sort();
        let mut found: Vec<&str> = FILES.iter().map(|file| file.0).collect();
        found.sort_unstable();
        assert_eq!(found, expected);
    }
}
