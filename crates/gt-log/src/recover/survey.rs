//! The first pass over a file: what is sound, and where it stands.

use std::collections::BTreeMap;

use mcap::MAGIC;
use mcap::records::{Channel, ChunkHeader, Header, Record, SchemaHeader, op};

use super::claims::Claims;
use super::resync::resync;
use super::{Loss, LossKind, has_magic};
use crate::LogError;
use crate::chunk::{HEAD_LIMIT, head, unpack};
use crate::raw::{RawFile, Tiles};
use crate::records::{PREFIX, parse};

/// Where something sound stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Piece {
    /// The data of a chunk, and whether it has a checksum, which is right then.
    Chunk {
        offset: u64,
        length: u64,
        compression: String,
        vouched: bool,
    },
    /// The data of a chunk that the end of the file cuts off.
    CutChunk {
        offset: u64,
        length: u64,
        compression: String,
    },
    /// Schemas, channels and messages outside a chunk.
    Plain { offset: u64, length: u64 },
    /// An attachment.
    Attachment { offset: u64, length: u64 },
    /// A metadata record.
    Metadata { offset: u64, length: u64 },
}

/// What the first pass finds.
#[derive(Debug, Default)]
pub(super) struct Survey {
    pub(super) header: Option<Header>,
    pub(super) schemas: BTreeMap<u16, Claims<(SchemaHeader, Vec<u8>)>>,
    pub(super) channels: BTreeMap<u16, Claims<Channel>>,
    pub(super) pieces: Vec<Piece>,
    pub(super) losses: Vec<Loss>,
    /// Where the data end, and the checksum of them.
    pub(super) data_end: Option<(u64, u32)>,
    /// Whether the checksum of all data is there and right.
    pub(super) vouched: bool,
    /// Whether the end of the file was there.
    pub(super) closed: bool,
    /// Where the last record begins whose length nothing vouches for, if it is the last of all.
    doubtful: Option<u64>,
}

/// How the walk goes on.
enum Step {
    /// With the record at this offset.
    On(u64),
    /// The file is at its end.
    End,
    /// Bytes that are no record begin here.
    Astray,
}

impl Survey {
    /// Walks over a whole file.
    pub(super) fn of(file: &mut RawFile) -> Result<Self, LogError> {
        let mut survey = Self::default();
        let mut offset = MAGIC.len() as u64;
        if !has_magic(file)? {
            offset = survey.skip(file, 0, "expected the first bytes of an MCAP file")?;
        }
        loop {
            let own = offset;
            match survey.step(file, offset)? {
                Step::On(next) => {
                    offset = next;
                    survey.doubtful = (!survey.vouched(next)).then_some(own);
                }
                Step::End => return Ok(survey),
                Step::Astray => offset = survey.skip(file, offset, "no record")?,
            }
        }
    }

    /// Whether the last record, which ends at `end`, is one with a checksum.
    fn vouched(&self, end: u64) -> bool {
        match self.pieces.last() {
            Some(Piece::Chunk { offset, length, .. }) => offset + length == end,
            Some(Piece::Attachment { offset, length }) => offset + PREFIX as u64 + length == end,
            _ => false,
        }
    }

    /// The record at `offset`.
    fn step(&mut self, file: &mut RawFile, offset: u64) -> Result<Step, LogError> {
        let size = file.size();
        let Some((opcode, length)) = file.prefix(offset)? else {
            if offset < size {
                self.lose(offset, size - offset, LossKind::Bytes, "cut off");
            }
            return Ok(Step::End);
        };
        if opcode == op::CHUNK {
            return self.chunk(file, offset, length);
        }
        let end = offset.saturating_add(PREFIX as u64).saturating_add(length);
        if !is_plausible(opcode, length) {
            return self.disguised(file, offset, length);
        }
        let Some(body) = file.body(offset, length)? else {
            return self.overlong(file, offset, opcode);
        };
        let attachment = Piece::Attachment { offset, length };
        match parse(opcode, &body) {
            Ok(Record::Header(header)) => self.header = self.header.take().or(Some(header)),
            Ok(Record::Footer(_)) => return self.footer(file, end),
            Ok(Record::DataEnd(record)) => {
                self.data_end = self.data_end.or(Some((offset, record.data_section_crc)));
            }
            Ok(Record::Attachment { .. }) => self.pieces.push(attachment),
            Ok(Record::Metadata(_)) => self.pieces.push(Piece::Metadata { offset, length }),
            Ok(record @ (Record::Schema { .. } | Record::Channel(_))) => {
                self.define(record, false);
                self.plain(offset, end);
            }
            Ok(Record::Message { .. }) => self.plain(offset, end),
            Ok(Record::Unknown { .. }) => return self.disguised(file, offset, length),
            Ok(_) => {}
            Err(cause) if opcode == op::ATTACHMENT => {
                self.lose(
                    offset,
                    end - offset,
                    LossKind::Attachment,
                    &cause.to_string(),
                );
            }
            Err(_) => return self.disguised(file, offset, length),
        }
        Ok(Step::On(end))
    }

