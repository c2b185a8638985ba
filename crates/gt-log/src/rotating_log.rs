//! Logs that go on for years: one whole file after the other, the oldest removed.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use gt_core::Signal;
use jiff::Timestamp;
use serde::Serialize;

use crate::writer::QualityTopicId;
use crate::{JsonTopicId, LogError, LogWriter, Quality, RunMetadata, TopicId};

/// How often the size of the open file is looked at, in messages.
const SIZE_PERIOD: u32 = 256;
/// The extension of a whole file.
const EXTENSION: &str = ".mcap";

/// When a new file begins, and which old ones are kept.
///
/// | name | default | purpose | range |
/// |---|---|---|---|
/// | `folder` | none | where the files are | there |
/// | `stem` | `log` | how their names begin | letters, digits, `_` and `-` |
/// | `span_s` | 3600 | a file ends at the next multiple of this since 1970, by the times of messages | >= 1 |
/// | `max_bytes` | 1 GiB | a file ends when it has as many | >= 64 KiB |
/// | `keep_s` | forever | whole files that began longer ago are removed | >= `span_s` |
/// | `keep_bytes` | no limit | the oldest whole files are removed until the others have no more | >= `max_bytes` |
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RotationOptions {
    /// The folder, which is there.
    pub folder: PathBuf,
    /// How the names of the files begin.
    pub stem: String,
    /// The span of a file in seconds.
    pub span_s: u64,
    /// The bytes after which a file ends.
    pub max_bytes: u64,
    /// How long files are kept, in seconds since they began.
    pub keep_s: Option<u64>,
    /// How many bytes of whole files are kept.
    pub keep_bytes: Option<u64>,
}

impl RotationOptions {
    /// The defaults, in this folder.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            stem: "log".to_owned(),
            span_s: 3600,
            max_bytes: 1 << 30,
            keep_s: None,
            keep_bytes: None,
        }
    }

    fn check(&self) -> Result<(), LogError> {
        let refuse = |option, expected: String, found: String| {
            Err(LogError::Rotation {
                option,
                expected,
                found,
            })
        };
        let is_safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
        if self.stem.is_empty() || !self.stem.chars().all(is_safe) {
            let expected = "letters, digits, _ and -".to_owned();
            return refuse("stem", expected, format!("`{}`", self.stem));
        }
        if self.span_s == 0 {
            return refuse("span_s", "1 or more".to_owned(), "0".to_owned());
        }
        if self.max_bytes < 1 << 16 {
            let expected = "65536 or more".to_owned();
            return refuse("max_bytes", expected, self.max_bytes.to_string());
        }
        if let Some(keep_s) = self.keep_s.filter(|own| *own < self.span_s) {
            let expected = format!("span_s ({}) or more", self.span_s);
            return refuse("keep_s", expected, keep_s.to_string());
        }
        if let Some(keep_bytes) = self.keep_bytes.filter(|own| *own < self.max_bytes) {
            let expected = format!("max_bytes ({}) or more", self.max_bytes);
            return refuse("keep_bytes", expected, keep_bytes.to_string());
        }
        if !self.folder.is_dir() {
            let found = self.folder.display().to_string();
            return refuse("folder", "a folder that is there".to_owned(), found);
        }
        Ok(())
    }
}

/// What every file of a [`RotatingLog`] begins with.
#[derive(Debug, Clone, Default)]
pub struct LogHead {
    /// The metadata of the run.
    pub run: RunMetadata,
    /// Attachments: name, media type, bytes.
    pub attachments: Vec<(String, String, Vec<u8>)>,
    /// The topics of doubles, in the order of [`RotatingLog::write`]'s numbers.
    pub topics: Vec<TopicHead>,
    /// The topics of qualities, in the order of [`RotatingLog::write_quality`]'s numbers; their
    /// messages need no name.
    pub quality_topics: Vec<TopicHead>,
    /// The topics of JSON, in the order of [`RotatingLog::write_json`]'s numbers.
    pub json_topics: Vec<JsonTopicHead>,
}

