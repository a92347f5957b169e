//! Scatter, by form, texture and sampling, of the widths that a mean is taken over.
//!
//! Neighbouring columns share texture, so that the scatter of single columns would understate the
//! uncertainty of their mean. It is computed from the means of blocks about a line (a taper is form
//! to be measured), less the noise. Before that the width of every block is corrected for lens
//! distortion, as the diameter is; uncorrected, distortion would count as form. With fewer than
//! three whole blocks form and noise cannot be separated: the columns are then cut into three, the
//! noise stays in, and their one degree of freedom widens U.

use crate::gauge::calibration::{ColumnSpread, LensModel};
use crate::gauge::edges::FrameEdges;
use crate::gauge::limit::limits;
use crate::gauge::width::column_means::ColumnMeans;
use crate::numerics::line::Line;

limits! {
    /// Blocks whose widths show form.
    FormScatterLimits = "form_scatter";
    /// Columns of a block: longer than texture and blur correlate neighbours.
    block_columns: usize = 16;
    /// Fewest blocks: two lie on any line.
    least_blocks: usize = 3;
    /// Most blocks: their scatter then has ten degrees of freedom, and form shorter than a twelfth
    /// of the mean is averaged.
    most_blocks: usize = 12;
}

impl FormScatterLimits {
    /// Columns below which their scatter does not separate form from noise.
    pub(super) fn few_columns(&self) -> usize {
        self.least_blocks * self.block_columns
    }
}

/// Mean edges of a block of neighbouring columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block {
    /// Its columns, px.
    pub columns: ColumnSpread,
    /// Mean rows of the two edges, px.
    pub rows_px: (f64, f64),
}

impl Block {
    fn of(edges: &FrameEdges, part: &[usize]) -> Self {
        let n = part.len().max(1) as f64;
        let mean = |f: &dyn Fn(usize) -> f64| part.iter().map(|c| f(*c)).sum::<f64>() / n;
        let mean_px = mean(&|c| c as f64);
        Self {
            columns: ColumnSpread { mean_px, variance_px2: mean(&|c| (c as f64 - mean_px).powi(2)) },
            rows_px: (mean(&|c| edges.top[c].row_px), mean(&|c| edges.bottom[c].row_px)),
        }
    }

    /// Width as a perfect lens would have shown it, px.
    fn width_px(&self, lens: Option<&LensModel>) -> f64 {
        let (top, bottom) = self.rows_px;
        let Some(lens) = lens else { return bottom - top };
        let u = ColumnSpread { mean_px: self.columns.mean_px - lens.centre_column_px, ..self.columns };
        let ideal = |row: f64| lens.ideal_mean(u, row - lens.centre_row_px);
        ideal(bottom) - ideal(top)
    }
}

/// Data on the scatter of the widths averaged.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Scatter {
    /// Blocks, whose widths show it.
    Blocks {
        /// Mean edges of each.
        blocks: Vec<Block>,
        /// Whether there are columns enough to separate form from noise.
        tell_noise: bool,
    },
    /// The scatter itself.
    Known {
        /// Standard uncertainty of the mean width, px.
        u_px: f64,
        /// Its degrees of freedom.
        freedom: f64,
    },
}

impl Scatter {
    /// Blocks of the columns that a mean was taken over.
    pub(super) fn of_blocks(edges: &FrameEdges, over: &ColumnMeans) -> Self {
        let limits = FormScatterLimits::get();
        let used = &over.used;
        let count = (used.len() / limits.block_columns).clamp(limits.least_blocks, limits.most_blocks);
        let part = |b: usize| &used[b * used.len() / count..(b + 1) * used.len() / count];
        let blocks = (0..count).map(|b| Block::of(edges, part(b))).collect();
        Self::Blocks { blocks, tell_noise: used.len() >= limits.few_columns() }
    }

    /// Standard uncertainty of the mean width beyond the noise' own, px, and its degrees of
    /// freedom.
    pub(crate) fn u_px(&self, lens: Option<&LensModel>, u_noise_px: f64) -> (f64, f64) {
        match self {
            Self::Known { u_px, freedom } => (*u_px, *freedom),
            Self::Blocks { blocks, tell_noise } => {
                let widths: Vec<(f64, f64)> =
                    blocks.iter().map(|b| (b.columns.mean_px, b.width_px(lens))).collect();
                let n = blocks.len() as f64;
                let variance = variance_about_line(&widths) / n;
                let noise = if *tell_noise { u_noise_px * u_noise_px } else { 0.0 };
                ((variance - noise).max(0.0).sqrt(), (n - 2.0).max(1.0))
            }
        }
    }
}

