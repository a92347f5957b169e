//! TIFF and BigTIFF: every page, grey and palettes at 1 to 64 bits (including packed ones), signed
//! and floating point, colours.
//!
//! The `tiff` crate unpacks strips and tiles. It reads neither samples of 9 to 15 bits nor
//! palettes, so that it is given such a page under a substitute directory (behind the end of the
//! file): packed rows as rows of bytes, indices as grey.

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::{TiffError, TiffUnsupportedError};

use super::error::{DecodeError, MOST_PIXELS, check_size, damaged};
use super::ifd::{Directory, Exif, TiffBytes};
use super::packed::unpack;
use super::png::palette_values;
use super::raster::{Raster, Stated};
use super::relaid::{Relaid, Tag};
use super::scale::FileScale;
use super::transfer::Transfer;
use crate::frame::Buffer;

/// Tags that are copied for the unpacking: compression, fill order, strips, predictor, tiles, JPEG
/// tables.
const KEPT: [u16; 10] = [259, 273, 278, 279, 317, 322, 323, 324, 325, 347];

/// The layout of the samples by a page's tags.
struct Page {
    columns: u32,
    rows: u32,
    bits: u8,
    channels: u16,
    kind: Kind,
    palette: bool,
    white_is_zero: bool,
    planar: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Unsigned = 1,
    Signed = 2,
    Float = 3,
}

/// Offsets of the directories that are frames: pages, not their thumbnails or masks.
pub(super) fn pages(bytes: &[u8]) -> Vec<u64> {
    let Some(tiff) = TiffBytes::new(bytes) else { return Vec::new() };
    let all = tiff.chain();
    let frame = |at: &u64| {
        let Some(directory) = tiff.directory(*at) else { return false };
        let reduced = tiff.integer(&directory, 254, 0).is_some_and(|kind| kind & 5 != 0);
        !reduced && tiff.integer(&directory, 255, 0) != Some(2)
    };
    let frames: Vec<u64> = all.iter().copied().filter(frame).collect();
    if frames.is_empty() { all } else { frames }
}

/// Reads the page whose directory is at offset `place`.
pub(super) fn read(bytes: &[u8], place: u64) -> Result<Raster, DecodeError> {
    let tiff = TiffBytes::new(bytes).ok_or(DecodeError::NotAnImage)?;
    let directory =
        tiff.directory(place).ok_or_else(|| damaged("no directory of tags where the file says"))?;
    let page = Page::of(&tiff, &directory)?;
    let samples = page.samples(&tiff, &directory)?;
    let mut stated = page.stated(&tiff, &directory)?;
    let (samples, channels) = if page.palette {
        stated.full_scale = None;
        colours(samples, &tiff, &directory)?
    } else {
        (page.upright_grey(samples)?, page.channels as usize)
    };
    Ok(Raster {
        samples,
        columns: page.columns as usize,
        rows: page.rows as usize,
        channels,
        planar: page.planar && channels > 1,
        stated,
    })
}

fn unsupported(what: impl std::fmt::Display) -> DecodeError {
    DecodeError::Unsupported(what.to_string())
}

impl Page {
    fn of(tiff: &TiffBytes<'_>, directory: &Directory) -> Result<Self, DecodeError> {
        let first = |tag: u16| tiff.integer(directory, tag, 0);
        let side = |tag: u16, name: &str| {
            let value = first(tag).and_then(|v| u32::try_from(v).ok()).filter(|v| *v > 0);
            value.ok_or_else(|| damaged(format_args!("no {name} (tag {tag})")))
        };
        let (columns, rows) = (side(256, "width")?, side(257, "height")?);
        check_size(columns, rows)?;
        let channels = first(277).unwrap_or(1) as u16;
        let bits = first(258).unwrap_or(1);
        let same =
            (1..u64::from(channels)).all(|i| tiff.integer(directory, 258, i).is_none_or(|b| b == bits));
        if !same || !(1..=64).contains(&bits) {
            return Err(unsupported("a TIFF whose channels have different bits a sample (tag 258)"));
        }
        let kind = match first(339).unwrap_or(1) {
            1 | 4 => Kind::Unsigned,
            2 => Kind::Signed,
            3 => Kind::Float,
            other => {
                return Err(unsupported(format_args!("a TIFF of complex numbers (SampleFormat {other})")));
            }
        };
        let photometric = first(262);
        let most = if matches!(photometric, Some(2)) { 4 } else { 2 };
        match photometric {
            Some(0..=3) => {}
            None => {
                return Err(damaged("no PhotometricInterpretation (tag 262); 1 is right for grey values"));
            }
            Some(other) => {
                return Err(DecodeError::NotGrey(format!("a TIFF of colours ({})", interpretation(other))));
            }
        }
        if channels == 0 || channels > most || (photometric == Some(2) && channels < 3) {
            return Err(DecodeError::NotGrey(format!("a TIFF of {channels} samples a pixel")));
        }
        if first(266) == Some(2) {
            return Err(unsupported("bits from right to left (FillOrder 2); save with FillOrder 1"));
        }
        Ok(Self {
            columns,
            rows,
            bits: bits as u8,
            channels,
            kind,
            palette: photometric == Some(3),
            white_is_zero: photometric == Some(0),
            planar: first(284) == Some(2),
        })
    }

