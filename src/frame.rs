//! Frames: the output of a camera and the input of a gauge.
//!
//! Images have `row` (down) and `column` (right), pixel centres at integers. With p mm per pixel
//! and the machine's axes (z along the spindle, x up in the image, y towards the camera):
//! row = r0 - x/p, column = c0 + z/p. [`FrameMeta::z_mm`] is the machine z of the image's central
//! column c0 = (columns - 1)/2.

mod camera_binding;
mod encoding;
mod roi;

pub use camera_binding::{BindingError, BoundSource, CameraBinding};
pub use encoding::Encoding;
pub use roi::Roi;

use thiserror::Error;

/// Grey values of a frame, borrowed, in the container the camera used.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'a> {
    /// 8-bit counts.
    U8(&'a [u8]),
    /// 10-, 12- or 16-bit counts, unshifted in 16-bit containers.
    U16(&'a [u16]),
    /// Unquantised counts (simulation and accuracy tests only).
    F32(&'a [f32]),
}

impl Pixels<'_> {
    /// Number of pixels in the buffer.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(p) => p.len(),
            Self::U16(p) => p.len(),
            Self::F32(p) => p.len(),
        }
    }

    /// Whether the buffer holds no pixel at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Format of a grey value, which defines full scale.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum PixelFormat {
    /// 8-bit grey, 0..=255.
    Mono8,
    /// 10-bit grey in 16-bit containers, 0..=1023.
    Mono10,
    /// 12-bit grey in 16-bit containers, 0..=4095.
    Mono12,
    /// 14-bit grey in 16-bit containers, 0..=16383.
    Mono14,
    /// 16-bit grey, 0..=65535.
    Mono16,
    /// Unquantised f32 counts; full scale is not defined.
    F32,
}

impl PixelFormat {
    /// Largest count of the format; `None` for unquantised frames.
    pub fn full_scale(self) -> Option<u16> {
        match self {
            Self::Mono8 => Some(255),
            Self::Mono10 => Some(1023),
            Self::Mono12 => Some(4095),
            Self::Mono14 => Some(16383),
            Self::Mono16 => Some(65535),
            Self::F32 => None,
        }
    }

    /// Bits per grey value, 32 for unquantised frames.
    pub fn bit_depth(self) -> u8 {
        match self {
            Self::Mono8 => 8,
            Self::Mono10 => 10,
            Self::Mono12 => 12,
            Self::Mono14 => 14,
            Self::Mono16 => 16,
            Self::F32 => 32,
        }
    }
}

/// Why a buffer cannot be read as a frame.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// A frame without rows or columns.
    #[error("a frame of {rows} rows x {columns} columns has no pixel; both must be at least 1")]
    Empty {
        /// Rows requested.
        rows: usize,
        /// Columns requested.
        columns: usize,
    },
    /// The buffer ends before the last pixel.
    #[error(
        "the buffer holds {found} pixels, but {rows} rows x {columns} columns at a stride of {stride} need {needed}"
    )]
    TooShort {
        /// Pixels in the buffer.
        found: usize,
        /// Pixels needed.
        needed: usize,
        /// Rows requested.
        rows: usize,
        /// Columns requested.
        columns: usize,
        /// Pixels from one row to the next.
        stride: usize,
    },
    /// Rows overlap.
    #[error("a stride of {stride} pixels is shorter than the {columns} columns of a row")]
    StrideTooShort {
        /// Pixels from one row to the next.
        stride: usize,
        /// Columns requested.
        columns: usize,
    },
    /// The container does not fit the format.
    #[error("{format:?} does not fit a container of {container} pixels")]
    Container {
        /// Format requested.
        format: PixelFormat,
        /// The buffer's element type.
        container: &'static str,
    },
}

