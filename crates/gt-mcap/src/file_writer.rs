//! The writer of a file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapResult, WriteOptions, Writer};

/// Writes an MCAP file; all of it is as [`mcap::Writer`] has it.
///
/// Nothing of it is inlined elsewhere: what calls it would compile the writer again.
pub struct FileWriter(Writer<BufWriter<File>>);

impl FileWriter {
    /// Begins a file.
    ///
    /// # Errors
    /// [`mcap::McapError`], as of every call below.
    #[inline(never)]
    pub fn create(file: File, options: WriteOptions) -> McapResult<Self> {
        options.create(BufWriter::new(file)).map(Self)
    }

    /// Appends a metadata record.
    ///
    /// # Errors
    /// As [`FileWriter::create`].
    #[inline(never)]
    pub fn write_metadata(&mut self, metadata: &Metadata) -> McapResult<()> {
        self.0.write_metadata(metadata)
    }

    /// Appends an attachment.
    ///
    /// # Errors
    /// As [`FileWriter::create`].
    #[inline(never)]
    pub fn attach(&mut self, attachment: &Attachment<'_>) -> McapResult<()> {
        self.0.attach(attachment)
    }

    /// Adds a schema and gives its id, that of an equal one where there is one.
    ///
    /// # Errors
    /// As [`FileWriter::create`].
    #[inline(never)]
    pub fn add_schema(&mut self, name: &str, encoding: &str, data: &[u8]) -> McapResult<u16> {
        self.0.add_schema(name, encoding, data)
    }

    /// Adds a channel and gives its id, that of an equal one where there is one.
    ///
    /// # Errors
    /// As [`FileWriter::create`].
    #[inline(never)]
    pub fn add_channel(
        &mut self,
        schema_id: u16,
        topic: &str,
        message_encoding: &str,
        metadata: &BTreeMap<String, String>,
    ) -> McapResult<u16> {
        self.0
            .add_channel(schema_id, topic, message_encoding, metadata)
    }

    /// Adds a schema under this id, and gives it.
    ///
    /// # Errors
    /// As [`FileWriter::create`].
    #[inline(never)]
    pub fn add_schema_with_id(
        &mut self,
        id: u16,
        name: &str,
        encoding: &str,
        data: &[u8],
    ) -> McapResult<u16> {
        self.0.add_schema_with_id(id, name, encoding, data)
    }

    /// Adds a channel under this id, and gives it.
    ///
    /// # Errors
    /// As [`FileWriter::create`].
    #[inline(never)]
    pub fn add_channel_with_id(
        &mut self,
        id: u16,
        schema_id: u16,
        topic: &str,
        message_encoding: &str,
        metadata: &BTreeMap<String, String>,
    ) -> McapResult<u16> {
        self.0
            .add_channel_with_id(id, schema_id, topic, message_encoding, metadata)
    }

    /// Appends a message of a channel that was added.
    ///
    /// # Errors
    /// As [`FileWriter::create`].
    #[inline(never)]
    pub fn write_message(&mut self, header: &MessageHeader, data: &[u8]) -> McapResult<()> {
        self.0.write_to_known_channel(header, data)
    }

    /// Closes the chunk and hands all of it to the operating system.
    ///
    /// # Errors
    /// As [`FileWriter::create`].
    #[inline(never)]
    pub fn flush(&mut self) -> McapResult<()> {
        self.0.flush()
    }

    /// Writes the summary.
    ///
    /// # Errors
    /// As [`FileWriter::create`].
    #[inline(never)]
    pub fn finish(&mut self) -> McapResult<()> {
        self.0.finish().map(|_| ())
    }

    /// The file, with all that was written in it.
    ///
    /// # Errors
    /// Of the last write.
    #[inline(never)]
    pub fn into_file(self) -> io::Result<File> {
        let inner = self.0.into_inner().into_inner();
        inner.map_err(io::IntoInnerError::into_error)
    }
}
