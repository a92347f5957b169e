//! Shadows with light on both sides, whatever the light's own form.
//!
//! Down a column of grey values v let
//!
//! ```text
//! fill(r) = min(max v over rows ≤ r, max v over rows ≥ r)
//! ```
//!
//! be the level to which a valley fills before it overflows (morphological reconstruction by
//! erosion from the two ends, Vincent, IEEE Trans. Image Process. 2 (1993) 176, in one dimension).
//! Where light rises to one maximum or falls off to one side, fill = v, however steeply; a shadow
//! with light on both sides is a valley, and black with light on one side only (a vignette, the
//! margin of an undistorted picture) is none. A cell is shadow where it lies below the middle
//! between its valley's floor and its fill. No level of the whole frame is needed, so that light
//! may fall off by as much as its noise allows.
use crate::gauge::limit::limits;

limits! {
    /// When a valley of grey values is a shadow.
    ValleyLimits = "valleys";
    /// Depth of a valley in standard deviations of the noise: of a hundred thousand cells of noise
    /// none is as deep.
    least_depth_sigmas: f32 = 8.0;
    /// Depth of a valley over the frame's whole range of grey values: a part is opaque; what hardly
    /// dims the light is mist or a film. Tuned: see study limits.
    least_depth_share: f32 = 0.03;
    /// Cells of a row between two shadow cells that count as shadow: a stuck column of the sensor
    /// does not cut a part in two. A cell is a pixel or more, so that four columns side by side
    /// are bridged.
    bridge: usize = 4;
    /// Share of the way from shadow to light below which a pixel is shadow: below the middle, which
    /// is the edge, so that a pixel of the shadow is one to two thirds at least.
    shadow_level: f64 = 0.35;
}

/// The valleys of a thinned image, row by row; buffers that a stream keeps. `shares` and `fill`
/// have one entry a cell and are arrays apart: the flood runs over whole rows of `fill` in lanes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Valleys {
    /// 0 at the floor of a valley, 1 in the light.
    pub(crate) shares: Vec<f32>,
    /// Level below which a pixel is shadow, for each column of the grid; NaN without a valley.
    pub(crate) shadow: Vec<f32>,
    fill: Vec<f32>,
    highest: Vec<f32>,
    differences: Vec<f32>,
}

/// Whether short gaps of a row between shadow cells count as shadow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bridged {
    /// They do: of a part that is longer than the gap, as a shaft is.
    Yes,
    /// They are light: a bore's.
    No,
}

/// Middle of three values.
fn median_of_three(a: f32, b: f32, c: f32) -> f32 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    if c < low {
        low
    } else if c > high {
        high
    } else {
        c
    }
}

/// Replaces each cell by the median of itself and the cells above and below: single hot and dead
/// pixels and stuck rows go, what is two cells high stays.
pub(crate) fn median_down(values: &mut [f32], columns: usize, above: &mut Vec<f32>) {
    if values.len() < 3 * columns {
        return;
    }
    above.clear();
    above.extend_from_slice(&values[..columns]);
    for row in 1..values.len() / columns - 1 {
        let (before, after) = values.split_at_mut((row + 1) * columns);
        let line = &mut before[row * columns..];
        for ((value, above), below) in line.iter_mut().zip(above.iter_mut()).zip(&after[..columns]) {
            let own = *value;
            *value = median_of_three(*above, own, *below);
            *above = own;
        }
    }
}

impl Valleys {
    /// Finds the valleys of a grid of so many columns.
    pub(crate) fn find(&mut self, values: &[f32], columns: usize, bridged: Bridged) {
        self.flood(values, columns);
        let least = self.least_depth(values, columns);
        self.shares.clear();
        self.shares.resize(values.len(), 1.0);
        for column in 0..columns {
            self.share_out(values, columns, column, least);
        }
        if bridged == Bridged::Yes {
            self.shares.chunks_exact_mut(columns).for_each(bridge);
        }
    }

    /// Fill of every cell.
    fn flood(&mut self, values: &[f32], columns: usize) {
        let Self { fill, highest, .. } = self;
        fill.clear();
        fill.extend_from_slice(values);
        for row in 1..values.len() / columns {
            let (above, line) = fill.split_at_mut(row * columns);
            let above = &above[(row - 1) * columns..];
            line[..columns].iter_mut().zip(above).for_each(|(v, a)| *v = v.max(*a));
        }
        highest.clear();
        highest.resize(columns, f32::NEG_INFINITY);
        for (fill, values) in fill.chunks_exact_mut(columns).zip(values.chunks_exact(columns)).rev() {
            for ((fill, highest), value) in fill.iter_mut().zip(highest.iter_mut()).zip(values) {
                *highest = highest.max(*value);
                *fill = fill.min(*highest);
            }
        }
    }

    /// Depth from which a valley counts, counts: by the scatter of neighbours in a row and the
    /// range of the grey values.
    fn least_depth(&mut self, values: &[f32], columns: usize) -> f32 {
        let limits = ValleyLimits::get();
        let step = (values.len() / 4096).max(1);
        self.differences.clear();
        let pairs = (0..values.len().saturating_sub(1)).step_by(step).filter(|k| (k + 1) % columns != 0);
        self.differences.extend(pairs.map(|k| (values[k + 1] - values[k]).abs()));
        if self.differences.is_empty() {
            return f32::INFINITY;
        }
        let middle = self.differences.len() / 2;
        let (_, median, _) = self.differences.select_nth_unstable_by(middle, f32::total_cmp);
        // The median of |difference| of two normal values is 0.954 of their standard deviation.
        let noise = *median / 0.954;
        let range =
            values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        (limits.least_depth_sigmas * noise)
            .max(limits.least_depth_share * (range.1 - range.0))
            .max(f32::MIN_POSITIVE)
    }