    /// A record that reaches past the end of the file: cut off, unless records go on after it.
    fn overlong(&mut self, file: &mut RawFile, offset: u64, opcode: u8) -> Result<Step, LogError> {
        if resync(file, offset + 1, false)?.is_some() {
            return Ok(Step::Astray);
        }
        let kind = match opcode {
            op::ATTACHMENT => LossKind::Attachment,
            _ => LossKind::Bytes,
        };
        self.lose(offset, file.size() - offset, kind, "cut off");
        Ok(Step::End)
    }

    /// A record whose opcode means nothing here: a chunk if its checksum says so, else astray, or of
    /// a kind that is not known.
    fn disguised(
        &mut self,
        file: &mut RawFile,
        offset: u64,
        length: u64,
    ) -> Result<Step, LogError> {
        let start = offset + PREFIX as u64;
        let bytes = file.read(start, HEAD_LIMIT)?;
        if let Some((header, skip)) = head(&bytes)
            && let Some(next) = self.by_checksum(file, &header, start + skip as u64)?
        {
            return Ok(Step::On(next));
        }
        let opcode = file.prefix(offset)?.map_or(0, |(opcode, _)| opcode);
        let end = start.saturating_add(length);
        // Opcodes from 0x80 on are private; their records have lengths that lead on.
        if opcode >= 0x80
            && end <= file.size()
            && let Some((next, _)) = file.prefix(end)?
            && (op::HEADER..=op::DATA_END).contains(&next)
        {
            let cause = format!("the opcode 0x{opcode:02x} is not known");
            self.lose(offset, end - offset, LossKind::UnknownRecord, &cause);
            return Ok(Step::On(end));
        }
        Ok(Step::Astray)
    }

    /// Takes a chunk by what its checksum says, whatever its lengths do; the offset after it.
    fn by_checksum(
        &mut self,
        file: &mut RawFile,
        header: &ChunkHeader,
        data: u64,
    ) -> Result<Option<u64>, LogError> {
        let length = header.compressed_size;
        if header.uncompressed_crc == 0 || length > file.size().saturating_sub(data) {
            return Ok(None);
        }
        let packed = file.read(data, length)?;
        let unpacked = unpack(&header.compression, &packed);
        // Bytes that are too many stop the unpacking after the last that counts.
        if unpacked.stopped.is_some() || unpacked.fault(header).is_some() {
            return Ok(None);
        }
        self.take_chunk(&unpacked.bytes, data, header);
        Ok(Some(data + length))
    }

    /// A chunk, or what is left of one.
    fn chunk(&mut self, file: &mut RawFile, offset: u64, length: u64) -> Result<Step, LogError> {
        let size = file.size();
        let start = offset + PREFIX as u64;
        let bytes = file.read(start, HEAD_LIMIT)?;
        let Some((header, skip)) = head(&bytes) else {
            return Ok(Step::Astray);
        };
        let data = start + skip as u64;
        let by_length = start.checked_add(length).filter(|end| *end <= size);
        let by_size = data
            .checked_add(header.compressed_size)
            .filter(|end| *end <= size);
        if let (Some(end), Some(own)) = (by_length, by_size)
            && own <= end
        {
            let unpacked = unpack(&header.compression, &file.read(data, own - data)?);
            match unpacked.fault(&header) {
                None => self.take_chunk(&unpacked.bytes, data, &header),
                Some(cause) => self.lose_chunk(offset, end, &header, &cause),
            }
            return Ok(Step::On(end));
        }
        // The two lengths do not agree: one of them may be right.
        for end in [by_size, by_length].into_iter().flatten() {
            let mut header = header.clone();
            header.compressed_size = end.saturating_sub(data);
            if let Some(next) = self.by_checksum(file, &header, data)? {
                return Ok(Step::On(next));
            }
        }
        if let Some(next) = resync(file, data, false)? {
            self.lose_chunk(offset, next, &header, "its lengths do not agree");
            return Ok(Step::On(next));
        }
        self.cut_chunk(file, offset, data, &header)?;
        Ok(Step::End)
    }

    /// Takes the whole messages of a chunk that the end of the file cuts off.
    fn cut_chunk(
        &mut self,
        file: &mut RawFile,
        offset: u64,
        data: u64,
        header: &ChunkHeader,
    ) -> Result<(), LogError> {
        let size = file.size();
        let unpacked = unpack(&header.compression, &file.read(data, size - data)?);
        let mut records = Tiles::new(&unpacked.bytes);
        let messages = records.by_ref().filter(|own| own.1 == op::MESSAGE).count();
        let whole = records.end();
        for (_, opcode, body) in Tiles::new(&unpacked.bytes) {
            if let Ok(record) = parse(opcode, body) {
                self.define(record, false);
            }
        }
        self.lose(
            offset,
            size - offset,
            LossKind::EndOfChunk,
            &format!(
                "cut off; {} bytes could be unpacked, of which {whole} are whole records with \
                 {messages} messages (no checksum vouches for them: those that decode are written)",
                unpacked.bytes.len()
            ),
        );
        if whole > 0 {
            self.pieces.push(Piece::CutChunk {
                offset: data,
                length: size - data,
                compression: header.compression.clone(),
            });
        }
        Ok(())
    }

