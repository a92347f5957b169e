//! Image bytes to grey frames: PNG, TIFF and BigTIFF, JPEG, BMP, PGM and its kin.
//!
//! Grey values are not changed; 10-, 12- and 14-bit values are unshifted in 16-bit files. Encoded
//! values become proportional to the light (`transfer`), rotated images upright (`orientation`).
//! Without further information a 16-bit file is 12-bit where no value exceeds 4095, otherwise
//! 16-bit. Memory: the file's samples, unpacked, and the frame.

use super::error::{DecodeError, damaged};
use super::raster::{Channel, Raster};
use super::scale::FileScale;
use super::spare::Spare;
use super::{bmp, depth, jpeg, orientation, png, pnm, tiff};
use crate::frame::{Frame, FrameMeta, PixelFormat};

/// Options for decoding an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Bits of a grey value (`frames.csv`): 8, 10, 12, 14 or 16.
    pub bit_depth: Option<u8>,
    /// Channel of a colour image; without it all three must be equal.
    pub channel: Option<Channel>,
    /// Where the frame begins, one of `pages`; `None` is the first.
    pub place: Option<u64>,
}

/// A frame and what its file's own tags state.
#[derive(Clone, Debug, PartialEq)]
pub struct Decoded {
    /// The frame: upright, its grey values proportional to the light.
    pub frame: Frame,
    /// The scale of the file's own tags.
    pub scale: Option<FileScale>,
    /// Changes made to the values of the file, in words.
    pub changed: Vec<String>,
    /// Bytes that the file's samples occupied while they were read.
    pub sample_bytes: usize,
}

/// Formats by their first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Tiff,
    Jpeg,
    Bmp,
    Pnm,
}

fn format(bytes: &[u8]) -> Option<Format> {
    match bytes {
        [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Some(Format::Png),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Format::Tiff),
        [0xff, 0xd8, 0xff, ..] => Some(Format::Jpeg),
        [b'B', b'M', ..] => Some(Format::Bmp),
        _ if pnm::begins(bytes) => Some(Format::Pnm),
        _ => None,
    }
}

/// Offsets at which the frames of a file begin, for [`Wanted::place`]: the pages of a TIFF without
/// thumbnails and masks, the images of a PGM stream; one place in every other file.
pub(crate) fn pages(bytes: &[u8]) -> Vec<u64> {
    let places = match format(bytes) {
        Some(Format::Tiff) => tiff::pages(bytes),
        Some(Format::Pnm) => pnm::pages(bytes),
        _ => Vec::new(),
    };
    if places.is_empty() { vec![0] } else { places }
}

/// The first frame of an image, in grey. `bit_depth` is that of `frames.csv`.
///
/// # Errors
/// As [`decode_wanted`].
pub fn decode(bytes: &[u8], bit_depth: Option<u8>, meta: FrameMeta) -> Result<Frame, DecodeError> {
    let wanted = Wanted { bit_depth, ..Wanted::default() };
    decode_wanted(bytes, &wanted, meta).map(|decoded| decoded.frame)
}

/// Decodes one frame of an image.
///
/// # Errors
/// Refuses files that are empty, not an image, damaged, coloured without a chosen channel,
/// transparent, encoded in an unsupported way, too large, or with values beyond the stated bit
/// depth.
pub fn decode_wanted(bytes: &[u8], wanted: &Wanted, meta: FrameMeta) -> Result<Decoded, DecodeError> {
    decode_into(bytes, wanted, meta, &Spare::default())
}

