//! The output of a format's reader: the samples of the file, and the file's statements on them.

use super::error::DecodeError;
use super::scale::FileScale;
use super::transfer::Transfer;
use crate::frame::Buffer;

/// A channel of a colour image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Channel {
    /// Red.
    #[cfg_attr(feature = "cli", value(alias = "red"))]
    R,
    /// Green.
    #[cfg_attr(feature = "cli", value(alias = "green"))]
    G,
    /// Blue.
    #[cfg_attr(feature = "cli", value(alias = "blue"))]
    B,
}

impl Channel {
    /// Its colour.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::R => "red",
            Self::G => "green",
            Self::B => "blue",
        }
    }
}

/// Samples of all channels.
pub(super) struct Raster {
    pub(super) samples: Buffer,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// 1 grey, 2 grey and alpha, 3 red, green and blue, 4 these and alpha.
    pub(super) channels: usize,
    /// Whether the channels follow one another as planes, instead of pixel by pixel.
    pub(super) planar: bool,
    pub(super) stated: Stated,
}

/// Statements of a file on its grey values.
#[derive(Default)]
pub(super) struct Stated {
    /// Full scale, where it is not the container's.
    pub(super) full_scale: Option<f32>,
    /// Bits of the camera's values, in a larger container (`sBIT`).
    pub(super) significant_bits: Option<u8>,
    /// How light is encoded; `None` where the file does not state it.
    pub(super) transfer: Option<Transfer>,
    /// EXIF orientation, 1 to 8.
    pub(super) orientation: Option<u64>,
    /// Scale.
    pub(super) scale: Option<FileScale>,
    /// The largest 16-bit sample, where the reader has met it on the way.
    pub(super) most: Option<u16>,
    /// Bytes of the samples at the file's own depth, where these are more than now.
    pub(super) wider_bytes: usize,
}

impl Raster {
    /// Size of the samples, bytes.
    pub(super) fn sample_bytes(&self) -> usize {
        match &self.samples {
            Buffer::U8(v) => v.len(),
            Buffer::U16(v) => 2 * v.len(),
            Buffer::F32(v) => 4 * v.len(),
        }
    }

    /// The grey values: the only channel, all three where they are equal, otherwise the chosen one.
    ///
    /// # Errors
    /// Refuses colours without a chosen channel, and pixels that are not opaque.
    pub(super) fn grey(self, channel: Option<Channel>) -> Result<(Buffer, Stated), DecodeError> {
        let Self { samples, columns, channels, planar, mut stated, .. } = self;
        // That of all channels need not be in the one that is picked.
        stated.most = stated.most.filter(|_| channels == 1);
        let layout = Layout { columns, channels, planar };
        let picked = match samples {
            Buffer::U8(v) => Buffer::U8(pick(v, layout, channel, u8::MAX)?),
            Buffer::U16(v) => Buffer::U16(pick(v, layout, channel, u16::MAX)?),
            Buffer::F32(v) => Buffer::F32(pick(v, layout, channel, 1.0)?),
        };
        Ok((picked, stated))
    }
}

/// Layout of samples in their buffer.
#[derive(Clone, Copy)]
struct Layout {
    columns: usize,
    channels: usize,
    /// One plane per channel; otherwise the channels of a pixel together.
    planar: bool,
}

fn pick<T: Copy + PartialEq + Into<f64>>(
    samples: Vec<T>,
    Layout { columns, channels, planar }: Layout,
    channel: Option<Channel>,
    opaque: T,
) -> Result<Vec<T>, DecodeError> {
    if channels == 1 {
        return Ok(samples);
    }
    let pixels = samples.len() / channels;
    let at = |pixel: usize, c: usize| samples[if planar { c * pixels + pixel } else { pixel * channels + c }];
    let place = |pixel: usize| (pixel / columns.max(1), pixel % columns.max(1));
    if channels == 2 || channels == 4 {
        let clear = (0..pixels).find(|&p| at(p, channels - 1) != opaque);
        if let Some((row, column)) = clear.map(place) {
            return Err(DecodeError::Transparent { row, column });
        }
    }
    if channels < 3 {
        return Ok((0..pixels).map(|p| at(p, 0)).collect());
    }
    let chosen = match channel {
        Some(channel) => channel as usize,
        None => {
            let coloured = (0..pixels).find(|&p| at(p, 0) != at(p, 1) || at(p, 1) != at(p, 2));
            if let Some(pixel) = coloured {
                let (row, column) = place(pixel);
                let value = [0, 1, 2].map(|c| at(pixel, c).into());
                return Err(DecodeError::Coloured { row, column, value });
            }
            1
        }
    };
    Ok((0..pixels).map(|p| at(p, chosen)).collect())
}
