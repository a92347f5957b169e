//! A frame before it is measured: its size, and the calibration's corrections of sensor and light.

use super::error::MeasureError;
use crate::frame::{Buffer, Frame, FrameError, FrameMeta, FrameView, Pixels};
use crate::gauge::Calibration;
use crate::gauge::sensor::ShaftRuns;

/// A frame, named `name`, with the calibration's corrections of sensor and light; `vertical`: its
/// shaft stands upright, and the calibration is [`Calibration::transposed`].
///
/// # Errors
/// Another size than the calibration's.
pub(crate) fn prepared(
    name: &str,
    frame: Frame,
    calibration: Option<&Calibration>,
    vertical: bool,
) -> Result<Frame, MeasureError> {
    let Some(setup) = calibration.and_then(|c| c.setup.as_ref()) else { return Ok(frame) };
    check_size(name, &laid(&frame.view(), vertical), calibration)?;
    let shaft = if vertical { ShaftRuns::AlongColumns } else { ShaftRuns::AlongRows };
    Ok(match &setup.flat_field {
        Some(field) => field.corrected_along(frame, shaft),
        None => frame,
    })
}

/// Refuses a frame, its shaft lying level, of another size than the calibration's.
pub(super) fn check_size(
    name: &str,
    view: &FrameView<'_>,
    calibration: Option<&Calibration>,
) -> Result<(), MeasureError> {
    let Some(setup) = calibration.and_then(|c| c.setup.as_ref()) else { return Ok(()) };
    setup
        .check_size(view.rows(), view.columns())
        .map_err(|source| MeasureError::OtherSize { frame: name.to_owned(), source })
}

/// A view with the shaft lying level.
pub(super) fn laid<'a>(view: &FrameView<'a>, vertical: bool) -> FrameView<'a> {
    if vertical { view.transposed() } else { *view }
}

/// A frame of its own with the pixels of a view, to be corrected, in the memory of an earlier one
/// where that is of the same type.
pub(super) fn copied(
    meta: &FrameMeta,
    view: &FrameView<'_>,
    earlier: Option<Buffer>,
) -> Result<Frame, FrameError> {
    let buffer = match (view.pixels(), earlier) {
        (Pixels::U8(pixels), Some(Buffer::U8(kept))) => Buffer::U8(rows_of(view, pixels, kept)),
        (Pixels::U16(pixels), Some(Buffer::U16(kept))) => Buffer::U16(rows_of(view, pixels, kept)),
        (Pixels::F32(pixels), Some(Buffer::F32(kept))) => Buffer::F32(rows_of(view, pixels, kept)),
        (Pixels::U8(pixels), _) => Buffer::U8(rows_of(view, pixels, Vec::new())),
        (Pixels::U16(pixels), _) => Buffer::U16(rows_of(view, pixels, Vec::new())),
        (Pixels::F32(pixels), _) => Buffer::F32(rows_of(view, pixels, Vec::new())),
    };
    let frame = Frame::new(buffer, view.format(), view.rows(), view.columns(), meta.clone())?;
    Ok(match view.full_scale() {
        Some(counts) => frame.with_full_scale(counts),
        None => frame,
    })
}

fn rows_of<T: Copy>(view: &FrameView<'_>, pixels: &[T], mut into: Vec<T>) -> Vec<T> {
    into.clear();
    let row =
        |r: usize| (0..view.columns()).map(move |c| pixels[r * view.row_stride() + c * view.column_stride()]);
    into.extend((0..view.rows()).flat_map(row));
    into
}