/// A borrowed, possibly strided or transposed view of a frame's pixels: the input of the gauge.
///
/// Pixel (row, column) is at index `row * row_stride + column * column_stride`.
#[derive(Clone, Copy, Debug)]
pub struct FrameView<'a> {
    pixels: Pixels<'a>,
    format: PixelFormat,
    rows: usize,
    columns: usize,
    row_stride: usize,
    column_stride: usize,
    stated_full_scale: Option<f32>,
}

impl<'a> FrameView<'a> {
    /// A view of a row-major buffer; `stride` is in pixels from one row to the next.
    ///
    /// # Errors
    /// Refuses empty frames, buffers that are too short, strides below the row length, and
    /// containers that cannot hold the format.
    pub fn new(
        pixels: Pixels<'a>,
        format: PixelFormat,
        rows: usize,
        columns: usize,
        stride: usize,
    ) -> Result<Self, FrameError> {
        if rows == 0 || columns == 0 {
            return Err(FrameError::Empty { rows, columns });
        }
        if stride < columns {
            return Err(FrameError::StrideTooShort { stride, columns });
        }
        check_container(&pixels, format)?;
        let needed = (rows - 1).saturating_mul(stride).saturating_add(columns);
        if pixels.len() < needed {
            return Err(FrameError::TooShort { found: pixels.len(), needed, rows, columns, stride });
        }
        Ok(Self {
            pixels,
            format,
            rows,
            columns,
            row_stride: stride,
            column_stride: 1,
            stated_full_scale: None,
        })
    }

    /// A view of pixels that lie `row_stride` and `column_stride` apart, in pixels: a transposed
    /// buffer, every second column of one.
    ///
    /// # Errors
    /// As [`Self::new`]; rows or columns that overlap. A stride of 0 counts as 1.
    pub fn strided(
        (pixels, format): (Pixels<'a>, PixelFormat),
        (rows, columns): (usize, usize),
        (row_stride, column_stride): (usize, usize),
    ) -> Result<Self, FrameError> {
        if rows == 0 || columns == 0 {
            return Err(FrameError::Empty { rows, columns });
        }
        check_container(&pixels, format)?;
        let (row_stride, column_stride) = (row_stride.max(1), column_stride.max(1));
        let spans = |count: usize, stride: usize| (count - 1).saturating_mul(stride).saturating_add(1);
        let (down, along) = (spans(rows, row_stride), spans(columns, column_stride));
        // One of them lies within the steps of the other, or pixels are shared.
        if !(rows == 1 || columns == 1 || row_stride >= along || column_stride >= down) {
            return Err(FrameError::StrideTooShort {
                stride: row_stride.max(column_stride),
                columns: along.min(down),
            });
        }
        let needed = down.saturating_add(along - 1);
        if pixels.len() < needed {
            let found = pixels.len();
            return Err(FrameError::TooShort { found, needed, rows, columns, stride: row_stride });
        }
        Ok(Self { pixels, format, rows, columns, row_stride, column_stride, stated_full_scale: None })
    }

    /// With a full scale, counts, that is not the format's own (10-bit values up to 1000). A value
    /// that is not above 0 is ignored.
    #[must_use]
    pub fn with_full_scale(self, counts: f32) -> Self {
        Self { stated_full_scale: (counts > 0.0).then_some(counts), ..self }
    }

    /// The same pixels with rows and columns exchanged, without a copy: a vertical shaft seen as a
    /// horizontal one.
    #[must_use]
    pub fn transposed(self) -> Self {
        Self {
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
            ..self
        }
    }

    /// The columns `from` to before `to`, without a copy; `None` where there are none.
    pub(crate) fn columns_between(&self, from: usize, to: usize) -> Option<Self> {
        if from >= to || to > self.columns {
            return None;
        }
        let first = from * self.column_stride;
        let pixels = match self.pixels {
            Pixels::U8(p) => Pixels::U8(p.get(first..)?),
            Pixels::U16(p) => Pixels::U16(p.get(first..)?),
            Pixels::F32(p) => Pixels::F32(p.get(first..)?),
        };
        Some(Self { pixels, columns: to - from, ..*self })
    }

    /// The buffer; index it with [`Self::row_stride`] and [`Self::column_stride`].
    pub fn pixels(&self) -> Pixels<'a> {
        self.pixels
    }

