//! The layout of raw pixels: `WIDTHxHEIGHT:FORMAT`.

use std::fmt;
use std::str::FromStr;

use super::unpack::{unpack10p, unpack12_packed, unpack12p};
use crate::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use crate::source::decode::Decoded;
use crate::source::error::{DecodeError, check_size, damaged};
use crate::source::spare::Spare;

/// Pixel formats by their names in PFNC 2.4, and Mono12Packed of GigE Vision 1.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RawFormat {
    /// A byte a pixel.
    Mono8,
    /// 10 bits in two bytes, little endian, right-aligned.
    Mono10,
    /// 12 bits in two bytes, little endian, right-aligned.
    Mono12,
    /// Two bytes, little endian.
    Mono16,
    /// Four pixels in five bytes, the least significant bit first.
    Mono10p,
    /// Two pixels in three bytes, the least significant bit first.
    Mono12p,
    /// Two pixels in three bytes: upper bits of both around a byte of their lower ones.
    Mono12Packed,
}

/// Formats by the names that the command line takes.
const FORMATS: [(&str, RawFormat); 7] = [
    ("mono8", RawFormat::Mono8),
    ("mono10", RawFormat::Mono10),
    ("mono12", RawFormat::Mono12),
    ("mono16", RawFormat::Mono16),
    ("mono10p", RawFormat::Mono10p),
    ("mono12p", RawFormat::Mono12p),
    ("mono12packed", RawFormat::Mono12Packed),
];

impl RawFormat {
    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        FORMATS.iter().find_map(|(name, format)| (*format == self).then_some(*name)).unwrap_or_default()
    }

    /// The format of unpacked pixels.
    pub(super) fn pixel_format(self) -> PixelFormat {
        match self {
            Self::Mono8 => PixelFormat::Mono8,
            Self::Mono10 | Self::Mono10p => PixelFormat::Mono10,
            Self::Mono12 | Self::Mono12p | Self::Mono12Packed => PixelFormat::Mono12,
            Self::Mono16 => PixelFormat::Mono16,
        }
    }

    /// Bits that a pixel takes among the bytes.
    fn stored_bits(self) -> u64 {
        match self {
            Self::Mono8 => 8,
            Self::Mono10p => 10,
            Self::Mono12p | Self::Mono12Packed => 12,
            Self::Mono10 | Self::Mono12 | Self::Mono16 => 16,
        }
    }
}

/// Size and pixel format of raw frames; rows follow one another without padding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RawLayout {
    columns: u32,
    rows: u32,
    format: RawFormat,
}

impl RawLayout {
    /// Frames of this size.
    ///
    /// # Errors
    /// No pixel, or more than a frame may have.
    pub(super) fn new(columns: u32, rows: u32, format: RawFormat) -> Result<Self, DecodeError> {
        if columns == 0 || rows == 0 {
            return Err(DecodeError::Unsupported(format!("{columns} x {rows} pixels; both must be above 0")));
        }
        check_size(columns, rows)?;
        Ok(Self { columns, rows, format })
    }

    /// Bytes of a frame: packed formats run on over the ends of rows, the last byte is filled up.
    pub(crate) fn bytes(&self) -> u64 {
        (self.pixels() * self.format.stored_bits()).div_ceil(8)
    }

    fn pixels(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }

    /// The frame in [`Self::bytes`] bytes, in spare memory.
    ///
    /// # Errors
    /// Fewer bytes than a frame has; values that the format does not have.
    pub(in crate::source) fn decode(
        &self,
        bytes: &[u8],
        meta: FrameMeta,
        spare: &Spare,
    ) -> Result<Decoded, DecodeError> {
        let cut = || DecodeError::Cut { had: bytes.len() as u64, needed: self.bytes() };
        let bytes = bytes.get(..self.bytes() as usize).ok_or_else(cut)?;
        let buffer = self.unpacked(bytes, spare)?;
        let format = self.format.pixel_format();
        let frame = Frame::new(buffer, format, self.rows as usize, self.columns as usize, meta);
        let sample_bytes = bytes.len();
        Ok(Decoded { frame: frame.map_err(damaged)?, scale: None, changed: Vec::new(), sample_bytes })
    }

