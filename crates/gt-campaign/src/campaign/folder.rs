//! The folder of a campaign: what is in it, and what is left to do.
//!
//! | file | what it is |
//! |---|---|
//! | `campaign.toml` | [`Manifest`]: specification, version, hashes |
//! | `bank.json` | the bank or isolator that judges |
//! | `rows-00012-0123456789abcdef.parquet` | the rows of the runs `12 * 32 .. 13 * 32`, until all are there; the digits begin the SHA-256 of its bytes |
//! | `rows.parquet`, `rows.sha256` | all rows, and the SHA-256 of the file; the chunks are gone then |
//! | `summary.json`, `report.html`, `figures/` | what they say |
//! | `campaign.lock` | held by the process at work |
//!
//! Every file appears whole, as `NAME.part` that is flushed and renamed. So whatever ends a campaign
//! leaves whole chunks, and a run is in exactly one of them.

use std::fs::{self, File};
use std::ops::Range;
use std::path::{Path, PathBuf};

use gt_log::DetectorFile;

use super::lock::{self, lock};
use super::manifest::Manifest;
use super::row::Row;
use super::spec::Spec;
use super::table::Table;
use super::task::Part;
use crate::error::CampaignError;

/// Runs of a chunk; a task of a core, a second or so.
pub(super) const CHUNK_RUNS: u64 = 32;
/// The manifest's name.
pub(super) const MANIFEST: &str = "campaign.toml";
/// The bank's name.
pub(super) const BANK: &str = "bank.json";
/// The name of all rows.
const ROWS: &str = "rows.parquet";
/// The name of that file's SHA-256, in the format of `sha256sum`.
const ROWS_SHA256: &str = "rows.sha256";
/// How the name of a file under construction ends.
const PART: &str = ".part";
/// Digits of the SHA-256 in the name of a chunk.
const DIGITS: usize = 16;

/// A campaign's folder, locked for this process.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    manifest: Manifest,
    runs: u64,
    /// Held as long as the folder is used; a process that ends lets go, however it ends.
    _lock: File,
}

/// What a folder had in it.
#[derive(Debug)]
pub enum Found {
    /// Nothing of a campaign: the bank is still to be made.
    Empty(Vacant),
    /// A campaign that this one continues.
    Campaign(Folder, Box<DetectorFile>),
}

/// A folder without a campaign.
#[derive(Debug)]
pub struct Vacant {
    path: PathBuf,
    lock: File,
}

/// Opens a folder, makes it where it is missing, and removes what half-written files a process left.
/// `bank` is the text of the bank, where the specification names a file.
///
/// # Errors
/// [`CampaignError::Foreign`] for a folder with other things in it, [`CampaignError::Busy`] where
/// another process is at work, [`CampaignError::Changed`] for another campaign.
pub(super) fn open(path: &Path, spec: &Spec, bank: Option<&[u8]>) -> Result<Found, CampaignError> {
    fs::create_dir_all(path).map_err(|source| CampaignError::Folder {
        path: path.to_owned(),
        source,
    })?;
    let manifest_path = path.join(MANIFEST);
    let is_campaign = manifest_path.exists();
    if !is_campaign {
        refuse_foreign(path)?;
    }
    let lock = lock(path)?;
    for name in names(path)? {
        if name.ends_with(PART) {
            let part = path.join(&name);
            fs::remove_file(&part)
                .map_err(|source| CampaignError::Folder { path: part, source })?;
        }
    }
    if !is_campaign {
        let path = path.to_owned();
        return Ok(Found::Empty(Vacant { path, lock }));
    }
    let manifest = Manifest::read(&manifest_path)?;
    let bank_path = path.join(BANK);
    let stored = fs::read(&bank_path).map_err(|source| CampaignError::SpecFile {
        path: bank_path.clone(),
        source,
    })?;
    let wanted = Manifest::new(spec, gt_log::sha256_hex(bank.unwrap_or(&stored)))?;
    manifest.check(&manifest_path, &wanted)?;
    let found = gt_log::sha256_hex(&stored);
    if found != manifest.bank_sha256 {
        return Err(CampaignError::Changed {
            path: manifest_path,
            key: "bank_sha256".to_owned(),
            expected: manifest.bank_sha256,
            found: format!("{found} of {}", bank_path.display()),
        });
    }
    let bank = DetectorFile::read(&bank_path)?;
    let folder = Folder {
        path: path.to_owned(),
        manifest,
        runs: spec.runs,
        _lock: lock,
    };
    Ok(Found::Campaign(folder, Box::new(bank)))
}

