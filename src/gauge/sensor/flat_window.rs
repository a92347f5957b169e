//! The flat field of a part of the frames that it was made from.
//!
//! The light over a window is the same quadratic surface in other coordinates. With columns
//! c = c₀ + c' of N and n columns, u = 2c/(N − 1) − 1 and u' likewise,
//!
//! ```text
//! u = α·u' + β,   α = (n − 1)/(N − 1),   β = 2·c₀/(N − 1) + α − 1
//! ```
//!
//! and v likewise by rows: exact, nothing is fitted again. The surface is scaled to 1 at its
//! brightest in the window: all grey values of a window then differ from those of the whole frame
//! by one factor, which moves no edge.

use super::flat_field::{FlatField, extremes};
use crate::frame::Roi;

/// α and β of `part` pixels from pixel `from` of `whole`.
fn coordinates(from: u32, part: u32, whole: usize) -> (f64, f64) {
    let last = (whole as f64 - 1.0).max(1.0);
    let scale = (f64::from(part) - 1.0) / last;
    (scale, 2.0 * f64::from(from) / last + scale - 1.0)
}

impl FlatField {
    /// The flat field of a window that lies inside its frames, in their rows and columns.
    #[must_use]
    pub(crate) fn within(&self, window: Roi) -> Self {
        let (a, b) = coordinates(window.column, window.columns, self.columns);
        let (c, d) = coordinates(window.row, window.rows, self.rows);
        let [l0, l1, l2, l3, l4, l5] = self.light;
        let mut light = [
            l0 + l1 * b + l2 * d + l3 * b * b + l4 * b * d + l5 * d * d,
            a * (l1 + 2.0 * l3 * b + l4 * d),
            c * (l2 + 2.0 * l5 * d + l4 * b),
            a * a * l3,
            a * c * l4,
            c * c * l5,
        ];
        let (low, high) = extremes(&light);
        light.iter_mut().for_each(|l| *l /= high);
        let inside = |[row, column]: &[u32; 2]| {
            let row = row.checked_sub(window.row).filter(|row| *row < window.rows)?;
            let column = column.checked_sub(window.column).filter(|column| *column < window.columns)?;
            Some([row, column])
        };
        Self {
            rows: window.rows as usize,
            columns: window.columns as usize,
            light,
            fall_off: 1.0 - low / high,
            defects: self.defects.iter().filter_map(inside).collect(),
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::flat_field::unit;
    use super::*;

    fn field() -> FlatField {
        let mut light = [0.94, 0.01, -0.02, -0.03, 0.015, -0.025];
        let (low, high) = extremes(&light);
        light.iter_mut().for_each(|l| *l /= high);
        FlatField {
            rows: 101,
            columns: 161,
            black_counts: 64.0,
            light,
            fall_off: 1.0 - low / high,
            defects: vec![[3, 7], [40, 60], [40, 99], [80, 159]],
            prnu_rel: 0.005,
            dsnu_counts: 0.3,
            response: None,
        }
    }

    fn at(field: &FlatField, row: usize, column: usize) -> f64 {
        let (u, v) = (unit(column, field.columns), unit(row, field.rows));
        let l = field.light;
        l[0] + l[1] * u + l[2] * v + l[3] * u * u + l[4] * u * v + l[5] * v * v
    }

    #[test]
    fn a_window_has_the_same_light_by_one_factor_and_its_own_defects() {
        let whole = field();
        let window = Roi { row: 20, column: 40, rows: 61, columns: 60 };
        let part = whole.within(window);
        let factor = at(&whole, 20, 40) / at(&part, 0, 0);
        for (row, column) in [(0, 59), (60, 0), (60, 59), (31, 17)] {
            let ratio = at(&whole, row + 20, column + 40) / at(&part, row, column);
            assert!((ratio / factor - 1.0).abs() < 1e-14, "{row} {column}: {ratio} {factor}");
        }
        assert_eq!(part.defects, [[20, 20], [20, 59]]);
        assert!(part.impossible_light().is_none() && part.impossible_defects().is_none());
        assert!(part.fall_off < whole.fall_off);
    }

    #[test]
    fn the_whole_window_changes_nothing() {
        let whole = field();
        let part = whole.within(Roi { row: 0, column: 0, rows: 101, columns: 161 });
        let largest = part.light.iter().zip(&whole.light).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest < 1e-15 && part.defects == whole.defects, "{largest}");
    }
}