/// Variance of one value about the least-squares line through (place, value).
fn variance_about_line(values: &[(f64, f64)]) -> f64 {
    let n = values.len() as f64;
    if n < 3.0 {
        return 0.0;
    }
    let line = Line::through(values.iter().copied());
    let (x, y, slope) = (line.mean_x, line.mean_y, line.slope());
    values.iter().map(|v| (v.1 - y - slope * (v.0 - x)).powi(2)).sum::<f64>() / (n - 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::edges::Edge;
    use crate::gauge::edges::EdgeState;

    const COLUMNS: usize = 2448;

    fn lens() -> LensModel {
        LensModel {
            radial: 4.8e-4,
            keystone_across: -4e-5,
            keystone_along: -6e-5,
            ..LensModel::perfect(2048, COLUMNS)
        }
    }

    /// What a lens shows of a pin that a perfect one shows from row 137 to row 1908 and a taper, by
    /// bisection.
    fn seen(lens: &LensModel, form_px: impl Fn(usize) -> f64) -> FrameEdges {
        let edge = |column: usize, ideal: f64| {
            let (mut low, mut high) = (0.0, 2400.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if lens.ideal_row(column as f64, middle) < ideal { low = middle } else { high = middle }
            }
            Edge { row_px: low, u_own_px: 1e-6, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good }
        };
        let (top, bottom) =
            (0..COLUMNS).map(|c| (edge(c, 137.0), edge(c, 1908.0 + 1e-4 * c as f64 + form_px(c)))).unzip();
        FrameEdges { top, bottom, ..FrameEdges::default() }
    }

    fn scatter(edges: &FrameEdges) -> Scatter {
        Scatter::of_blocks(edges, &ColumnMeans::over(edges, 0..COLUMNS).unwrap())
    }

    /// A perfect pin behind a lens of .05 % distortion: its widths scatter by the lens alone, for
    /// which the diameter is corrected.
    #[test]
    fn distortion_is_not_taken_for_form() {
        let lens = lens();
        let pin = scatter(&seen(&lens, |_| 0.0));
        let (uncorrected, _) = pin.u_px(None, 0.0);
        let (corrected, freedom) = pin.u_px(Some(&lens), 0.0);
        assert!((0.03..0.06).contains(&uncorrected), "{uncorrected}");
        assert!(corrected < 1e-5 && freedom == 10.0, "{corrected} {freedom}");
    }

    /// Form of the part itself remains: waves of which a block holds one half.
    #[test]
    fn form_of_the_part_stays_in() {
        let lens = lens();
        let wave = |c: usize| if (c * 12 / COLUMNS).is_multiple_of(2) { 0.1 } else { -0.1 };
        let (u_px, _) = scatter(&seen(&lens, wave)).u_px(Some(&lens), 0.0);
        // ± 0.1 px in 12 blocks, hardly less about a line: 0.1·√(12/10/12).
        assert!((u_px / (0.1 * 0.1_f64.sqrt()) - 1.0).abs() < 0.03, "{u_px}");
        let noisy = scatter(&seen(&lens, wave)).u_px(Some(&lens), 0.03).0;
        assert!((noisy.hypot(0.03) / u_px - 1.0).abs() < 1e-9);
    }

    /// Two blocks lie on any line: below 48 columns the row was 0.
    #[test]
    fn few_columns_do_not_hide_their_form() {
        let lens = lens();
        for columns in [9, 30, 40, 47] {
            let middle = 1000 + columns / 3..1000 + 2 * columns / 3;
            let edges = seen(&lens, |c| if middle.contains(&c) { 0.1 } else { 0.0 });
            let over = ColumnMeans::over(&edges, 1000..1000 + columns).unwrap();
            let (u_px, freedom) = Scatter::of_blocks(&edges, &over).u_px(Some(&lens), 0.2);
            // 0, 0.1, 0 about a line: √(0.01·2/3/3), and noise stays in.
            assert!(freedom == 1.0 && (u_px / 0.0471 - 1.0).abs() < 0.02, "{columns}: {u_px} {freedom}");
        }
    }
}