/// The bank of a folder that has this campaign, where it has one; nothing is changed in it.
///
/// # Errors
/// As [`open`].
pub(super) fn stored_bank(path: &Path, spec: &Spec) -> Result<Option<DetectorFile>, CampaignError> {
    let manifest_path = path.join(MANIFEST);
    if !manifest_path.exists() {
        return Ok(None);
    }
    let manifest = Manifest::read(&manifest_path)?;
    let wanted = Manifest::new(spec, manifest.bank_sha256.clone())?;
    manifest.check(&manifest_path, &wanted)?;
    Ok(Some(DetectorFile::read(&path.join(BANK))?))
}

impl Vacant {
    /// Puts a campaign into the folder, and gives its bank as every later process will read it.
    ///
    /// # Errors
    /// [`CampaignError::Log`] names the file that could not be written.
    pub fn begin(
        self,
        spec: &Spec,
        write: impl FnOnce(&Path) -> Result<(), CampaignError>,
    ) -> Result<(Folder, DetectorFile), CampaignError> {
        let bank_path = self.path.join(BANK);
        write(&bank_path)?;
        let stored = fs::read(&bank_path).map_err(|source| CampaignError::SpecFile {
            path: bank_path.clone(),
            source,
        })?;
        let bank = DetectorFile::read(&bank_path)?;
        // The manifest comes last: with it, the folder is a campaign's.
        let manifest = Manifest::new(spec, gt_log::sha256_hex(&stored))?;
        manifest.write(&self.path.join(MANIFEST))?;
        let folder = Folder {
            path: self.path,
            manifest,
            runs: spec.runs,
            _lock: self.lock,
        };
        Ok((folder, bank))
    }
}

impl Folder {
    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it says of itself.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The number of chunks.
    fn chunks(&self) -> u64 {
        self.runs.div_ceil(CHUNK_RUNS)
    }

    /// The runs of a chunk.
    pub fn runs_of(&self, chunk: u64) -> Range<u64> {
        runs_of(chunk, self.runs)
    }

    /// The files of a chunk, by their names among those of the folder, which are in order; more than
    /// one where one of them is broken.
    fn files_of<'a>(&self, chunk: u64, names: &'a [String]) -> impl Iterator<Item = ChunkFile<'a>> {
        let start = format!("rows-{chunk:05}-");
        let path = self.path.clone();
        let first = names.partition_point(|name| *name < start);
        let names = names.get(first..).unwrap_or_default().iter();
        names
            .map_while(move |name| {
                let rest = name.strip_prefix(&start)?;
                Some((path.join(name), rest))
            })
            .filter_map(|(path, rest)| {
                let digits = rest.strip_suffix(".parquet")?;
                (digits.len() == DIGITS).then_some(ChunkFile { path, digits })
            })
    }

    /// The rows of a chunk, where they are there and whole.
    fn chunk(&self, chunk: u64, names: &[String]) -> Option<Vec<Row>> {
        let mut files = self.files_of(chunk, names);
        files.find_map(|file| self.read(&file.path, file.digits, self.runs_of(chunk)))
    }

    /// The chunks that are still to be run. One that is broken, or of something else, is one of them.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn missing(&self) -> Result<Vec<u64>, CampaignError> {
        let names = names(&self.path)?;
        let chunks = 0..self.chunks();
        Ok(chunks
            .filter(|&chunk| self.chunk(chunk, &names).is_none())
            .collect())
    }

    /// All rows, once they are in one file.
    pub fn finished(&self) -> Option<Vec<Row>> {
        let line = fs::read_to_string(self.path.join(ROWS_SHA256)).ok()?;
        let sha256 = line.split_whitespace().next()?;
        self.read(&self.path.join(ROWS), sha256, 0..self.runs)
    }

    /// The rows of a file of this campaign, of just these runs.
    fn read(&self, path: &Path, sha256: &str, runs: Range<u64>) -> Option<Vec<Row>> {
        let table = Table::read(path, sha256).ok()?;
        let own = self.manifest.marks();
        let same = own.iter().all(|pair| table.metadata.contains(pair));
        (same && table.rows.iter().map(|row| row.run).eq(runs)).then_some(table.rows)
    }

    /// Keeps the rows of a chunk.
    ///
    /// # Errors
    /// [`CampaignError::Log`] names the file.
    pub(super) fn keep(&self, chunk: u64, rows: Vec<Row>) -> Result<(), CampaignError> {
        let metadata = self.manifest.marks();
        let name = |sha256: &str| self.chunk_path(chunk, sha256);
        Table { rows, metadata }.write(name).map(|_| ())
    }

    /// Keeps what another process made of a chunk, once it is seen to be whole and of this campaign.
    ///
    /// # Errors
    /// [`CampaignError::Part`] for something else, [`CampaignError::Log`] names the file that could
    /// not be written.
    pub fn keep_part(&self, part: &Part) -> Result<(), CampaignError> {
        let refused = |found: String| CampaignError::Part {
            chunk: part.chunk,
            found,
        };
        if part.chunk >= self.chunks() {
            return Err(refused(format!("one of a campaign of {} runs", self.runs)));
        }
        let sha256 = gt_log::sha256_hex(&part.bytes);
        if sha256 != part.sha256 {
            let found = format!("bytes with the SHA-256 {sha256}, not {}", part.sha256);
            return Err(refused(found));
        }
        let path = self.chunk_path(part.chunk, &sha256);
        gt_log::write_atomically(&path, &part.bytes)?;
        if self
            .read(&path, &sha256, self.runs_of(part.chunk))
            .is_some()
        {
            return Ok(());
        }
        fs::remove_file(&path).map_err(|source| CampaignError::Folder { path, source })?;
        Err(refused("rows of something else".to_owned()))
    }

    /// Where the rows of a chunk are, by the SHA-256 of the file's bytes.
    fn chunk_path(&self, chunk: u64, sha256: &str) -> PathBuf {
        let digits = sha256.get(..DIGITS).unwrap_or(sha256);
        self.path.join(format!("rows-{chunk:05}-{digits}.parquet"))
    }

    /// The text of the bank.
    ///
    /// # Errors
    /// [`CampaignError::SpecFile`].
    pub(super) fn bank_text(&self) -> Result<String, CampaignError> {
        let path = self.path.join(BANK);
        fs::read_to_string(&path).map_err(|source| CampaignError::SpecFile { path, source })
    }

    /// Puts the rows of all chunks into one file, and removes the chunks.
    ///
    /// # Errors
    /// [`CampaignError::Log`] and [`CampaignError::Table`] name the file.
    pub(super) fn join(&self) -> Result<Vec<Row>, CampaignError> {
        let names = names(&self.path)?;
        let mut table = Table {
            rows: Vec::new(),
            metadata: self.manifest.marks(),
        };
        for chunk in 0..self.chunks() {
            let rows = self
                .chunk(chunk, &names)
                .ok_or_else(|| CampaignError::Table {
                    path: self.path.clone(),
                    reason: format!(
                        "expected the rows of chunk {chunk}, found none that are whole"
                    ),
                })?;
            table.rows.extend(rows);
        }
        let path = self.path.join(ROWS);
        let sha256 = table.write(|_| path.clone())?;
        // Without this line the file does not count, and the chunks are still there.
        let line = format!("{sha256}  {ROWS}\n");
        gt_log::write_atomically(&self.path.join(ROWS_SHA256), line.as_bytes())?;
        self.remove_chunks()?;
        Ok(table.rows)
    }

    /// Removes the chunks, where all rows are in one file.
    ///
    /// # Errors
    /// [`CampaignError::Folder`] names the file.
    pub(super) fn remove_chunks(&self) -> Result<(), CampaignError> {
        let names = names(&self.path)?;
        for chunk in 0..self.chunks() {
            for ChunkFile { path, .. } in self.files_of(chunk, &names) {
                fs::remove_file(&path).map_err(|source| CampaignError::Folder { path, source })?;
            }
        }
        Ok(())
    }
}

