//! An outline as the corners of a drawing, for `[shaft] contour`.
//!
//! Lines meet in corners; an arc between two lines that are tangent to it is the radius of the
//! corner in which they would meet. End faces that close the part to the axis are left out, but for
//! the stretch that an arc beside one needs.

use glam::DVec2;

use super::error::PartProgramError;
use crate::outline::{Outline, Piece, meetings};
use crate::shaft::ContourPoint;

/// Angle within which a line and an arc are tangent, rad, and a line is an end face.
const TANGENT_RAD: f64 = 1e-6;
/// Share of an end face's diameter that stays as the stretch beside an arc.
const FACE_SHARE: f64 = 0.5;
/// Steps of a corner's numbers a millimetre: a tenth of a control's finest increment, above the
/// digits of a file in single precision.
const DIGITS: f64 = 1e5;
/// Z by which a shoulder may run back for rounding, mm.
const ROUNDING_MM: f64 = 1e-4;

/// The corners from the chuck to the tailstock.
///
/// # Errors
/// An arc that is not tangent to a line on both sides, a place at which Z falls: `[shaft] contour`
/// has no word for them.
pub(crate) fn shaft_corners(outline: &Outline) -> Result<Vec<ContourPoint>, PartProgramError> {
    let pieces = &outline.pieces;
    let is_face =
        |p: &Piece| p.arc.is_none() && (p.from_rad.abs() - std::f64::consts::FRAC_PI_2).abs() < TANGENT_RAD;
    let mut points = Vec::new();
    for (i, piece) in pieces.iter().enumerate() {
        if piece.arc.is_some() {
            points.push(rounding(pieces, i)?);
            continue;
        }
        let (before, behind) = (i.checked_sub(1).map(|k| &pieces[k]), pieces.get(i + 1));
        let closes = is_face(piece) && (piece.from.x == 0.0 || piece.to.x == 0.0);
        let arc = |p: Option<&Piece>| p.is_some_and(|p| p.arc.is_some());
        // the corner of an arc stands for the end of its line
        if before.is_none() && (!closes || arc(behind)) {
            points
                .push(corner(if closes { piece.to * DVec2::new(FACE_SHARE, 1.0) } else { piece.from }, 0.0));
        }
        if !(arc(behind) || closes && behind.is_none()) {
            points.push(corner(piece.to, 0.0));
        }
        if closes && behind.is_none() && arc(before) {
            points.push(corner(piece.from * DVec2::new(FACE_SHARE, 1.0), 0.0));
        }
    }
    for i in 1..points.len() {
        let before = points[i - 1].z_mm;
        if points[i].z_mm < before && before - points[i].z_mm < ROUNDING_MM {
            points[i].z_mm = before;
        }
    }
    match points.windows(2).find(|w| w[1].z_mm < w[0].z_mm) {
        None => Ok(points),
        Some(pair) => Err(PartProgramError::NoCorners {
            z_mm: pair[1].z_mm,
            why: "the outline runs back towards the chuck",
        }),
    }
}

fn corner(at: DVec2, radius_mm: f64) -> ContourPoint {
    let rounded = |v: f64| (v * DIGITS).round() / DIGITS;
    ContourPoint {
        z_mm: rounded(at.y),
        diameter_mm: rounded(2.0 * at.x),
        chamfer_mm: 0.0,
        radius_mm: rounded(radius_mm),
    }
}

/// The corner in which the lines on both sides of an arc meet.
fn rounding(pieces: &[Piece], i: usize) -> Result<ContourPoint, PartProgramError> {
    let arc = &pieces[i];
    let none = |why| PartProgramError::NoCorners { z_mm: arc.from.y, why };
    let sides = i.checked_sub(1).map(|k| pieces[k]).zip(pieces.get(i + 1));
    let (before, behind) = sides.ok_or(none("an arc at an end of the part has no line on one side"))?;
    let tangent = (arc.from_rad - before.to_rad).abs() < TANGENT_RAD
        && (behind.from_rad - arc.to_rad).abs() < TANGENT_RAD;
    if before.arc.is_some() || behind.arc.is_some() || !tangent {
        return Err(none("an arc that is not tangent to a line on both sides"));
    }
    let at = meetings(&before, behind).into_iter().next().ok_or(none("an arc between parallel lines"))?;
    Ok(corner(at, arc.arc.map_or(0.0, |a| a.radius_mm.abs())))
}