/// A topic of doubles, as [`LogWriter::add_topic`] takes it.
#[derive(Debug, Clone)]
pub struct TopicHead {
    /// The topic.
    pub topic: String,
    /// The name of the message.
    pub message: String,
    /// The fields.
    pub fields: Vec<Signal>,
    /// The time between samples in seconds.
    pub sample_period_s: f64,
    /// The machine.
    pub asset: String,
}

/// A topic of JSON, as [`LogWriter::add_json_topic`] takes it.
#[derive(Debug, Clone)]
pub struct JsonTopicHead {
    /// The topic.
    pub topic: String,
    /// The name of the message.
    pub message: String,
    /// The JSON Schema of a message.
    pub schema: serde_json::Value,
    /// The machine.
    pub asset: String,
}

struct Open {
    log: LogWriter,
    topics: Vec<TopicId>,
    quality_topics: Vec<QualityTopicId>,
    json_topics: Vec<JsonTopicId>,
    /// Which span since 1970 the first message lies in.
    span: u64,
    written: u32,
    /// Tells other processes, and [`recover_parts`](crate::recover_parts), that it is at work.
    _lock: Option<File>,
}

/// A log in files that follow each other, each whole by itself: metadata, attachments and topics
/// stand at its beginning.
///
/// A file is called `STEM-20060118T000000.000000000Z.mcap` after the time of its first message in
/// UTC, with `-2`, `-3`, ... where that name is taken; until it is closed, `.part` follows. There is no
/// clock inside: time is that of the messages and of [`RotatingLog::tick`].
///
/// When the process dies, a write fails or the log is dropped without [`RotatingLog::finish`], the
/// `.part` stays: [`recover_parts`](crate::recover_parts) writes what was flushed. Files of other
/// names are never touched, nor is a `.part`.
pub struct RotatingLog {
    options: RotationOptions,
    head: LogHead,
    open: Option<Open>,
    /// The latest time that is known.
    now_ns: u64,
}

impl RotatingLog {
    /// Checks the options; the first file begins with the first message.
    ///
    /// # Errors
    /// [`LogError::Rotation`] names the option.
    pub fn create(options: RotationOptions, head: LogHead) -> Result<Self, LogError> {
        options.check()?;
        Ok(Self {
            options,
            head,
            open: None,
            now_ns: 0,
        })
    }

    /// Writes a message of topic number `topic` that leaves out the fields without a value.
    ///
    /// # Errors
    /// As [`LogWriter::write_partial`]; [`LogError::NoSpace`] on a full disk. The files before are
    /// whole then, the open one stays as `.part`, and the next message begins another.
    pub fn write(
        &mut self,
        topic: usize,
        time_ns: u64,
        values: &[Option<f64>],
    ) -> Result<(), LogError> {
        let expected = self.head.topics.len();
        let found = topic;
        self.send(time_ns, |open| {
            let own = open.topics.get(topic).copied();
            let own = own.ok_or(LogError::ForeignTopic { expected, found })?;
            open.log.write_partial(own, time_ns, values)
        })
    }

    /// Writes a message of quality topic number `topic`.
    ///
    /// # Errors
    /// As [`RotatingLog::write`].
    pub fn write_quality(
        &mut self,
        topic: usize,
        time_ns: u64,
        qualities: &[Quality],
    ) -> Result<(), LogError> {
        let expected = self.head.quality_topics.len();
        let found = topic;
        self.send(time_ns, |open| {
            let own = open.quality_topics.get(topic).copied();
            let own = own.ok_or(LogError::ForeignTopic { expected, found })?;
            open.log.write_quality(own, time_ns, qualities)
        })
    }

    /// Writes a message of JSON topic number `topic`.
    ///
    /// # Errors
    /// As [`RotatingLog::write`].
    pub fn write_json<T: Serialize + ?Sized>(
        &mut self,
        topic: usize,
        time_ns: u64,
        value: &T,
    ) -> Result<(), LogError> {
        let expected = self.head.json_topics.len();
        let found = topic;
        self.send(time_ns, |open| {
            let own = open.json_topics.get(topic).copied();
            let own = own.ok_or(LogError::ForeignTopic { expected, found })?;
            open.log.write_json(own, time_ns, value)
        })
    }