    /// As [`Self::decode`], of memory that is given away: bytes that are pixels already stay where
    /// they are.
    ///
    /// # Errors
    /// As [`Self::decode`].
    #[cfg_attr(not(feature = "camera"), allow(dead_code, reason = "cameras give their memory away"))]
    pub(in crate::source) fn decode_owned(
        &self,
        bytes: Vec<u8>,
        meta: FrameMeta,
        spare: &Spare,
    ) -> Result<Frame, DecodeError> {
        if self.format != RawFormat::Mono8 || bytes.len() as u64 != self.bytes() {
            return self.decode(&bytes, meta, spare).map(|decoded| decoded.frame);
        }
        let (rows, columns) = (self.rows as usize, self.columns as usize);
        Frame::new(Buffer::U8(bytes), self.format.pixel_format(), rows, columns, meta).map_err(damaged)
    }

    fn unpacked(&self, bytes: &[u8], spare: &Spare) -> Result<Buffer, DecodeError> {
        let count = self.pixels() as usize;
        if self.format == RawFormat::Mono8 {
            let mut octets = spare.octets(count);
            octets.copy_from_slice(bytes);
            return Ok(Buffer::U8(octets));
        }
        let mut words = spare.words(count);
        match self.format {
            RawFormat::Mono10p => unpack10p(bytes, count, &mut words),
            RawFormat::Mono12p => unpack12p(bytes, count, &mut words),
            RawFormat::Mono12Packed => unpack12_packed(bytes, count, &mut words),
            RawFormat::Mono8 | RawFormat::Mono10 | RawFormat::Mono12 | RawFormat::Mono16 => {
                words.extend(bytes.as_chunks().0.iter().map(|pair| u16::from_le_bytes(*pair)));
                self.check_depth(&words)?;
            }
        }
        Ok(Buffer::U16(words))
    }

    /// Refuses values that the format does not have: another byte order, or left-aligned values.
    fn check_depth(&self, words: &[u16]) -> Result<(), DecodeError> {
        let most = self.format.pixel_format().full_scale().unwrap_or(u16::MAX);
        // One pass that the compiler can do in lanes; the place is looked for in a bad frame only.
        if words.iter().fold(0, |all, word| all | word) <= most {
            return Ok(());
        }
        let Some(at) = words.iter().position(|word| *word > most) else { return Ok(()) };
        let columns = self.columns as usize;
        let (row, column, format) = (at / columns, at % columns, self.format.name());
        Err(DecodeError::BeyondRaw { found: words[at], row, column, format, most })
    }
}

impl fmt::Display for RawLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}:{}", self.columns, self.rows, self.format.name())
    }
}

impl FromStr for RawLayout {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let right = "right would be WIDTHxHEIGHT:FORMAT, for instance 2448x2048:mono12";
        let (size, format) = text.split_once(':').ok_or_else(|| format!("no format; {right}"))?;
        let (columns, rows) =
            size.split_once(['x', 'X']).ok_or_else(|| format!("no size in \"{size}\"; {right}"))?;
        let side = |text: &str| {
            text.parse::<u32>().map_err(|_| format!("\"{text}\" is no number of pixels; {right}"))
        };
        let (columns, rows) = (side(columns)?, side(rows)?);
        let lower = format.to_ascii_lowercase();
        let known = FORMATS.iter().find(|(name, _)| *name == lower).map(|(_, format)| *format);
        let names = || FORMATS.map(|(name, _)| name).join(", ");
        let format = known.ok_or_else(|| format!("no pixel format \"{format}\"; there are {}", names()))?;
        Self::new(columns, rows, format).map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(layout: &str, bytes: &[u8]) -> Result<Vec<u16>, String> {
        let layout: RawLayout = layout.parse()?;
        let decoded = layout.decode(bytes, FrameMeta::default(), &Spare::default());
        match decoded.map_err(|e| e.to_string())?.frame.into_buffer() {
            Buffer::U8(octets) => Ok(octets.into_iter().map(u16::from).collect()),
            Buffer::U16(words) => Ok(words),
            Buffer::F32(_) => Err("floats".to_owned()),
        }
    }

