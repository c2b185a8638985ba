//! The self-contained HTML page of a report: no script, no font, no network.

use std::fmt::Write as _;

use super::chart::{Chart, STYLE};
use super::escape;

const PAGE_STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1d2733;--soft:#5b6675;--paper:#fff;--band:#f4f6f9;\
--rule:#dde3ea;--good:#0b7a55;--bad:#b3261e;--accent:#0b62a8}\
@media(prefers-color-scheme:dark){:root{--ink:#e6ebf1;--soft:#9aa7b5;--paper:#12171d;\
--band:#1a2129;--rule:#2c3642;--good:#5fcaa0;--bad:#ff8a80;--accent:#6bb5f2}}\
*{box-sizing:border-box}body{margin:0;background:var(--paper);color:var(--ink);\
font:15px/1.55 system-ui,-apple-system,'Segoe UI',Roboto,sans-serif}\
main{max-width:60rem;margin:0 auto;padding:2rem 1rem 4rem}\
h1{font-size:1.7rem;line-height:1.2;margin:0 0 .3rem}h2{font-size:1.25rem;margin:2.6rem 0 .5rem;\
padding-top:.6rem;border-top:1px solid var(--rule)}h3{font-size:1rem;margin:1.6rem 0 .3rem}\
p{margin:.4rem 0 .8rem;max-width:46rem}.lead,.note,figcaption,footer{color:var(--soft)}\
.note{font-size:.9rem}nav{margin:1rem 0 0;font-size:.95rem}nav a{margin-right:1rem}\
a{color:var(--accent)}.scroll{overflow-x:auto}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.92rem;margin:.4rem 0}\
th,td{padding:.25rem .7rem;text-align:right;white-space:nowrap}\
th:first-child,td:first-child{text-align:left}thead th{border-bottom:2px solid var(--rule);\
font-weight:600}tbody tr:nth-child(even){background:var(--band)}\
.good{color:var(--good)}.bad{color:var(--bad)}figure{margin:1rem 0}figure svg{width:100%;\
min-width:34rem;height:auto;display:block}.shade{background:color-mix(in srgb,var(--accent) \
var(--share),transparent)}.facts{display:grid;grid-template-columns:repeat(auto-fit,\
minmax(13rem,1fr));gap:.8rem;margin:1.2rem 0;padding:0;list-style:none}\
.facts li{background:var(--band);border-radius:.5rem;padding:.7rem .9rem}\
.facts b{display:block;font-size:1.35rem;font-variant-numeric:tabular-nums}\
footer{margin-top:3rem;font-size:.85rem;border-top:1px solid var(--rule);padding-top:.8rem}\
.prose td{white-space:normal;text-align:left;vertical-align:top;min-width:11rem}\
.prose th{text-align:left}details{margin:.8rem 0}summary{cursor:pointer;font-weight:600}\
@media print{nav{display:none}h2{break-after:avoid}figure,table{break-inside:avoid}}";

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
        let _ = write!(self.body, "<p>{}</p>", escape(text));
    }

    /// A paragraph in small print, for definitions.
    pub fn note(&mut self, text: &str) {
        let _ = write!(self.body, "<p class=\"note\">{}</p>", escape(text));
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
    pub fn figure(&mut self, chart: &Chart, caption: &str) {
        let _ = write!(
            self.body,
            "<figure><div class=\"scroll\">{}</div><figcaption class=\"note\">{} (<a href=\"figures/{id}.svg\">SVG</a>, <a \
             href=\"figures/{id}.csv\">CSV</a>)</figcaption></figure>",
            chart.inline(),
            escape(caption),
            id = escape(&chart.id)
        );
    }

    /// The finished document.
    pub fn finish(self, footer: &str) -> String {
        let mut nav = String::new();
        for (id, title) in &self.sections {
            let _ = write!(nav, "<a href=\"#{}\">{}</a>", escape(id), escape(title));
        }
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta \
             name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>{title}\
             </title><link rel=\"icon\" href=\"data:,\"><style>{PAGE_STYLE}{STYLE}</style></head>\
             <body><main><header><h1>{title}</h1><p class=\"lead\">{lead}</p><nav>{nav}</nav>\
             </header>{body}<footer>{footer}</footer></main></body></html>\n",
            title = escape(&self.title),
            lead = escape(&self.lead),
            body = self.body,
            footer = escape(footer)
        )
    }
}

#[cfg(test)]
mod tests {
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
}
