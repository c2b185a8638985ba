//! The self-contained HTML page of a report: no font, no network, and whole without its script, which
//! lets charts zoom.

use std::fmt::Write as _;

use super::draw::STYLE;
use super::escape;
use super::figure::Figure;
use super::points;

const PAGE_STYLE: &str = include_str!("assets/page.css");
const ZOOM_SCRIPT: &str = include_str!("assets/zoom.js");
/// What a browser may load for the page: nothing that is not in it.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      img-src data:";

/// How charts zoom; the script shows it.
const HINT: &str = "<p class=\"note script\" hidden>Charts: drag to zoom, double click to see all; \
                    with the keyboard + and -, arrows and 0. Those over the same time move \
                    together.</p>";

/// How a cell is coloured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tone {
    /// No judgement.
    Plain,
    /// Within its limit.
    Good,
    /// Outside its limit.
    Bad,
    /// A share between 0 and 1, as depth of colour.
    Shade(f64),
}

/// A table cell.
#[derive(Debug, Clone)]
pub struct Cell {
    text: String,
    tone: Tone,
}

impl Cell {
    /// A cell without judgement.
    pub fn plain(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            tone: Tone::Plain,
        }
    }

    /// A cell that says whether its limit was met.
    pub fn judged(text: impl Into<String>, met: bool) -> Self {
        Self {
            text: text.into(),
            tone: if met { Tone::Good } else { Tone::Bad },
        }
    }

    /// A cell whose background deepens with `share`, from 0 to 1.
    pub fn shaded(text: impl Into<String>, share: f64) -> Self {
        Self {
            text: text.into(),
            tone: Tone::Shade(share),
        }
    }
}

impl Tone {
    /// The attributes of the cell's element.
    fn attributes(self) -> String {
        match self {
            Self::Plain => String::new(),
            Self::Good => " class=\"good\"".to_owned(),
            Self::Bad => " class=\"bad\"".to_owned(),
            // Half the accent at most, so that the number stays readable on it.
            Self::Shade(share) => {
                format!(
                    " class=\"shade\" style=\"--share:{:.0}%\"",
                    50.0 * share.clamp(0.0, 1.0)
                )
            }
        }
    }
}

/// A page under construction.
#[derive(Debug, Default)]
pub struct Page {
    title: String,
    lead: String,
    sections: Vec<(String, String)>,
    body: String,
    /// Whether there is a chart that zooms.
    zooms: bool,
}

impl Page {
    /// A page with its heading and the sentence beneath.
    pub fn new(title: &str, lead: &str) -> Self {
        Self {
            title: title.to_owned(),
            lead: lead.to_owned(),
            ..Self::default()
        }
    }

    /// The few numbers that come first.
    pub fn facts(&mut self, facts: &[(String, String)]) {
        self.body.push_str("<ul class=\"facts\">");
        for (value, what) in facts {
            let _ = write!(
                self.body,
                "<li><b>{}</b>{}</li>",
                escape(value),
                escape(what)
            );
        }
        self.body.push_str("</ul>");
    }

    /// Starts a section; it appears in the navigation.
    pub fn section(&mut self, id: &str, title: &str) {
        self.sections.push((id.to_owned(), title.to_owned()));
        let _ = write!(
            self.body,
            "<h2 id=\"{}\">{}</h2>",
            escape(id),
            escape(title)
        );
    }

    /// A heading inside a section.
    pub fn heading(&mut self, title: &str) {
        let _ = write!(self.body, "<h3>{}</h3>", escape(title));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = write!(self.body, "<p>{}</p>", marked(text));
    }

    /// A paragraph in small print, for definitions.
    pub fn note(&mut self, text: &str) {
        let _ = write!(self.body, "<p class=\"note\">{}</p>", marked(text));
    }

    /// Text whose lines and spaces stay as they are.
    pub fn preformatted(&mut self, text: &str) {
        let _ = write!(self.body, "<pre>{}</pre>", escape(text));
    }

    /// What its reader may fold away.
    pub fn fold(&mut self, summary: &str, open: bool, fill: impl FnOnce(&mut Self)) {
        let open = if open { " open" } else { "" };
        let summary = escape(summary);
        let _ = write!(self.body, "<details{open}><summary>{summary}</summary>");
        fill(self);
        self.body.push_str("</details>");
    }