    /// Whether rows are decoded as bytes and unpacked here.
    fn packed(&self) -> bool {
        !matches!(self.bits, 8 | 16 | 32 | 64)
    }

    /// The samples of the file.
    fn samples(&self, tiff: &TiffBytes<'_>, directory: &Directory) -> Result<Buffer, DecodeError> {
        if self.packed() {
            return self.packed_samples(tiff, directory);
        }
        let tile_columns = tiff.integer(directory, 322, 0).and_then(|w| u32::try_from(w).ok());
        let (channels, planes) = if self.planar { (1, self.channels) } else { (self.channels, 1) };
        let Self { columns, rows, bits, kind, .. } = *self;
        unpacked(tiff, directory, &Laid { columns, rows, bits, channels, planes, kind, tile_columns })
    }

    /// Rows of packed samples, unpacked as rows of bytes first.
    fn packed_samples(&self, tiff: &TiffBytes<'_>, directory: &Directory) -> Result<Buffer, DecodeError> {
        let bits = self.bits;
        if bits > 16 || self.kind != Kind::Unsigned {
            let kind = format!("{:?}", self.kind).to_lowercase();
            return Err(unsupported(format_args!(
                "a TIFF of {kind} samples of {bits} bits; save as 8, 16 or 32 bits"
            )));
        }
        if tiff.integer(directory, 317, 0).is_some_and(|predictor| predictor != 1) {
            return Err(unsupported(format_args!(
                "{bits} bits a sample with a predictor (tag 317); save without one"
            )));
        }
        let together = if self.planar { 1 } else { u64::from(self.channels) };
        let bytes_of = |samples: u64| (samples * together * u64::from(bits)).div_ceil(8) as u32;
        let tile = tiff.integer(directory, 322, 0).filter(|w| *w <= u64::from(u32::MAX) / 64);
        if let Some(width) = tile.filter(|w| w * together * u64::from(bits) % 8 != 0) {
            return Err(unsupported(format_args!(
                "tiles of {width} samples of {bits} bits, which end within a byte"
            )));
        }
        let laid = Laid {
            columns: bytes_of(self.columns.into()),
            rows: self.rows,
            bits: 8,
            channels: 1,
            planes: if self.planar { self.channels } else { 1 },
            kind: Kind::Unsigned,
            tile_columns: tile.map(bytes_of),
        };
        let Buffer::U8(rows) = unpacked(tiff, directory, &laid)? else {
            return Err(damaged("rows that are not bytes"));
        };
        Ok(unpack(&rows, bits, self.columns as usize * together as usize))
    }

    /// Files with white as zero are inverted, so that values increase with light.
    fn upright_grey(&self, samples: Buffer) -> Result<Buffer, DecodeError> {
        if !self.white_is_zero {
            return Ok(samples);
        }
        if self.kind != Kind::Unsigned || self.bits > 16 || self.channels > 1 {
            return Err(unsupported(
                "white is zero (PhotometricInterpretation 0) in values whose full scale is not known; save with 1",
            ));
        }
        let full = ((1_u32 << self.bits) - 1) as u16;
        Ok(match samples {
            Buffer::U8(v) => Buffer::U8(v.into_iter().map(|v| full as u8 - v).collect()),
            Buffer::U16(v) => Buffer::U16(v.into_iter().map(|v| full - v).collect()),
            floats @ Buffer::F32(_) => floats,
        })
    }

