//! JPEG: grey and three channels, sequential, in strips that take less memory than the frame.
//!
//! JFIF (T.871) does not define how light is encoded: grey values of a JPEG without an ICC profile
//! and without EXIF's colour space are not changed. Photographic cameras write sRGB with its tag;
//! machine-vision cameras write linear values unless their gamma was set.

use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;
use zune_jpeg::{ImageInfo, JpegDecoder, SampleRatios};

use super::error::{DecodeError, check_size};
use super::ifd::Exif;
use super::raster::{Raster, Stated};
use super::scale::FileScale;
use super::transfer::Transfer;
use crate::frame::Buffer;

/// Memory of a strip of 8 rows, bytes per column: 16-bit samples.
const STRIP: usize = 16;
/// The same where the single channel declares sampling factors above 1, with memory for upsampled
/// rows.
const SAMPLED_STRIP: usize = 64;
/// Strips up to this many bytes are decoded however small the frame.
const SMALL_STRIP: usize = 256 << 10;

/// Reads the image.
pub(super) fn read(bytes: &[u8]) -> Result<Raster, DecodeError> {
    let longest = usize::from(u16::MAX);
    let options = DecoderOptions::default().set_strict_mode(false);
    let options = options.set_max_width(longest).set_max_height(longest);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(damaged)?;
    let info = decoder.info().ok_or_else(|| DecodeError::Damaged("no start of frame".to_owned()))?;
    check_size(info.width.into(), info.height.into())?;
    let (columns, rows) = (usize::from(info.width), usize::from(info.height));
    let (channels, space) = match info.components {
        1 => (1, ColorSpace::Luma),
        3 => (3, ColorSpace::RGB),
        n => return Err(DecodeError::NotGrey(format!("a JPEG of {n} channels"))),
    };
    check_memory(&info, channels)?;
    decoder.set_options(options.jpeg_set_out_colorspace(space));
    let mut samples = vec![0; columns * rows * channels];
    decoder.decode_into(&mut samples).map_err(damaged)?;
    let exif = decoder.exif().map(|block| Exif::read(block)).unwrap_or_default();
    let transfer = match decoder.icc_profile() {
        Some(profile) => Some(Transfer::of_profile("ICC profile", &profile)?),
        None => (exif.colour_space == Some(1)).then(|| Transfer::srgb("EXIF ColorSpace 1")),
    };
    let stated = Stated { transfer, orientation: exif.orientation, scale: scale(bytes), ..Stated::default() };
    Ok(Raster { samples: Buffer::U8(samples), columns, rows, channels, planar: false, stated })
}

fn damaged(error: impl std::fmt::Debug) -> DecodeError {
    DecodeError::Damaged(format!("{error:?}"))
}

/// Refuses an image that needs more memory for decoding than twice its own size.
fn check_memory(info: &ImageInfo, channels: usize) -> Result<(), DecodeError> {
    if info.sof.is_progressive() {
        return Err(DecodeError::Progressive);
    }
    let (columns, rows) = (usize::from(info.width), usize::from(info.height));
    if channels * strip_bytes(info) > channels * columns * rows + SMALL_STRIP {
        return Err(DecodeError::FlatJpeg { columns, rows });
    }
    Ok(())
}

fn strip_bytes(info: &ImageInfo) -> usize {
    let a_column = if matches!(info.sample_ratio, SampleRatios::None) { STRIP } else { SAMPLED_STRIP };
    a_column * usize::from(info.width).next_multiple_of(32)
}

/// JFIF's density in its own segment (T.871 10.1): 1 is dots per inch, 2 dots per centimetre, 0 an
/// aspect ratio only.
fn scale(bytes: &[u8]) -> Option<FileScale> {
    let [unit, density @ ..] = jfif(bytes)?;
    let (unit_um, name) = match unit {
        1 => (25_400.0, "inch"),
        2 => (1e4, "cm"),
        _ => return None,
    };
    let [x, y] = [0, 2].map(|i| u16::from_be_bytes([density[i], density[i + 1]]));
    FileScale::of_density([x.into(), y.into()], true, unit_um, format!("JFIF {x} x {y} px/{name}"))
}

/// Unit and densities of the JFIF segment, which is among the first.
fn jfif(bytes: &[u8]) -> Option<&[u8; 5]> {
    let mut rest = bytes.get(2..)?;
    while let [0xff, marker @ 0xe0..=0xef, high, low, ..] = rest {
        let size = usize::from(u16::from_be_bytes([*high, *low]));
        let data = rest.get(4..size.checked_add(2)?)?;
        if *marker == 0xe0 && data.starts_with(b"JFIF\0") {
            return data.get(7..12)?.try_into().ok();
        }
        rest = rest.get(size + 2..)?;
    }
    None
}
