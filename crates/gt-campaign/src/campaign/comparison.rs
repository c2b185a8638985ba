//! Finished campaigns side by side: what differs between them, and what that did.

use std::path::{Path, PathBuf};

use serde::Serialize;
use toml::Table;

use super::fault_summary::is_of;
use super::folder::{MANIFEST, finished_rows, manifest_of};
use super::row::{Row, Status};
use super::size_limit::{DetectionCurve, SizeLimit};
use super::summary::Summary;
use crate::error::CampaignError;
use crate::report::chart::{Chart, Series};
use crate::report::page::{Cell, Page};
use crate::report::text::digits;
use crate::report::{Figure, Scale};

/// Version of the JSON object; it rises when a key changes its meaning.
const SCHEMA_VERSION: u32 = 1;
/// Points of a curve.
const POINTS: u32 = 120;

/// Finished campaigns side by side.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Version of this object.
    pub schema_version: u32,
    /// The campaigns, by the names of their folders, in the order given.
    pub campaigns: Vec<Compared>,
    /// The keys of the specifications whose values differ.
    pub differences: Vec<Difference>,
    /// Each fault that any of them has.
    pub faults: Vec<ComparedFault>,
}

/// One campaign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared {
    /// Its folder's name.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// What its rows say.
    pub summary: Summary,
    #[serde(skip)]
    rows: Vec<Row>,
}

/// A key of the specifications.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// Its path, such as `plant.noise`.
    pub key: String,
    /// Its value in each campaign; empty where a campaign has none.
    pub values: Vec<String>,
}

/// A fault in all campaigns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedFault {
    /// The paper's number.
    pub case: u64,
    /// Its name.
    pub fault: String,
    /// How it goes with time.
    pub waveform: String,
    /// The unit of its size.
    pub unit: String,
    /// Of each campaign, the size detected by the horizon with probability .95; `None` where it has
    /// not this fault.
    pub limits: Vec<Option<SizeLimit>>,
}

impl Comparison {
    /// Reads finished campaigns.
    ///
    /// # Errors
    /// [`CampaignError::SpecFile`], [`CampaignError::SpecText`] and [`CampaignError::Table`] for a
    /// folder without a finished campaign.
    pub fn read(folders: &[PathBuf]) -> Result<Self, CampaignError> {
        let mut campaigns: Vec<Compared> = Vec::new();
        let mut specs = Vec::new();
        for folder in folders {
            let manifest = manifest_of(folder)?;
            let spec = manifest.specification(&folder.join(MANIFEST))?;
            let rows = finished_rows(folder)?;
            specs.push(manifest.spec);
            campaigns.push(Compared {
                name: name_of(folder, &campaigns),
                folder: folder.clone(),
                summary: Summary::new(&spec, &rows),
                rows,
            });
        }
        Ok(Self {
            schema_version: SCHEMA_VERSION,
            differences: differences(&specs),
            faults: faults(&campaigns),
            campaigns,
        })
    }

    /// Writes `comparison.json`, `comparison.html` and `figures/*` into a folder, which is made
    /// where it is missing.
    ///
    /// # Errors
    /// [`CampaignError`] names the file or the folder.
    pub fn write(&self, folder: &Path) -> Result<(), CampaignError> {
        let figures_path = folder.join("figures");
        std::fs::create_dir_all(&figures_path).map_err(|source| CampaignError::Folder {
            path: figures_path.clone(),
            source,
        })?;
        let figures: Vec<Figure> = self
            .faults
            .iter()
            .filter_map(|fault| self.detection(fault))
            .collect();
        for figure in &figures {
            figure.write(&figures_path)?;
        }
        gt_log::write_json(&folder.join("comparison.json"), self)?;
        let page = self.page(&figures);
        Ok(gt_log::write_atomically(
            &folder.join("comparison.html"),
            page.as_bytes(),
        )?)
    }

