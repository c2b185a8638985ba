//! Messages of doubles, encoded and decoded by field number.

use std::collections::HashMap;

use prost::bytes::Buf;
use prost::encoding::{DecodeContext, decode_key, double, int32, skip_field};

use crate::schema::DoubleField;

/// Appends the fields that have a value; an absent one leaves no byte.
pub(crate) fn encode(
    numbers: &[u32],
    values: impl IntoIterator<Item = Option<f64>>,
    buffer: &mut Vec<u8>,
) {
    for (&number, value) in numbers.iter().zip(values) {
        if let Some(value) = value {
            double::encode(number, &value, buffer);
        }
    }
}

/// Appends a value of an enumeration for every field.
pub(crate) fn encode_values(
    numbers: &[u32],
    values: impl IntoIterator<Item = i32>,
    buffer: &mut Vec<u8>,
) {
    for (&number, value) in numbers.iter().zip(values) {
        int32::encode(number, &value, buffer);
    }
}

/// Reads some of a message's fields, by their numbers.
#[derive(Debug)]
pub(crate) struct Decoder {
    slots: HashMap<u32, usize>,
    absent: Vec<Option<f64>>,
}

impl Decoder {
    /// A decoder of these fields, in this order.
    pub(crate) fn new<'a>(fields: impl IntoIterator<Item = &'a DoubleField>) -> Self {
        let (mut slots, mut absent) = (HashMap::new(), Vec::new());
        for field in fields {
            slots.insert(field.number, absent.len());
            absent.push(field.absent);
        }
        Self { slots, absent }
    }

    /// The values of the fields. As Protobuf has it, the last of several counts, and fields that
    /// are not asked for are skipped.
    pub(crate) fn decode(&self, mut data: &[u8]) -> Result<Vec<Option<f64>>, prost::DecodeError> {
        let mut values = self.absent.clone();
        while data.has_remaining() {
            let (number, wire_type) = decode_key(&mut data)?;
            if let Some(&slot) = self.slots.get(&number) {
                let mut value = 0.0;
                double::merge(wire_type, &mut value, &mut data, DecodeContext::default())?;
                values[slot] = Some(value);
            } else {
                skip_field(wire_type, number, &mut data, DecodeContext::default())?;
            }
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gt_core::Signal;
    use proptest::prelude::*;

    fn fields(numbers: &[u32]) -> Vec<DoubleField> {
        let signal = Signal::new("x", "");
        numbers
            .iter()
            .map(|&number| DoubleField {
                signal: signal.clone(),
                number,
                absent: None,
            })
            .collect()
    }

    proptest! {
        #[test]
        fn prop_every_bit_pattern_survives(
            bits in proptest::collection::vec(proptest::option::of(any::<u64>()), 1..30),
        ) {
            let numbers: Vec<u32> = (1..).take(bits.len()).collect();
            let mut buffer = Vec::new();
            encode(&numbers, bits.iter().map(|bits| bits.map(f64::from_bits)), &mut buffer);
            let decoded = Decoder::new(&fields(&numbers)).decode(&buffer).unwrap();
            let found: Vec<Option<u64>> = decoded.iter().map(|v| v.map(f64::to_bits)).collect();
            prop_assert_eq!(found, bits);
        }

        #[test]
        fn prop_any_bytes_are_an_answer(bytes in proptest::collection::vec(any::<u8>(), 0..60)) {
            let _ = Decoder::new(&fields(&[1, 2, 3])).decode(&bytes);
        }
    }

    #[test]
    fn the_wire_format_is_protobufs() {
        let mut buffer = Vec::new();
        encode(&[1, 2], [Some(1.0), None], &mut buffer);
        // Field 1 with wire type 1, then 1.0 in little endian (Protobuf encoding guide).
        assert_eq!(buffer, [0x09, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
    }

    #[test]
    fn a_field_of_another_wire_type_is_an_error() {
        let decoder = Decoder::new(&fields(&[1]));
        assert!(decoder.decode(&[0x08, 0x01]).is_err());
        // The same varint in field 2, which nobody asked for.
        assert_eq!(decoder.decode(&[0x10, 0x01]).unwrap(), [None]);
    }
}
