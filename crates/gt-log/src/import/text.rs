//! Bytes into UTF-8 text.

use std::borrow::Cow;
use std::path::Path;

use encoding_rs::{DecoderResult, Encoding, UTF_8, UTF_16BE, UTF_16LE};

use super::ReadingError;
use crate::LogError;

/// Text and how it was written.
pub(crate) struct Text<'a> {
    /// UTF-8 without a byte-order mark.
    pub(crate) bytes: Cow<'a, [u8]>,
    /// The name of the encoding.
    pub(crate) encoding: &'static str,
}

/// Reads bytes in the encoding that is `given`, or that a byte-order mark tells, or in UTF-8.
pub(crate) fn decode<'a>(
    path: &Path,
    bytes: &'a [u8],
    given: Option<&'static Encoding>,
) -> Result<Text<'a>, LogError> {
    let marked = Encoding::for_bom(bytes);
    let (encoding, mark) = match (given, marked) {
        (Some(given), Some((marked, length))) if given == marked => (given, length),
        (Some(given), _) => (given, 0),
        (None, Some((marked, length))) => (marked, length),
        (None, None) => (UTF_8, 0),
    };
    let body = &bytes[mark..];
    let is_wide = encoding == UTF_16LE || encoding == UTF_16BE;
    let bytes = if encoding == UTF_8 {
        check_utf8(path, bytes)?;
        Cow::Borrowed(body)
    } else {
        let text = transcode(body, encoding).map_err(|cause| LogError::reading(path, cause))?;
        if !is_wide {
            check_utf8(path, text.as_bytes())?;
        }
        Cow::Owned(text.into_bytes())
    };
    Ok(Text {
        bytes,
        encoding: encoding.name(),
    })
}

fn transcode(bytes: &[u8], encoding: &'static Encoding) -> Result<String, ReadingError> {
    let mut decoder = encoding.new_decoder_without_bom_handling();
    let most = decoder.max_utf8_buffer_length_without_replacement(bytes.len());
    let mut text = String::with_capacity(most.unwrap_or(bytes.len()));
    let (result, _) = decoder.decode_to_string_without_replacement(bytes, &mut text, true);
    match result {
        DecoderResult::InputEmpty => Ok(text),
        DecoderResult::Malformed(..) | DecoderResult::OutputFull => {
            Err(ReadingError::Undecodable {
                line: line_after(text.as_bytes()),
                encoding: encoding.name(),
            })
        }
    }
}

/// The line, from 1, that a text ends in.
fn line_after(text: &[u8]) -> u64 {
    text.split(|&byte| byte == b'\n').count() as u64
}

/// Refuses what is not UTF-8 text. A NUL is valid UTF-8, but no text has one (UTF-16 has many).
fn check_utf8(path: &Path, bytes: &[u8]) -> Result<(), LogError> {
    let nul = bytes.iter().position(|&byte| byte == 0);
    let invalid = std::str::from_utf8(bytes)
        .err()
        .map(|cause| cause.valid_up_to());
    let Some(offset) = nul.into_iter().chain(invalid).min() else {
        return Ok(());
    };
    Err(LogError::NotText {
        path: path.to_owned(),
        line: line_after(&bytes[..offset]),
        offset,
        found: bytes[offset],
    })
}