    /// Probability of detection over size, a curve a campaign.
    fn detection(&self, fault: &ComparedFault) -> Option<Figure> {
        let sizes = self
            .campaigns
            .iter()
            .map(|campaign| campaign.runs_of(fault));
        let sizes: Vec<Vec<(f64, bool)>> = sizes.collect();
        let all = || sizes.iter().flatten().map(|(size, _)| *size);
        let (low, high) = (all().reduce(f64::min)?, all().reduce(f64::max)?);
        let x: Vec<f64> = (0..=POINTS)
            .map(|point| low * (high / low).powf(f64::from(point) / f64::from(POINTS)))
            .collect();
        let curves = self.campaigns.iter().zip(&sizes);
        let curves = curves.filter_map(|(campaign, runs)| {
            let curve = DetectionCurve::fit(runs)?;
            let values = x.iter().map(|size| curve.at(*size).unwrap_or(f64::NAN));
            Some(Series::line(&campaign.name, values.collect()))
        });
        let series: Vec<_> = curves.collect();
        if series.is_empty() {
            return None;
        }
        Some(Figure {
            caption: format!(
                "{}: logistic curves through the runs of each campaign, over the sizes it drew.",
                fault.fault
            ),
            chart: Chart {
                id: format!("detection_{}_{}", fault.case, fault.waveform),
                title: format!("Detection of case {} ({})", fault.case, fault.waveform),
                x_label: format!("size [{}]", fault.unit),
                y_label: "share detected".to_owned(),
                x,
                x_scale: Scale::Logarithmic,
                series,
                ..Chart::default()
            },
        })
    }

    fn page(&self, figures: &[Figure]) -> String {
        let names: Vec<&str> = self.campaigns.iter().map(|own| own.name.as_str()).collect();
        let mut page = Page::new("Campaigns compared", &names.join(", "));
        let head = |first: &'static str| -> Vec<&str> {
            std::iter::once(first)
                .chain(names.iter().copied())
                .collect()
        };
        page.section("differences", "What differs");
        let rows: Vec<Vec<Cell>> = self
            .differences
            .iter()
            .map(|own| {
                let values = own.values.iter().map(Cell::plain);
                std::iter::once(Cell::plain(&own.key))
                    .chain(values)
                    .collect()
            })
            .collect();
        page.prose_table(&head("key"), &rows);
        page.section("limits", "Sizes detected with probability .95");
        page.table(&head("fault"), &self.limit_cells());
        for figure in figures {
            page.figure(figure);
        }
        page.section("all", "False alarms and names");
        page.table(&head("of all runs"), &self.overall_cells());
        if let Some(first) = self.campaigns.first() {
            page.note(&first.summary.definition);
        }
        page.finish(&format!("gtfdi {}", env!("CARGO_PKG_VERSION")))
    }

    /// A row a fault: its limits with their intervals.
    pub fn limit_rows(&self) -> Vec<Vec<String>> {
        let limit = |limit: &Option<SizeLimit>, unit: &str| match limit {
            None => "-".to_owned(),
            Some(limit) => match (limit.size, limit.low, limit.high) {
                (Some(size), Some(low), Some(high)) => {
                    let [size, low, high] = [size, low, high].map(|own| digits(own, 3));
                    format!("{size} {unit} ({low} .. {high})")
                }
                _ => "beyond those drawn".to_owned(),
            },
        };
        let rows = self.faults.iter().map(|fault| {
            let limits = fault.limits.iter().map(|own| limit(own, &fault.unit));
            let name = format!("{} {}, {}", fault.case, fault.fault, fault.waveform);
            std::iter::once(name).chain(limits).collect()
        });
        rows.collect()
    }

    fn limit_cells(&self) -> Vec<Vec<Cell>> {
        let rows = self.limit_rows().into_iter();
        rows.map(|row| row.into_iter().map(Cell::plain).collect())
            .collect()
    }

    fn overall_cells(&self) -> Vec<Vec<Cell>> {
        type Told = fn(&Summary) -> Option<String>;
        let rows: [(&str, Told); 5] = [
            ("whole runs", |own| Some(own.ok.to_string())),
            ("failed runs", |own| Some(own.failed.to_string())),
            ("false alarms an hour", |own| {
                let rate = own.false_alarms.as_ref()?;
                let [rate, low, high] = [rate.per_hour, rate.per_hour_low, rate.per_hour_high]
                    .map(|own| digits(own, 3));
                Some(format!("{rate} ({low} .. {high})"))
            }),
            ("named right %", |own| {
                Some(own.naming.as_ref()?.right.to_string())
            }),
            ("undecided %", |own| {
                Some(own.naming.as_ref()?.undecided.to_string())
            }),
        ];
        let rows = rows.iter().map(|(name, told)| {
            let cells = self
                .campaigns
                .iter()
                .map(|own| Cell::plain(told(&own.summary).unwrap_or_else(|| "-".to_owned())));
            std::iter::once(Cell::plain(*name)).chain(cells).collect()
        });
        rows.collect()
    }
}

