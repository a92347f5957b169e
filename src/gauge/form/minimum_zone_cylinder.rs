//! Minimum-zone cylinder (MZCY, ISO 12180): two coaxial cylinders closest together that hold every
//! point.
//!
//! The zone is the least of max r − min r over the axes, r the distances from the axis; a linear
//! programme in the four steps of the axis, the radius and half the width once the distances are
//! linearised (Stiefel's exchange), linearised again at what was found. A distance is curved by
//! 1/r, so that a step s leaves s²/2r: from a deviation of 10 µm on 10 mm, 5 nm, then nothing.

use glam::DVec3;

use super::cylinder::{Cylinder, least_squares_cylinder};
use super::error::FormError;
use super::linear_program::{LinearProgram, Row};

/// A minimum-zone cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CylinderZone {
    /// The middle cylinder.
    pub(crate) cylinder: Cylinder,
    /// Radial distance of the two, CYLt, in the points' unit.
    pub(crate) width: f64,
    /// By how much the linear programme at this axis could still lower the width.
    pub(crate) gap: f64,
}

/// The minimum-zone cylinder of points all around an axis near z. At least six points.
///
/// # Errors
/// As [`least_squares_cylinder`]; rounding that defeats the linear programme.
pub(crate) fn minimum_zone_cylinder(points: &[DVec3]) -> Result<CylinderZone, FormError> {
    let feature = "minimum zone cylinder";
    if points.len() < 6 {
        return Err(FormError::TooFew { feature, found: points.len(), needed: 6 });
    }
    let start = least_squares_cylinder(points)?;
    let frame = Frame::of(points);
    let rounding = 1e-15 * start.cylinder.radius;
    let mut found = frame.zone(points, start.cylinder);
    let mut bound = 4.0 * found.width + rounding;
    // A handful settle; as many again for boxes that were too wide.
    for _ in 0..20 {
        let (step, gap) = frame.step(points, &found, bound).ok_or(FormError::NotConverged { feature })?;
        let next = frame.zone(points, step);
        if next.width >= found.width - 2.0 * rounding {
            // No better at the exact distances: the programme's own gain is the proof, or the box
            // was too wide for the linearisation.
            found.gap = gap.max(0.0);
            if gap <= 1e-3 * bound.min(found.width) || bound <= 4.0 * rounding {
                return Ok(found);
            }
            bound *= 0.1;
        } else {
            bound = (4.0 * (found.width - next.width) + rounding).min(bound);
            found = next;
        }
    }
    Err(FormError::NotConverged { feature })
}

/// Where along z the axis is described: its place in the middle and its slope over half the length
/// are lengths of the same size.
struct Frame {
    middle: f64,
    half: f64,
}

impl Frame {
    fn of(points: &[DVec3]) -> Self {
        let (low, high) =
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.z), h.max(p.z)));
        Self { middle: 0.5 * (low + high), half: (0.5 * (high - low)).max(f64::MIN_POSITIVE) }
    }

    /// The zone about the axis of a cylinder, exact.
    fn zone(&self, points: &[DVec3], cylinder: Cylinder) -> CylinderZone {
        let (low, high) = points
            .iter()
            .map(|p| cylinder.deviation(*p))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(e), h.max(e)));
        let middle = Cylinder { radius: cylinder.radius + 0.5 * (low + high), ..cylinder };
        CylinderZone { cylinder: middle, width: high - low, gap: f64::INFINITY }
    }

    /// The axis of the linearised programme, and by how much that lowers the linearised width.
    fn step(&self, points: &[DVec3], found: &CylinderZone, bound: f64) -> Option<(Cylinder, f64)> {
        let (c, half_width) = (found.cylinder, 0.5 * found.width);
        let mut rows = Vec::with_capacity(2 * points.len());
        for p in points {
            let [x, y, lx, ly] = self.slopes(&c, *p);
            let e = c.deviation(*p);
            rows.push(Row { a: [x, y, lx, ly, 1.0, 1.0], b: e - half_width });
            rows.push(Row { a: [-x, -y, -lx, -ly, -1.0, 1.0], b: -e - half_width });
        }
        let lp = LinearProgram {
            cost: [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            lower: [-bound; 6],
            upper: [bound; 6],
            tolerance: 1e-15 * c.radius,
        };
        let [x, y, lx, ly, r, narrower] = lp.solve(&rows)?;
        let (slope_x, slope_y) = (lx / self.half, ly / self.half);
        let axis = Cylinder {
            x0: c.x0 + x - slope_x * self.middle,
            y0: c.y0 + y - slope_y * self.middle,
            slope_x: c.slope_x + slope_x,
            slope_y: c.slope_y + slope_y,
            radius: c.radius + r,
        };
        Some((axis, -2.0 * narrower))
    }

    /// What a step of the axis takes off a point's distance: its direction from the axis, and the
    /// same by its lever along the axis.
    fn slopes(&self, cylinder: &Cylinder, point: DVec3) -> [f64; 4] {
        let axis = DVec3::new(cylinder.slope_x, cylinder.slope_y, 1.0);
        let from = point - DVec3::new(cylinder.x0, cylinder.y0, 0.0);
        let along = axis.dot(from) / axis.length_squared();
        let radial = (from - axis * along).normalize_or_zero();
        let lever = (along - self.middle) / self.half;
        [radial.x, radial.y, lever * radial.x, lever * radial.y]
    }
}