    fn stated(&self, tiff: &TiffBytes<'_>, directory: &Directory) -> Result<Stated, DecodeError> {
        let full_scale = match (self.kind, self.bits) {
            (Kind::Unsigned, bits @ (1..=7 | 9..=15)) => Some(((1_u32 << bits) - 1) as f32),
            (Kind::Unsigned, bits @ (32 | 64)) => Some(2_f32.powi(bits.into())),
            (Kind::Signed, bits) => Some((2_f64.powi(i32::from(bits) - 1) - 1.0) as f32),
            _ => None,
        };
        let exif = Exif::of(tiff, directory);
        Ok(Stated {
            full_scale,
            significant_bits: None,
            wider_bytes: if self.bits == 64 {
                8 * self.columns as usize * self.rows as usize * usize::from(self.channels)
            } else {
                0
            },
            transfer: self.transfer(tiff, directory, exif)?,
            orientation: exif.orientation,
            scale: scale(tiff, directory),
            most: None,
        })
    }

    /// TransferFunction, GrayResponseCurve, an ICC profile, EXIF's colour space.
    fn transfer(
        &self,
        tiff: &TiffBytes<'_>,
        directory: &Directory,
        exif: Exif,
    ) -> Result<Option<Transfer>, DecodeError> {
        let table = |tag: u16, light: &dyn Fn(u64) -> f32| -> Result<Option<Vec<f32>>, DecodeError> {
            let Some(entry) = directory.entry(tag) else { return Ok(None) };
            let each = 1_u64 << self.bits.min(16);
            if self.kind != Kind::Unsigned
                || self.bits > 16
                || !(entry.count == each || entry.count == 3 * each)
            {
                return Err(DecodeError::Encoding(format!(
                    "tag {tag}: {} values; one for each of the {each} grey values is needed",
                    entry.count
                )));
            }
            Ok(Some((0..each).map(|i| tiff.integer(directory, tag, i).map_or(f32::NAN, light)).collect()))
        };
        let mut found = None;
        if let Some(light) = table(301, &|v| v as f32)? {
            found = Some(Transfer::of_table("TransferFunction (tag 301)", &light)?);
        }
        let unit = 10_f32.powi(tiff.integer(directory, 290, 0).unwrap_or(2).min(5) as i32);
        if let Some(mut light) = table(291, &|density| 10_f32.powf(-(density as f32) / unit))? {
            // The response curve is that of the stored values: with white as zero it is inverted as
            // well.
            if self.white_is_zero {
                light.reverse();
            }
            found = Some(Transfer::of_table("GrayResponseCurve (tag 291)", &light)?);
        }
        if found.is_none()
            && let Some(profile) = tiff.raw(directory, 34_675)
        {
            found = Some(Transfer::of_profile("ICC profile (tag 34675)", profile)?);
        }
        Ok(found.or_else(|| (exif.colour_space == Some(1)).then(|| Transfer::srgb("EXIF ColorSpace 1"))))
    }
}

/// An unsupported variant is named; any other error is damage.
fn failed(error: TiffError) -> DecodeError {
    match error {
        TiffError::UnsupportedError(TiffUnsupportedError::UnsupportedCompressionMethod(method)) => {
            unsupported(format_args!(
                "a TIFF compressed by {method:?}; save it without compression, or with LZW, Deflate or PackBits"
            ))
        }
        TiffError::UnsupportedError(what) => unsupported(format_args!("a TIFF that is not read: {what}")),
        other => damaged(other),
    }
}

fn interpretation(photometric: u64) -> String {
    match photometric {
        5 => "CMYK".to_owned(),
        6 => "YCbCr".to_owned(),
        8..=10 => "L*a*b*".to_owned(),
        32_803 => "a colour filter array".to_owned(),
        other => format!("PhotometricInterpretation {other}"),
    }
}

/// A page as given to the decoder: black is zero, channels without a meaning.
struct Laid {
    columns: u32,
    rows: u32,
    bits: u8,
    /// Number of interleaved samples per pixel.
    channels: u16,
    /// Number of separate planes.
    planes: u16,
    kind: Kind,
    tile_columns: Option<u32>,
}