    /// Format of the grey values.
    pub fn format(&self) -> PixelFormat {
        self.format
    }

    /// Full scale, counts: as stated by the file (a PGM's `maxval`, `sBIT`), otherwise the
    /// format's; `None` where neither is given.
    pub fn full_scale(&self) -> Option<f32> {
        self.stated_full_scale.or_else(|| self.format.full_scale().map(f32::from))
    }

    /// Number of rows, at least 1.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns, at least 1.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Pixels from one row to the next.
    pub fn row_stride(&self) -> usize {
        self.row_stride
    }

    /// Pixels from one column to the next: 1 unless transposed.
    pub fn column_stride(&self) -> usize {
        self.column_stride
    }

    /// Grey value at (row, column) in counts; `None` outside the frame.
    pub fn get(&self, row: usize, column: usize) -> Option<f32> {
        if row >= self.rows || column >= self.columns {
            return None;
        }
        let index = row * self.row_stride + column * self.column_stride;
        Some(match self.pixels {
            Pixels::U8(p) => f32::from(p[index]),
            Pixels::U16(p) => f32::from(p[index]),
            Pixels::F32(p) => p[index],
        })
    }
}

fn check_container(pixels: &Pixels<'_>, format: PixelFormat) -> Result<(), FrameError> {
    match (pixels, format) {
        (Pixels::U8(_), PixelFormat::Mono8)
        | (
            Pixels::U16(_),
            PixelFormat::Mono10 | PixelFormat::Mono12 | PixelFormat::Mono14 | PixelFormat::Mono16,
        )
        | (Pixels::F32(_), PixelFormat::F32) => Ok(()),
        (Pixels::U8(_), _) => Err(FrameError::Container { format, container: "8-bit" }),
        (Pixels::U16(_), _) => Err(FrameError::Container { format, container: "16-bit" }),
        (Pixels::F32(_), _) => Err(FrameError::Container { format, container: "f32" }),
    }
}

/// Pixels that a frame owns.
#[derive(Clone, Debug, PartialEq)]
pub enum Buffer {
    /// 8-bit counts.
    U8(Vec<u8>),
    /// Counts in 16-bit containers.
    U16(Vec<u16>),
    /// Unquantised counts.
    F32(Vec<f32>),
}

/// Pixels of a frame, to be changed in place.
#[derive(Debug)]
pub enum PixelsMut<'a> {
    /// 8-bit counts.
    U8(&'a mut [u8]),
    /// Counts in 16-bit containers.
    U16(&'a mut [u16]),
    /// Unquantised counts.
    F32(&'a mut [f32]),
}

/// Metadata of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameMeta {
    /// Sequence number, unwrapped to 64 bits.
    pub frame_id: u64,
    /// Start of exposure on the device's clock, ns.
    pub t_ns: u64,
    /// Exposure time, µs.
    pub exposure_us: f64,
    /// Spindle angle φ, degrees; at mid-exposure where it comes from an encoder.
    pub angle_deg: f64,
    /// Angle that the spindle turned during the exposure, degrees; 0 where it stood or is not known
    /// to have turned.
    pub sweep_deg: f64,
    /// Machine z of the image's central column, mm.
    pub z_mm: f64,
    /// The window of the sensor this frame shows; `None` for a full frame.
    pub roi: Option<Roi>,
    /// A second window, below the first, whose rows stand beneath those of the first: each shows an
    /// edge. `None` for one window.
    pub second_roi: Option<Roi>,
    /// Encoding of light in its file; the frame's own grey values are linear.
    pub encoding: Encoding,
}

impl FrameMeta {
    /// Rows of the sensor between two windows; `None` for one window, and for two that overlap.
    pub fn rows_between(&self) -> Option<u32> {
        let (first, second) = (self.roi?, self.second_roi?);
        second.row.checked_sub(first.row.checked_add(first.rows)?)
    }
}

/// A frame that owns its pixels, row-major without padding.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    buffer: Buffer,
    format: PixelFormat,
    rows: usize,
    columns: usize,
    stated_full_scale: Option<f32>,
    /// Metadata.
    pub meta: FrameMeta,
}

