//! BMP: palettes and colours.

use std::io::Cursor;

use image::ImageDecoder;
use image::codecs::bmp::BmpDecoder;

use super::error::{DecodeError, check_size, damaged};
use super::png::palette_values;
use super::raster::{Raster, Stated};
use super::scale::FileScale;
use crate::frame::Buffer;

/// Reads the image.
pub(super) fn read(bytes: &[u8]) -> Result<Raster, DecodeError> {
    let mut decoder = BmpDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
    let (columns, rows) = decoder.dimensions();
    check_size(columns, rows)?;
    let (columns, rows) = (columns as usize, rows as usize);
    // The decoder returns indices only for eight bits; smaller ones it looks up itself.
    let octets = bytes.get(28..30) == Some(&[8, 0]);
    let palette: Option<Vec<[u8; 3]>> = decoder.get_palette().filter(|_| octets).map(<[[u8; 3]]>::to_vec);
    if palette.is_some() {
        decoder.set_indexed_color(true);
    }
    let channels = if palette.is_some() { 1 } else { usize::from(decoder.color_type().channel_count()) };
    let mut samples = vec![0; columns * rows * channels];
    if decoder.total_bytes() != samples.len() as u64 {
        return Err(DecodeError::NotGrey(format!("a {:?} BMP", decoder.color_type())));
    }
    decoder.read_image(&mut samples).map_err(damaged)?;
    if channels == 4 && samples.iter().skip(3).step_by(4).all(|a| *a == 0) {
        // A fourth byte that is 0 everywhere is padding, not opacity.
        samples.iter_mut().skip(3).step_by(4).for_each(|a| *a = u8::MAX);
    }
    let (samples, channels) = match palette {
        Some(colours) => palette_values(samples, &colours)?,
        None => (samples, channels),
    };
    let stated = Stated { scale: scale(bytes), ..Stated::default() };
    Ok(Raster { samples: Buffer::U8(samples), columns, rows, channels, planar: false, stated })
}

/// Pixels per metre from the header, where it has them.
fn scale(bytes: &[u8]) -> Option<FileScale> {
    let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let (size, x, y) = (number(14)?, number(38)?, number(42)?);
    let some = size >= 40 && x > 0 && y > 0;
    some.then(|| {
        FileScale::of_density([x.into(), y.into()], true, 1e6, format!("BMP header {x} x {y} px/m"))
    })?
}
