//! Pose of the axis of a straight part in a frame: its slope and that of the flanks, and their
//! effect on a width.

use crate::gauge::edges::FrameEdges;
use crate::gauge::width::reused::Reused;
use crate::numerics::line::Line;

/// Slopes of the axis and of the flanks in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pose {
    /// Slope tan τ of the axis, rows per column.
    pub tan_tilt: f64,
    /// Slope tan α of the flanks, rows per column.
    pub tan_taper: f64,
}

impl Pose {
    /// Robust lines through middles and half widths; level where there are too few columns.
    pub(crate) fn of(edges: &FrameEdges) -> Self {
        let pairs: Reused<(f64, f64, f64)> = edges
            .top
            .iter()
            .zip(&edges.bottom)
            .enumerate()
            .filter(|(_, (t, b))| t.is_usable() && b.is_usable())
            .map(|(c, (t, b))| (c as f64, 0.5 * (t.row_px + b.row_px), 0.5 * (b.row_px - t.row_px)))
            .collect();
        let slope = |pick: fn(&(f64, f64, f64)) -> f64| {
            robust_slope(&pairs.iter().map(|p| (p.0, pick(p))).collect::<Reused<_>>())
        };
        Self { tan_tilt: slope(|p| p.1), tan_taper: slope(|p| p.2) }
    }

    /// D/w of the module's formula.
    pub(crate) fn chord_factor(&self) -> f64 {
        let cos2 = 1.0 / (1.0 + self.tan_tilt * self.tan_tilt);
        let sin2 = 1.0 - cos2;
        ((cos2 - sin2 * self.tan_taper * self.tan_taper) / cos2.sqrt()).max(0.0)
    }
}

/// Least-squares slope, three times with points beyond three standard deviations left out.
fn robust_slope(points: &[(f64, f64)]) -> f64 {
    if points.len() < 16 {
        return 0.0;
    }
    let mut limit = f64::INFINITY;
    let (mut intercept, mut slope) = (0.0, 0.0);
    for _ in 0..3 {
        let kept = || points.iter().copied().filter(|p| (p.1 - intercept - slope * p.0).abs() <= limit);
        let n = kept().count() as f64;
        if n < 8.0 {
            break;
        }
        let line = Line::through(kept());
        let next = if line.square > 0.0 { line.slope() } else { 0.0 };
        let start = line.mean_y - next * line.mean_x;
        let rest: f64 = kept().map(|p| (p.1 - start - next * p.0).powi(2)).sum();
        (intercept, slope) = (start, next);
        limit = 3.0 * (rest / n).sqrt() + 1e-9;
    }
    slope
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chord of a tilted cone by geometry: intersect the column with the two flanks.
    #[test]
    fn chord_factor_is_that_of_a_tilted_cone() {
        let (tilt, taper, diameter) = (0.05_f64, 0.03_f64, 100.0_f64);
        // Flanks: points q(s, ±) = s·a ± (D/2 + s·tan α)·n along the axis a = (cos τ, sin τ),
        // normal n.
        let flank = |sign: f64| {
            // Solve x = 0 for s, then y.
            let s = sign * 0.5 * diameter * tilt.sin() / (tilt.cos() - sign * taper.tan() * tilt.sin());
            s * tilt.sin() + sign * (0.5 * diameter + s * taper.tan()) * tilt.cos()
        };
        let chord = flank(1.0) - flank(-1.0);
        // Slopes of middle and half width as the image shows them.
        let slope = |sign: f64| (tilt + sign * taper).tan();
        let pose = Pose { tan_tilt: tilt.tan(), tan_taper: taper.tan() };
        assert!((0.5 * (slope(1.0) + slope(-1.0)) - tilt.tan()).abs() < 1e-4);
        assert!((chord * pose.chord_factor() / diameter - 1.0).abs() < 1e-12);
    }
}
