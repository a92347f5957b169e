//! The strip along a cutting edge, rectified: columns go along the reference curve, rows from the
//! air into the flank at right angles to it.

use glam::DVec2;

use super::limits::FlankLimits;
use super::raster::{Raster, quantile};
use super::reference::EdgeLine;

/// Where a strip lies in the image.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frame {
    /// The straight line that it follows.
    pub line: EdgeLine,
    /// The reference curve's departure from the line into the flank, px, by powers of s/length.
    pub curve: Vec<f64>,
    /// Scale of the image, µm per px.
    pub um_per_px: f64,
    /// Rows above the reference.
    pub above: usize,
    /// Rows below it.
    pub below: usize,
    /// First and last place along the line, px.
    pub range_px: (f64, f64),
}

impl Frame {
    /// About a line, without a curve.
    pub(crate) fn about(line: EdgeLine, um_per_px: f64, (above_um, below_um): (f64, f64)) -> Self {
        let pitch = FlankLimits::get().pitch_um;
        let rows = |um: f64| (um / pitch).round() as usize;
        let range_px = (0.0, line.length_px);
        Self { line, curve: Vec::new(), um_per_px, above: rows(above_um), below: rows(below_um), range_px }
    }

    /// Distance of two rows, µm.
    pub(crate) fn row_um(&self) -> f64 {
        FlankLimits::get().pitch_um
    }

    /// Distance of two columns, µm.
    pub(crate) fn column_um(&self) -> f64 {
        let limits = FlankLimits::get();
        limits.column_pitches * limits.pitch_um
    }

    /// Columns.
    pub(crate) fn columns(&self) -> usize {
        let length_um = (self.range_px.1 - self.range_px.0) * self.um_per_px;
        (length_um / self.column_um()).floor() as usize + 1
    }

    /// The reference curve at a place along the line, px into the flank.
    pub(crate) fn reference_px(&self, s_px: f64) -> f64 {
        let t = s_px / self.line.length_px;
        self.curve.iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// Place along the line of a column, px.
    pub(crate) fn s_px(&self, column: f64) -> f64 {
        self.range_px.0 + column * self.column_um() / self.um_per_px
    }

    /// Place in the image, (column, row), of a strip's column and a depth below the reference, µm.
    pub(crate) fn place(&self, column: f64, depth_um: f64) -> DVec2 {
        let s = self.s_px(column);
        let v = self.reference_px(s) + depth_um / self.um_per_px;
        self.line.from + self.line.along * s + self.line.normal * v
    }

    /// Depth of a row, µm; rows stand for their middles.
    pub(crate) fn depth_um(&self, row: usize) -> f64 {
        (row as f64 - self.above as f64) * self.row_um()
    }

    /// The strip's values, and how many rows of each column lie inside of the image.
    pub(crate) fn cut(&self, image: &Raster) -> (Raster, Vec<usize>) {
        let (rows, columns) = (self.above + self.below, self.columns());
        let mut strip = Raster::new(rows, columns);
        let mut inside = vec![rows; columns];
        for (column, inside) in inside.iter_mut().enumerate() {
            let mut last = f32::NAN;
            for row in 0..rows {
                let p = self.place(column as f64, self.depth_um(row));
                match image.between(p.y, p.x) {
                    Some(value) => last = value,
                    None if row >= self.above => *inside = (*inside).min(row),
                    None => {}
                }
                strip.values[row * columns + column] = last;
            }
            // rows outside above the first one inside take its value
            let first = (0..rows).map(|r| strip.at(r, column)).find(|v| v.is_finite()).unwrap_or(0.0);
            for row in 0..rows {
                let value = &mut strip.values[row * columns + column];
                if !value.is_finite() {
                    *value = first;
                }
            }
        }
        (strip, inside)
    }
}

/// Grey values relative to the air beside the edge and to the light on the flank: the same at any
/// exposure.
pub(crate) fn normalised(strip: &Raster, frame: &Frame) -> Raster {
    let limits = FlankLimits::get();
    let near = (limits.air_um / frame.row_um()) as usize;
    let air: Vec<f32> =
        (0..frame.above.saturating_sub(near).max(1)).flat_map(|r| strip.row(r).to_vec()).collect();
    let level = quantile(air, 0.5);
    // as deep as the limit of a notch: wide lands alone are no flank
    let lit_rows = frame.above..(frame.above + (250.0 / frame.row_um()) as usize).min(strip.rows);
    let lit: Vec<f32> = lit_rows.flat_map(|r| strip.row(r).to_vec()).collect();
    let light = quantile(lit, 0.9) - level;
    let scale = if light > 0.0 { light.recip() } else { 1.0 };
    strip.map(|v| ((v - level) * scale).clamp(-1.0, 3.0))
}