impl Laid {
    /// Columns of all tiles, for LZW (compression 5), where the decoder fails on tiles that extend
    /// beyond the right edge.
    fn padded_columns(&self, compression: Option<u64>) -> u32 {
        let tile = self.tile_columns.filter(|t| *t > 0 && compression == Some(5));
        tile.and_then(|t| self.columns.checked_next_multiple_of(t)).unwrap_or(self.columns)
    }

    fn tags(&self, columns: u32) -> Vec<Tag> {
        let mut tags = vec![
            Tag::long(256, columns),
            Tag::long(257, self.rows),
            Tag::short(258, self.bits.into()),
            Tag::short(262, 1),
            Tag::short(277, self.channels),
            Tag::short(339, self.kind as u16),
        ];
        tags.extend(self.tile_columns.map(|t| Tag::long(322, t)));
        tags
    }
}

/// The page's samples, separate planes one after another.
fn unpacked(tiff: &TiffBytes<'_>, directory: &Directory, laid: &Laid) -> Result<Buffer, DecodeError> {
    let padded = laid.padded_columns(tiff.integer(directory, 259, 0));
    check_size(padded.min(laid.columns.saturating_mul(2)), laid.rows)?;
    let tags = laid.tags(padded);
    let samples = if laid.planes > 1 {
        let planes =
            (0..u64::from(laid.planes)).map(|k| plane(tiff, directory, &tags, (k, laid.planes.into())));
        planes.reduce(|all, next| joined(all?, next?)).unwrap_or_else(|| Err(damaged("no channel")))?
    } else {
        decoded(tiff, directory, tags)?
    };
    if padded == laid.columns {
        return Ok(samples);
    }
    let each = |columns: u32| columns as usize * usize::from(laid.channels);
    let (from, to) = (each(padded), each(laid.columns));
    Ok(match samples {
        Buffer::U8(v) => Buffer::U8(cropped(v, from, to)),
        Buffer::U16(v) => Buffer::U16(cropped(v, from, to)),
        Buffer::F32(v) => Buffer::F32(cropped(v, from, to)),
    })
}

/// One plane of several: its share of the strips or tiles.
fn plane(
    tiff: &TiffBytes<'_>,
    directory: &Directory,
    tags: &[Tag],
    (index, planes): (u64, u64),
) -> Result<Buffer, DecodeError> {
    let mut tags = tags.to_vec();
    for tag in [273, 279, 324, 325] {
        let Some(count) = directory.entry(tag).map(|e| e.count / planes) else { continue };
        let own = (index * count..(index + 1) * count).map(|i| tiff.integer(directory, tag, i));
        let own: Option<Vec<u64>> = own.collect();
        let own = own.ok_or_else(|| damaged(format_args!("places of strips or tiles (tag {tag})")))?;
        tags.push(Tag::places(tag, own, tiff.layout.big));
    }
    decoded(tiff, directory, tags)
}

fn joined(all: Buffer, next: Buffer) -> Result<Buffer, DecodeError> {
    match (all, next) {
        (Buffer::U8(mut a), Buffer::U8(b)) => {
            a.extend(b);
            Ok(Buffer::U8(a))
        }
        (Buffer::U16(mut a), Buffer::U16(b)) => {
            a.extend(b);
            Ok(Buffer::U16(a))
        }
        (Buffer::F32(mut a), Buffer::F32(b)) => {
            a.extend(b);
            Ok(Buffer::F32(a))
        }
        _ => Err(damaged("channels of different kinds")),
    }
}

/// The first `to` samples of every row of `from`.
fn cropped<T: Copy>(mut samples: Vec<T>, from: usize, to: usize) -> Vec<T> {
    let rows = samples.len() / from;
    for row in 1..rows {
        samples.copy_within(row * from..row * from + to, row * to);
    }
    samples.truncate(rows * to);
    samples
}