    /// Puts what was written on the disk, ends the file if it is time, and removes old files. Call it
    /// every few seconds with the time in nanoseconds since 1970.
    ///
    /// # Errors
    /// As [`RotatingLog::write`], or a file that cannot be removed.
    pub fn tick(&mut self, now_ns: u64) -> Result<(), LogError> {
        self.now_ns = self.now_ns.max(now_ns);
        let span = self.span(now_ns);
        if self.open.as_ref().is_some_and(|open| span > open.span) {
            self.close()?;
        }
        if let Some(open) = &mut self.open {
            let result = open.log.flush().and_then(|()| open.log.size());
            match result {
                Ok(size) if size >= self.options.max_bytes => self.close()?,
                Ok(_) => {}
                Err(error) => {
                    self.abandon();
                    return Err(error);
                }
            }
        }
        self.remove_old()
    }

    /// Ends the open file; the next begins with this head.
    ///
    /// # Errors
    /// As [`LogWriter::finish`], but the `.part` stays; the head is the new one all the same.
    pub fn begin_with(&mut self, head: LogHead) -> Result<(), LogError> {
        self.head = head;
        self.close()
    }

    /// Ends the open file.
    ///
    /// # Errors
    /// As [`LogWriter::finish`], but the `.part` stays.
    pub fn finish(mut self) -> Result<(), LogError> {
        self.close()
    }

    fn span(&self, time_ns: u64) -> u64 {
        time_ns / 1_000_000_000 / self.options.span_s
    }

    fn send(
        &mut self,
        time_ns: u64,
        write: impl FnOnce(&mut Open) -> Result<(), LogError>,
    ) -> Result<(), LogError> {
        self.now_ns = self.now_ns.max(time_ns);
        let span = self.span(time_ns);
        let is_due = match &self.open {
            // A late message stays with those that it is late for.
            Some(open) if span > open.span => true,
            Some(open) if open.written % SIZE_PERIOD == SIZE_PERIOD - 1 => {
                open.log.size()? >= self.options.max_bytes
            }
            None | Some(_) => false,
        };
        if is_due {
            self.close()?;
            self.remove_old()?;
        }
        let mut open = match self.open.take() {
            Some(open) => open,
            None => self.begin(time_ns, span)?,
        };
        let result = write(&mut open);
        open.written = open.written.wrapping_add(1);
        self.open = Some(open);
        if matches!(
            result,
            Err(LogError::Write { .. } | LogError::Io { .. } | LogError::NoSpace { .. })
        ) {
            self.abandon();
        }
        result
    }

    fn begin(&self, time_ns: u64, span: u64) -> Result<Open, LogError> {
        let path = free_name(&self.options, time_ns);
        let mut log = LogWriter::create(&path, &self.head.run)?;
        for (name, media_type, bytes) in &self.head.attachments {
            log.attach(name, media_type, bytes)?;
        }
        let mut topics = Vec::new();
        for own in &self.head.topics {
            topics.push(log.add_topic(
                &own.topic,
                &own.message,
                &own.fields,
                own.sample_period_s,
                &own.asset,
            )?);
        }
        let mut quality_topics = Vec::new();
        for own in &self.head.quality_topics {
            quality_topics.push(log.add_quality_topic(
                &own.topic,
                &own.fields,
                own.sample_period_s,
                &own.asset,
            )?);
        }
        let mut json_topics = Vec::new();
        for own in &self.head.json_topics {
            json_topics.push(log.add_json_topic(
                &own.topic,
                &own.message,
                &own.schema,
                &own.asset,
            )?);
        }
        // On the disk before the first message: what comes after can be recovered.
        log.flush()?;
        let part = PathBuf::from(format!("{}.part", path.display()));
        // Where the file system has no locks, nobody is told.
        let lock = File::open(part).ok().filter(|own| own.try_lock().is_ok());
        Ok(Open {
            log,
            topics,
            quality_topics,
            json_topics,
            span,
            written: 0,
            _lock: lock,
        })
    }

    fn close(&mut self) -> Result<(), LogError> {
        match self.open.take() {
            Some(mut open) => {
                // What can be flushed is there even where the rest fails.
                if let Err(error) = open.log.flush() {
                    open.log.abandon();
                    return Err(error);
                }
                open.log.finish_or_keep()
            }
            None => Ok(()),
        }
    }

