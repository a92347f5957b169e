//! PGM, PPM, PBM (plain and raw), PAM and PFM, as the Netpbm manual pages define them: grey values
//! unchanged, `maxval` as full scale.

use super::error::{DecodeError, check_size, damaged};
use super::packed::unpack;
use super::raster::{Raster, Stated};
use crate::frame::Buffer;

/// The header before the samples.
struct Header {
    columns: usize,
    rows: usize,
    channels: usize,
    maxval: u32,
    little_endian: bool,
}

/// Offsets at which the images of a file begin: raw ones may follow one another.
pub(super) fn pages(bytes: &[u8]) -> Vec<u64> {
    let mut starts = vec![0];
    let mut at = 0;
    while let Some(end) = bytes.get(at..).and_then(end) {
        at += end;
        let gap = bytes[at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        if !bytes.get(at + gap..).is_some_and(begins) {
            break;
        }
        at += gap;
        starts.push(at as u64);
    }
    starts
}

/// Whether an image begins here.
pub(super) fn begins(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'1'..=b'7' | b'f' | b'F', next, ..] if next.is_ascii_whitespace() || *next == b'#')
}

/// Offset of the end of the first image, if it is a raw one.
fn end(bytes: &[u8]) -> Option<usize> {
    length(bytes).filter(|end| *end <= bytes.len())
}

/// Length of the raw image whose header begins here, whether or not its pixels are there; `None` as
/// long as the header is not whole, and of plain images, whose digits state none.
pub(super) fn length(bytes: &[u8]) -> Option<usize> {
    let mut words = Words { bytes, at: 2 };
    let kind = *bytes.get(1)?;
    let header = Header::of(kind, &mut words).ok()?;
    let row_samples = header.columns * header.channels;
    let row_bytes = match kind {
        b'1'..=b'3' => return None,
        b'4' => header.columns.div_ceil(8),
        b'f' | b'F' => 4 * row_samples,
        _ => row_samples * if header.maxval < 256 { 1 } else { 2 },
    };
    // The white space that ends the header is part of it.
    (words.at <= bytes.len()).then_some(words.at + row_bytes * header.rows)
}

/// Reads the image that begins with `P1` to `P7`, `Pf` or `PF`.
pub(super) fn read(bytes: &[u8]) -> Result<Raster, DecodeError> {
    let mut words = Words { bytes, at: 2 };
    let kind = *bytes.get(1).ok_or(DecodeError::NotAnImage)?;
    let header = Header::of(kind, &mut words)?;
    match kind {
        b'1' => bitmap_digits(&words, &header),
        b'2' | b'3' => plain(words, &header),
        b'4' => bitmap_bits(&words, &header),
        b'f' | b'F' => float_map(&words, &header),
        _ => raw(&words, &header),
    }
}

impl Header {
    /// Reads it, with the single white space that separates it from raw pixels.
    fn of(kind: u8, words: &mut Words<'_>) -> Result<Self, DecodeError> {
        let this = match kind {
            b'7' => pam_header(words)?,
            b'f' | b'F' => {
                let (columns, rows) = (words.number("width")?, words.number("height")?);
                let scale =
                    words.word().and_then(|w| std::str::from_utf8(w).ok()).and_then(|w| w.parse().ok());
                let scale: Option<f32> = scale.filter(|s: &f32| s.is_finite() && *s != 0.0);
                let scale = scale.ok_or_else(|| damaged("a PFM without its scale"))?;
                let channels = if kind == b'F' { 3 } else { 1 };
                Self { little_endian: scale < 0.0, ..header(columns, rows, channels, 1)? }
            }
            b'1'..=b'6' => {
                let (columns, rows) = (words.number("width")?, words.number("height")?);
                let maxval = if matches!(kind, b'1' | b'4') { 1 } else { words.number("maxval")? };
                header(columns, rows, if matches!(kind, b'3' | b'6') { 3 } else { 1 }, maxval)?
            }
            _ => return Err(DecodeError::NotAnImage),
        };
        if !matches!(kind, b'1'..=b'3') {
            words.at += 1;
        }
        Ok(this)
    }
}