    /// A line of links to files beside the page: address and text.
    pub fn files(&mut self, what: &str, files: &[(String, String)]) {
        let _ = write!(self.body, "<p class=\"note\">{}", escape(what));
        for (index, (address, text)) in files.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            let (address, text) = (escape(address), escape(text));
            let _ = write!(self.body, "{comma} <a href=\"{address}\">{text}</a>");
        }
        self.body.push_str(".</p>");
    }

    /// A table of numbers.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<Cell>]) {
        self.tabulate("", head, rows);
    }

    /// A table of sentences, which break into lines.
    pub fn prose_table(&mut self, head: &[&str], rows: &[Vec<Cell>]) {
        self.tabulate(" class=\"prose\"", head, rows);
    }

    fn tabulate(&mut self, attributes: &str, head: &[&str], rows: &[Vec<Cell>]) {
        let _ = write!(
            self.body,
            "<div class=\"scroll\"><table{attributes}><thead><tr>"
        );
        for cell in head {
            let _ = write!(self.body, "<th scope=\"col\">{}</th>", escape(cell));
        }
        self.body.push_str("</tr></thead><tbody>");
        for row in rows {
            self.body.push_str("<tr>");
            for cell in row {
                let attributes = cell.tone.attributes();
                let _ = write!(self.body, "<td{attributes}>{}</td>", escape(&cell.text));
            }
            self.body.push_str("</tr>");
        }
        self.body.push_str("</tbody></table></div>");
    }

    /// A chart, with links to the files that hold it alone.
    pub fn figure(&mut self, figure: &Figure) {
        let Figure { chart, caption } = figure;
        let id = escape(&chart.id);
        let _ = write!(
            self.body,
            "<figure id=\"figure_{id}\"><div class=\"scroll\">{}</div><figcaption \
             class=\"note\">{}{} (<a href=\"figures/{id}.svg\">SVG</a>, <a \
             href=\"figures/{id}.csv\">CSV</a>)</figcaption>",
            chart.inline(),
            escape(caption),
            points::samples_a_bucket(chart).map_or_else(String::new, |samples| {
                format!(
                    " Drawn by the least and the greatest of every {samples} samples; the CSV has \
                     all."
                )
            }),
        );
        // Without its numbers a chart does not zoom, and is a chart all the same.
        if let Ok(numbers) = points::json(chart) {
            let _ = write!(
                self.body,
                "<script type=\"application/json\">{numbers}</script>"
            );
            self.zooms = true;
        }
        self.body.push_str("</figure>");
    }

    /// The finished document.
    pub fn finish(self, footer: &str) -> String {
        let mut nav = String::new();
        for (id, title) in &self.sections {
            let _ = write!(nav, "<a href=\"#{}\">{}</a>", escape(id), escape(title));
        }
        let (hint, script) = if self.zooms {
            (HINT, format!("<script>{ZOOM_SCRIPT}</script>"))
        } else {
            ("", String::new())
        };
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta \
             name=\"viewport\" content=\"width=device-width,initial-scale=1\"><meta \
             http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"><title>{title}</title>\
             <link rel=\"icon\" href=\"data:,\"><style>{PAGE_STYLE}{STYLE}</style></head>\
             <body><main><header><h1>{title}</h1><p class=\"lead\">{lead}</p><nav>{nav}</nav>\
             {hint}</header>{body}<footer>{footer}</footer></main>{script}</body></html>\n",
            title = escape(&self.title),
            lead = marked(&self.lead),
            body = self.body,
            footer = escape(footer)
        )
    }
}

/// Text with names between backticks set as code.
fn marked(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    // An odd backtick is one.
    if parts.len().is_multiple_of(2) {
        return escape(text);
    }
    let set = parts.iter().enumerate().map(|(place, part)| {
        let part = escape(part);
        if place % 2 == 1 {
            format!("<code>{part}</code>")
        } else {
            part
        }
    });
    set.collect()
}

#[cfg(test)]
mod tests {
    use super::super::chart::{Chart, Series};
    use super::*;

    #[test]
    fn the_page_is_self_contained_and_escaped() {
        let mut page = Page::new("A & B", "lead");
        page.section("t", "Table <3>");
        page.table(&["x"], &[vec![Cell::judged("<b>", false)]]);
        page.fold("more <", true, |page| {
            page.prose_table(&["y"], &[vec![Cell::plain("a & b")]]);
        });
        page.files(
            "CSV:",
            &[
                ("t/a.csv".into(), "a".into()),
                ("t/b.csv".into(), "b".into()),
            ],
        );
        let html = page.finish("foot");
        assert!(html.contains("A &amp; B") && html.contains("<td class=\"bad\">&lt;b&gt;</td>"));
        assert!(html.contains("<a href=\"#t\">Table &lt;3&gt;</a>"));
        assert!(html.contains("<details open><summary>more &lt;</summary><div class=\"scroll\">"));
        assert!(html.contains("<table class=\"prose\">") && html.contains("<td>a &amp; b</td>"));
        assert!(html.contains("CSV: <a href=\"t/a.csv\">a</a>, <a href=\"t/b.csv\">b</a>.</p>"));
        for outside in ["http://", "https://", "<script", "url("] {
            assert!(!html.contains(outside), "{outside} leaves the page");
        }
    }

    #[test]
    fn names_between_backticks_are_code() {
        assert_eq!(marked("of `a<b` and"), "of <code>a&lt;b</code> and");
        assert_eq!(marked("a ` alone"), "a ` alone");
    }

    /// The only address in a page with charts is the name of SVG's elements, which nobody fetches.
    #[test]
    fn a_chart_brings_its_numbers_and_one_script() {
        let chart = Chart {
            id: "y".into(),
            x: vec![0.0, 1.0],
            series: vec![Series::line("a <b>", vec![1.0, 2.0])],
            ..Chart::default()
        };
        let mut page = Page::new("A", "lead");
        for _ in 0..2 {
            page.figure(&Figure::new(chart.clone(), "caption"));
        }
        let html = page.finish("foot");
        assert_eq!(
            html.matches("<script type=\"application/json\">").count(),
            2
        );
        assert_eq!(html.matches("<script>").count(), 1);
        assert_eq!(html.matches("</script>").count(), 3);
        assert!(html.contains("(<a href=\"figures/y.svg\">SVG</a>"));
        let rest = html.replace("http://www.w3.org/2000/svg", "");
        for outside in ["http://", "https://", "//cdn", "src=", "import("] {
            assert!(!rest.contains(outside), "{outside} leaves the page");
        }
    }
}
