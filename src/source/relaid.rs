//! A TIFF with a substitute first directory: the bytes of the file, with a new directory behind
//! them.

use std::io::{Read, Result as IoResult, Seek, SeekFrom};

use super::ifd::{Entry, Layout};

/// A tag with the value or offset in its field.
#[derive(Clone, Debug)]
pub(super) struct Tag {
    pub(super) tag: u16,
    kind: u16,
    count: u64,
    value: Value,
}

#[derive(Clone, Debug)]
enum Value {
    Number(u32),
    /// 64-bit numbers in BigTIFF, otherwise 32-bit ones.
    Numbers(Vec<u64>),
    /// Copied from the file, in the file's own byte order.
    Field([u8; 8]),
}

impl Tag {
    /// One 16-bit number.
    pub(super) fn short(tag: u16, value: u16) -> Self {
        Self { tag, kind: 3, count: 1, value: Value::Number(value.into()) }
    }

    /// One 32-bit number.
    pub(super) fn long(tag: u16, value: u32) -> Self {
        Self { tag, kind: 4, count: 1, value: Value::Number(value) }
    }

    /// Offsets or sizes of strips or tiles.
    pub(super) fn places(tag: u16, values: Vec<u64>, big: bool) -> Self {
        Self {
            tag,
            kind: if big { 16 } else { 4 },
            count: values.len() as u64,
            value: Value::Numbers(values),
        }
    }

    /// A tag copied from the file.
    pub(super) fn kept(entry: &Entry) -> Self {
        Self { tag: entry.tag, kind: entry.kind, count: entry.count, value: Value::Field(entry.field) }
    }
}

/// The bytes of a file between a header that points behind them and the new directory there.
pub(super) struct Relaid<'a> {
    header: Vec<u8>,
    bytes: &'a [u8],
    directory: Vec<u8>,
    at: u64,
}

impl<'a> Relaid<'a> {
    /// A directory of `tags`.
    pub(super) fn new(bytes: &'a [u8], layout: Layout, mut tags: Vec<Tag>) -> Self {
        tags.sort_by_key(|t| t.tag);
        let writer = Writer { layout };
        let size = if layout.big { 8 } else { 4 };
        let mut header = bytes[..if layout.big { 8 } else { 4 }].to_vec();
        header.extend(writer.number(bytes.len() as u64, size));
        let head = if layout.big { 8 } else { 2 };
        let mut directory = writer.number(tags.len() as u64, head);
        // Values that do not fit their fields follow the directory.
        let behind = bytes.len() + head + tags.len() * (4 + 2 * size) + size;
        let mut values = Vec::new();
        for tag in &tags {
            directory.extend(writer.number(tag.tag.into(), 2));
            directory.extend(writer.number(tag.kind.into(), 2));
            directory.extend(writer.number(tag.count, size));
            let mut field = writer.value(tag, size);
            if field.len() > size && !matches!(tag.value, Value::Field(_)) {
                let at = writer.number((behind + values.len()) as u64, size);
                values.extend(std::mem::replace(&mut field, at));
            }
            field.resize(size, 0);
            directory.extend(field);
        }
        directory.extend(vec![0; size]);
        directory.extend(values);
        Self { header, bytes, directory, at: 0 }
    }
}

struct Writer {
    layout: Layout,
}

impl Writer {
    fn number(&self, value: u64, size: usize) -> Vec<u8> {
        if self.layout.big_endian {
            value.to_be_bytes()[8 - size..].to_vec()
        } else {
            value.to_le_bytes()[..size].to_vec()
        }
    }

    /// The bytes of a value, which is at the beginning of its field.
    fn value(&self, tag: &Tag, size: usize) -> Vec<u8> {
        match &tag.value {
            Value::Field(field) => field[..size].to_vec(),
            Value::Number(value) => self.number((*value).into(), if tag.kind == 3 { 2 } else { 4 }),
            Value::Numbers(values) => values.iter().flat_map(|v| self.number(*v, size)).collect(),
        }
    }
}

impl Read for Relaid<'_> {
    fn read(&mut self, out: &mut [u8]) -> IoResult<usize> {
        let at = usize::try_from(self.at).unwrap_or(usize::MAX);
        let rest = if at < self.header.len() {
            &self.header[at..]
        } else if at < self.bytes.len() {
            &self.bytes[at..]
        } else {
            self.directory.get(at - self.bytes.len()..).unwrap_or(&[])
        };
        let count = rest.len().min(out.len());
        out[..count].copy_from_slice(&rest[..count]);
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for Relaid<'_> {
    fn seek(&mut self, to: SeekFrom) -> IoResult<u64> {
        let end = (self.bytes.len() + self.directory.len()) as u64;
        let place = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::End(by) => end.checked_add_signed(by),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
        };
        self.at = place.ok_or(std::io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}
