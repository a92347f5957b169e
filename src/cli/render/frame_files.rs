//! Frames as image files: 16- and 8-bit linear grey PNG, 16-bit and f32 TIFF, each with the pixel
//! size in its tags.

use std::io::{Cursor, Error as IoError};

use tiff::encoder::{Rational, TiffEncoder, colortype};
use tiff::tags::ResolutionUnit;

use crate::frame::{Frame, FrameView, PixelFormat, Pixels};

/// Container of rendered frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum FileFormat {
    /// 16-bit grey PNG; 12-bit counts stand unshifted.
    #[default]
    Png16,
    /// 8-bit grey PNG; the sensor is read out with 8 bits.
    Png8,
    /// 16-bit grey TIFF.
    Tiff16,
    /// 32-bit float grey TIFF of unquantised counts.
    F32,
}

impl FileFormat {
    /// Extension without the dot.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Png16 | Self::Png8 => "png",
            Self::Tiff16 | Self::F32 => "tif",
        }
    }

    /// Pixel format to render in, given the sensor's own.
    pub(crate) fn pixel_format(self, sensor: PixelFormat) -> PixelFormat {
        match (self, sensor) {
            (Self::F32, _) => PixelFormat::F32,
            (Self::Png8, _) => PixelFormat::Mono8,
            (_, PixelFormat::F32) => PixelFormat::Mono16,
            (_, own) => own,
        }
    }
}

/// A mask of a frame's size as an 8-bit PNG.
///
/// # Errors
/// When the encoder refuses it.
pub(crate) fn encode_mask(view: &FrameView<'_>, mask: &[u8], um_per_px: f64) -> Result<Vec<u8>, IoError> {
    write_png(view.columns(), view.rows(), png::BitDepth::Eight, mask, Some(um_per_px))
}

/// An 8-bit grey PNG without a scale, at the strongest compression.
///
/// # Errors
/// When the encoder refuses it.
pub(crate) fn write_grey(columns: usize, grey: &[u8]) -> Result<Vec<u8>, IoError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns as u32, (grey.len() / columns.max(1)) as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(grey)?;
    Ok(file)
}

/// Widest preview, px.
const PREVIEW_COLUMNS: usize = 1224;

/// A frame as the bytes of a file; `um_per_px` goes into the tags, where it is known.
///
/// # Errors
/// When an encoder refuses the frame.
pub(crate) fn encode(
    frame: &Frame,
    format: FileFormat,
    um_per_px: impl Into<Option<f64>>,
) -> Result<Vec<u8>, IoError> {
    let (view, um_per_px) = (frame.view(), um_per_px.into());
    match (format, view.pixels()) {
        (FileFormat::Png16, Pixels::U16(p)) => png(&view, png::BitDepth::Sixteen, &big_endian(p), um_per_px),
        (FileFormat::Png16, Pixels::U8(p)) => {
            let wide: Vec<u16> = p.iter().map(|&v| u16::from(v)).collect();
            png(&view, png::BitDepth::Sixteen, &big_endian(&wide), um_per_px)
        }
        (FileFormat::Png8, Pixels::U8(p)) => png(&view, png::BitDepth::Eight, p, um_per_px),
        (FileFormat::Tiff16, Pixels::U16(p)) => tiff::<colortype::Gray16>(&view, p, um_per_px),
        (FileFormat::Tiff16, Pixels::U8(p)) => {
            let wide: Vec<u16> = p.iter().map(|&v| u16::from(v)).collect();
            tiff::<colortype::Gray16>(&view, &wide, um_per_px)
        }
        (FileFormat::F32, Pixels::F32(p)) => tiff::<colortype::Gray32Float>(&view, p, um_per_px),
        _ => Err(IoError::other(format!("a {:?} frame does not fit a {format:?} file", view.format()))),
    }
}

/// An 8-bit PNG stretched from the darkest to the brightest percentile, reduced by averaging to a
/// handy width.
///
/// # Errors
/// When the encoder refuses the frame.
pub(crate) fn preview(frame: &Frame, um_per_px: f64) -> Result<Vec<u8>, IoError> {
    let view = frame.view();
    let step = view.columns().div_ceil(PREVIEW_COLUMNS);
    let (rows, columns) = ((view.rows() / step).max(1), (view.columns() / step).max(1));
    let mean = |r: usize, c: usize| {
        let all = (0..step).flat_map(|i| (0..step).map(move |j| (r * step + i, c * step + j)));
        let seen: Vec<f32> = all.filter_map(|(r, c)| view.get(r, c)).collect();
        seen.iter().sum::<f32>() / seen.len().max(1) as f32
    };
    let small: Vec<f32> =
        (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))).map(|(r, c)| mean(r, c)).collect();
    let (low, high) = percentiles(&small);
    let grey: Vec<u8> =
        small.iter().map(|v| ((v - low) / (high - low).max(1e-6) * 255.0).clamp(0.0, 255.0) as u8).collect();
    write_png(columns, rows, png::BitDepth::Eight, &grey, Some(um_per_px * step as f64))
}

fn percentiles(values: &[f32]) -> (f32, f32) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
    (at(0.001), at(0.999))
}

fn big_endian(pixels: &[u16]) -> Vec<u8> {
    pixels.iter().flat_map(|v| v.to_be_bytes()).collect()
}

fn png(
    view: &FrameView<'_>,
    depth: png::BitDepth,
    bytes: &[u8],
    um_per_px: Option<f64>,
) -> Result<Vec<u8>, IoError> {
    write_png(view.columns(), view.rows(), depth, bytes, um_per_px)
}

fn write_png(
    columns: usize,
    rows: usize,
    depth: png::BitDepth,
    bytes: &[u8],
    um_per_px: Option<f64>,
) -> Result<Vec<u8>, IoError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_pixel_dims(um_per_px.map(|um_per_px| {
        let per_metre = (1e6 / um_per_px).round() as u32;
        png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }
    }));
    encoder.write_header()?.write_image_data(bytes)?;
    Ok(file)
}

fn tiff<C>(view: &FrameView<'_>, pixels: &[C::Inner], um_per_px: Option<f64>) -> Result<Vec<u8>, IoError>
where
    C: colortype::ColorType,
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut file = Cursor::new(Vec::new());
    let write = |file: &mut Cursor<Vec<u8>>| -> Result<(), tiff::TiffError> {
        let mut encoder = TiffEncoder::new(file)?;
        let mut image = encoder.new_image::<C>(view.columns() as u32, view.rows() as u32)?;
        if let Some(um_per_px) = um_per_px {
            let per_metre = Rational { n: (1e8 / um_per_px).round() as u32, d: 10_000 };
            image.resolution(ResolutionUnit::Centimeter, per_metre);
        }
        image.write_data(pixels)
    };
    write(&mut file).map_err(IoError::other)?;
    Ok(file.into_inner())
}