/// As [`decode_wanted`], in spare memory where the format's reader takes some.
///
/// # Errors
/// As [`decode_wanted`].
pub(super) fn decode_into(
    bytes: &[u8],
    wanted: &Wanted,
    meta: FrameMeta,
    spare: &Spare,
) -> Result<Decoded, DecodeError> {
    if bytes.is_empty() {
        return Err(DecodeError::Empty);
    }
    let format = format(bytes).ok_or(DecodeError::NotAnImage)?;
    let raster = read(bytes, format, wanted.place, spare)?;
    let (columns, rows, sample_bytes) = (raster.columns, raster.rows, raster.sample_bytes());
    let channel = wanted.channel.filter(|_| raster.channels >= 3);
    let (values, stated) = raster.grey(wanted.channel)?;
    let sample_bytes = sample_bytes.max(stated.wider_bytes);
    let settled = depth::settle(values, wanted.bit_depth, &stated)?;
    let depth::Depth { mut buffer, format: mut pixel_format, mut full_scale } = settled;
    let mut meta = meta;
    let mut changed: Vec<String> =
        channel.map(|c| format!("of red, green and blue {} is measured", c.name())).into_iter().collect();
    match &stated.transfer {
        Some(transfer) if !transfer.encoding().is_linear() => {
            let full = full_scale.or_else(|| pixel_format.full_scale().map(f32::from));
            let (light, full) = transfer.linearised(buffer, full)?;
            (buffer, pixel_format, full_scale) = (light, PixelFormat::F32, Some(full));
            meta.encoding = transfer.encoding();
            changed.push(format!(
                "{}: grey values were encoded ({}) and are made linear",
                transfer.origin, meta.encoding
            ));
        }
        None if format == Format::Jpeg => {
            changed.push(
                "a JPEG that does not say how it encodes light: grey values are taken as linear".to_owned(),
            );
        }
        _ => {}
    }
    let turned = stated.orientation.filter(|o| (2..=8).contains(o));
    let (mut columns, mut rows, mut scale) = (columns, rows, stated.scale);
    if let Some(orientation) = turned {
        buffer = orientation::upright(buffer, columns, orientation);
        changed.push(format!("orientation tag {orientation}: the picture is set upright"));
        if orientation::exchanges(orientation) {
            (columns, rows) = (rows, columns);
            scale = scale.map(FileScale::transposed);
        }
    }
    let frame = Frame::new(buffer, pixel_format, rows, columns, meta).map_err(damaged)?;
    let frame = match full_scale {
        Some(full) => frame.with_full_scale(full),
        None => frame,
    };
    Ok(Decoded { frame, scale, changed, sample_bytes })
}

fn read(bytes: &[u8], format: Format, place: Option<u64>, spare: &Spare) -> Result<Raster, DecodeError> {
    match format {
        Format::Png => png::read(bytes, spare),
        Format::Jpeg => jpeg::read(bytes),
        Format::Bmp => bmp::read(bytes),
        Format::Pnm => {
            let rest = place.and_then(|at| bytes.get(usize::try_from(at).ok()?..));
            pnm::read(rest.unwrap_or(bytes))
        }
        Format::Tiff => tiff::read(bytes, place.unwrap_or_else(|| pages(bytes)[0])),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image::ImageFormat;

    use super::*;
    use crate::frame::PixelFormat;

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
            Err(DecodeError::BeyondDepth { bits: 10, .. })
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
        assert!(matches!(refusal(&colour), DecodeError::Coloured { row: 0, column: 0, .. }));
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
        // An inverted palette is still grey.
        let turned: Vec<[u8; 3]> = (0..=255).map(|i| [255 - i; 3]).collect();
        let frame = decode(&encoded(Some(&turned)), None, FrameMeta::default()).unwrap();
        assert_eq!(frame.view().get(0, 1), Some(252.0));
        let red: Vec<[u8; 3]> = (0..=255).map(|i| [255, i, i]).collect();
        assert!(matches!(refusal(&encoded(Some(&red))), DecodeError::Coloured { .. }));
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
    fn every_page_of_a_stack_is_a_frame() {
        let mut out = Cursor::new(Vec::new());
        let mut encoder = ::tiff::encoder::TiffEncoder::new(&mut out).unwrap();
        for page in 0..3 {
            let values = [1, 2, 3, 4, 5, 6].map(|v| 10 * page + v);
            encoder.write_image::<::tiff::encoder::colortype::Gray8>(3, 2, &values).unwrap();
        }
        let bytes = out.into_inner();
        let places = pages(&bytes);
        assert_eq!(places.len(), 3);
        let frame = |place| {
            decode_wanted(&bytes, &Wanted { place, ..Wanted::default() }, FrameMeta::default())
                .map(|d| d.frame)
        };
        for (page, place) in places.into_iter().enumerate() {
            assert_eq!(frame(Some(place)).unwrap().view().get(1, 2), Some(10.0 * page as f32 + 6.0));
        }
        assert_eq!(frame(None).unwrap().view().get(0, 0), Some(1.0));
        assert!(frame(Some(1 << 40)).is_err());
    }

    #[test]
    fn raw_images_in_one_stream_are_pages() {
        let image = |v: u8| [b"P5 2 1 255\n".as_slice(), &[v, b'P']].concat();
        let stream = [image(1), b"\n".to_vec(), image(2), b"P4\n9 1\n\xff\x80".to_vec()].concat();
        let places = pages(&stream);
        assert_eq!(places, [0, 14, 27]);
        let wanted = Wanted { place: Some(14), ..Wanted::default() };
        let second = decode_wanted(&stream, &wanted, FrameMeta::default()).unwrap().frame;
        assert_eq!(second.view().get(0, 0), Some(2.0));
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
