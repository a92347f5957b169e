//! Two lines whose angle is made that of the insert: one of them is turned in steps.
//!
//! The mean distance ε of a line to its edge pixels decides which: where the angle is larger than
//! the insert's, the line with the larger ε is turned, where it is smaller, the one with the
//! smaller ε.

use glam::DVec2;

use super::limits::PaperNoseLimits;
use super::segment::Segment;

/// An edge as the paper has it.
#[derive(Clone, Debug)]
pub(super) struct EdgeOfPaper {
    /// The middle of its segment, about which it is turned.
    pub(super) at: DVec2,
    /// Unit vector along it, away from the nose.
    pub(super) along: DVec2,
    /// Mean distance ε of the edge's pixels from it, px.
    pub(super) distance_px: f64,
}

impl EdgeOfPaper {
    /// A segment as seen from where the edges meet, with the edge's pixels.
    pub(super) fn new(segment: &Segment, apex: DVec2, pixels: &[DVec2]) -> Self {
        let near_px = PaperNoseLimits::get().near_px;
        let (at, half) = (segment.middle(), 0.5 * segment.length());
        let along = (segment.ends[1] - segment.ends[0]).normalize_or_zero();
        let along = if along.dot(at - apex) < 0.0 { -along } else { along };
        let own = pixels.iter().filter(|p| along.dot(**p - at).abs() <= half);
        let off: Vec<f64> =
            own.map(|p| along.perp_dot(*p - at).abs()).filter(|off| *off <= near_px).collect();
        let distance_px = off.iter().sum::<f64>() / off.len().max(1) as f64;
        Self { at, along, distance_px }
    }
}

/// Included angle of two edges, degrees.
pub(super) fn included_deg(edges: &[EdgeOfPaper; 2]) -> f64 {
    edges[0].along.angle_to(edges[1].along).abs().to_degrees()
}

/// Turns one edge until both enclose `epsilon_deg` to half a step; the number of the one turned.
pub(super) fn force(edges: &mut [EdgeOfPaper; 2], epsilon_deg: f64) -> usize {
    let excess = included_deg(edges) - epsilon_deg;
    let further = usize::from(edges[1].distance_px > edges[0].distance_px);
    let turned = if excess > 0.0 { further } else { 1 - further };
    let towards = edges[turned].along.angle_to(edges[1 - turned].along).signum();
    let step = PaperNoseLimits::get().step_deg;
    let by = DVec2::from_angle((towards * (excess / step).round() * step).to_radians());
    edges[turned].along = by.rotate(edges[turned].along);
    turned
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges(deg: f64, distances: [f64; 2]) -> [EdgeOfPaper; 2] {
        let edge = |a: f64, distance_px: f64| {
            let along = DVec2::from_angle(f64::to_radians(a));
            EdgeOfPaper { at: 300.0 * along, along, distance_px }
        };
        [edge(10.0, distances[0]), edge(10.0 + deg, distances[1])]
    }

    #[test]
    fn the_line_further_from_its_pixels_is_turned_where_the_angle_is_larger_and_the_nearer_where_smaller() {
        for (deg, distances, wanted) in
            [(60.3, [0.4, 0.7], 1), (60.3, [0.7, 0.4], 0), (59.8, [0.4, 0.7], 0), (59.8, [0.7, 0.4], 1)]
        {
            let mut lines = edges(deg, distances);
            let before = lines.clone();
            assert_eq!(force(&mut lines, 60.0), wanted);
            assert!((included_deg(&lines) - 60.0).abs() <= 0.0025 + 1e-9, "{}", included_deg(&lines));
            assert_eq!(lines[1 - wanted].along, before[1 - wanted].along);
            assert_eq!(lines[wanted].at, before[wanted].at);
        }
    }
}