/// The runs of a chunk of a campaign of so many.
pub(super) fn runs_of(chunk: u64, runs: u64) -> Range<u64> {
    let first = chunk.saturating_mul(CHUNK_RUNS).min(runs);
    first..first.saturating_add(CHUNK_RUNS).min(runs)
}

/// A file that by its name has the rows of a chunk.
struct ChunkFile<'a> {
    path: PathBuf,
    /// How the SHA-256 of its bytes begins.
    digits: &'a str,
}

/// What a folder says of the campaign in it; nothing is changed in it.
///
/// # Errors
/// As [`Manifest::read`].
pub(super) fn manifest_of(folder: &Path) -> Result<Manifest, CampaignError> {
    Manifest::read(&folder.join(MANIFEST))
}

/// The rows of a campaign that is finished.
///
/// # Errors
/// [`CampaignError::SpecFile`] where the folder has no `rows.sha256`, [`CampaignError::Table`] for rows
/// that are not those.
pub fn finished_rows(folder: &Path) -> Result<Vec<Row>, CampaignError> {
    let path = folder.join(ROWS_SHA256);
    let line =
        fs::read_to_string(&path).map_err(|source| CampaignError::SpecFile { path, source })?;
    let sha256 = line.split_whitespace().next().unwrap_or_default();
    Ok(Table::read(&folder.join(ROWS), sha256)?.rows)
}

/// Refuses a folder with files that no campaign wrote.
fn refuse_foreign(path: &Path) -> Result<(), CampaignError> {
    let own = |name: &str| name == lock::NAME || name == BANK || name.ends_with(PART);
    match names(path)?.into_iter().find(|name| !own(name)) {
        Some(found) => Err(CampaignError::Foreign {
            path: path.to_owned(),
            found,
        }),
        None => Ok(()),
    }
}

fn names(path: &Path) -> Result<Vec<String>, CampaignError> {
    let failed = |source| CampaignError::Folder {
        path: path.to_owned(),
        source,
    };
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        names.push(name.to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}
