//! The encoding of protobuf messages (<https://protobuf.dev/programming-guides/encoding>), as much
//! of it as frames need.

/// Wire types.
const VARINT: u64 = 0;
const EIGHT_BYTES: u64 = 1;
const LENGTH: u64 = 2;
const FOUR_BYTES: u64 = 5;

/// A message while it is written. Fields of the value 0 are left out, as proto3 does.
#[derive(Clone, Debug, Default)]
pub(super) struct Message(Vec<u8>);

impl Message {
    /// An empty message with room for so many bytes, in the memory of one that is written.
    pub(super) fn of_capacity(bytes: usize, spent: Self) -> Self {
        let mut memory = spent.0;
        memory.clear();
        memory.reserve_exact(bytes);
        Self(memory)
    }

    fn raw_varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    fn key(&mut self, field: u32, wire_type: u64) {
        self.raw_varint((u64::from(field) << 3) | wire_type);
    }

    /// A field of type `uint32`, `uint64`, `int32`, `int64` or of an enumeration, not negative.
    #[must_use]
    pub(super) fn varint(mut self, field: u32, value: u64) -> Self {
        if value != 0 {
            self.key(field, VARINT);
            self.raw_varint(value);
        }
        self
    }

    /// A field of type `double`, to the bit: -0 and NaN are kept.
    #[must_use]
    pub(super) fn double(self, field: u32, value: f64) -> Self {
        self.fixed64(field, value.to_bits())
    }

    /// A field of type `fixed64`.
    #[must_use]
    pub(super) fn fixed64(mut self, field: u32, value: u64) -> Self {
        if value != 0 {
            self.key(field, EIGHT_BYTES);
            self.0.extend(value.to_le_bytes());
        }
        self
    }

    /// A field of type `fixed32`.
    #[must_use]
    pub(super) fn fixed32(mut self, field: u32, value: u32) -> Self {
        if value != 0 {
            self.key(field, FOUR_BYTES);
            self.0.extend(value.to_le_bytes());
        }
        self
    }

    /// A field of type `bytes`, of so many bytes, filled by `fill`.
    #[must_use]
    pub(super) fn filled(mut self, field: u32, length: usize, fill: impl FnOnce(&mut [u8])) -> Self {
        if length > 0 {
            self.key(field, LENGTH);
            self.raw_varint(length as u64);
            let start = self.0.len();
            self.0.resize(start + length, 0);
            fill(&mut self.0[start..]);
        }
        self
    }

    /// A field of type `bytes`.
    #[must_use]
    pub(super) fn data(mut self, field: u32, bytes: &[u8]) -> Self {
        if !bytes.is_empty() {
            self.key(field, LENGTH);
            self.raw_varint(bytes.len() as u64);
            self.0.extend_from_slice(bytes);
        }
        self
    }

    /// A field of type `string`.
    #[must_use]
    pub(super) fn text(self, field: u32, text: &str) -> Self {
        self.data(field, text.as_bytes())
    }

    /// A field that is a message; there even if it is empty.
    #[must_use]
    pub(super) fn message(mut self, field: u32, message: &Self) -> Self {
        self.key(field, LENGTH);
        self.raw_varint(message.0.len() as u64);
        self.0.extend(&message.0);
        self
    }

    /// A field that is a message, where there is one.
    #[must_use]
    pub(super) fn optional(self, field: u32, message: Option<&Self>) -> Self {
        match message {
            Some(message) => self.message(field, message),
            None => self,
        }
    }

    /// The bytes.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.0
    }
}

/// The value of a field that was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Value<'a> {
    /// A number of variable length.
    Varint(u64),
    /// Eight bytes.
    Fixed64(u64),
    /// Four bytes.
    Fixed32(u32),
    /// Bytes, a text or a message.
    Bytes(&'a [u8]),
}

impl<'a> Value<'a> {
    /// A number; 0 for other types.
    pub(super) fn number(self) -> u64 {
        match self {
            Self::Varint(value) | Self::Fixed64(value) => value,
            Self::Fixed32(value) => u64::from(value),
            Self::Bytes(_) => 0,
        }
    }

