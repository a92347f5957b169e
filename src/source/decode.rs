//! Image bytes to grey frames: PNG, TIFF (8, 16 bit and f32), JPEG, BMP, PGM.
//!
//! Grey values are taken as they stand; 10-, 12- and 14-bit values stand unshifted in 16-bit files. Without further knowledge a
//! 16-bit file is 12-bit where no value exceeds 4095, else 16-bit.

use std::io::Cursor;

use image::codecs::bmp::BmpDecoder;
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use thiserror::Error;
use tiff::decoder::{Decoder, DecodingResult, Limits as TiffLimits};

use super::jpeg;
use crate::frame::{Buffer, Frame, FrameMeta, PixelFormat};

/// Most pixels of an image: 16 times the largest sensors in use, so that a few bytes cannot ask for all memory.
const MOST_PIXELS: u64 = 1 << 28;
/// Longest side of an image, px.
const LONGEST_SIDE: u32 = 65_535;

/// Why bytes are not a grey frame.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum DecodeError {
    /// No byte at all.
    #[error("the file is empty; a grey PNG, TIFF, JPEG, BMP or PGM image is needed")]
    Empty,
    /// Not an image.
    #[error("not an image in a known format; a grey PNG, TIFF, JPEG, BMP or PGM image is needed")]
    NotAnImage,
    /// An image that ends early or is damaged.
    #[error("damaged or truncated image: {0}")]
    Damaged(String),
    /// A colour image or one with transparency.
    #[error("a {0} image; one grey channel without transparency is needed")]
    NotGrey(String),
    /// An image too large to be a frame.
    #[error(
        "{columns} x {rows} pixels are more than a frame may have ({LONGEST_SIDE} a side, {MOST_PIXELS} in all)"
    )]
    TooLarge {
        /// Pixels in a row.
        columns: u32,
        /// Rows.
        rows: u32,
    },
    /// A TIFF of several pages.
    #[error("a TIFF of several pages; one frame a file is needed")]
    SeveralPages,
    /// A JPEG whose whole picture is kept as coefficients while it is decoded: three times the frame's memory.
    #[error("a progressive JPEG; save it as a baseline JPEG, or without loss as PNG, TIFF, BMP or PGM")]
    Progressive,
    /// A JPEG of few and long rows: strips of eight take more memory than the frame.
    #[error(
        "a JPEG of {columns} x {rows} pixels takes more than twice its memory to decode; save it as PNG, TIFF, BMP or PGM"
    )]
    FlatJpeg {
        /// Pixels in a row.
        columns: usize,
        /// Rows.
        rows: usize,
    },
    /// A bit depth that says not where full scale is.
    #[error("a bit depth of {0}; 8, 10, 12, 14 or 16 are needed")]
    Depth(u8),
    /// Values that the stated bit depth cannot carry.
    #[error("a grey value of {found} in a frame said to have {bits} bits")]
    BeyondDepth {
        /// Largest value.
        found: u16,
        /// Stated bit depth.
        bits: u8,
    },
}

/// Decodes one image. `bit_depth` is what is known beside the file (`frames.csv`): 8, 10, 12, 14 or 16 (16-bit files only).
///
/// # Errors
/// Refuses what is empty, no image, damaged, coloured, too large or beyond its stated bit depth.
pub fn decode(bytes: &[u8], bit_depth: Option<u8>, meta: FrameMeta) -> Result<Frame, DecodeError> {
    if bytes.is_empty() {
        return Err(DecodeError::Empty);
    }
    let format = image::guess_format(bytes).map_err(|_| DecodeError::NotAnImage)?;
    let (buffer, columns, rows) = match format {
        ImageFormat::Tiff => decode_tiff(bytes)?,
        ImageFormat::Bmp => decode_bmp(bytes)?,
        _ => decode_other(bytes, format)?,
    };
    let format = pixel_format(&buffer, bit_depth)?;
    let buffer = match buffer {
        Buffer::U16(values) if format == PixelFormat::Mono8 => {
            Buffer::U8(values.into_iter().map(|v| v as u8).collect())
        }
        buffer => buffer,
    };
    Frame::new(buffer, format, rows as usize, columns as usize, meta)
        .map_err(|e| DecodeError::Damaged(e.to_string()))
}

