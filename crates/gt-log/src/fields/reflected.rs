//! Numbers in Protobuf messages of any descriptor.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use prost::DecodeError;
use prost::bytes::Buf;
use prost::encoding as wire;
use prost::encoding::{DecodeContext, WireType};
use prost_types::field_descriptor_proto::Type;

use super::descriptor::{Descriptor, Field, Kind};
use super::{ELEMENTS, FIELDS};

/// Messages within messages: what lies deeper is no field, and a message that is deeper is refused,
/// as other readers of Protobuf have it.
const DEPTH: usize = 100;

/// The way to a number: a field, and where it is repeated which element, then that of a message.
pub(crate) type Path = Vec<Hop>;

/// A step on the way to a number.
#[derive(Debug, Clone)]
pub(crate) struct Hop {
    number: u32,
    element: Option<usize>,
    absent: Option<f64>,
}

/// A kind of message.
#[derive(Debug, Clone)]
pub(crate) struct Message {
    descriptor: Arc<Descriptor>,
    place: usize,
}

/// What is known of the lengths of repeated fields.
#[derive(Debug)]
pub(crate) struct Survey {
    message: Message,
    repeated: bool,
    lengths: BTreeMap<String, usize>,
}

impl Survey {
    /// The message called `name` of an encoded set of descriptors. The error says in words why there
    /// is none.
    pub(crate) fn of(name: &str, descriptors: &[u8]) -> Result<Self, String> {
        let descriptor = Descriptor::of(descriptors)?;
        let place = descriptor
            .place(name)
            .ok_or_else(|| "a descriptor without it".to_owned())?;
        let repeated = has_list(&descriptor, place, &mut HashSet::new(), DEPTH);
        Ok(Self {
            message: Message {
                descriptor: Arc::new(descriptor),
                place,
            },
            repeated,
            lengths: BTreeMap::new(),
        })
    }

    pub(crate) fn needs_messages(&self) -> bool {
        self.repeated
    }

    pub(crate) fn add(&mut self, data: &[u8]) {
        let Message { descriptor, place } = self.message.clone();
        let mut values = Values::default();
        if values.merge(&descriptor, place, data, DEPTH).is_ok() {
            self.measure(&descriptor, place, &values, "");
        }
    }

    /// Takes the lengths of repeated fields, wherever they are.
    fn measure(&mut self, descriptor: &Descriptor, place: usize, values: &Values, prefix: &str) {
        let Some(message) = descriptor.message(place) else {
            return;
        };
        for field in &message.fields {
            let Some(items) = values.0.get(&field.number) else {
                continue;
            };
            let name = inner_name(prefix, &field.name);
            let count = items.len().min(ELEMENTS);
            if field.repeated && self.lengths.len() < FIELDS {
                let length = self.lengths.entry(name.clone()).or_default();
                *length = count.max(*length);
            }
            let Kind::Message(inner) = field.kind else {
                continue;
            };
            for (index, item) in items.iter().take(count).enumerate() {
                if let Item::Message(values) = item {
                    let own = if field.repeated {
                        format!("{name}[{index}]")
                    } else {
                        name.clone()
                    };
                    self.measure(descriptor, inner, values, &own);
                }
            }
        }
    }

    /// The names of the numbers with the ways to them.
    pub(crate) fn fields(self) -> (Vec<(String, Path)>, Message) {
        let mut list = List {
            descriptor: &self.message.descriptor,
            lengths: &self.lengths,
            found: Vec::new(),
            left: FIELDS,
        };
        let place = self.message.place;
        list.message(place, "", &mut Vec::new(), &mut vec![place]);
        (list.found, self.message)
    }
}

fn inner_name(prefix: &str, name: &str) -> String {
    if prefix.is_empty() {
        name.to_owned()
    } else {
        format!("{prefix}.{name}")
    }
}