fn header(columns: u32, rows: u32, channels: u32, maxval: u32) -> Result<Header, DecodeError> {
    check_size(columns, rows)?;
    if columns == 0 || rows == 0 {
        return Err(DecodeError::Damaged(format!("{columns} x {rows} pixels")));
    }
    if !(1..=65_535).contains(&maxval) {
        return Err(DecodeError::Damaged(format!("maxval {maxval}; it lies from 1 to 65535")));
    }
    let (columns, rows, channels) = (columns as usize, rows as usize, channels as usize);
    Ok(Header { columns, rows, channels, maxval, little_endian: false })
}

/// `P7`: lines of a key and a value to `ENDHDR`.
fn pam_header(words: &mut Words<'_>) -> Result<Header, DecodeError> {
    let [mut width, mut height, mut depth, mut maxval] = [None; 4];
    loop {
        match words.word().ok_or_else(|| damaged("a PAM without ENDHDR"))? {
            b"WIDTH" => width = Some(words.number("WIDTH")?),
            b"HEIGHT" => height = Some(words.number("HEIGHT")?),
            b"DEPTH" => depth = Some(words.number("DEPTH")?),
            b"MAXVAL" => maxval = Some(words.number("MAXVAL")?),
            b"TUPLTYPE" => {
                words.word();
            }
            b"ENDHDR" => break,
            other => {
                let key = String::from_utf8_lossy(other).into_owned();
                return Err(DecodeError::Damaged(format!("a PAM with an unknown key {key}")));
            }
        }
    }
    let (Some(width), Some(height), Some(depth), Some(maxval)) = (width, height, depth, maxval) else {
        return Err(damaged("a PAM without WIDTH, HEIGHT, DEPTH or MAXVAL"));
    };
    if !(1..=4).contains(&depth) {
        return Err(DecodeError::NotGrey(format!("a PAM of {depth} channels")));
    }
    header(width, height, depth, maxval)
}

fn raster(samples: Buffer, header: &Header) -> Raster {
    let own = match samples {
        Buffer::U8(_) => 255,
        _ => 0,
    };
    let full_scale = (header.maxval != own).then_some(header.maxval as f32);
    let stated = Stated { full_scale, ..Stated::default() };
    let Header { columns, rows, channels, .. } = *header;
    Raster { samples, columns, rows, channels, planar: false, stated }
}

/// One byte per sample up to a maxval of 255, otherwise two, the upper one first.
fn raw(words: &Words<'_>, header: &Header) -> Result<Raster, DecodeError> {
    let each = if header.maxval < 256 { 1 } else { 2 };
    let data = words.data(header.columns * header.rows * header.channels * each)?;
    let samples = if each == 1 {
        Buffer::U8(data.to_vec())
    } else {
        Buffer::U16(data.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect())
    };
    check_values(&samples, header.maxval)?;
    Ok(raster(opaque_alpha(samples, header), header))
}

/// Alpha is opaque at maxval, which is replaced by the container's maximum.
fn opaque_alpha(samples: Buffer, header: &Header) -> Buffer {
    let last = header.channels - 1;
    let (channels, most) = (header.channels, header.maxval);
    if channels != 2 && channels != 4 {
        return samples;
    }
    match samples {
        Buffer::U8(mut v) => {
            let opaque = v.iter_mut().skip(last).step_by(channels).filter(|a| u32::from(**a) == most);
            opaque.for_each(|a| *a = u8::MAX);
            Buffer::U8(v)
        }
        Buffer::U16(mut v) => {
            let opaque = v.iter_mut().skip(last).step_by(channels).filter(|a| u32::from(**a) == most);
            opaque.for_each(|a| *a = u16::MAX);
            Buffer::U16(v)
        }
        floats @ Buffer::F32(_) => floats,
    }
}

fn check_values(samples: &Buffer, maxval: u32) -> Result<(), DecodeError> {
    let most = match samples {
        Buffer::U8(v) => v.iter().copied().max().map_or(0, u32::from),
        Buffer::U16(v) => v.iter().copied().max().map_or(0, u32::from),
        Buffer::F32(_) => 0,
    };
    if most > maxval {
        return Err(DecodeError::Damaged(format!("a grey value of {most} above the file's maxval {maxval}")));
    }
    Ok(())
}

