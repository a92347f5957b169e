//! The caliper of crests that face roots: knurls, feed marks, threads.
//!
//! A jaw of a caliper touches the crests, wherever the roots of the other side are: the diameter is
//! the distance of the two tangents, not the largest width of a column. The axis is the line midway
//! between both sides' own lines; each side's largest height above it is found over a stretch of
//! `crests.pitches` pitches, so that both jaws touch crests of the same place.

use super::largest_value::{Choice, Largest, Line};
use crate::gauge::edges::{Edge, FrameEdges};
use crate::gauge::limit::limits;
use crate::gauge::width::reused::Reused;

limits! {
    /// When crests face roots.
    CrestLimits = "crests";
    /// Columns whose mean shows whether the middle leaves the axis: half a pitch of ten or more has
    /// two blocks.
    block_columns: usize = 5;
    /// Sign changes of the middle about the axis from which on crests and roots alternate: two
    /// pitches.
    least_changes: usize = 4;
    /// Departure of a block's middle, in its standard uncertainties, that counts for a sign: 6·10⁻⁵
    /// of blocks on the axis have more.
    significant: f64 = 4.0;
    /// Least amplitude of the middle, px: vibration and texture are below it and remain with the
    /// columns.
    least_px: f64 = 0.1;
    /// Stretch over which both jaws touch, pitches: one crest of either side at least, wherever it
    /// begins.
    pitches: f64 = 2.5;
    /// Relative standard deviation of half a pitch, up to which it is that of a thread or knurl:
    /// blocks of five columns leave 1.4 px of ten or more.
    most_uneven: f64 = 0.3;
    /// Shortest such stretch, columns: the widest mean's (`largest_value.widest_mean`), so that the
    /// largest value of a fine thread is no more local than a cylinder's.
    shortest: f64 = 65.0;
}

/// Crests and roots of a frame.
pub(crate) struct Crests {
    top: Line,
    bottom: Line,
    /// Pitch, px.
    pub(crate) pitch_px: f64,
    /// Relative standard deviation of half a pitch.
    unevenness: f64,
    columns: usize,
}

/// Pitch of crests that face roots, px, where the frame shows such at even distances: contamination
/// on both sides alternates, but not evenly.
pub(crate) fn crest_pitch_px(edges: &FrameEdges) -> Option<f64> {
    let limits = CrestLimits::get();
    Crests::find(edges).filter(|crests| crests.unevenness <= limits.most_uneven).map(|crests| crests.pitch_px)
}

/// A side's heights above the axis as points of a line.
fn heights(line: &[Edge], axis: impl Fn(f64) -> f64, sign: f64) -> Line {
    let points: Reused<(f64, f64, f64, f64)> = line
        .iter()
        .enumerate()
        .filter(|(_, edge)| edge.is_usable())
        .map(|(column, edge)| {
            let x = column as f64;
            let height = sign * (edge.row_px - axis(x));
            (x, height, height, f64::from(edge.u_own_px))
        })
        .collect();
    Line::new(&points)
}

/// Slope of the line through the outermost edge of every whole pitch of a side; `None` for fewer
/// than three.
fn crest_slope(line: &[Edge], sign: f64, pitch_px: f64) -> Option<f64> {
    let count = (line.len() as f64 / pitch_px).floor() as usize;
    let crests: Reused<(f64, f64)> = (0..count)
        .filter_map(|k| {
            let (from, to) = ((k as f64 * pitch_px) as usize, ((k + 1) as f64 * pitch_px) as usize);
            let usable = (from..to.min(line.len())).filter(|c| line[*c].is_usable());
            let top = usable.max_by(|a, b| (sign * line[*a].row_px).total_cmp(&(sign * line[*b].row_px)))?;
            Some((top as f64, line[top].row_px))
        })
        .collect();
    let through = crate::numerics::line::Line::through(crests.iter().copied());
    (crests.len() >= 3 && through.square > 0.0).then(|| through.slope())
}

