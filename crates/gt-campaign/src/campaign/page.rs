//! The page of a campaign, and all files of its summary.

use std::path::Path;

use super::fault_summary::FaultSummary;
use super::figures::figures;
use super::folder::Folder;
use super::naming_summary::NamingCounts;
use super::summary::Summary;
use crate::error::CampaignError;
use crate::report::page::{Cell, Page};
use crate::report::text::digits;

impl Summary {
    /// Writes `summary.json`, `report.html` and `figures/*` into a campaign's folder.
    ///
    /// # Errors
    /// [`CampaignError`] names the file or the folder.
    pub fn write(&self, folder: &Folder) -> Result<(), CampaignError> {
        let path = folder.path();
        let figures_path = path.join("figures");
        std::fs::create_dir_all(&figures_path).map_err(|source| CampaignError::Folder {
            path: figures_path.clone(),
            source,
        })?;
        for figure in figures(self) {
            figure.write(&figures_path)?;
        }
        gt_log::write_json(&path.join("summary.json"), self)?;
        write(
            &path.join("report.html"),
            &self.page(&folder.manifest().version),
        )
    }

    /// The page.
    fn page(&self, version: &str) -> String {
        let lead = format!(
            "{} runs of the {} profile with {} maps, noise {}, seed {}.",
            self.runs, self.profile, self.map_set, self.noise, self.seed
        );
        let mut page = Page::new("Campaign", &lead);
        let rate = self.false_alarms.as_ref();
        page.facts(&[
            (self.ok.to_string(), "whole runs".to_owned()),
            (self.failed.to_string(), "failed runs".to_owned()),
            (
                rate.map_or_else(|| "-".to_owned(), |rate| digits(rate.per_hour, 3)),
                "false alarms an hour".to_owned(),
            ),
        ]);
        page.section("detection", "Detection");
        let rows: Vec<Vec<Cell>> = self.faults.iter().map(row).collect();
        page.table(
            &[
                "fault",
                "runs",
                "detected %",
                "median delay s",
                "90 % within s",
                "found from size",
                "first alarm",
            ],
            &rows,
        );
        if let Some(rate) = rate {
            page.paragraph(&format!(
                "{} false alarms in {} h before the onsets: {} an hour, 95 % interval {} .. {}{}.",
                rate.alarms,
                digits(rate.hours, 3),
                digits(rate.per_hour, 3),
                digits(rate.per_hour_low, 3),
                digits(rate.per_hour_high, 3),
                self.arl0_h.map_or_else(String::new, |hours| {
                    format!("; one in {hours} h was asked for")
                })
            ));
        }
        for figure in figures(self) {
            page.figure(&figure);
        }
        page.note(&self.definition);
        self.naming_section(&mut page);
        page.section("sizes", "By size");
        for fault in self.faults.iter().filter(|fault| fault.detected.of > 0) {
            page.heading(&format!("{}, {}", fault.fault, fault.waveform));
            let rows = fault.sizes.iter().map(|bin| {
                let share = bin.detected.share.unwrap_or(0.0);
                vec![
                    Cell::plain(format!("{} .. {}", digits(bin.from, 3), digits(bin.to, 3))),
                    Cell::plain(bin.detected.of.to_string()),
                    Cell::shaded(bin.detected.to_string(), share),
                ]
            });
            let rows: Vec<Vec<Cell>> = rows.collect();
            let size = format!("size [{}]", fault.unit);
            page.table(&[&size, "runs", "detected %"], &rows);
        }
        page.section("failed", "Failed runs");
        if self.failures.is_empty() {
            page.paragraph("None.");
        } else {
            let rows = self.failures.iter().map(|failure| {
                vec![
                    Cell::plain(failure.fault.as_deref().unwrap_or("healthy")),
                    Cell::plain(&failure.reason),
                    Cell::plain(failure.runs.to_string()),
                ]
            });
            page.prose_table(&["fault", "reason", "runs"], &rows.collect::<Vec<_>>());
        }
        page.files(
            "All of it:",
            &["rows.parquet", "summary.json", "campaign.toml", "bank.json"]
                .map(|file| (file.to_owned(), file.to_owned())),
        );
        page.finish(&format!("gtfdi {version}"))
    }
}

impl Summary {
    /// How faults were named, where something names them.
    fn naming_section(&self, page: &mut Page) {
        let Some(all) = &self.naming else {
            return;
        };
        page.section("naming", "Naming");
        let faults = self.faults.iter();
        let named = faults.filter_map(|fault| Some((fault.fault.as_str(), fault.naming.as_ref()?)));
        let rows: Vec<Vec<Cell>> = named
            .chain([("all", all)])
            .map(|(fault, counts)| {
                std::iter::once(Cell::plain(fault))
                    .chain(counts.cells().map(Cell::plain))
                    .collect()
            })
            .collect();
        let head: Vec<&str> = std::iter::once("fault").chain(NamingCounts::HEAD).collect();
        page.table(&head, &rows);
        page.heading("Which fault was named as which");
        let names = self.confusion.names.iter().map(String::as_str);
        let head: Vec<&str> = std::iter::once("fault").chain(names).collect();
        let rows = self.confusion.faults.iter().zip(&self.confusion.runs);
        let rows: Vec<Vec<Cell>> = rows
            .map(|(fault, runs)| {
                let all: u64 = runs.iter().sum();
                let cells = runs.iter().map(|count| {
                    Cell::shaded(count.to_string(), *count as f64 / all.max(1) as f64)
                });
                std::iter::once(Cell::plain(fault)).chain(cells).collect()
            })
            .collect();
        page.table(&head, &rows);
    }
}

fn row(fault: &FaultSummary) -> Vec<Cell> {
    let quantile = |share: f64| {
        let found = fault
            .delay_s
            .iter()
            .find(|found| found.share.total_cmp(&share).is_eq());
        Cell::plain(found.map_or_else(|| "-".to_owned(), ToString::to_string))
    };
    let first = fault.first_alarms.first();
    let limit = fault.size_limits.last().and_then(|own| own.limit.size);
    vec![
        Cell::plain(format!(
            "{} {}, {}",
            fault.case, fault.fault, fault.waveform
        )),
        Cell::plain(fault.detected.of.to_string()),
        Cell::plain(fault.detected.to_string()),
        quantile(0.5),
        quantile(0.9),
        Cell::plain(limit.map_or_else(
            || "-".to_owned(),
            |size| format!("{} {}", digits(size, 2), fault.unit),
        )),
        Cell::plain(first.map_or_else(
            || "-".to_owned(),
            |first| format!("{} {}", first.tag, first.statistic),
        )),
    ]
}

fn write(path: &Path, text: &str) -> Result<(), CampaignError> {
    Ok(gt_log::write_atomically(path, text.as_bytes())?)
}
