//! Messages of doubles, encoded and decoded by field number.

use std::cmp::Reverse;

use prost::bytes::Buf;
use prost::encoding::{DecodeContext, decode_key, double, int32, skip_field};

/// Bytes of a double.
const WIDTH: usize = 8;

/// The fields of a topic's messages, in order.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    numbers: Vec<u32>,
    /// A message with a 0 in every field, and where each begins.
    zeros: Vec<u8>,
    places: Vec<usize>,
}

impl Layout {
    /// Messages of these fields, by their numbers (1 to 2^29 - 1).
    #[inline(never)]
    pub fn new(numbers: Vec<u32>) -> Self {
        let (mut zeros, mut places) = (Vec::new(), Vec::with_capacity(numbers.len()));
        for &number in &numbers {
            double::encode(number, &0.0, &mut zeros);
            places.push(zeros.len() - WIDTH);
        }
        Self {
            numbers,
            zeros,
            places,
        }
    }

    /// How many fields there are.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Makes `message` one with a value in every field; fields without one have 0.
    #[inline(never)]
    pub fn encode(&self, values: &[f64], message: &mut Vec<u8>) {
        message.clear();
        message.extend_from_slice(&self.zeros);
        for (&place, value) in self.places.iter().zip(values) {
            message[place..place + WIDTH].copy_from_slice(&value.to_le_bytes());
        }
    }

    /// Makes `message` one of the fields that have a value; an absent one leaves no byte.
    #[inline(never)]
    pub fn encode_present(&self, values: &[Option<f64>], message: &mut Vec<u8>) {
        message.clear();
        for (&number, value) in self.numbers.iter().zip(values) {
            if let Some(value) = value {
                double::encode(number, value, message);
            }
        }
    }

    /// Makes `message` one with a value of an enumeration in every field.
    pub fn encode_enumeration(&self, values: impl IntoIterator<Item = i32>, message: &mut Vec<u8>) {
        message.clear();
        for (&number, value) in self.numbers.iter().zip(values) {
            int32::encode(number, &value, message);
        }
    }
}

/// Reads some of a message's fields, by their numbers.
#[derive(Debug)]
pub struct Decoder {
    /// The numbers in ascending order, and where the value of each goes.
    slots: Vec<(u32, usize)>,
    absent: Vec<Option<f64>>,
}

impl Decoder {
    /// A decoder of these fields, in this order: the number of each, and its value in a message
    /// without it.
    #[inline(never)]
    pub fn new(fields: &[(u32, Option<f64>)]) -> Self {
        let numbered = fields.iter().enumerate();
        let mut slots: Vec<_> = numbered.map(|(slot, own)| (own.0, slot)).collect();
        // Of several of one number the last counts.
        slots.sort_unstable_by_key(|&(number, slot)| (number, Reverse(slot)));
        slots.dedup_by_key(|own| own.0);
        Self {
            slots,
            absent: fields.iter().map(|&(_, absent)| absent).collect(),
        }
    }

    /// Where a field stands among the slots. Most messages have their fields in ascending order: it
    /// is looked for at `guess` first.
    fn place(&self, number: u32, guess: usize) -> Option<usize> {
        let is_own = |place: usize| self.slots.get(place).is_some_and(|own| own.0 == number);
        if is_own(guess) {
            return Some(guess);
        }
        let found = self.slots.binary_search_by_key(&number, |own| own.0);
        found.ok()
    }

    /// The values of the fields. As Protobuf has it, the last of several counts, and fields that
    /// are not asked for are skipped.
    ///
    /// # Errors
    /// [`prost::DecodeError`] for bytes that are no message, or a field that is no double.
    #[inline(never)]
    pub fn decode(&self, mut data: &[u8]) -> Result<Vec<Option<f64>>, prost::DecodeError> {
        let (mut values, mut guess) = (self.absent.clone(), 0);
        while data.has_remaining() {
            let (number, wire_type) = decode_key(&mut data)?;
            if let Some(place) = self.place(number, guess) {
                let mut value = 0.0;
                double::merge(wire_type, &mut value, &mut data, DecodeContext::default())?;
                values[self.slots[place].1] = Some(value);
                guess = place + 1;
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
    use proptest::prelude::*;

    fn decoder(numbers: &[u32]) -> Decoder {
        let fields: Vec<(u32, Option<f64>)> =
            numbers.iter().map(|&number| (number, None)).collect();
        Decoder::new(&fields)
    }

    proptest! {
        #[test]
        fn prop_every_bit_pattern_survives(
            bits in proptest::collection::vec(proptest::option::of(any::<u64>()), 1..30),
        ) {
            let numbers: Vec<u32> = (1..).take(bits.len()).collect();
            let mut buffer = Vec::new();
            let values: Vec<Option<f64>> = bits.iter().map(|bits| bits.map(f64::from_bits)).collect();
            let layout = Layout::new(numbers.clone());
            layout.encode_present(&values, &mut buffer);
            let decoded = decoder(&numbers).decode(&buffer).unwrap();
            let found: Vec<Option<u64>> = decoded.iter().map(|v| v.map(f64::to_bits)).collect();
            prop_assert_eq!(found, bits);

            // With all fields there, both ways of encoding give the same bytes.
            let all: Vec<f64> = values.iter().map(|value| value.unwrap_or(-0.0)).collect();
            let mut at_once = vec![7];
            layout.encode(&all, &mut at_once);
            layout.encode_present(&all.iter().copied().map(Some).collect::<Vec<_>>(), &mut buffer);
            prop_assert_eq!(at_once, buffer);
        }

        #[test]
        fn prop_any_bytes_are_an_answer(bytes in proptest::collection::vec(any::<u8>(), 0..60)) {
            let _ = decoder(&[1, 2, 3]).decode(&bytes);
        }
    }

    proptest! {
        /// Fields in any order, in the message and in what is asked for, some of them not asked for
        /// and some twice: the last of several counts.
        #[test]
        fn prop_fields_are_found_in_any_order(
            sent in proptest::collection::vec((1_u32..40, any::<i32>()), 0..30),
            asked in proptest::collection::hash_set(1_u32..40, 1..20),
        ) {
            let asked: Vec<u32> = asked.into_iter().collect();
            let numbers = sent.iter().map(|(number, _)| *number).collect();
            let values: Vec<f64> = sent.iter().map(|(_, value)| f64::from(*value)).collect();
            let mut message = Vec::new();
            Layout::new(numbers).encode(&values, &mut message);
            let expected: Vec<Option<f64>> = asked.iter().map(|number| {
                let last = sent.iter().rev().find(|own| own.0 == *number);
                last.map(|(_, value)| f64::from(*value))
            }).collect();
            prop_assert_eq!(decoder(&asked).decode(&message).unwrap(), expected);
        }
    }

    #[test]
    fn the_wire_format_is_protobufs() {
        let mut buffer = Vec::new();
        Layout::new(vec![1, 2]).encode_present(&[Some(1.0), None], &mut buffer);
        // Field 1 with wire type 1, then 1.0 in little endian (Protobuf encoding guide).
        assert_eq!(buffer, [0x09, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
    }

    #[test]
    fn a_field_of_another_wire_type_is_an_error() {
        let decoder = decoder(&[1]);
        assert!(decoder.decode(&[0x08, 0x01]).is_err());
        // The same varint in field 2, which nobody asked for.
        assert_eq!(decoder.decode(&[0x10, 0x01]).unwrap(), [None]);
    }
}