impl Compared {
    /// Sizes of the whole runs of a fault, and whether they were detected.
    fn runs_of(&self, fault: &ComparedFault) -> Vec<(f64, bool)> {
        let rows = self.rows.iter().filter(|row| row.status == Status::Ok);
        let own = rows.filter(|row| is_of(row, &fault.fault, &fault.waveform));
        own.filter_map(|row| Some((row.size?, row.detected?)))
            .collect()
    }
}

/// The folder's name, with a number where one before has the same.
fn name_of(folder: &Path, others: &[Compared]) -> String {
    let name = folder.file_name().map_or_else(
        || folder.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    );
    let mut free = name.clone();
    let mut number = 2;
    while others.iter().any(|other| other.name == free) {
        free = format!("{name} {number}");
        number += 1;
    }
    free
}

fn faults(campaigns: &[Compared]) -> Vec<ComparedFault> {
    let mut faults: Vec<ComparedFault> = Vec::new();
    for (place, campaign) in campaigns.iter().enumerate() {
        for own in &campaign.summary.faults {
            let same = |other: &&mut ComparedFault| {
                other.fault == own.fault && other.waveform == own.waveform
            };
            let limit = own.size_limits.last().map(|last| last.limit);
            if let Some(known) = faults.iter_mut().find(same) {
                known.limits[place] = limit;
                continue;
            }
            let mut limits = vec![None; campaigns.len()];
            limits[place] = limit;
            faults.push(ComparedFault {
                case: own.case,
                fault: own.fault.clone(),
                waveform: own.waveform.clone(),
                unit: own.unit.clone(),
                limits,
            });
        }
    }
    faults
}

/// The keys of tables whose values are not all alike.
fn differences(specs: &[Table]) -> Vec<Difference> {
    let flat: Vec<Vec<(String, String)>> = specs
        .iter()
        .map(|spec| {
            let mut pairs = Vec::new();
            for (key, value) in spec {
                flatten(key, value, &mut pairs);
            }
            pairs
        })
        .collect();
    let mut keys: Vec<&String> = Vec::new();
    for (key, _) in flat.iter().flatten() {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let value = |pairs: &[(String, String)], key: &str| {
        let own = pairs.iter().find(|(own, _)| own == key);
        own.map_or_else(String::new, |(_, value)| value.clone())
    };
    keys.into_iter()
        .map(|key| Difference {
            key: key.clone(),
            values: flat.iter().map(|pairs| value(pairs, key)).collect(),
        })
        .filter(|own| own.values.iter().any(|value| *value != own.values[0]))
        .collect()
}

fn flatten(key: &str, value: &toml::Value, pairs: &mut Vec<(String, String)>) {
    match value {
        toml::Value::Table(table) => {
            for (inner, value) in table {
                flatten(&format!("{key}.{inner}"), value, pairs);
            }
        }
        toml::Value::Array(values) if values.iter().any(toml::Value::is_table) => {
            for (place, value) in values.iter().enumerate() {
                flatten(&format!("{key}[{place}]"), value, pairs);
            }
        }
        value => pairs.push((key.to_owned(), value.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_told_by_its_key() {
        let table = |text: &str| toml::from_str::<Table>(text).expect("a table");
        let specs = [
            table("seed = 1\n[plant]\nnoise = 'none'\n[[faults]]\ncase = 1\nsize = [1.0, 2.0]"),
            table("seed = 1\n[plant]\nnoise = 'table8'\n[[faults]]\ncase = 1\nsize = [1.0, 3.0]"),
            table("seed = 1\nruns = 2\n[plant]\nnoise = 'none'"),
        ];
        let found: Vec<(String, Vec<String>)> = differences(&specs)
            .into_iter()
            .map(|own| (own.key, own.values))
            .collect();
        let expected = [
            ("plant.noise", ["\"none\"", "\"table8\"", "\"none\""]),
            ("faults[0].case", ["1", "1", ""]),
            ("faults[0].size", ["[1.0, 2.0]", "[1.0, 3.0]", ""]),
            ("runs", ["", "", "2"]),
        ];
        let mut found_keys: Vec<&str> = found.iter().map(|(key, _)| key.as_str()).collect();
        found_keys.sort_unstable();
        let mut expected_keys = expected.map(|(key, _)| key);
        expected_keys.sort_unstable();
        assert_eq!(found_keys, expected_keys);
        for (key, values) in expected {
            let own = found.iter().find(|(own, _)| own == key).expect("the key");
            assert_eq!(own.1, values, "{key}");
        }
    }
}