/// Whether a message or one in it has a repeated field.
fn has_list(
    descriptor: &Descriptor,
    place: usize,
    seen: &mut HashSet<usize>,
    depth: usize,
) -> bool {
    if depth == 0 || !seen.insert(place) {
        return false;
    }
    let fields = descriptor.message(place).map_or(&[][..], |own| &own.fields);
    fields.iter().any(|field| {
        field.repeated
            || matches!(field.kind, Kind::Message(inner)
                if has_list(descriptor, inner, seen, depth - 1))
    })
}

/// The listing of numbers.
struct List<'a> {
    descriptor: &'a Descriptor,
    lengths: &'a BTreeMap<String, usize>,
    found: Vec<(String, Path)>,
    /// How many fields may still be looked at.
    left: usize,
}

impl List<'_> {
    fn message(&mut self, place: usize, prefix: &str, path: &mut Path, above: &mut Vec<usize>) {
        let descriptor = self.descriptor;
        let Some(message) = descriptor.message(place) else {
            return;
        };
        for field in &message.fields {
            let name = inner_name(prefix, &field.name);
            if field.repeated {
                let count = self.lengths.get(&name).copied().unwrap_or(0);
                for element in 0..count {
                    let own = format!("{name}[{element}]");
                    self.leaf(field, Some(element), &own, path, above);
                }
            } else {
                self.leaf(field, None, &name, path, above);
            }
        }
    }

    fn leaf(
        &mut self,
        field: &Field,
        element: Option<usize>,
        name: &str,
        path: &mut Path,
        above: &mut Vec<usize>,
    ) {
        let Some(left) = self.left.checked_sub(1) else {
            return;
        };
        self.left = left;
        path.push(Hop {
            number: field.number,
            element,
            absent: field.absent,
        });
        match field.kind {
            Kind::Number(_) => self.found.push((name.to_owned(), path.clone())),
            // A message within one of its own kind is not entered: its names would not end.
            Kind::Message(inner) if above.len() < DEPTH && !above.contains(&inner) => {
                above.push(inner);
                self.message(inner, name, path, above);
                above.pop();
            }
            Kind::Message(_) => {}
        }
        path.pop();
    }
}

impl Message {
    /// The numbers at the ends of `paths`.
    pub(crate) fn decode(&self, data: &[u8], paths: &[Path]) -> Result<Vec<Option<f64>>, String> {
        let mut values = Values::default();
        values.merge(&self.descriptor, self.place, data, DEPTH)?;
        Ok(paths.iter().map(|path| values.at(path)).collect())
    }
}

/// What a message holds, by the numbers of its fields.
#[derive(Debug, Default)]
struct Values(BTreeMap<u32, Vec<Item>>);

#[derive(Debug)]
enum Item {
    Number(f64),
    Message(Values),
}

impl Values {
    /// The number at the end of a path; none where a field on it is absent.
    fn at(&self, path: &[Hop]) -> Option<f64> {
        let (hop, rest) = path.split_first()?;
        let Some(items) = self.0.get(&hop.number) else {
            return hop.absent.filter(|_| rest.is_empty());
        };
        match items.get(hop.element.unwrap_or(0))? {
            Item::Number(value) => rest.is_empty().then_some(*value),
            Item::Message(values) => values.at(rest),
        }
    }