    /// Shares of the valleys of one column that are deep enough.
    fn share_out(&mut self, values: &[f32], columns: usize, column: usize, least: f32) {
        let rows = values.len() / columns;
        let mut row = 0;
        while row < rows {
            let at = |row: usize| row * columns + column;
            let from = row;
            let (mut floor, mut depth) = (f32::INFINITY, 0.0_f32);
            while row < rows && values[at(row)] < self.fill[at(row)] {
                floor = floor.min(values[at(row)]);
                depth = depth.max(self.fill[at(row)] - values[at(row)]);
                row += 1;
            }
            if depth >= least {
                for cell in (from..row).map(at) {
                    self.shares[cell] =
                        (values[cell] - floor) / (self.fill[cell] - floor).max(f32::MIN_POSITIVE);
                }
            }
            row += usize::from(row == from);
        }
    }

    /// Levels of the pixels' own threshold in each column of a part's spans; a bridged column has
    /// its neighbour's.
    pub(crate) fn set_levels(&mut self, values: &[f32], spans: &[Option<(usize, usize)>]) {
        let limits = ValleyLimits::get();
        let columns = spans.len();
        self.shadow.clear();
        let mut last = f32::NAN;
        for (column, span) in spans.iter().enumerate() {
            let Some((first, end)) = span else {
                self.shadow.push(f32::NAN);
                continue;
            };
            let (mut sum, mut fill, mut count) = (0.0, f32::INFINITY, 0.0_f32);
            for cell in (*first..=*end).map(|row| row * columns + column) {
                if values[cell] < self.fill[cell] {
                    (sum, fill, count) = (sum + values[cell], fill.min(self.fill[cell]), count + 1.0);
                }
            }
            if 2.0 * count > (end - first) as f32 {
                let floor = sum / count;
                last = floor + limits.shadow_level as f32 * (fill - floor);
            }
            self.shadow.push(last);
        }
    }
}

/// Counts short gaps between the shadow cells of a row as shadow.
fn bridge(row: &mut [f32]) {
    let limits = ValleyLimits::get();
    let mut last = None;
    for column in 0..row.len() {
        if row[column] < 0.5 {
            if let Some(from) = last.filter(|from| column - from <= limits.bridge + 1) {
                row[from + 1..column].fill(0.0);
            }
            last = Some(column);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares of one column.
    fn shares(values: &[f32]) -> Vec<f32> {
        let mut valleys = Valleys::default();
        // Two equal columns: neighbours in a row have no noise.
        let grid: Vec<f32> = values.iter().flat_map(|v| [*v, *v]).collect();
        valleys.find(&grid, 2, Bridged::No);
        valleys.shares.iter().step_by(2).copied().collect()
    }

    #[test]
    fn light_that_only_rises_and_falls_and_black_margins_have_no_valley() {
        let spot: Vec<f32> = (0..200).map(|r| 200.0 * (-((r as f32 - 70.0) / 40.0).powi(2)).exp()).collect();
        assert!(shares(&spot).iter().all(|s| *s == 1.0));
        let margins: Vec<f32> = (0..200).map(|r| if (30..170).contains(&r) { 180.0 } else { 0.0 }).collect();
        assert!(shares(&margins).iter().all(|s| *s == 1.0));
    }

    #[test]
    fn a_shadow_is_found_between_light_of_any_two_levels() {
        for (above, below) in [(200.0, 200.0), (200.0, 50.0), (30.0, 240.0)] {
            let light = |r: usize| above + (below - above) * r as f32 / 199.0;
            let values: Vec<f32> = (0..200)
                .map(|r| {
                    if r < 20 {
                        0.0
                    } else if (80..120).contains(&r) {
                        15.0
                    } else {
                        light(r)
                    }
                })
                .collect();
            for (row, share) in shares(&values).iter().enumerate() {
                assert_eq!(*share < 0.5, (80..120).contains(&row), "{above} {below}: row {row} {share}");
            }
        }
    }

    #[test]
    fn stuck_rows_go_and_stuck_columns_are_bridged() {
        let (rows, columns) = (60, 40);
        let mut grid: Vec<f32> = (0..rows * columns)
            .map(|k| if (20..40).contains(&(k / columns)) { 10.0 } else { 200.0 })
            .collect();
        grid[30 * columns..31 * columns].fill(250.0);
        for row in 0..rows {
            grid[row * columns + 17] = 250.0;
            grid[row * columns + 23] = 0.0;
        }
        median_down(&mut grid, columns, &mut Vec::new());
        let mut valleys = Valleys::default();
        valleys.find(&grid, columns, Bridged::Yes);
        for (k, share) in valleys.shares.iter().enumerate() {
            assert_eq!(*share < 0.5, (20..40).contains(&(k / columns)), "cell {k}");
        }
    }
}