    /// A `double`; 0 for other types.
    pub(super) fn double(self) -> f64 {
        f64::from_bits(self.number())
    }

    /// Bytes; none for other types.
    pub(super) fn bytes(self) -> &'a [u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            _ => &[],
        }
    }

    /// A text; characters that are none are replaced.
    pub(super) fn text(self) -> String {
        String::from_utf8_lossy(self.bytes()).into_owned()
    }
}

/// The fields of a message in their order, until the first that is damaged.
#[derive(Clone, Debug)]
pub(super) struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// The fields of these bytes.
    pub(super) fn of(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    fn take(&mut self, length: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(taken)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        // Ten groups of seven bits hold 64.
        for shift in (0..70).step_by(7) {
            let byte = self.take(1)?[0];
            value |= u64::from(byte & 0x7f).checked_shl(shift).unwrap_or(0);
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn field(&mut self) -> Option<(u32, Value<'a>)> {
        let key = self.varint()?;
        let value = match key & 7 {
            VARINT => Value::Varint(self.varint()?),
            EIGHT_BYTES => Value::Fixed64(u64::from_le_bytes(self.take(8)?.try_into().ok()?)),
            FOUR_BYTES => Value::Fixed32(u32::from_le_bytes(self.take(4)?.try_into().ok()?)),
            LENGTH => {
                let length = self.varint()?;
                Value::Bytes(self.take(length)?)
            }
            _ => return None,
        };
        Some((u32::try_from(key >> 3).ok()?, value))
    }
}

/// A message whose bytes are no protobuf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Damaged;

impl<'a> Iterator for Fields<'a> {
    type Item = Result<(u32, Value<'a>), Damaged>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() {
            return None;
        }
        let field = self.field();
        if field.is_none() {
            self.0 = &[];
        }
        Some(field.ok_or(Damaged))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_examples_are_encoded_to_the_byte() {
        // 150 in field 1, "testing" in field 2 and both nested in field 3: the guide's examples.
        let inner = Message::default().varint(1, 150);
        assert_eq!(inner.bytes(), [0x08, 0x96, 0x01]);
        let text = Message::default().text(2, "testing");
        assert_eq!(text.bytes(), [0x12, 0x07, 0x74, 0x65, 0x73, 0x74, 0x69, 0x6e, 0x67]);
        assert_eq!(Message::default().message(3, &inner).bytes(), [0x1a, 0x03, 0x08, 0x96, 0x01]);
        let numbers = Message::default().double(1, 1.0).fixed32(2, 5).varint(3, 0);
        assert_eq!(numbers.bytes(), [0x09, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0x15, 5, 0, 0, 0]);
    }

    #[test]
    fn fields_come_back_to_the_bit_and_damage_is_found() {
        let written = Message::default()
            .varint(1, u64::MAX)
            .double(2, -0.0)
            .double(3, f64::NAN)
            .fixed32(4, u32::MAX)
            .text(900, "Ø");
        let fields: Vec<_> = Fields::of(written.bytes()).collect();
        let right = [
            (1, Value::Varint(u64::MAX)),
            (2, Value::Fixed64(1 << 63)),
            (3, Value::Fixed64(f64::NAN.to_bits())),
            (4, Value::Fixed32(u32::MAX)),
            (900, Value::Bytes("Ø".as_bytes())),
        ];
        assert_eq!(fields, right.map(Ok));
        for cut in 1..written.bytes().len() {
            let read: Vec<_> = Fields::of(&written.bytes()[..cut]).collect();
            let is_between = read.iter().all(Result::is_ok);
            assert!(read.len() <= 5 && (!is_between || read.len() < 5), "{cut}");
        }
        assert_eq!(Fields::of(&[0x80; 11]).collect::<Vec<_>>(), [Err(Damaged)]);
        assert_eq!(Fields::of(&[0x0b]).collect::<Vec<_>>(), [Err(Damaged)]);
    }
}