fn check_size(columns: u32, rows: u32) -> Result<(), DecodeError> {
    let fits = u64::from(columns) * u64::from(rows) <= MOST_PIXELS;
    if fits && columns <= LONGEST_SIDE && rows <= LONGEST_SIDE {
        Ok(())
    } else {
        Err(DecodeError::TooLarge { columns, rows })
    }
}

fn damaged(error: impl std::fmt::Display) -> DecodeError {
    DecodeError::Damaged(error.to_string())
}

fn decode_other(bytes: &[u8], format: ImageFormat) -> Result<(Buffer, u32, u32), DecodeError> {
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (columns, rows) = reader().into_dimensions().map_err(damaged)?;
    check_size(columns, rows)?;
    if format == ImageFormat::Jpeg {
        jpeg::check(bytes)?;
    }
    let mut limited = reader();
    let mut limits = Limits::default();
    limits.max_alloc = Some(16 * MOST_PIXELS);
    limited.limits(limits);
    let decoder = limited.into_decoder().map_err(damaged)?;
    // Before its pixels are unpacked: a colour image takes three to eight times the room of a grey one.
    let colour = decoder.color_type();
    if !matches!(colour, ColorType::L8 | ColorType::L16) {
        return Err(DecodeError::NotGrey(format!("{colour:?}")));
    }
    match DynamicImage::from_decoder(decoder).map_err(damaged)? {
        DynamicImage::ImageLuma8(image) => Ok((Buffer::U8(image.into_raw()), columns, rows)),
        DynamicImage::ImageLuma16(image) => Ok((Buffer::U16(image.into_raw()), columns, rows)),
        other => Err(DecodeError::NotGrey(format!("{:?}", other.color()))),
    }
}

/// A BMP has no grey of its own, but a palette whose entries may all be grey.
fn decode_bmp(bytes: &[u8]) -> Result<(Buffer, u32, u32), DecodeError> {
    let mut decoder = BmpDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
    let (columns, rows) = decoder.dimensions();
    check_size(columns, rows)?;
    let grey = |palette: &[[u8; 3]]| palette.iter().all(|c| c[0] == c[1] && c[1] == c[2]);
    let Some(levels) = decoder.get_palette().filter(|p| grey(p)).map(|p| p.iter().map(|c| c[0]).collect())
    else {
        return Err(DecodeError::NotGrey(format!("{:?}", decoder.color_type())));
    };
    let levels: Vec<u8> = levels;
    decoder.set_indexed_color(true);
    let mut pixels = vec![0; columns as usize * rows as usize];
    if decoder.total_bytes() != pixels.len() as u64 {
        return Err(DecodeError::NotGrey(format!("{:?}", decoder.color_type())));
    }
    decoder.read_image(&mut pixels).map_err(damaged)?;
    pixels.iter_mut().for_each(|p| *p = levels.get(usize::from(*p)).copied().unwrap_or(0));
    Ok((Buffer::U8(pixels), columns, rows))
}

fn decode_tiff(bytes: &[u8]) -> Result<(Buffer, u32, u32), DecodeError> {
    let mut limits = TiffLimits::default();
    limits.decoding_buffer_size = 4 * MOST_PIXELS as usize;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(damaged)?.with_limits(limits);
    let (columns, rows) = decoder.dimensions().map_err(damaged)?;
    check_size(columns, rows)?;
    let colour = decoder.colortype().map_err(damaged)?;
    if !matches!(colour, tiff::ColorType::Gray(8 | 16 | 32)) {
        return Err(DecodeError::NotGrey(format!("{colour:?}")));
    }
    if decoder.more_images() {
        return Err(DecodeError::SeveralPages);
    }
    match decoder.read_image().map_err(damaged)? {
        DecodingResult::U8(values) => Ok((Buffer::U8(values), columns, rows)),
        DecodingResult::U16(values) => Ok((Buffer::U16(values), columns, rows)),
        DecodingResult::F32(values) => Ok((Buffer::F32(values), columns, rows)),
        _ => Err(DecodeError::NotGrey("signed, 32-bit integer or 64-bit".to_owned())),
    }
}