impl Frame {
    /// Takes ownership of `rows * columns` pixels.
    ///
    /// # Errors
    /// As [`FrameView::new`].
    pub fn new(
        buffer: Buffer,
        format: PixelFormat,
        rows: usize,
        columns: usize,
        meta: FrameMeta,
    ) -> Result<Self, FrameError> {
        FrameView::new(buffer.as_pixels(), format, rows, columns, columns)?;
        Ok(Self { buffer, format, rows, columns, stated_full_scale: None, meta })
    }

    /// A frame of light in floating point, row-major; pixels that are missing are 0, those beyond
    /// the frame left out.
    pub fn linear(
        mut light: Vec<f32>,
        rows: usize,
        columns: usize,
        full_scale: Option<f32>,
        meta: FrameMeta,
    ) -> Self {
        let (rows, columns) = (rows.max(1), columns.max(1));
        light.resize(rows * columns, 0.0);
        let buffer = Buffer::F32(light);
        Self { buffer, format: PixelFormat::F32, rows, columns, stated_full_scale: full_scale, meta }
    }

    /// Sets the full scale, counts, where it is not its format's own (10-bit values up to 1000,
    /// floats with a known full scale). A value that is not above 0 is ignored.
    #[must_use]
    pub fn with_full_scale(self, counts: f32) -> Self {
        Self { stated_full_scale: (counts > 0.0).then_some(counts), ..self }
    }

    /// A view of the pixels for the gauge.
    pub fn view(&self) -> FrameView<'_> {
        FrameView {
            pixels: self.buffer.as_pixels(),
            format: self.format,
            rows: self.rows,
            columns: self.columns,
            row_stride: self.columns,
            column_stride: 1,
            stated_full_scale: self.stated_full_scale,
        }
    }

    /// The pixels, to be corrected in place.
    pub fn pixels_mut(&mut self) -> PixelsMut<'_> {
        match &mut self.buffer {
            Buffer::U8(p) => PixelsMut::U8(p),
            Buffer::U16(p) => PixelsMut::U16(p),
            Buffer::F32(p) => PixelsMut::F32(p),
        }
    }

    /// Returns the pixels, so that a source can reuse the allocation.
    pub fn into_buffer(self) -> Buffer {
        self.buffer
    }
}

impl Buffer {
    /// The pixels, borrowed.
    pub fn as_pixels(&self) -> Pixels<'_> {
        match self {
            Self::U8(p) => Pixels::U8(p),
            Self::U16(p) => Pixels::U16(p),
            Self::F32(p) => Pixels::F32(p),
        }
    }
}

/// Why a source failed to deliver the next frame.
#[derive(Debug, Error)]
#[error("{what}")]
pub struct SourceError {
    /// What failed, with the file or device and a remedy.
    pub what: String,
    /// The underlying cause, where there is one.
    #[source]
    pub cause: Option<Box<dyn std::error::Error + Send + Sync>>,
}

/// A source of frames: a simulator, a recording or a camera. Everything after it is the same for
/// all three.
pub trait FrameSource {
    /// The next frame, or `None` at the end of the stream.
    ///
    /// # Errors
    /// When the next frame cannot be delivered; the stream may continue after it.
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError>;

    /// Number of remaining frames, where it is known.
    fn remaining(&self) -> Option<usize> {
        None
    }

    /// Takes a spent frame back so that its buffer can be used again.
    fn recycle(&mut self, _frame: Frame) {}
}
