//! Directories of a TIFF (TIFF 6.0 section 2; BigTIFF, magic 43), as TIFF files and EXIF blocks
//! hold them: a chain of tagged entries. Every read is checked against the length; a value outside
//! is `None`.

/// Most directories followed: more pages than any recording; bounds the work on cyclic chains.
const MOST_DIRECTORIES: usize = 1 << 20;
/// Most entries of a directory; a photograph's have some dozens.
const MOST_ENTRIES: u64 = 4096;

/// How the numbers of a TIFF are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) big_endian: bool,
    /// BigTIFF: 64-bit offsets and counts.
    pub(super) big: bool,
}

/// One tag of a directory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) tag: u16,
    pub(super) kind: u16,
    pub(super) count: u64,
    /// The value itself, or its offset: 4 bytes, 8 in BigTIFF.
    pub(super) field: [u8; 8],
    /// Position of `field` in the file.
    at: u64,
}

/// The tags of one page.
#[derive(Clone, Debug, Default)]
pub(super) struct Directory {
    pub(super) entries: Vec<Entry>,
    /// Offset of the next directory; 0 at the end.
    next: u64,
}

/// A TIFF's bytes, with access to its directories.
#[derive(Clone, Copy, Debug)]
pub(super) struct TiffBytes<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) layout: Layout,
    first: u64,
}

impl<'a> TiffBytes<'a> {
    /// `None` where the bytes do not begin with a TIFF header.
    pub(super) fn new(bytes: &'a [u8]) -> Option<Self> {
        let big_endian = match bytes.get(..2)? {
            b"II" => false,
            b"MM" => true,
            _ => return None,
        };
        let mut this = Self { bytes, layout: Layout { big_endian, big: false }, first: 0 };
        match this.number(2, 2)? {
            42 => this.first = this.number(4, 4)?,
            43 if this.number(4, 2)? == 8 => {
                this.layout.big = true;
                this.first = this.number(8, 8)?;
            }
            _ => return None,
        }
        Some(this)
    }

    /// The unsigned number of `size` bytes at `at`.
    pub(super) fn number(&self, at: u64, size: usize) -> Option<u64> {
        let at = usize::try_from(at).ok()?;
        let bytes = self.bytes.get(at..at.checked_add(size)?)?;
        let join = |sum: u64, b: &u8| sum << 8 | u64::from(*b);
        let numbers = bytes.iter();
        Some(if self.layout.big_endian { numbers.fold(0, join) } else { numbers.rev().fold(0, join) })
    }

    /// The directory at `at`.
    pub(super) fn directory(&self, at: u64) -> Option<Directory> {
        let (head, size, field) = if self.layout.big { (8, 20, 8) } else { (2, 12, 4) };
        let count = self.number(at, head)?;
        if count == 0 || count > MOST_ENTRIES {
            return None;
        }
        let mut entries = Vec::with_capacity(count as usize);
        for index in 0..count {
            let start = at.checked_add(head as u64 + size * index)?;
            let value = start + size - field;
            let from = usize::try_from(value).ok()?;
            let mut raw = [0; 8];
            raw[..field as usize].copy_from_slice(self.bytes.get(from..from.checked_add(field as usize)?)?);
            entries.push(Entry {
                tag: self.number(start, 2)? as u16,
                kind: self.number(start + 2, 2)? as u16,
                count: self.number(start + 4, field as usize)?,
                field: raw,
                at: value,
            });
        }
        let next = self.number(at.checked_add(head as u64 + size * count)?, field as usize).unwrap_or(0);
        Some(Directory { entries, next })
    }

    /// The directories of the chain, in order; stops at an invalid offset or a cycle.
    pub(super) fn chain(&self) -> Vec<u64> {
        let (mut places, mut at) = (Vec::new(), self.first);
        let mut seen = std::collections::HashSet::new();
        while at != 0 && places.len() < MOST_DIRECTORIES && seen.insert(at) {
            let Some(directory) = self.directory(at) else { break };
            places.push(at);
            at = directory.next;
        }
        places
    }

    /// Offset of an entry's values and size of each, bytes.
    fn place(&self, entry: &Entry) -> Option<(u64, usize)> {
        let each = match entry.kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 | 16 | 17 | 18 => 8,
            _ => return None,
        };
        let inline = if self.layout.big { 8 } else { 4 };
        let at = if entry.count.checked_mul(each as u64)? <= inline {
            entry.at
        } else {
            self.number(entry.at, inline as usize)?
        };
        Some((at, each))
    }

    /// The bytes of a tag (a profile, a text, another directory's block).
    pub(super) fn raw(&self, directory: &Directory, tag: u16) -> Option<&'a [u8]> {
        let entry = directory.entry(tag)?;
        let (at, each) = self.place(entry)?;
        let (at, size) =
            (usize::try_from(at).ok()?, usize::try_from(entry.count.checked_mul(each as u64)?).ok()?);
        self.bytes.get(at..at.checked_add(size)?)
    }

    /// Value `index` of a tag of unsigned integers.
    pub(super) fn integer(&self, directory: &Directory, tag: u16, index: u64) -> Option<u64> {
        let entry = directory.entry(tag)?;
        let (at, each) = self.place(entry)?;
        let whole = matches!(entry.kind, 1 | 3 | 4 | 13 | 16 | 18);
        (whole && index < entry.count).then(|| self.number(at + index * each as u64, each))?
    }

    /// The first value of a tag of unsigned ratios or integers.
    pub(super) fn ratio(&self, directory: &Directory, tag: u16) -> Option<f64> {
        let entry = directory.entry(tag)?;
        if entry.kind != 5 {
            return self.integer(directory, tag, 0).map(|v| v as f64);
        }
        let (at, _) = self.place(entry)?;
        let (above, below) = (self.number(at, 4)?, self.number(at + 4, 4)?);
        (entry.count > 0 && below > 0).then(|| above as f64 / below as f64)
    }
}

impl Directory {
    /// The entry of a tag.
    pub(super) fn entry(&self, tag: u16) -> Option<&Entry> {
        self.entries.iter().find(|e| e.tag == tag)
    }
}

/// Tags of an EXIF block (of a JPEG, a PNG or a TIFF's own) that a gauge needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Exif {
    /// Orientation, 1 to 8; 1 where there is none.
    pub(super) orientation: Option<u64>,
    /// `ColorSpace` of the EXIF directory: 1 is sRGB, 65535 uncalibrated.
    pub(super) colour_space: Option<u64>,
}

impl Exif {
    /// Reads a block that begins with a TIFF header, after an optional `Exif\0\0`.
    pub(super) fn read(block: &[u8]) -> Self {
        let block = block.strip_prefix(b"Exif\0\0").unwrap_or(block);
        let Some(tiff) = TiffBytes::new(block) else { return Self::default() };
        let Some(directory) = tiff.directory(tiff.first) else { return Self::default() };
        Self::of(&tiff, &directory)
    }

    /// Reads a TIFF's own directory.
    pub(super) fn of(tiff: &TiffBytes<'_>, directory: &Directory) -> Self {
        let inner = tiff.integer(directory, 34_665, 0).and_then(|at| tiff.directory(at));
        Self {
            orientation: tiff.integer(directory, 274, 0),
            colour_space: inner.and_then(|inner| tiff.integer(&inner, 40_961, 0)),
        }
    }
}