fn plain(mut words: Words<'_>, header: &Header) -> Result<Raster, DecodeError> {
    let count = header.columns * header.rows * header.channels;
    // Each needs a digit and a space: a shorter file is truncated.
    words.data(2 * count - 1)?;
    let samples = if header.maxval < 256 {
        let mut values = Vec::with_capacity(count);
        for _ in 0..count {
            values.push(words.sample(header.maxval)? as u8);
        }
        Buffer::U8(values)
    } else {
        let mut values = Vec::with_capacity(count);
        for _ in 0..count {
            values.push(words.sample(header.maxval)? as u16);
        }
        Buffer::U16(values)
    };
    Ok(raster(samples, header))
}

/// Plain bitmap: digits, 1 is black.
fn bitmap_digits(words: &Words<'_>, header: &Header) -> Result<Raster, DecodeError> {
    let count = header.columns * header.rows;
    words.data(count)?;
    let digits = words.bytes[words.at..].iter().filter(|b| !b.is_ascii_whitespace()).take(count);
    let values: Vec<u8> = digits.map(|b| u8::from(*b == b'0')).collect();
    if values.len() < count {
        return Err(damaged(format_args!("{} of {count} pixels", values.len())));
    }
    Ok(raster(Buffer::U8(values), header))
}

/// Raw bitmap: eight pixels per byte, 1 is black.
fn bitmap_bits(words: &Words<'_>, header: &Header) -> Result<Raster, DecodeError> {
    let data = words.data(header.columns.div_ceil(8) * header.rows)?;
    let samples = match unpack(data, 1, header.columns) {
        Buffer::U8(bits) => Buffer::U8(bits.into_iter().map(|b| 1 - b).collect()),
        other => other,
    };
    Ok(raster(samples, header))
}

/// PFM: 32-bit floats, the lowest row first, little-endian where the scale is negative.
fn float_map(words: &Words<'_>, header: &Header) -> Result<Raster, DecodeError> {
    let row_bytes = 4 * header.columns * header.channels;
    let data = words.data(row_bytes * header.rows)?;
    let number: fn([u8; 4]) -> f32 =
        if header.little_endian { f32::from_le_bytes } else { f32::from_be_bytes };
    let rows = data.chunks_exact(row_bytes).rev().flat_map(|row| row.chunks_exact(4));
    let samples = Buffer::F32(rows.map(|b| number([b[0], b[1], b[2], b[3]])).collect());
    let Header { columns, rows, channels, .. } = *header;
    Ok(Raster { samples, columns, rows, channels, planar: false, stated: Stated::default() })
}

/// Words between white space; `#` starts a comment to the end of its line.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Words<'a> {
    fn word(&mut self) -> Option<&'a [u8]> {
        loop {
            match *self.bytes.get(self.at)? {
                b'#' => {
                    while !matches!(self.bytes.get(self.at), None | Some(b'\n' | b'\r')) {
                        self.at += 1;
                    }
                }
                b if b.is_ascii_whitespace() => self.at += 1,
                _ => break,
            }
        }
        let start = self.at;
        while self.bytes.get(self.at).is_some_and(|b| !b.is_ascii_whitespace() && *b != b'#') {
            self.at += 1;
        }
        Some(&self.bytes[start..self.at])
    }

    fn number(&mut self, what: &str) -> Result<u32, DecodeError> {
        let word = self.word().and_then(|w| std::str::from_utf8(w).ok()).and_then(|w| w.parse().ok());
        word.ok_or_else(|| damaged(format_args!("no number for {what} in its header")))
    }

    fn sample(&mut self, maxval: u32) -> Result<u32, DecodeError> {
        let value = self.number("a pixel")?;
        if value > maxval {
            return Err(damaged(format_args!("a grey value of {value} above the file's maxval {maxval}")));
        }
        Ok(value)
    }

    /// The following `size` bytes.
    fn data(&self, size: usize) -> Result<&'a [u8], DecodeError> {
        let rest = self.bytes.get(self.at..).unwrap_or(&[]);
        rest.get(..size).ok_or_else(|| damaged(format_args!("{} of {size} bytes of pixels", rest.len())))
    }
}
