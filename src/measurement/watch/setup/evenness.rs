//! Light outside of the part against an even one: of a frame that the calibrated flat field has
//! corrected, what has changed since then (a window that is contaminated, a light that moved).

use crate::frame::FrameView;
use crate::gauge::FrameEdges;
use crate::numerics::robust::median_of;

/// Tiles along either side: one is some per cent of the field, as a drop on the window is.
const TILES: usize = 12;
/// Pixels of a tile that are looked at, along either side: noise of 1 % leaves 0.06 %.
const PIXELS: usize = 16;
/// Fewest tiles that a median is of.
const LEAST: usize = 8;
/// Blurs from an edge to where its light is even: beyond eight a Gaussian is, and a wide base of
/// the edge-spread function mostly.
const CLEAR: f64 = 8.0;

/// How even the light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Evenness {
    /// Departure of the darkest tile from the median of all, below 0.
    pub lowest: f64,
    /// Row and column of the middle of that tile.
    pub lowest_at: [usize; 2],
    /// Departure of the brightest tile.
    pub highest: f64,
    /// Tiles that are lit wholly, of 144.
    pub tiles: usize,
}

impl Evenness {
    /// The light of a frame outside of the part; without edges of all of it. `None` where too few
    /// tiles are lit.
    pub(super) fn of(view: &FrameView<'_>, edges: Option<&FrameEdges>, black: f64) -> Option<Self> {
        let mut tiles: Vec<(f64, [usize; 2])> = Vec::new();
        for i in 0..TILES {
            for j in 0..TILES {
                let rows = [i * view.rows() / TILES, (i + 1) * view.rows() / TILES];
                let columns = [j * view.columns() / TILES, (j + 1) * view.columns() / TILES];
                let is_lit = edges.is_none_or(|edges| is_clear(edges, rows, columns));
                if let Some(level) = is_lit.then(|| mean(view, rows, columns)).flatten() {
                    tiles.push((level - black, [rows[0].midpoint(rows[1]), columns[0].midpoint(columns[1])]));
                }
            }
        }
        let median = median_of(tiles.iter().map(|tile| tile.0).collect());
        if tiles.len() < LEAST || !(median > 0.0) {
            return None;
        }
        let by_level = |a: &&(f64, [usize; 2]), b: &&(f64, [usize; 2])| a.0.total_cmp(&b.0);
        let (lowest, highest) = (tiles.iter().min_by(by_level)?, tiles.iter().max_by(by_level)?);
        Some(Self {
            lowest: lowest.0 / median - 1.0,
            lowest_at: lowest.1,
            highest: highest.0 / median - 1.0,
            tiles: tiles.len(),
        })
    }
}

/// Whether a tile lies clear of both edges in all of its columns.
fn is_clear(edges: &FrameEdges, rows: [usize; 2], [from, to]: [usize; 2]) -> bool {
    let clear_px = CLEAR * edges.figures.sigma_px[0].max(edges.figures.sigma_px[1]);
    let sides = edges.top.iter().zip(&edges.bottom).take(to).skip(from);
    let mut columns = sides.filter(|(top, bottom)| top.is_usable() && bottom.is_usable()).peekable();
    // Without an edge in any column it is not known where the part is.
    columns.peek().is_some()
        && columns.all(|(top, bottom)| {
            (rows[1] as f64) < top.row_px - clear_px || rows[0] as f64 > bottom.row_px + clear_px
        })
}

fn mean(view: &FrameView<'_>, [top, bottom]: [usize; 2], [left, right]: [usize; 2]) -> Option<f64> {
    let by = |from: usize, to: usize| (to - from).div_ceil(PIXELS).max(1);
    let rows = (top..bottom).step_by(by(top, bottom));
    let places = rows.flat_map(|row| (left..right).step_by(by(left, right)).map(move |c| (row, c)));
    let seen: Vec<f64> = places.filter_map(|(r, c)| view.get(r, c)).map(f64::from).collect();
    (!seen.is_empty()).then(|| seen.iter().sum::<f64>() / seen.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Frame, FrameMeta};
    use crate::gauge::{Edge, EdgeState, FrameFigures};

    /// A part from row 100 to 140, light of 510 over a black of 10, and a drop that takes 20 % of
    /// the light around row 30, column 210.
    fn frame() -> Frame {
        let grey = |row: usize, column: usize| {
            let is_part = (100..140).contains(&row);
            let is_drop = (20..40).contains(&row) && (200..220).contains(&column);
            if is_part {
                10.0
            } else if is_drop {
                410.0
            } else {
                510.0
            }
        };
        let all = (0..240).flat_map(|row| (0..240).map(move |column| grey(row, column)));
        Frame::linear(all.collect(), 240, 240, Some(1000.0), FrameMeta::default())
    }

    #[test]
    fn a_drop_on_the_window_is_named_and_the_part_left_out() {
        let edge =
            |row_px| Edge { row_px, u_own_px: 0.01, u_shared_px: 0.0, chi2: 1.0, state: EdgeState::Good };
        let edges = FrameEdges {
            top: vec![edge(99.5); 240],
            bottom: vec![edge(139.5); 240],
            figures: FrameFigures { sigma_px: [1.0; 2], ..FrameFigures::default() },
            ..FrameEdges::default()
        };
        let found = Evenness::of(&frame().view(), Some(&edges), 10.0).unwrap();
        assert!((found.lowest + 0.2).abs() < 1e-6 && found.highest.abs() < 1e-12, "{found:?}");
        // Tiles are 20 px wide: four rows of them above, four below are clear of the part.
        assert_eq!((found.lowest_at, found.tiles), ([30, 210], 8 * 12));
        // Without edges the part is the darkest.
        assert!(Evenness::of(&frame().view(), None, 10.0).unwrap().lowest < -0.99);
        let nowhere = FrameEdges { top: vec![edge(0.0); 240], bottom: vec![edge(239.0); 240], ..edges };
        assert_eq!(Evenness::of(&frame().view(), Some(&nowhere), 10.0), None);
    }
}
