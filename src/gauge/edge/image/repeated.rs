//! Rows and columns that repeat: lines doubled by a frame grabber, half pictures filled up,
//! pictures enlarged by whole factors.
//!
//! Two neighbouring lines of a noisy picture are never the same in every pixel: with at least 3/8
//! of the pixels differing from line to line, a chance of (5/8)⁶⁴ = 9e-14 a pair. Lines that are
//! the same between neighbours that differ so are repeated; where neighbours hardly differ (a
//! picture without noise) equal grey values are no evidence. Runs of up to three pairs (enlarged
//! four times) are looked for: longer ones are also what compression leaves of a flat field.

use std::fmt;

use super::plane::{Plane, Sample};
use crate::gauge::limit::limits;

limits! {
    /// When equal lines of pixels repeat each other.
    RepeatedLimits = "repeated";
    /// Fewest pixels of a line that are evidence: chance makes two lines of a noisy picture equal
    /// in 48 pixels with a probability of (5/8)⁴⁸ = 2e-10.
    least_places: usize = 48;
    /// Pixels compared that lie side by side: sixteen of four bytes are read as one line of the
    /// cache.
    cluster: usize = 16;
    /// Most equal pairs in a row that are looked for: a picture enlarged four times. Longer runs
    /// are also what compression leaves of a flat field.
    longest_run: usize = 3;
}

/// Pixels of a line that are compared, the length of an array: see the chance above.
const PLACES: usize = 64;

/// Lines that repeat the one before them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RepeatedLines {
    /// "row" or "column".
    pub(crate) line: &'static str,
    /// The first that is repeated.
    pub(crate) first: usize,
    /// How many repeat the one before them.
    pub(crate) count: usize,
    /// Pairs of neighbours.
    of: usize,
}

impl fmt::Display for RepeatedLines {
    /// What was seen and what would be right.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, first, count, of } = *self;
        write!(
            f,
            "{line}s {first} and {} are the same to the last grey value, and so are {count} of {of} pairs: repeated {line}s (line doubling, half \
             pictures filled up, a picture enlarged) hold no edge of their own and count noise twice; give the frames as the sensor delivers them",
            first + 1
        )
    }
}

/// Looks for repeated rows, then for repeated columns.
pub(crate) fn repeated_lines<T: Sample>(plane: &Plane<'_, T>) -> Option<RepeatedLines> {
    let (along, across) = (places(plane.columns), places(plane.rows));
    let rows = scan("row", plane.rows, &along.0[..along.1], |line, place| plane.at(line, place));
    rows.or_else(|| scan("column", plane.columns, &across.0[..across.1], |line, place| plane.at(place, line)))
}

/// Places along a line in clusters spread over it; none where there are too few.
fn places(length: usize) -> ([usize; PLACES], usize) {
    let limits = RepeatedLimits::get();
    let clusters = PLACES / limits.cluster;
    let first = |k: usize| ((2 * k + 1) * length / (2 * clusters)).saturating_sub(limits.cluster / 2);
    let spread = length >= PLACES;
    let place = |i: usize| if spread { first(i / limits.cluster) + i % limits.cluster } else { i };
    let count = if length < limits.least_places { 0 } else { length.min(PLACES) };
    (std::array::from_fn(place), count)
}

fn scan(
    line: &'static str,
    lines: usize,
    places: &[usize],
    at: impl Fn(usize, usize) -> f32,
) -> Option<RepeatedLines> {
    let limits = RepeatedLimits::get();
    if places.is_empty() {
        return None;
    }
    let enough = 3 * places.len() / 8;
    let (mut found, mut run, mut differed) = (None::<RepeatedLines>, 0, false);
    for upper in 0..lines - 1 {
        let different = places.iter().filter(|p| at(upper, **p) != at(upper + 1, **p)).take(enough).count();
        if different == 0 {
            run += 1;
            continue;
        }
        let differs = different >= enough;
        // A row that is one grey value throughout (a level edge without noise) repeats nothing.
        let varies = || {
            let along = places.windows(2).filter(|p| at(upper, p[0]) != at(upper, p[1]));
            2 * along.count() >= enough
        };
        if differs && differed && (1..=limits.longest_run).contains(&run) && varies() {
            found.get_or_insert(RepeatedLines { line, first: upper - run, count: 0, of: lines - 1 }).count +=
                run;
        }
        (differed, run) = (differs, 0);
    }
    found
}
