//! A file read at any place, for work on files whose order cannot be trusted.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::records::PREFIX;
use crate::{LogError, source};

/// A file of records, opened to read at any offset.
pub(crate) struct RawFile {
    path: PathBuf,
    file: BufReader<File>,
    position: u64,
    size: u64,
}

impl RawFile {
    pub(crate) fn open(path: &Path) -> Result<Self, LogError> {
        let (file, size) = source::open(path)?;
        Ok(Self {
            path: path.to_owned(),
            file: BufReader::with_capacity(1 << 16, file),
            position: 0,
            size,
        })
    }

    /// The bytes of the file when it was opened.
    pub(crate) fn size(&self) -> u64 {
        self.size
    }

    /// The bytes from `offset` on, `length` of them or as many as there are.
    pub(crate) fn read(&mut self, offset: u64, length: u64) -> Result<Vec<u8>, LogError> {
        let length = length.min(self.size.saturating_sub(offset));
        let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
        self.go_to(offset)
            .and_then(|()| (&mut self.file).take(length).read_to_end(&mut bytes))
            .map_err(|cause| LogError::io(&self.path, "read", cause))?;
        self.position = offset + bytes.len() as u64;
        Ok(bytes)
    }

    /// The opcode and the length of the body of the record at `offset`, as far as they are there.
    pub(crate) fn prefix(&mut self, offset: u64) -> Result<Option<(u8, u64)>, LogError> {
        let bytes = self.read(offset, PREFIX as u64)?;
        Ok(prefix(&bytes))
    }

    /// The body of a record; `None` where it reaches past the end of the file.
    pub(crate) fn body(&mut self, offset: u64, length: u64) -> Result<Option<Vec<u8>>, LogError> {
        let start = offset.saturating_add(PREFIX as u64);
        if start > self.size || length > self.size - start {
            return Ok(None);
        }
        let bytes = self.read(start, length)?;
        Ok((bytes.len() as u64 == length).then_some(bytes))
    }

    /// Calls `visit` with the bytes of the file up to `end`, block after block.
    pub(crate) fn blocks(
        &mut self,
        end: u64,
        mut visit: impl FnMut(&[u8]),
    ) -> Result<(), LogError> {
        let mut offset = 0;
        while offset < end {
            let block = self.read(offset, (end - offset).min(1 << 16))?;
            if block.is_empty() {
                break;
            }
            visit(&block);
            offset += block.len() as u64;
        }
        Ok(())
    }

    fn go_to(&mut self, offset: u64) -> std::io::Result<()> {
        // A short way within the buffer costs no call of the operating system.
        let way = i128::from(offset) - i128::from(self.position);
        match i64::try_from(way) {
            Ok(way) => self.file.seek_relative(way)?,
            Err(_) => {
                self.file.seek(SeekFrom::Start(offset))?;
            }
        }
        self.position = offset;
        Ok(())
    }
}

/// Opcode and length of the body of a record that begins with these bytes.
pub(crate) fn prefix(bytes: &[u8]) -> Option<(u8, u64)> {
    let (opcode, rest) = bytes.split_first()?;
    let length = rest.first_chunk::<8>()?;
    Some((*opcode, u64::from_le_bytes(*length)))
}

/// The records that fill `bytes` one after the other: the offset, opcode and body of each.
#[derive(Debug, Clone)]
pub(crate) struct Tiles<'a> {
    bytes: &'a [u8],
    offset: usize,
}

impl<'a> Tiles<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, offset: 0 }
    }

    /// How many bytes the whole records so far fill.
    pub(crate) fn end(&self) -> usize {
        self.offset
    }
}

impl<'a> Iterator for Tiles<'a> {
    type Item = (usize, u8, &'a [u8]);

    /// The next record; none where the rest holds no whole one.
    fn next(&mut self) -> Option<Self::Item> {
        let rest = self.bytes.get(self.offset..)?;
        let (opcode, length) = prefix(rest)?;
        let end = usize::try_from(length).ok()?.checked_add(PREFIX)?;
        let body = rest.get(PREFIX..end)?;
        let at = self.offset;
        self.offset += end;
        Some((at, opcode, body))
    }
}
