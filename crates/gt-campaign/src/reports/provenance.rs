//! What a report was made from.

use std::fmt::Write as _;

use gt_log::build_info;

use crate::report::page::Page;

/// Where the numbers of a report come from, for its foot.
#[derive(Debug, Clone, Default)]
pub struct Provenance {
    /// The files that were read, each with its SHA-256 where it is known.
    pub files: Vec<(String, Option<String>)>,
    /// All options of the run as TOML; empty where there are none to tell.
    pub options_toml: String,
    /// What was warned of.
    pub warnings: Vec<String>,
}

impl Provenance {
    /// The warnings, before anything else is read.
    pub(super) fn warn(&self, page: &mut Page) {
        if self.warnings.is_empty() {
            return;
        }
        page.section("warnings", "Warnings");
        for warning in &self.warnings {
            page.paragraph(warning);
        }
    }

    /// The options, folded, and the finished page with what made it at its foot.
    pub(super) fn finish(&self, mut page: Page) -> String {
        if !self.options_toml.is_empty() {
            page.fold("All options of this run", false, |page| {
                page.preformatted(&self.options_toml);
            });
        }
        let build = build_info();
        let mut foot = format!("gtfdi {} ({}), {}.", build.version, build.git, build.rustc);
        for (name, sha256) in &self.files {
            let _ = write!(foot, " {name}");
            if let Some(digest) = sha256 {
                let _ = write!(foot, ": SHA-256 {digest}");
            }
            foot.push('.');
        }
        page.finish(&foot)
    }
}