    /// Leaves the open file as it is, as `.part`.
    fn abandon(&mut self) {
        if let Some(open) = self.open.take() {
            open.log.abandon();
        }
    }

    /// Removes the whole files that are too old, and the oldest that are too many.
    fn remove_old(&self) -> Result<(), LogError> {
        if self.options.keep_s.is_none() && self.options.keep_bytes.is_none() {
            return Ok(());
        }
        let folder = &self.options.folder;
        let listing = fs::read_dir(folder).map_err(|cause| LogError::io(folder, "list", cause))?;
        // Sorted by the time in the name, the newest first.
        let mut files: Vec<(u64, String, u64)> = Vec::new();
        for entry in listing.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let Some(began_ns) = began_ns(&self.options.stem, &name) else {
                continue;
            };
            if let Ok(metadata) = entry.metadata()
                && metadata.is_file()
            {
                files.push((began_ns, name, metadata.len()));
            }
        }
        files.sort_unstable_by(|a, b| b.cmp(a));
        let mut kept_bytes = 0_u64;
        for (began_ns, name, size) in files {
            kept_bytes = kept_bytes.saturating_add(size);
            let age_s = self.now_ns.saturating_sub(began_ns) / 1_000_000_000;
            let is_old = self.options.keep_s.is_some_and(|own| age_s > own);
            let is_much = self.options.keep_bytes.is_some_and(|own| kept_bytes > own);
            if is_old || is_much {
                kept_bytes -= size;
                let path = folder.join(name);
                fs::remove_file(&path).map_err(|cause| LogError::io(&path, "remove", cause))?;
            }
        }
        Ok(())
    }
}

impl Drop for RotatingLog {
    fn drop(&mut self) {
        self.abandon();
    }
}

/// The time of a file's name.
fn stamp(time_ns: u64) -> String {
    let time = Timestamp::from_nanosecond(i128::from(time_ns)).unwrap_or(Timestamp::UNIX_EPOCH);
    format!("{time:.9}").replace([':', '-'], "")
}

/// A name that neither a file nor a `.part` has.
fn free_name(options: &RotationOptions, time_ns: u64) -> PathBuf {
    let stem = format!("{}-{}", options.stem, stamp(time_ns));
    let taken = |path: &Path| {
        let part = PathBuf::from(format!("{}.part", path.display()));
        fs::symlink_metadata(path).is_ok() || fs::symlink_metadata(part).is_ok()
    };
    let mut path = options.folder.join(format!("{stem}{EXTENSION}"));
    let mut number = 2_u64;
    while taken(&path) {
        path = options.folder.join(format!("{stem}-{number}{EXTENSION}"));
        number += 1;
    }
    path
}

/// When the file of this name began, if it is one of a log with this stem.
pub(crate) fn began_ns(stem: &str, name: &str) -> Option<u64> {
    let rest = name.strip_prefix(stem)?.strip_prefix('-')?;
    let rest = rest.strip_suffix(EXTENSION)?;
    let (time, number) = rest.split_at_checked(rest.find('Z')? + 1)?;
    if !number.is_empty() && number.strip_prefix('-')?.parse::<u64>().is_err() {
        return None;
    }
    let found = time.parse::<Timestamp>().ok()?;
    let found = u64::try_from(found.as_nanosecond()).ok()?;
    // Nothing but what this module writes.
    (stamp(found) == time).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_when_a_file_began() {
        let name = format!("log-{}.mcap", stamp(crate::EPOCH_NS + 1));
        assert_eq!(name, "log-20060118T000000.000000001Z.mcap");
        assert_eq!(began_ns("log", &name), Some(crate::EPOCH_NS + 1));
        let second = "log-20060118T000000.000000001Z-2.mcap";
        assert_eq!(began_ns("log", second), Some(crate::EPOCH_NS + 1));
        for other in [
            "log-20060118T000000.000000001Z.mcap.part",
            "log-20060118T000000Z.mcap",
            "log-20060118T000000.000000001Z-x.mcap",
            "log-2-20060118T000000.000000001Z.mcap",
            "other-20060118T000000.000000001Z.mcap",
            "log-.mcap",
            "log.mcap",
        ] {
            assert_eq!(began_ns("log", other), None, "{other}");
        }
    }
}
