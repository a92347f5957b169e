//! A large frame in square cells, for the coarse search, and single pixels of it without hot ones.

use super::limits::NoseLimits;
use crate::frame::{FrameView, Pixels};
use crate::gauge::ring::coarse::Grey;

/// Means of square cells, stuck lines and hot pixels taken off; what is left of a whole number of
/// cells at the right and below is not in them.
pub(super) struct Cells {
    /// The means.
    pub(super) grey: Grey,
    /// Side of a cell, px.
    pub(super) side: usize,
}

impl Cells {
    /// Of a frame; `None` of a small one, and where a pixel is no number.
    pub(super) fn of(view: &FrameView<'_>) -> Option<Self> {
        let limits = NoseLimits::get();
        let side = (view.rows().min(view.columns()) / limits.cells_across.max(1)).min(limits.most_side);
        if side < 2 {
            return None;
        }
        let (rows, columns) = (view.rows() / side, view.columns() / side);
        let steps = (view.row_stride(), view.column_stride());
        let values = match view.pixels() {
            Pixels::U8(p) => means(p, steps, (rows, columns, side)),
            Pixels::U16(p) => means(p, steps, (rows, columns, side)),
            Pixels::F32(p) => means(p, steps, (rows, columns, side)),
        };
        if values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        Some(Self { grey: Grey { values, rows, columns }.without_stuck_lines(), side })
    }

    /// The uppermost pixel of a column of the shadow `own`, from its first cell that has one.
    pub(super) fn top_of(
        &self,
        labels: &[u32],
        own: u32,
        inside: impl Fn(usize, usize) -> bool,
    ) -> Option<(usize, usize)> {
        let columns = self.grey.columns;
        let cells = (0..labels.len()).filter(|at| labels[*at] == own);
        let pixel = |at: usize| {
            let (row, column) = (at / columns * self.side, at % columns * self.side);
            let own = (0..self.side * self.side).map(|k| (row + k / self.side, column + k % self.side));
            own.into_iter().find(|(r, c)| inside(*r, *c))
        };
        let (mut row, column) = cells.into_iter().find_map(pixel)?;
        while row > 0 && inside(row - 1, column) {
            row -= 1;
        }
        Some((row, column))
    }
}

/// Means of `rows` × `columns` cells of `side` × `side` pixels.
fn means<T: Copy + Into<f32>>(
    pixels: &[T],
    (down, across): (usize, usize),
    (rows, columns, side): (usize, usize, usize),
) -> Vec<f32> {
    let share = 1.0 / (side * side) as f32;
    let mut values = vec![0.0_f32; rows * columns];
    for (row, sums) in values.chunks_exact_mut(columns).enumerate() {
        for line in row * side..(row + 1) * side {
            let line = &pixels[line * down..];
            match (across, side) {
                // the side of the largest frames, known where this is compiled
                (1, 4) => add_cells(sums, line, 4),
                (1, _) => add_cells(sums, line, side),
                _ => sums.iter_mut().enumerate().for_each(|(k, sum)| {
                    let own = (k * side..(k + 1) * side).map(|column| line[column * across].into());
                    *sum += own.sum::<f32>();
                }),
            }
        }
        sums.iter_mut().for_each(|sum| *sum *= share);
    }
    values
}

/// Adds the pixels of a line to the sums of its cells.
#[inline(always)]
fn add_cells<T: Copy + Into<f32>>(sums: &mut [f32], line: &[T], side: usize) {
    for (sum, cell) in sums.iter_mut().zip(line.chunks_exact(side)) {
        *sum += cell.iter().map(|v| (*v).into()).sum::<f32>();
    }
}

/// Pixels of a frame as [`Grey::without_stuck_lines`] has them: medians of three, down and then
/// across, computed where they are looked at.
#[derive(Clone, Copy)]
pub(super) struct Smoothed<'a>(pub(super) &'a FrameView<'a>);

impl Smoothed<'_> {
    /// The value at a pixel of the frame.
    pub(super) fn at(self, row: usize, column: usize) -> f32 {
        let across = column > 0 && column + 1 < self.0.columns();
        match across && self.0.columns() >= 3 {
            true => median([column - 1, column, column + 1].map(|c| self.down(row, c))),
            false => self.down(row, column),
        }
    }

    fn down(self, row: usize, column: usize) -> f32 {
        let value = |r: usize| self.0.get(r, column).unwrap_or(f32::NAN);
        let beside = row > 0 && row + 1 < self.0.rows();
        match beside {
            true => median([row - 1, row, row + 1].map(value)),
            false => value(row),
        }
    }
}

fn median([a, b, c]: [f32; 3]) -> f32 {
    a.min(b).max(a.max(b).min(c))
}
