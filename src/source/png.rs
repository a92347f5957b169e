//! PNG: grey and palettes at 1 to 16 bits, colours, with the statements of its chunks (PNG, third
//! edition, 2025).

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, Limits, Reader};

use super::error::{DecodeError, check_size, damaged};
use super::ifd::Exif;
use super::packed::unpack;
use super::raster::{Raster, Stated};
use super::scale::FileScale;
use super::spare::Spare;
use super::transfer::Transfer;
use crate::frame::Buffer;

/// Memory limit for profiles and palettes while a PNG is read, bytes.
const CHUNKS: usize = 256 << 10;
/// A metre, µm.
const METRE_UM: f64 = 1e6;

/// Reads the image, its samples into spare memory.
pub(super) fn read(bytes: &[u8], spare: &Spare) -> Result<Raster, DecodeError> {
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    let info = decoder.read_header_info().map_err(damaged)?;
    let (columns, rows) = (info.width, info.height);
    check_size(columns, rows)?;
    let row_bytes = info.raw_row_length();
    decoder.set_limits(Limits { bytes: CHUNKS + 4 * row_bytes });
    let mut reader = decoder.read_info().map_err(damaged)?;
    if reader.info().is_animated() {
        return Err(DecodeError::Unsupported("an animated PNG; save each frame as a file".to_owned()));
    }
    let size = reader.output_buffer_size().ok_or(DecodeError::TooLarge { columns, rows })?;
    let mut most = None;
    let samples = match reader.info().bit_depth {
        BitDepth::Sixteen if !reader.info().interlaced => {
            let (words, found) = words(&mut reader, spare.words(size / 2))?;
            most = Some(found);
            Buffer::U16(words)
        }
        BitDepth::Sixteen => {
            let mut words = vec![0_u16; size / 2];
            reader.next_frame(bytemuck::cast_slice_mut(&mut words)).map_err(damaged)?;
            words.iter_mut().for_each(|w| *w = u16::from_be(*w));
            Buffer::U16(words)
        }
        depth => {
            let mut packed = spare.octets(size);
            reader.next_frame(&mut packed).map_err(damaged)?;
            let row_samples = columns as usize * reader.info().color_type.samples();
            if depth == BitDepth::Eight {
                Buffer::U8(packed)
            } else {
                unpack(&packed, depth as u8, row_samples)
            }
        }
    };
    let info = reader.info();
    let (columns, rows) = (columns as usize, rows as usize);
    let colour = info.color_type;
    let mut stated = Stated { most, ..stated(bytes, info)? };
    let (samples, channels) = if colour == ColorType::Indexed {
        stated.full_scale = None;
        stated.significant_bits = None;
        let palette = Palette { colours: info.palette.as_deref(), opacity: info.trns.as_deref() };
        palette.look_up(samples)?
    } else {
        opaque(&samples, colour.samples(), info.trns.as_deref(), columns)?;
        (samples, colour.samples())
    };
    Ok(Raster { samples, columns, rows, channels, planar: false, stated })
}

/// The data of a chunk; `None` where the file ends before it.
fn chunk<'a>(bytes: &'a [u8], name: &[u8; 4]) -> Option<&'a [u8]> {
    let mut rest = bytes.get(8..)?;
    loop {
        let size = u32::from_be_bytes(rest.get(..4)?.try_into().ok()?) as usize;
        let data = rest.get(8..8_usize.checked_add(size)?)?;
        if rest.get(4..8)? == name {
            return Some(data);
        }
        rest = rest.get(size.checked_add(12)?..)?;
    }
}

fn stated(bytes: &[u8], info: &png::Info<'_>) -> Result<Stated, DecodeError> {
    let depth = info.bit_depth as u8;
    let exif = chunk(bytes, b"eXIf").map(Exif::read).unwrap_or_default();
    let bits = info.sbit.as_deref().and_then(|bits| {
        let of_colour = bits.get(..if info.color_type.samples() < 3 { 1 } else { 3 })?;
        of_colour.iter().all(|b| *b == of_colour[0]).then_some(of_colour[0])
    });
    Ok(Stated {
        full_scale: (depth < 8).then(|| f32::from((1_u8 << depth) - 1)),
        significant_bits: bits.filter(|b| *b < depth),
        transfer: transfer(bytes, info, exif)?,
        orientation: exif.orientation,
        scale: scale(bytes),
        ..Stated::default()
    })
}

/// The 16-bit samples, in empty memory, and the largest of them: row by row, while a row is in the
/// cache.
fn words(reader: &mut Reader<Cursor<&[u8]>>, mut words: Vec<u16>) -> Result<(Vec<u16>, u16), DecodeError> {
    let columns = reader.info().width;
    let row_bytes = reader.output_line_size(columns).ok_or_else(|| damaged("a row without an end"))?;
    let (mut row, mut most) = (vec![0; row_bytes], 0);
    while reader.read_row(&mut row).map_err(damaged)?.is_some() {
        let begins = words.len();
        words.extend(row.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])));
        most = words[begins..].iter().copied().fold(most, u16::max);
    }
    Ok((words, most))
}

