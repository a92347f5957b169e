//! Reading grey values through a view's strides, whatever the container.

use crate::frame::{FrameView, Pixels};

/// A grey value in its container.
pub(crate) trait Sample: Copy + Send + Sync {
    /// The value in counts.
    fn counts(self) -> f32;
}

impl Sample for u8 {
    #[inline(always)]
    fn counts(self) -> f32 {
        f32::from(self)
    }
}

impl Sample for u16 {
    #[inline(always)]
    fn counts(self) -> f32 {
        f32::from(self)
    }
}

impl Sample for f32 {
    #[inline(always)]
    fn counts(self) -> f32 {
        self
    }
}

/// A view with its container known: pixel (row, column) stands at `row * row_stride + column *
/// column_stride`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane<'a, T> {
    pub(crate) pixels: &'a [T],
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) row_stride: usize,
    pub(crate) column_stride: usize,
    /// −1 for bright parts on dark ground, so that the part is always the darker side.
    pub(crate) sign: f32,
}

impl<'a, T: Sample> Plane<'a, T> {
    pub(crate) fn new(pixels: &'a [T], view: &FrameView<'_>, sign: f32) -> Self {
        Self {
            pixels,
            rows: view.rows(),
            columns: view.columns(),
            row_stride: view.row_stride(),
            column_stride: view.column_stride(),
            sign,
        }
    }

    /// The same pixels with rows and columns exchanged.
    pub(crate) fn transposed(&self) -> Self {
        Self {
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
            ..*self
        }
    }

    /// The same pixels with light and shadow exchanged.
    pub(crate) fn inverted(&self) -> Self {
        Self { sign: -self.sign, ..*self }
    }

    /// Counts at a pixel inside the frame.
    pub(crate) fn at(&self, row: usize, column: usize) -> f32 {
        self.sign * self.pixels[row * self.row_stride + column * self.column_stride].counts()
    }

    /// Reads neighbouring pixels of a row; columns must be contiguous.
    #[inline(always)]
    pub(crate) fn read_tile_row<const N: usize>(&self, row: usize, from: usize, out: &mut [f32; N]) {
        let start = row * self.row_stride + from;
        if let Some(pixels) = self.pixels[start..].first_chunk::<N>() {
            for (value, pixel) in out.iter_mut().zip(pixels) {
                *value = self.sign * pixel.counts();
            }
        }
    }

    /// Reads `out.len()` pixels of a column from `first_row` on, upwards in rows (`down`) or
    /// downwards. False, with `out` unspecified, where they do not all lie inside the frame.
    pub(crate) fn gather(&self, first_row: isize, down: bool, column: usize, out: &mut [f32]) -> bool {
        let last_row =
            if down { first_row + out.len() as isize - 1 } else { first_row + 1 - out.len() as isize };
        let limit = self.rows as isize;
        if first_row < 0 || first_row >= limit || last_row < 0 || last_row >= limit {
            return false;
        }
        let low = first_row.min(last_row) as usize;
        let start = low * self.row_stride + column * self.column_stride;
        let source = self.pixels[start..].iter().step_by(self.row_stride);
        let sign = self.sign;
        if down {
            for (value, pixel) in out.iter_mut().zip(source) {
                *value = sign * pixel.counts();
            }
        } else {
            for (value, pixel) in out.iter_mut().rev().zip(source) {
                *value = sign * pixel.counts();
            }
        }
        true
    }
}

/// Calls a generic function with the plane of a view: `with_plane!(view, sign, plane => body)`.
macro_rules! with_plane {
    ($view:expr, $sign:expr, $plane:ident => $body:expr) => {
        match $view.pixels() {
            $crate::frame::Pixels::U8(pixels) => {
                let $plane = $crate::gauge::edge::image::plane::Plane::new(pixels, $view, $sign);
                $body
            }
            $crate::frame::Pixels::U16(pixels) => {
                let $plane = $crate::gauge::edge::image::plane::Plane::new(pixels, $view, $sign);
                $body
            }
            $crate::frame::Pixels::F32(pixels) => {
                let $plane = $crate::gauge::edge::image::plane::Plane::new(pixels, $view, $sign);
                $body
            }
        }
    };
}
pub(crate) use with_plane;

/// Whether every value sampled is a finite number; integer containers always are.
pub(crate) fn all_finite(view: &FrameView<'_>) -> bool {
    match view.pixels() {
        Pixels::U8(_) | Pixels::U16(_) => true,
        Pixels::F32(p) => (0..view.rows()).all(|row| {
            let start = row * view.row_stride();
            (0..view.columns()).all(|column| p[start + column * view.column_stride()].is_finite())
        }),
    }
}
