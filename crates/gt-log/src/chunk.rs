//! Chunks, unpacked within limits and as far as they go.

use std::io::Read;

use mcap::records::{ChunkHeader, Record, op};

use crate::records::parse;

/// No chunk of a log comes near this; one that unpacks to more is broken.
const UNPACKED_LIMIT: u64 = 1 << 30;
/// The longest head of a chunk: 28 bytes, the name of the compression, the size of what follows.
pub(crate) const HEAD_LIMIT: u64 = 28 + 4 + 8 + 8;

/// The compressions that can be unpacked.
const COMPRESSIONS: [&str; 3] = ["", "lz4", "zstd"];

/// The header of a chunk with how many bytes it fills, where its compression is one that can be
/// unpacked. What follows need not be there.
pub(crate) fn head(body: &[u8]) -> Option<(ChunkHeader, usize)> {
    let length = body.get(28..).and_then(<[u8]>::first_chunk::<4>)?;
    let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
    let end = 28 + 4 + length.min(8) + 8;
    let mut own = body.get(..end)?.to_vec();
    // With a size of nothing the parser asks for no data.
    let size = u64::from_le_bytes(*own.last_chunk::<8>()?);
    let without = own.len() - 8;
    own[without..].fill(0);
    let Ok(Record::Chunk { mut header, .. }) = parse(op::CHUNK, &own) else {
        return None;
    };
    header.compressed_size = size;
    COMPRESSIONS
        .contains(&header.compression.as_str())
        .then_some((header, end))
}

/// What a chunk holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Unpacked {
    /// The records, up to where they could be unpacked.
    pub(crate) bytes: Vec<u8>,
    /// What stopped the unpacking before its end.
    pub(crate) stopped: Option<String>,
}

impl Unpacked {
    /// The CRC-32 of what was unpacked.
    pub(crate) fn crc(&self) -> u32 {
        crc32fast::hash(&self.bytes)
    }

    /// What is wrong with the content, where that is known: the checksum decides, or, in a file
    /// without, the end of the unpacking and the size.
    pub(crate) fn fault(&self, header: &ChunkHeader) -> Option<String> {
        if header.uncompressed_crc != 0 {
            let found = self.crc();
            if found == header.uncompressed_crc {
                return None;
            }
            let crc = format!(
                "expected the CRC {:08x}, found {found:08x}",
                header.uncompressed_crc
            );
            return Some(match &self.stopped {
                Some(cause) => format!("{crc} (unpacking stopped: {cause})"),
                None => crc,
            });
        }
        if let Some(cause) = &self.stopped {
            return Some(format!("unpacking stopped: {cause}"));
        }
        let found = self.bytes.len() as u64;
        (found != header.uncompressed_size).then(|| {
            format!(
                "expected {} unpacked bytes, found {found}",
                header.uncompressed_size
            )
        })
    }
}

/// Unpacks the data of a chunk as far as it goes. A stream of zstd or lz4 comes block by block, so
/// of one that is cut every block before the cut is there.
pub(crate) fn unpack(compression: &str, data: &[u8]) -> Unpacked {
    let mut bytes = Vec::new();
    let stopped = match compression {
        "" => {
            bytes.extend_from_slice(data);
            None
        }
        _ if data.is_empty() => None,
        "zstd" => match zstd::stream::read::Decoder::with_buffer(data) {
            Ok(decoder) => drain(decoder, &mut bytes),
            Err(cause) => Some(cause.to_string()),
        },
        "lz4" => match lz4::Decoder::new(data) {
            Ok(mut decoder) => {
                let stopped = drain(&mut decoder, &mut bytes);
                let (_, end) = decoder.finish();
                stopped.or_else(|| end.err().map(|_| "its end is missing".to_owned()))
            }
            Err(cause) => Some(cause.to_string()),
        },
        other => Some(format!("the compression `{other}` is not known")),
    };
    Unpacked { bytes, stopped }
}

/// Reads until the end or the first mistake, whose text it gives.
fn drain(mut from: impl Read, into: &mut Vec<u8>) -> Option<String> {
    let mut block = vec![0; 1 << 15];
    loop {
        match from.read(&mut block) {
            Ok(0) => return None,
            Ok(count) => into.extend_from_slice(&block[..count]),
            Err(cause) if cause.kind() == std::io::ErrorKind::Interrupted => {}
            Err(cause) => return Some(cause.to_string()),
        }
        if into.len() as u64 > UNPACKED_LIMIT {
            return Some(format!("more than {UNPACKED_LIMIT} bytes"));
        }
    }
}