/// `cICP` before `iCCP` before `sRGB` before `gAMA` (PNG 13.13.2), and EXIF's colour space after
/// them.
fn transfer(bytes: &[u8], info: &png::Info<'_>, exif: Exif) -> Result<Option<Transfer>, DecodeError> {
    if let Some(code) = chunk(bytes, b"cICP").and_then(|c| c.try_into().ok())
        && let Some(transfer) = Transfer::of_cicp(code)?
    {
        return Ok(Some(transfer));
    }
    if chunk(bytes, b"iCCP").is_some() {
        return match info.icc_profile.as_deref() {
            Some(profile) => Transfer::of_profile("iCCP", profile).map(Some),
            None => Err(DecodeError::Encoding(
                "iCCP: a profile that cannot be read; remove it where grey values are linear".to_owned(),
            )),
        };
    }
    if chunk(bytes, b"sRGB").is_some() {
        return Ok(Some(Transfer::srgb("sRGB")));
    }
    if let Some(scaled) = chunk(bytes, b"gAMA").and_then(|c| c.try_into().ok()) {
        return Transfer::of_gama(u32::from_be_bytes(scaled)).map(Some);
    }
    Ok((exif.colour_space == Some(1)).then(|| Transfer::srgb("EXIF ColorSpace 1")))
}

fn scale(bytes: &[u8]) -> Option<FileScale> {
    let data: &[u8; 9] = chunk(bytes, b"pHYs")?.try_into().ok()?;
    let [x, y] = [0, 4].map(|i| u32::from_be_bytes([data[i], data[i + 1], data[i + 2], data[i + 3]]));
    let metre = data[8] == 1;
    metre.then(|| {
        FileScale::of_density([x.into(), y.into()], true, METRE_UM, format!("pHYs {x} x {y} px/m"))
    })?
}

/// Refuses an image with pixels of the colour or grey value that is declared transparent.
fn opaque(samples: &Buffer, channels: usize, key: Option<&[u8]>, columns: usize) -> Result<(), DecodeError> {
    let Some(key) = key.filter(|key| key.len() == 2 * channels) else { return Ok(()) };
    let key: Vec<u16> = key.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect();
    let found = match samples {
        Buffer::U8(v) => {
            v.chunks_exact(channels).position(|p| p.iter().map(|v| u16::from(*v)).eq(key.iter().copied()))
        }
        Buffer::U16(v) => v.chunks_exact(channels).position(|p| p == key),
        Buffer::F32(_) => None,
    };
    match found {
        Some(pixel) => Err(DecodeError::Transparent { row: pixel / columns, column: pixel % columns }),
        None => Ok(()),
    }
}

/// Colours and opacities of a palette.
struct Palette<'a> {
    colours: Option<&'a [u8]>,
    opacity: Option<&'a [u8]>,
}

impl Palette<'_> {
    /// Grey values where all colours in use are grey, otherwise the three channels.
    fn look_up(&self, indices: Buffer) -> Result<(Buffer, usize), DecodeError> {
        let Buffer::U8(indices) = indices else {
            return Err(DecodeError::Damaged("a palette of 16-bit indices".to_owned()));
        };
        let colours: Vec<[u8; 3]> =
            self.colours.unwrap_or(&[]).chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        let clear = |i: &u8| self.opacity.and_then(|o| o.get(usize::from(*i))).is_some_and(|o| *o < 255);
        if indices.iter().any(clear) {
            return Err(DecodeError::Transparent { row: 0, column: 0 });
        }
        palette_values(indices, &colours).map(|(values, channels)| (Buffer::U8(values), channels))
    }
}

/// Values of the indices: one channel where all colours in use are grey, otherwise three.
///
/// # Errors
/// An index beyond the palette.
pub(super) fn palette_values<T: Copy + PartialEq + Default>(
    indices: Vec<u8>,
    colours: &[[T; 3]],
) -> Result<(Vec<T>, usize), DecodeError> {
    let mut used = [false; 256];
    indices.iter().for_each(|i| used[usize::from(*i)] = true);
    let mut in_use = (0..256).filter(|i| used[*i]);
    if let Some(index) = in_use.clone().find(|i| *i >= colours.len()) {
        let entries = colours.len();
        return Err(DecodeError::Damaged(format!(
            "palette index {index}; the palette has {entries} entries"
        )));
    }
    let grey = in_use.all(|i| colours[i][0] == colours[i][1] && colours[i][1] == colours[i][2]);
    let of = |i: u8| colours[usize::from(i)];
    Ok(if grey {
        (indices.into_iter().map(|i| of(i)[0]).collect(), 1)
    } else {
        (indices.into_iter().flat_map(of).collect(), 3)
    })
}