fn pixel_format(buffer: &Buffer, bit_depth: Option<u8>) -> Result<PixelFormat, DecodeError> {
    let values = match buffer {
        Buffer::U8(_) => return Ok(PixelFormat::Mono8),
        Buffer::F32(_) => return Ok(PixelFormat::F32),
        Buffer::U16(values) => values,
    };
    let largest = values.iter().copied().max().unwrap_or(0);
    let format = match bit_depth {
        Some(8) => PixelFormat::Mono8,
        Some(10) => PixelFormat::Mono10,
        Some(12) => PixelFormat::Mono12,
        Some(14) => PixelFormat::Mono14,
        Some(16) => PixelFormat::Mono16,
        Some(other) => return Err(DecodeError::Depth(other)),
        None if largest <= 4095 => PixelFormat::Mono12,
        None => PixelFormat::Mono16,
    };
    match format.full_scale() {
        Some(full) if largest > full => {
            Err(DecodeError::BeyondDepth { found: largest, bits: format.bit_depth() })
        }
        _ => Ok(format),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(width: u32, height: u32, colour: image::ExtendedColorType, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        image::write_buffer_with_format(
            &mut Cursor::new(&mut out),
            bytes,
            width,
            height,
            colour,
            ImageFormat::Png,
        )
        .unwrap();
        out
    }

    fn refusal(bytes: &[u8]) -> DecodeError {
        decode(bytes, None, FrameMeta::default()).unwrap_err()
    }

    #[test]
    fn grey_is_taken_as_it_stands() {
        let bytes = png(2, 1, image::ExtendedColorType::L8, &[7, 200]);
        let frame = decode(&bytes, None, FrameMeta::default()).unwrap();
        assert_eq!((frame.view().get(0, 1), frame.view().format()), (Some(200.0), PixelFormat::Mono8));
        let values: Vec<u8> = [4095_u16, 3].iter().flat_map(|v| v.to_ne_bytes()).collect();
        let bytes = png(2, 1, image::ExtendedColorType::L16, &values);
        let frame = decode(&bytes, None, FrameMeta::default()).unwrap();
        assert_eq!((frame.view().get(0, 0), frame.view().format()), (Some(4095.0), PixelFormat::Mono12));
        assert!(matches!(
            decode(&bytes, Some(10), FrameMeta::default()),
            Err(DecodeError::BeyondDepth { found: 4095, bits: 10 })
        ));
        let depth = |bits| decode(&bytes, Some(bits), FrameMeta::default()).map(|f| f.view().format());
        assert_eq!(depth(14), Ok(PixelFormat::Mono14));
        assert_eq!(depth(13), Err(DecodeError::Depth(13)));
        // Full scale of eight bits is 255, whatever the container.
        let values: Vec<u8> = [255_u16, 3].iter().flat_map(|v| v.to_ne_bytes()).collect();
        let bytes = png(2, 1, image::ExtendedColorType::L16, &values);
        let frame = decode(&bytes, Some(8), FrameMeta::default()).unwrap();
        assert_eq!((frame.view().get(0, 0), frame.view().format()), (Some(255.0), PixelFormat::Mono8));
    }

    #[test]
    fn what_is_no_grey_frame_is_refused_with_its_reason() {
        assert_eq!(refusal(&[]), DecodeError::Empty);
        assert_eq!(refusal(b"hello"), DecodeError::NotAnImage);
        let colour = png(1, 1, image::ExtendedColorType::Rgb8, &[1, 2, 3]);
        assert!(matches!(refusal(&colour), DecodeError::NotGrey(_)));
        let whole = png(64, 64, image::ExtendedColorType::L8, &[9; 4096]);
        assert!(matches!(refusal(&whole[..whole.len() / 2]), DecodeError::Damaged(_)));
        assert!(matches!(refusal(&whole[..20]), DecodeError::Damaged(_)));
    }

    #[test]
    fn a_grey_palette_is_grey_and_a_coloured_one_is_not() {
        let grey: Vec<u8> = (0..70).map(|i| 3 * i).collect();
        let encoded = |palette: Option<&[[u8; 3]]>| {
            let mut out = Vec::new();
            image::codecs::bmp::BmpEncoder::new(&mut out)
                .encode_with_palette(&grey, 10, 7, image::ExtendedColorType::L8, palette)
                .unwrap();
            out
        };
        let frame = decode(&encoded(None), None, FrameMeta::default()).unwrap();
        assert_eq!((frame.view().rows(), frame.view().columns()), (7, 10));
        assert_eq!((frame.view().get(0, 1), frame.view().get(6, 9)), (Some(3.0), Some(207.0)));
        // A palette the wrong way round is still grey.
        let turned: Vec<[u8; 3]> = (0..=255).map(|i| [255 - i; 3]).collect();
        let frame = decode(&encoded(Some(&turned)), None, FrameMeta::default()).unwrap();
        assert_eq!(frame.view().get(0, 1), Some(252.0));
        let red: Vec<[u8; 3]> = (0..=255).map(|i| [255, i, i]).collect();
        assert!(matches!(refusal(&encoded(Some(&red))), DecodeError::NotGrey(_)));
    }

    #[test]
    fn a_few_bytes_cannot_ask_for_all_memory() {
        // A PNG header that claims 60000 x 60000 pixels.
        let mut bytes = png(1, 1, image::ExtendedColorType::L8, &[0]);
        bytes[16..20].copy_from_slice(&60_000_u32.to_be_bytes());
        bytes[20..24].copy_from_slice(&60_000_u32.to_be_bytes());
        assert!(matches!(refusal(&bytes), DecodeError::TooLarge { .. } | DecodeError::Damaged(_)));
    }

    #[test]
    fn a_stack_of_frames_in_one_file_is_refused() {
        let pages = |count: usize| {
            let mut out = Cursor::new(Vec::new());
            let mut encoder = tiff::encoder::TiffEncoder::new(&mut out).unwrap();
            for _ in 0..count {
                encoder.write_image::<tiff::encoder::colortype::Gray8>(3, 2, &[1, 2, 3, 4, 5, 6]).unwrap();
            }
            out.into_inner()
        };
        assert!(decode(&pages(1), None, FrameMeta::default()).is_ok());
        assert_eq!(refusal(&pages(2)), DecodeError::SeveralPages);
    }

    /// A grey JPEG whose start of frame is altered: (marker, rows, columns, sampling factors).
    fn altered_jpeg(marker: u8, rows: u16, columns: u16, sampling: u8) -> Vec<u8> {
        let mut bytes = Vec::new();
        let grey = image::GrayImage::from_pixel(16, 12, image::Luma([90]));
        grey.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Jpeg).unwrap();
        let at = bytes.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
        bytes[at + 1] = marker;
        bytes[at + 5..at + 7].copy_from_slice(&rows.to_be_bytes());
        bytes[at + 7..at + 9].copy_from_slice(&columns.to_be_bytes());
        bytes[at + 11] = sampling;
        bytes
    }

    #[test]
    fn a_jpeg_that_takes_more_than_twice_its_memory_is_refused() {
        for (marker, rows, columns, sampling) in
            [(0xc0, 12, 16, 0x11), (0xc0, 12, 16, 0x22), (0xc0, 8, 16, 0x14), (0xc0, 64, 60_000, 0x22)]
        {
            let frame =
                decode(&altered_jpeg(marker, rows, columns, sampling), None, FrameMeta::default()).unwrap();
            assert_eq!((frame.view().rows(), frame.view().columns()), (rows.into(), columns.into()));
        }
        assert_eq!(refusal(&altered_jpeg(0xc2, 12, 16, 0x11)), DecodeError::Progressive);
        for (rows, sampling) in [(1, 0x11), (12, 0x14), (12, 0x22)] {
            let refused = refusal(&altered_jpeg(0xc0, rows, 65_295, sampling));
            assert_eq!(refused, DecodeError::FlatJpeg { columns: 65_295, rows: rows.into() });
        }
    }
}