    #[test]
    fn sizes_are_those_of_the_standard() {
        for (text, bytes) in [
            ("4x1:mono8", 4),
            ("4x1:mono10", 8),
            ("4x1:mono10p", 5),
            ("3x1:mono10p", 4),
            ("2x1:mono12p", 3),
            ("3x1:Mono12Packed", 5),
            ("2448x2048:mono12", 2448 * 2048 * 2),
            ("2448x2048:mono12p", 2448 * 2048 * 3 / 2),
        ] {
            let layout: RawLayout = text.parse().unwrap();
            assert_eq!(layout.bytes(), bytes, "{text}");
            assert_eq!(layout.to_string(), text.to_lowercase());
        }
    }

    #[test]
    fn unpacked_values_are_little_endian_and_within_their_depth() {
        assert_eq!(decoded("2x1:mono16", &[1, 2, 0xff, 0xff]), Ok(vec![0x201, 0xffff]));
        assert_eq!(decoded("2x1:mono12", &[0xff, 0x0f, 0, 1]), Ok(vec![4095, 256]));
        assert_eq!(decoded("2x1:mono8", &[7, 255]), Ok(vec![7, 255]));
        // Big endian: 0x0100 as 0x0001 00.. is within the depth only by chance; 0x0ff0 is not.
        let error = decoded("2x2:mono12", &[0, 0, 0, 0, 0, 0, 0x0f, 0xf0]).unwrap_err();
        assert!(error.contains("61455 at row 1, column 1") && error.contains("4095"), "{error}");
        assert!(decoded("1x1:mono10", &[0, 4]).unwrap_err().contains("1024"));
        assert!(decoded("2x1:mono16", &[1, 2, 3]).unwrap_err().contains("3 bytes of 4"));
    }

    #[test]
    fn memory_that_is_given_away_is_the_frame_where_bytes_are_pixels() {
        let owned = |layout: &str, bytes: &[u8]| {
            let (layout, bytes) = (layout.parse::<RawLayout>().unwrap(), bytes.to_vec());
            let place = bytes.as_ptr();
            let frame = layout.decode_owned(bytes, FrameMeta::default(), &Spare::default())?;
            let is_kept = |buffer: &Buffer| matches!(buffer, Buffer::U8(b) if b.as_ptr() == place);
            let buffer = frame.into_buffer();
            Ok::<_, DecodeError>((is_kept(&buffer), buffer))
        };
        assert_eq!(owned("2x1:mono8", &[7, 255]).unwrap(), (true, Buffer::U8(vec![7, 255])));
        assert_eq!(owned("2x1:mono8", &[7, 255, 3]).unwrap(), (false, Buffer::U8(vec![7, 255])));
        assert_eq!(owned("1x1:mono16", &[1, 2]).unwrap(), (false, Buffer::U16(vec![0x201])));
        assert!(owned("2x1:mono8", &[7]).unwrap_err().to_string().contains("1 bytes of 2"));
    }

    #[test]
    fn what_is_no_layout_is_refused_with_the_form() {
        for (text, word) in [
            ("", "2448x2048:mono12"),
            ("2448x2048", "no format"),
            ("2448:mono8", "no size"),
            ("axb:mono8", "\"a\" is no number"),
            ("0x4:mono8", "above 0"),
            ("70000x4:mono8", "may have"),
            ("4x4:rgb8", "mono12packed"),
            ("-4x4:mono8", "\"-4\""),
        ] {
            let error = text.parse::<RawLayout>().unwrap_err();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
