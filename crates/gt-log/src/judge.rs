//! Whether the messages of a channel decode.

use std::path::Path;
use std::sync::Arc;

use mcap::records::{Channel, SchemaHeader};
use prost::bytes::Buf;
use prost::encoding::{DecodeContext, decode_key, skip_field};

use crate::LogError;
use crate::fields::{Decoder, Survey};

/// How the messages of a channel are decoded.
pub(crate) enum Judge {
    /// By its schema.
    Fields(Decoder),
    /// Protobuf whose schema is broken: by the wire format alone.
    Wire,
    /// JSON, with a schema or none.
    Json,
    /// Not at all: the encoding is not one that is read here.
    Foreign,
}

impl Judge {
    /// The judge of a channel with its schema.
    ///
    /// # Errors
    /// [`LogError::Encoding`] and [`LogError::Descriptor`] for a schema that does not describe
    /// messages of Protobuf.
    pub(crate) fn of(
        path: &Path,
        channel: &Channel,
        schema: Option<&(SchemaHeader, Vec<u8>)>,
    ) -> Result<Self, LogError> {
        match channel.message_encoding.as_str() {
            "json" => Ok(Self::Json),
            "protobuf" => {
                let schema = schema.map(|(header, data)| {
                    Arc::new(mcap::Schema {
                        id: header.id,
                        name: header.name.clone(),
                        encoding: header.encoding.clone(),
                        data: data.clone().into(),
                    })
                });
                let whole = mcap::Channel {
                    id: channel.id,
                    topic: channel.topic.clone(),
                    schema,
                    message_encoding: channel.message_encoding.clone(),
                    metadata: channel.metadata.clone(),
                };
                let fields = Survey::of(path, &whole)?.fields();
                Ok(Self::Fields(fields.decoder(0..fields.signals.len())))
            }
            _ => Ok(Self::Foreign),
        }
    }

    /// Whether a message was decoded: none of a foreign encoding is. The error says in words why it
    /// could not be.
    pub(crate) fn decode(&self, message: &[u8]) -> Result<bool, String> {
        match self {
            Self::Fields(decoder) => decoder.decode(message).map(drop),
            Self::Wire => walk_wire(message),
            Self::Json => serde_json::from_slice::<serde::de::IgnoredAny>(message)
                .map(drop)
                .map_err(|cause| cause.to_string()),
            Self::Foreign => return Ok(false),
        }
        .map(|()| true)
    }
}

/// Whether the bytes are fields of the wire format of Protobuf.
fn walk_wire(mut data: &[u8]) -> Result<(), String> {
    while data.has_remaining() {
        let (number, wire_type) = decode_key(&mut data).map_err(|cause| cause.to_string())?;
        skip_field(wire_type, number, &mut data, DecodeContext::default())
            .map_err(|cause| cause.to_string())?;
    }
    Ok(())
}