    fn take_chunk(&mut self, records: &[u8], data: u64, header: &ChunkHeader) {
        let vouched = header.uncompressed_crc != 0;
        for (_, opcode, body) in Tiles::new(records) {
            if matches!(opcode, op::SCHEMA | op::CHANNEL)
                && let Ok(record) = parse(opcode, body)
            {
                self.define(record, vouched);
            }
        }
        self.pieces.push(Piece::Chunk {
            offset: data,
            length: header.compressed_size,
            compression: header.compression.clone(),
            vouched,
        });
    }

    /// What a record says that an id means.
    fn define(&mut self, record: Record<'_>, vouched: bool) {
        match record {
            Record::Schema { header, data } if header.id != 0 => {
                let claims = self.schemas.entry(header.id).or_default();
                claims.add((header, data.into_owned()), vouched);
            }
            Record::Channel(channel) => {
                let claims = self.channels.entry(channel.id).or_default();
                claims.add(channel, vouched);
            }
            _ => {}
        }
    }

    /// Plain records in the data; in the summary they repeat what there was.
    fn plain(&mut self, offset: u64, end: u64) {
        if self.data_end.is_some() {
            return;
        }
        match self.pieces.last_mut() {
            Some(Piece::Plain {
                offset: first,
                length,
            }) if *first + *length == offset => *length += end - offset,
            _ => self.pieces.push(Piece::Plain {
                offset,
                length: end - offset,
            }),
        }
    }

    fn footer(&mut self, file: &mut RawFile, end: u64) -> Result<Step, LogError> {
        let rest = file.read(end, MAGIC.len() as u64 + 1)?;
        if rest == MAGIC {
            self.closed = self.data_end.is_some();
            return Ok(Step::End);
        }
        // A footer ends a file: if it does not, it may be one that the bytes of another record hold.
        let left = file.size() - end;
        if left < MAGIC.len() as u64 {
            self.lose(end, left, LossKind::Bytes, "the last bytes are cut off");
            return Ok(Step::End);
        }
        self.skip(file, end, "expected the last bytes of an MCAP file")
            .map(Step::On)
    }

    /// Passes over bytes that are no record; the offset where records go on, or the file ends.
    fn skip(&mut self, file: &mut RawFile, from: u64, cause: &str) -> Result<u64, LogError> {
        let chunked = self
            .pieces
            .iter()
            .any(|piece| matches!(piece, Piece::Chunk { .. }));
        let size = file.size();
        // The length of the record before may be the one that is wrong.
        let begin = self.doubtful.take().unwrap_or(from);
        let next = resync(file, begin + u64::from(from > 0), !chunked)?.unwrap_or(size);
        let (begin, cause) = if next < from {
            self.give_back(begin);
            (begin, "a record whose length is wrong")
        } else {
            (from, cause)
        };
        if next > begin {
            let cause = format!("{cause}, found {}", hint(file, begin)?);
            let kind = match file.prefix(begin)? {
                Some((op::CHUNK, _)) => LossKind::Chunk,
                _ => LossKind::Bytes,
            };
            self.lose(begin, next - begin, kind, &cause);
        }
        Ok(next)
    }

    /// Takes a plain record back, and what came after it.
    fn give_back(&mut self, begin: u64) {
        if let Some(Piece::Plain { offset, length }) = self.pieces.last_mut()
            && *offset + *length > begin
        {
            *length = begin.saturating_sub(*offset);
            if *length == 0 {
                self.pieces.pop();
            }
        }
    }

    fn lose(&mut self, offset: u64, bytes: u64, kind: LossKind, cause: &str) {
        self.losses.push(Loss {
            offset,
            bytes,
            kind,
            first_ns: None,
            last_ns: None,
            cause: cause.to_owned(),
        });
    }

    fn lose_chunk(&mut self, offset: u64, end: u64, header: &ChunkHeader, cause: &str) {
        self.lose(offset, end - offset, LossKind::Chunk, cause);
        if let Some(loss) = self.losses.last_mut()
            && header.message_start_time <= header.message_end_time
            && header.message_end_time > 0
        {
            loss.first_ns = Some(header.message_start_time);
            loss.last_ns = Some(header.message_end_time);
        }
    }
}

/// Whether a record of this kind may be as long.
fn is_plausible(opcode: u8, length: u64) -> bool {
    match opcode {
        op::ATTACHMENT | op::MESSAGE | op::MESSAGE_INDEX => true,
        op::HEADER..=op::DATA_END => length <= 256 << 20,
        _ => false,
    }
}

/// The first bytes of what is no record, for a message.
fn hint(file: &mut RawFile, offset: u64) -> Result<String, LogError> {
    let bytes = file.read(offset, PREFIX as u64)?;
    Ok(format!("{bytes:02x?}"))
}