/// Intercept and slope of the line through a side's usable edges.
fn straight(line: &[Edge]) -> Option<(f64, f64)> {
    let (mut n, mut sx, mut sy, mut sxx, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (column, edge) in line.iter().enumerate().filter(|(_, edge)| edge.is_usable()) {
        let x = column as f64;
        (n, sx, sy, sxx, sxy) = (n + 1.0, sx + x, sy + edge.row_px, sxx + x * x, sxy + x * edge.row_px);
    }
    let spread = n * sxx - sx * sx;
    (spread > 0.0).then(|| {
        let slope = (n * sxy - sx * sy) / spread;
        ((sy - slope * sx) / n, slope)
    })
}

impl Crests {
    /// Finds them; `None` where the middle of the shadow keeps to its axis or departs from it
    /// slowly.
    pub(crate) fn find(edges: &FrameEdges) -> Option<Self> {
        let (a, b) = (straight(&edges.top)?, straight(&edges.bottom)?);
        let axis = |x: f64| 0.5 * (a.0 + b.0 + (a.1 + b.1) * x);
        let (pitch_px, unevenness) = pitch(edges, axis)?;
        // Roots and flanks tilt a side's own line where the field shows no whole number of pitches;
        // its crests do not.
        let crest_slopes =
            crest_slope(&edges.top, -1.0, pitch_px).zip(crest_slope(&edges.bottom, 1.0, pitch_px));
        let slope = crest_slopes.map_or(0.5 * (a.1 + b.1), |(top, bottom)| 0.5 * (top + bottom));
        let axis = |x: f64| 0.5 * (a.0 + b.0) + slope * x;
        Some(Self {
            top: heights(&edges.top, axis, -1.0),
            bottom: heights(&edges.bottom, axis, 1.0),
            pitch_px,
            unevenness,
            columns: edges.columns(),
        })
    }

    /// Largest distance of the tangents over a stretch of `crests.pitches` pitches.
    pub(crate) fn tangents(&self, least: usize) -> Option<Largest> {
        let limits = CrestLimits::get();
        let length = (limits.pitches * self.pitch_px).max(limits.shortest).min(self.columns as f64);
        let mut best: [Option<(f64, Choice, Choice)>; 2] = [None, None];
        let last = self.columns as f64 - length;
        let steps = (4.0 * last / length).ceil().max(0.0) as usize;
        for k in 0..=steps {
            let from = if steps == 0 { 0.0 } else { last * k as f64 / steps as f64 };
            let (top, bottom) = (within(&self.top, from, length), within(&self.bottom, from, length));
            for (parity, best) in best.iter_mut().enumerate() {
                let chosen =
                    self.top.choose(&top, least, parity).zip(self.bottom.choose(&bottom, least, parity));
                let Some((a, b)) = chosen else { continue };
                let score = a.score + b.score;
                if best.as_ref().is_none_or(|known| score > known.0) {
                    *best = Some((score, a, b));
                }
            }
        }
        let [Some((_, top_a, bottom_a)), Some((_, top_b, bottom_b))] = best else { return None };
        let (top, bottom) = (self.top.measured([top_a, top_b])?, self.bottom.measured([bottom_a, bottom_b])?);
        Some(Largest {
            value_px: top.value_px + bottom.value_px,
            u_px: top.u_px.hypot(bottom.u_px),
            u_noise_px: top.u_noise_px.hypot(bottom.u_noise_px),
            column_px: 0.5 * (top.column_px + bottom.column_px),
            columns: (top.columns.0.min(bottom.columns.0), top.columns.1.max(bottom.columns.1)),
        })
    }
}

/// Points of a line in a stretch.
fn within(line: &Line, from: f64, length: f64) -> std::ops::Range<usize> {
    let start = line.x.partition_point(|x| *x < from);
    let end = line.x.partition_point(|x| *x <= from + length);
    start..end.max(start)
}

/// Pitch of crests that face roots, px: twice the mean distance of the middle's changes of side;
/// with that distance's relative scatter.
fn pitch(edges: &FrameEdges, axis: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
    let limits = CrestLimits::get();
    let (mut side, mut changes) = (0.0, Reused::<f64>::from_iter([]));
    let (mut square, mut count) = (0.0, 0.0);
    for from in (0..edges.columns()).step_by(limits.block_columns) {
        let (mut sum, mut variance, mut n) = (0.0, 0.0, 0.0);
        for column in from..(from + limits.block_columns).min(edges.columns()) {
            if edges.width_px(column).is_none() {
                continue;
            }
            let (top, bottom) = (&edges.top[column], &edges.bottom[column]);
            sum += 0.5 * (top.row_px + bottom.row_px) - axis(column as f64);
            variance += 0.25 * (f64::from(top.u_own_px).powi(2) + f64::from(bottom.u_own_px).powi(2));
            n += 1.0;
        }
        if n == 0.0 {
            continue;
        }
        let (mean, u) = (sum / n, variance.sqrt() / n);
        (square, count) = (square + mean * mean, count + 1.0);
        if mean.abs() <= limits.significant * u {
            continue;
        }
        let now = mean.signum();
        if now != side {
            if side != 0.0 {
                changes.push(from as f64);
            }
            side = now;
        }
    }
    let amplitude = (2.0 * square / f64::max(count, 1.0)).sqrt();
    if changes.len() < limits.least_changes || amplitude < limits.least_px {
        return None;
    }
    let n = (changes.len() - 1) as f64;
    let half = (changes[changes.len() - 1] - changes[0]) / n;
    let variance = changes.windows(2).map(|pair| (pair[1] - pair[0] - half).powi(2)).sum::<f64>() / n;
    Some((2.0 * half, variance.sqrt() / half))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    use super::*;
    use crate::gauge::edges::EdgeState;
    use crate::gauge::width::stretch::largest_value::LEAST_STRETCH;

    const U_PX: f64 = 0.02;

    fn frame(seed: u64, wave: impl Fn(f64) -> f64) -> FrameEdges {
        let noise = Normal::new(0.0, U_PX).unwrap();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut edge = |row: f64| Edge {
            row_px: row + noise.sample(&mut rng),
            u_own_px: U_PX as f32,
            u_shared_px: 0.0,
            chi2: 1.0,
            state: EdgeState::Good,
        };
        let mut edges = FrameEdges::default();
        for column in 0..400 {
            let x = f64::from(column);
            edges.top.push(edge(60.2 + 0.003 * x + wave(x)));
            edges.bottom.push(edge(140.6 + 0.003 * x + wave(x)));
        }
        edges
    }

    #[test]
    fn tangents_touch_the_crests_of_both_sides_within_u() {
        for (amplitude, pitch) in [(1.5, 24.0), (0.2, 30.0), (0.13, 40.0), (0.5, 11.0)] {
            let (mut mean, mut square, trials) = (0.0, 0.0, 20);
            for seed in 0..trials {
                let wave = |x: f64| amplitude * (std::f64::consts::TAU * x / pitch).cos();
                let crests = Crests::find(&frame(seed, wave)).unwrap();
                assert!((crests.pitch_px / pitch - 1.0).abs() < 0.1, "{}", crests.pitch_px);
                let found = crests.tangents(LEAST_STRETCH).unwrap();
                let error = (found.value_px - 80.4 - 2.0 * amplitude) / found.u_px;
                (mean, square) = (mean + error, square + error * error);
            }
            let n = trials as f64;
            println!(
                "crests of {amplitude} px every {pitch} px: mean {:.2} u, rms {:.2} u",
                mean / n,
                (square / n).sqrt()
            );
            assert!((square / n).sqrt() < 1.8, "{amplitude} {pitch}: {mean} {square}");
        }
    }

    #[test]
    fn a_cylinder_a_bend_and_a_bump_have_no_crests() {
        let forms: [fn(f64) -> f64; 3] =
            [|_| 0.0, |x| 2e-5 * (x - 200.0).powi(2), |x| if x > 200.0 { 0.5 } else { 0.0 }];
        for wave in forms {
            assert!(Crests::find(&frame(1, wave)).is_none());
        }
    }
}