/// Samples decoded under a directory with only the necessary tags.
fn decoded(tiff: &TiffBytes<'_>, directory: &Directory, mut tags: Vec<Tag>) -> Result<Buffer, DecodeError> {
    let kept =
        directory.entries.iter().filter(|e| KEPT.contains(&e.tag) && !tags.iter().any(|t| t.tag == e.tag));
    let kept: Vec<Tag> = kept.map(Tag::kept).collect();
    tags.extend(kept);
    let relaid = Relaid::new(tiff.bytes, tiff.layout, tags);
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 4 * MOST_PIXELS as usize;
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    let mut decoder = Decoder::new(relaid).map_err(failed)?.with_limits(limits);
    let layout = decoder.image_buffer_layout().map_err(failed)?;
    if layout.complete_len > 4 * MOST_PIXELS as usize {
        return Err(unsupported(format_args!("{} bytes of samples are too many", layout.complete_len)));
    }
    let mut samples = DecodingResult::U8(Vec::new());
    decoder.read_image_to_buffer(&mut samples).map_err(failed)?;
    Ok(match samples {
        DecodingResult::U8(v) => Buffer::U8(v),
        DecodingResult::U16(v) => Buffer::U16(v),
        DecodingResult::F32(v) => Buffer::F32(v),
        DecodingResult::F16(v) => Buffer::F32(v.into_iter().map(f32::from).collect()),
        DecodingResult::F64(v) => Buffer::F32(v.into_iter().map(|v| v as f32).collect()),
        DecodingResult::U32(v) => Buffer::F32(v.into_iter().map(|v| v as f32).collect()),
        DecodingResult::U64(v) => Buffer::F32(v.into_iter().map(|v| v as f32).collect()),
        DecodingResult::I8(v) => Buffer::F32(v.into_iter().map(f32::from).collect()),
        DecodingResult::I16(v) => Buffer::F32(v.into_iter().map(f32::from).collect()),
        DecodingResult::I32(v) => Buffer::F32(v.into_iter().map(|v| v as f32).collect()),
        DecodingResult::I64(v) => Buffer::F32(v.into_iter().map(|v| v as f32).collect()),
    })
}

/// A palette (tag 320: all reds, all greens, all blues): 16-bit colours, or 8-bit ones where the
/// writer used only eight bits.
fn colours(
    indices: Buffer,
    tiff: &TiffBytes<'_>,
    directory: &Directory,
) -> Result<(Buffer, usize), DecodeError> {
    let Buffer::U8(indices) = indices else {
        return Err(unsupported("a palette of more than 256 colours"));
    };
    let each = directory.entry(320).map_or(0, |e| e.count / 3);
    let colour = |i: u64| [0, 1, 2].map(|c| tiff.integer(directory, 320, c * each + i).unwrap_or(0) as u16);
    let colours: Vec<[u16; 3]> = (0..each.min(256)).map(colour).collect();
    let all = || colours.iter().flatten();
    let wide = ![257, 256].iter().any(|step| all().all(|v| v % step == 0)) && all().any(|v| *v > 255);
    if wide {
        return palette_values(indices, &colours).map(|(values, channels)| (Buffer::U16(values), channels));
    }
    // Some writers store 8-bit colours in the lower byte.
    let low = all().all(|v| *v < 256);
    let narrow = |v: u16| if low { v as u8 } else { (v >> 8) as u8 };
    let colours: Vec<[u8; 3]> = colours.iter().map(|c| c.map(narrow)).collect();
    palette_values(indices, &colours).map(|(values, channels)| (Buffer::U8(values), channels))
}

/// Pixels per unit (tags 282, 283, 296); ImageJ's unit is in its description.
fn scale(tiff: &TiffBytes<'_>, directory: &Directory) -> Option<FileScale> {
    let (x, y) = (tiff.ratio(directory, 282)?, tiff.ratio(directory, 283)?);
    let text = tiff.raw(directory, 270).map(String::from_utf8_lossy).unwrap_or_default();
    let described =
        text.starts_with("ImageJ=").then(|| text.lines().find_map(|l| l.strip_prefix("unit="))).flatten();
    let (unit_um, unit) = match (described.map(|u| u.trim_end_matches('\0')), tiff.integer(directory, 296, 0))
    {
        (Some("micron" | "um" | "µm" | "\\u00B5m"), _) => (1.0, "µm"),
        (Some("mm"), _) => (1e3, "mm"),
        (Some("cm"), _) | (None, Some(3)) => (1e4, "cm"),
        (Some("inch"), _) | (None, None | Some(2)) => (25_400.0, "inch"),
        _ => return None,
    };
    // A ratio of 1 is a placeholder, not a resolution.
    if x == 1.0 && y == 1.0 && described.is_none() {
        return None;
    }
    FileScale::of_density([x, y], false, unit_um, format!("TIFF resolution {x:.6} x {y:.6} px/{unit}"))
}
