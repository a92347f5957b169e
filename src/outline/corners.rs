//! Outlines from corners with chamfers and radii, as on a drawing.
//!
//! At a corner between the directions d1 and d2 with the turn φ a chamfer c removes the length c
//! from both lines; an arc of radius r is tangent to them r·tan(φ/2) from the corner.

use std::f64::consts::PI;

use glam::DVec2;

use super::piece::{Arc, Piece, unwrapped};
use crate::setting::{SettingError, require, within};
use crate::shaft::ContourPoint;

/// On which side of the surface the material lies.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Side {
    /// A shaft: the material lies towards the axis.
    #[default]
    External,
    /// A bore: the material lies away from the axis.
    Internal,
}

/// A chain of pieces in the direction that leaves the material on one side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outline {
    /// The pieces; each begins where the one before ends.
    pub pieces: Vec<Piece>,
    /// Where the material lies.
    pub side: Side,
}

/// Length below which a piece is none, mm: far below a control's increment.
const NO_LENGTH_MM: f64 = 1e-9;

impl Outline {
    /// The outline through corners whose z does not fall.
    ///
    /// # Errors
    /// Fewer than two corners, corners out of range or order, chamfers and radii that do not fit
    /// their lines; the key is `contour` with the number of the corner from 1.
    pub(crate) fn from_corners(points: &[ContourPoint], side: Side) -> Result<Self, SettingError> {
        check(points)?;
        let mut corners: Vec<(DVec2, &ContourPoint)> =
            points.iter().map(|p| (DVec2::new(0.5 * p.diameter_mm, p.z_mm), p)).collect();
        let middle = match side {
            Side::External => 0.0,
            Side::Internal => PI,
        };
        if side == Side::Internal {
            corners.reverse();
        }
        let cuts: Vec<f64> = (0..corners.len()).map(|i| cut(&corners, i)).collect();
        let mut pieces = Vec::new();
        for i in 1..corners.len() {
            let ((a, _), (b, _)) = (corners[i - 1], corners[i]);
            let length = a.distance(b);
            if cuts[i - 1] + cuts[i] > length * (1.0 + 1e-9) {
                return Err(SettingError::at(
                    "contour",
                    format!(
                        "the line between the corners at Z {} and Z {} mm is {length:.4} mm long, chamfers and radii at its \
                         ends need {:.4} mm: make them smaller",
                        a.y,
                        b.y,
                        cuts[i - 1] + cuts[i]
                    ),
                ));
            }
            let along = (b - a).normalize_or_zero();
            push_line(&mut pieces, a + cuts[i - 1] * along, b - cuts[i] * along, middle);
            if cuts[i] > 0.0
                && let Some((before, behind)) = directions(&corners, i)
            {
                let (start, end) = (b - cuts[i] * before, b + cuts[i] * behind);
                if corners[i].1.radius_mm > 0.0 {
                    pieces.push(rounding(start, corners[i].1.radius_mm, (before, behind), middle));
                } else {
                    push_line(&mut pieces, start, end, middle);
                }
            }
        }
        Ok(Self { pieces, side })
    }

    /// Least and largest Z, mm.
    pub(crate) fn z_mm(&self) -> (f64, f64) {
        let ends = self.pieces.iter().flat_map(|p| [p.from.y, p.to.y]);
        ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)))
    }

    /// Largest distance from the axis, mm; an arc between two corners does not pass beyond them.
    pub(crate) fn largest_radius_mm(&self) -> f64 {
        self.pieces.iter().flat_map(|p| [p.from.x, p.to.x]).fold(0.0, f64::max)
    }
}

fn check(points: &[ContourPoint]) -> Result<(), SettingError> {
    require(points.len() >= 2, "contour", points.len(), "two corners or more, as [[contour]] tables")?;
    for (i, p) in points.iter().enumerate() {
        let key = |name: &str| format!("contour[{}].{name}", i + 1);
        within(&key("z_mm"), p.z_mm, -1e6, 1e6, "a place in mm")?;
        within(&key("diameter_mm"), p.diameter_mm, 0.0, 1e5, "a diameter of 0 to 100000 mm")?;
        within(&key("chamfer_mm"), p.chamfer_mm, 0.0, 1e4, "a length of 0 to 10000 mm")?;
        within(&key("radius_mm"), p.radius_mm, 0.0, 1e4, "a radius of 0 to 10000 mm")?;
        let outer = i == 0 || i + 1 == points.len();
        if p.chamfer_mm > 0.0 && p.radius_mm > 0.0 || outer && p.chamfer_mm + p.radius_mm > 0.0 {
            return Err(SettingError::at(
                key("radius_mm"),
                "a corner has one of chamfer_mm and radius_mm, and lines on both sides",
            ));
        }
        if i > 0 && p.z_mm < points[i - 1].z_mm {
            let before = points[i - 1].z_mm;
            return Err(SettingError::of(
                key("z_mm"),
                p.z_mm,
                format!("{before} or more: corners run from the chuck to the tailstock"),
            ));
        }
        if i > 0 && p.z_mm == points[i - 1].z_mm && p.diameter_mm == points[i - 1].diameter_mm {
            return Err(SettingError::at(
                key("z_mm"),
                "the corner before it lies at the same place: give it once",
            ));
        }
    }
    Ok(())
}

/// Directions of the lines before and after a corner; none at the ends.
fn directions(corners: &[(DVec2, &ContourPoint)], i: usize) -> Option<(DVec2, DVec2)> {
    let before = (corners[i].0 - corners.get(i.checked_sub(1)?)?.0).try_normalize()?;
    let behind = (corners.get(i + 1)?.0 - corners[i].0).try_normalize()?;
    Some((before, behind))
}

/// Length that a corner's chamfer or arc removes from each line.
fn cut(corners: &[(DVec2, &ContourPoint)], i: usize) -> f64 {
    let corner = corners[i].1;
    if corner.radius_mm == 0.0 {
        return corner.chamfer_mm;
    }
    directions(corners, i).map_or(0.0, |(a, b)| corner.radius_mm * (0.5 * a.angle_to(b).abs()).tan())
}

/// Angle of the normal of a direction, in the turn about `middle`.
fn normal_angle(direction: DVec2, middle: f64) -> f64 {
    unwrapped((-direction.perp()).to_angle(), middle)
}

fn push_line(pieces: &mut Vec<Piece>, from: DVec2, to: DVec2, middle: f64) {
    if from.distance(to) > NO_LENGTH_MM {
        pieces.push(Piece::line(from, to, normal_angle(to - from, middle)));
    }
}

/// The arc of `radius` mm from `start`, tangent to both directions.
fn rounding(start: DVec2, radius: f64, (before, behind): (DVec2, DVec2), middle: f64) -> Piece {
    let turn = before.angle_to(behind);
    let from = normal_angle(before, middle);
    let signed = radius * turn.signum();
    let centre = start - signed * DVec2::from_angle(from);
    Piece { from: start, ..Piece::arc(Arc { centre, radius_mm: signed }, from, from + turn) }
}
