//! The contour found so far: two lines and, between them, radii about the centre.

use glam::DVec2;

use super::limits::NoseLimits;
use super::line::EdgeLine;

/// Edge, nose, edge, counter-clockwise.
#[derive(Clone, Debug)]
pub(super) struct Path {
    /// Centre, at `nominal_px` from both lines.
    pub(super) centre: DVec2,
    /// Nominal radius, px.
    pub(super) nominal_px: f64,
    /// The edges.
    pub(super) lines: [EdgeLine; 2],
    /// Direction of the first edge's normal, rad.
    pub(super) from_rad: f64,
    /// Angle from it to the second one's, rad.
    pub(super) sweep_rad: f64,
    /// Radii at the middles of even sectors of the sweep, px.
    pub(super) radii: Vec<f64>,
}

impl Path {
    /// A path about the centre that lies at the nominal radius from both lines, its radii nominal.
    pub(super) fn nominal(lines: [EdgeLine; 2], nominal_px: f64) -> Self {
        let (a, b) = (lines[0].normal, lines[1].normal);
        let sweep_rad = a.angle_to(b);
        let most = sweep_rad * nominal_px / NoseLimits::get().least_sector_px;
        let sectors = sweep_rad.to_degrees().round().min(most.floor()).max(8.0) as usize;
        Self {
            centre: at_radius(&lines, nominal_px),
            nominal_px,
            lines,
            from_rad: a.to_angle(),
            sweep_rad,
            radii: vec![nominal_px; sectors],
        }
    }

    /// Angle of a sector, rad.
    pub(super) fn step_rad(&self) -> f64 {
        self.sweep_rad / self.radii.len() as f64
    }

    /// Direction of the middle of sector k, rad.
    pub(super) fn direction_rad(&self, k: usize) -> f64 {
        self.from_rad + (k as f64 + 0.5) * self.step_rad()
    }

    /// Curvature of the contour in sector k, 1/px: (r² + 2r'² − r·r″)/(r² + r'²)^{3/2} by the
    /// parabola of least squares through seven sectors (A. Savitzky, M. J. E. Golay, Anal. Chem. 36
    /// (1964) 1627): a narrower one would add its noise to the sector's own.
    pub(super) fn curvature(&self, k: usize) -> f64 {
        let [r, slope, second] = self.parabola(k);
        let square = r * r + slope * slope;
        (square + slope * slope - r * second) / (square * square.sqrt())
    }

    /// Radius of sector k, and the first and second derivative by the direction of the parabola
    /// through seven.
    fn parabola(&self, k: usize) -> [f64; 3] {
        let step = self.step_rad();
        let r: [f64; 7] = std::array::from_fn(|i| self.value(k as isize + i as isize - 3));
        let sum = |by: [f64; 7]| by.iter().zip(&r).map(|(b, r)| b * r).sum::<f64>();
        let slope = sum([-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0]) / (28.0 * step);
        let second = sum([5.0, 0.0, -3.0, -4.0, -3.0, 0.0, 5.0]) / (42.0 * step * step);
        [r[3], slope, second]
    }

    /// The radius to which the shift of sector k refers, px. A shift is a mean over its sector: it
    /// counts from the mean of the cubic there (its integral over the sector), from which the
    /// middle of the parabola differs by r″·step²/24. From the cubic's own middle the shift would
    /// take a part of its noise twice, since the cubic follows the radii of the round before.
    pub(super) fn shifted_from(&self, k: usize) -> f64 {
        let at = |by: isize| self.value(k as isize + by);
        let mean = (322.0 * at(0) + 36.0 * (at(-1) + at(1)) - 5.0 * (at(-2) + at(2))) / 384.0;
        mean - self.parabola(k)[2] * self.step_rad().powi(2) / 24.0
    }

    /// Radius at the middle of sector k; the lines beyond the ends.
    pub(super) fn value(&self, k: isize) -> f64 {
        let (n, beyond) = (self.radii.len() as isize, (k as f64 + 0.5) * self.step_rad());
        match k {
            k if k < 0 => self.nominal_px / beyond.cos(),
            k if k >= n => self.nominal_px / (self.sweep_rad - beyond).cos(),
            k => self.radii[k as usize],
        }
    }

    /// Radius and its derivative by the direction, `turn` rad after the first edge's normal: a
    /// cubic through the sectors' middles, the lines beyond the ends.
    pub(super) fn radius(&self, turn: f64) -> (f64, f64) {
        let step = self.step_rad();
        let place = turn / step - 0.5;
        let k = place.floor() as isize;
        let t = place - k as f64;
        let [a, b, c, d] = [-1, 0, 1, 2].map(|by| self.value(k + by));
        let (m, o) = (0.5 * (c - a), 0.5 * (d - b));
        let (q, r) = (3.0 * (c - b) - 2.0 * m - o, 2.0 * (b - c) + m + o);
        (b + t * (m + t * (q + t * r)), (m + t * (2.0 * q + t * 3.0 * r)) / step)
    }
}

/// The place at a distance from both lines within the insert.
pub(super) fn at_radius(lines: &[EdgeLine; 2], radius_px: f64) -> DVec2 {
    let [a, b] = lines;
    let (p, q) = (a.normal.dot(a.at) - radius_px, b.normal.dot(b.at) - radius_px);
    let det = a.normal.perp_dot(b.normal);
    DVec2::new(p * b.normal.y - q * a.normal.y, q * a.normal.x - p * b.normal.x) / det
}