    /// Adds the fields of an encoded message. As Protobuf has it, of several single numbers the last
    /// counts, single messages are merged, and of a oneof the last member is there.
    fn merge(
        &mut self,
        descriptor: &Descriptor,
        place: usize,
        mut data: &[u8],
        depth: usize,
    ) -> Result<(), String> {
        let message = descriptor.message(place);
        while data.has_remaining() {
            let (number, wire_type) = wire::decode_key(&mut data).map_err(text)?;
            let Some((message, field)) =
                message.and_then(|own| own.numbered(number).map(|field| (own, field)))
            else {
                let context = DecodeContext::default();
                wire::skip_field(wire_type, number, &mut data, context).map_err(text)?;
                continue;
            };
            if let Some(oneof) = field.oneof {
                let others = message.fields.iter();
                for other in others.filter(|own| own.oneof == Some(oneof) && own.number != number) {
                    self.0.remove(&other.number);
                }
            }
            match field.kind {
                Kind::Message(inner) => {
                    let own = delimited(&mut data, wire_type, &field.name)?;
                    let depth = depth.checked_sub(1).ok_or("messages that nest too deep")?;
                    let items = self.0.entry(number).or_default();
                    if field.repeated || items.is_empty() {
                        items.push(Item::Message(Self::default()));
                    }
                    if let Some(Item::Message(values)) = items.last_mut() {
                        values.merge(descriptor, inner, own, depth)?;
                    }
                }
                Kind::Number(kind) if field.repeated && wire_type == WireType::LengthDelimited => {
                    let mut own = delimited(&mut data, wire_type, &field.name)?;
                    let items = self.0.entry(number).or_default();
                    while own.has_remaining() {
                        let value = scalar(kind, natural(kind), &mut own).map_err(text)?;
                        items.push(Item::Number(value));
                    }
                }
                Kind::Number(kind) => {
                    let value = scalar(kind, wire_type, &mut data).map_err(text)?;
                    let items = self.0.entry(number).or_default();
                    if !field.repeated {
                        items.clear();
                    }
                    items.push(Item::Number(value));
                }
            }
        }
        Ok(())
    }
}

#[expect(clippy::needless_pass_by_value, reason = "an argument of map_err")]
fn text(cause: DecodeError) -> String {
    cause.to_string()
}

/// The bytes of a field that begins with its length.
fn delimited<'a>(data: &mut &'a [u8], wire_type: WireType, name: &str) -> Result<&'a [u8], String> {
    if wire_type != WireType::LengthDelimited {
        return Err(format!("`{name}` with the wire type {wire_type:?}"));
    }
    let length = wire::decode_varint(data).map_err(text)?;
    let whole = *data;
    let cut = usize::try_from(length)
        .ok()
        .and_then(|length| whole.split_at_checked(length))
        .ok_or_else(|| format!("`{name}` of {length} bytes where {} are left", whole.len()))?;
    *data = cut.1;
    Ok(cut.0)
}

/// How a number stands in a packed list.
fn natural(kind: Type) -> WireType {
    match kind {
        Type::Double | Type::Fixed64 | Type::Sfixed64 => WireType::SixtyFourBit,
        Type::Float | Type::Fixed32 | Type::Sfixed32 => WireType::ThirtyTwoBit,
        _ => WireType::Varint,
    }
}

/// Reads a number.
fn scalar(kind: Type, wire_type: WireType, data: &mut &[u8]) -> Result<f64, DecodeError> {
    macro_rules! read {
        ($module:ident, $type:ty, $convert:expr) => {{
            let mut value = <$type>::default();
            wire::$module::merge(wire_type, &mut value, data, DecodeContext::default())?;
            $convert(value)
        }};
    }
    // Beyond 2^53 an integer is rounded.
    let (signed, unsigned) = (|own: i64| own as f64, |own: u64| own as f64);
    Ok(match kind {
        Type::Double => read!(double, f64, f64::from),
        Type::Float => read!(float, f32, f64::from),
        Type::Int64 => read!(int64, i64, signed),
        Type::Uint64 => read!(uint64, u64, unsigned),
        Type::Sint64 => read!(sint64, i64, signed),
        Type::Fixed64 => read!(fixed64, u64, unsigned),
        Type::Sfixed64 => read!(sfixed64, i64, signed),
        Type::Uint32 => read!(uint32, u32, f64::from),
        Type::Sint32 => read!(sint32, i32, f64::from),
        Type::Fixed32 => read!(fixed32, u32, f64::from),
        Type::Sfixed32 => read!(sfixed32, i32, f64::from),
        Type::Bool => read!(bool, bool, |own| f64::from(u8::from(own))),
        // Enumerations are encoded alike.
        _ => read!(int32, i32, f64::from),
    })
}
