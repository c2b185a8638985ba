//! What another process needs to run chunks of a campaign, and what it hands back.

use std::path::Path;

use gt_log::DetectorFile;
use gtfdi::plant::Noise;
use serde::{Deserialize, Serialize};

use super::folder::{BANK, Folder, MANIFEST, runs_of};
use super::manifest::Manifest;
use super::runner::Campaign;
use super::table::Table;
use crate::error::CampaignError;
use crate::progress::Progress;

/// This program's version.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// A campaign as another process needs it, which has neither its folder nor its file. Whoever has the
/// folder gives out numbers of chunks ([`Folder::missing`]) and keeps what comes back
/// ([`Folder::keep_part`]).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    manifest: Manifest,
    /// The text of the bank's file.
    bank: String,
    /// What the noise of the records is: it takes a simulation to tell.
    noise: Noise,
}

/// The rows of a chunk as another process made them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// The chunk.
    pub chunk: u64,
    /// SHA-256 of the bytes.
    pub sha256: String,
    /// The bytes of the chunk's file.
    pub bytes: Vec<u8>,
}

impl Task {
    /// The task of a campaign that is in a folder.
    ///
    /// # Errors
    /// [`CampaignError::SpecFile`] where the folder's bank cannot be read.
    pub fn new(campaign: &Campaign, folder: &Folder) -> Result<Self, CampaignError> {
        Ok(Self {
            manifest: folder.manifest().clone(),
            bank: folder.bank_text()?,
            noise: campaign.noise().clone(),
        })
    }

    /// The task as JSON.
    ///
    /// # Errors
    /// [`CampaignError::Task`].
    pub fn to_json(&self) -> Result<String, CampaignError> {
        Ok(serde_json::to_string(self)?)
    }

    /// The task of [`Task::to_json`]; `version` is that of the program that wrote it.
    ///
    /// # Errors
    /// [`CampaignError::Version`] where that is another one than this, whatever the text;
    /// [`CampaignError::Task`] for another text.
    pub fn from_json(version: &str, text: &str) -> Result<Self, CampaignError> {
        if version != VERSION {
            return Err(CampaignError::Version {
                expected: version.to_owned(),
                found: VERSION.to_owned(),
            });
        }
        Ok(serde_json::from_str(text)?)
    }

    /// Runs chunks one after the other, on one core.
    ///
    /// # Errors
    /// [`CampaignError::Stopped`] when progress says so; as [`Campaign::rows`].
    pub fn parts(
        &self,
        chunks: &[u64],
        progress: &dyn Progress,
    ) -> Result<Vec<Part>, CampaignError> {
        let spec = self.manifest.specification(Path::new(MANIFEST))?;
        let runs = spec.runs;
        let bank = DetectorFile::parse(Path::new(BANK), self.bank.as_bytes())?;
        let campaign = Campaign::with_noise(spec, bank, self.noise.clone());
        let mut parts = Vec::with_capacity(chunks.len());
        for &chunk in chunks {
            let rows = campaign.rows_of(runs_of(chunk, runs), progress)?;
            let rows = rows.ok_or(CampaignError::Stopped {
                done: 0,
                total: runs,
            })?;
            let metadata = self.manifest.marks();
            let bytes = Table { rows, metadata }.to_bytes()?;
            let sha256 = gt_log::sha256_hex(&bytes);
            parts.push(Part {
                chunk,
                sha256,
                bytes,
            });
        }
        Ok(parts)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::campaign::prepare;
    use crate::progress::Silent;

    const SPEC: &str = "
        seed = 3
        runs = 40
        healthy_share = 0.2
        [plant]
        noise = 'table8'
        noise_record_s = 60.0
        [record]
        duration_s = 20.0
        onset_s = [5.0, 10.0]
        [[faults]]
        case = 'thermocouple_drift'
        size = { log_uniform = [0.05, 0.5] }
        shape = { ramp = { rise_s = 3.0 } }
        [model]
        method = 'arx'
        record_s = 60.0
        order = 2
        [bank]
        arl0_h = 0.02
        calibration_h = 0.05
        tests = [{ statistic = 'cusum' }]
    ";

    struct Gone;

    impl Progress for Gone {
        fn report(&self, _what: &str, _done: usize, _total: usize) {}

        fn is_stopped(&self) -> bool {
            true
        }
    }

    #[test]
    fn parts_of_other_processes_are_those_of_this_one_and_nothing_else_is_kept() {
        let place = tempfile::tempdir().expect("a folder");
        let file = place.path().join("drift.toml");
        fs::write(&file, SPEC).expect("written");
        let [here, there] = ["here", "there"].map(|name| place.path().join(name));
        let (campaign, folder) = prepare(&file, &here, &Silent).expect("a campaign");
        let rows = campaign.fill(&folder, &Silent).expect("rows");
        assert_eq!(rows.len(), 40);

        let (campaign, folder) = prepare(&file, &there, &Silent).expect("a campaign");
        assert_eq!(folder.missing().expect("chunks"), [0, 1]);
        let text = Task::new(&campaign, &folder)
            .expect("a task")
            .to_json()
            .expect("its text");
        let task = Task::from_json(VERSION, &text).expect("the task");
        let parts = task.parts(&[1, 0], &Silent).expect("parts");
        let stopped = task.parts(&[1], &Gone).expect_err("nobody waits");
        assert!(matches!(stopped, CampaignError::Stopped { total: 40, .. }));

        let refused = |part: &Part, found: &str| {
            let error = folder
                .keep_part(part)
                .expect_err("another part")
                .to_string();
            let chunk = part.chunk;
            let expected = format!("expected the rows of chunk {chunk} of this campaign, found ");
            assert!(error.starts_with(&(expected + found)), "{error}");
            assert_eq!(folder.missing().expect("chunks"), [0, 1]);
        };
        let with = |change: fn(&mut Part)| {
            let mut part = parts[0].clone();
            change(&mut part);
            part
        };
        refused(&with(|part| part.chunk = 0), "rows of something else");
        refused(&with(|part| part.chunk = 2), "one of a campaign of 40 runs");
        refused(&with(|part| part.bytes[9] ^= 1), "bytes with the SHA-256");
        let mut other = task.clone();
        other.manifest.spec_sha256.replace_range(..1, "x");
        let other = other.parts(&[0], &Silent).expect("parts");
        refused(&other[0], "rows of something else");

        for part in &parts {
            folder.keep_part(part).expect("kept");
        }
        assert_eq!(folder.missing().expect("chunks"), [0_u64; 0]);
        assert_eq!(campaign.fill(&folder, &Silent).expect("rows"), rows);
        let bytes = |folder: &Path| fs::read(folder.join("rows.parquet")).expect("a file");
        assert_eq!(bytes(&here), bytes(&there));
    }

    #[test]
    fn another_version_is_refused_before_its_text_is_read() {
        let error = Task::from_json("0.0.0", "of another form").expect_err("another version");
        assert_eq!(
            error.to_string(),
            format!(
                "expected a worker with gtfdi 0.0.0, with which the campaign began, found {VERSION}"
            )
        );
        let error = Task::from_json(VERSION, "{}").expect_err("no task");
        assert!(
            error
                .to_string()
                .starts_with("expected a task of a campaign, found none: ")
        );
    }
}
