//! Contours as on a drawing, read from tables and turned into a profile of straight pieces.

use std::io::Read;

use crate::render::error::RenderError;
use crate::shaft::{ContourPoint, ProfileKnot, contour};
use crate::text_table::plain_rows;

/// Numbers of a point.
const NUMBERS: std::ops::RangeInclusive<usize> = 2..=4;

/// Largest sagitta of a chord, mm: below what an edge is measured to by a factor of ten.
const SAGITTA_MM: f64 = 1e-6;

/// Reads `z_mm,diameter_mm[,chamfer_mm,radius_mm]` lines; with an optional header line; lines that
/// start with `#` are skipped. Separators and decimal commas as [`crate::text_table`].
///
/// # Errors
/// Names the line and the valid form.
pub(crate) fn read_contour(mut from: impl Read) -> Result<Vec<ContourPoint>, RenderError> {
    let refuse = |found: &str, right: &str| RenderError::setting("shaft.contour_file", found, right);
    let right = "must be text with the columns z_mm,diameter_mm[,chamfer_mm,radius_mm]";
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes).map_err(|e| refuse(&e.to_string(), right))?;
    let mut points = Vec::new();
    for row in plain_rows(&bytes, &NUMBERS).map_err(|e| refuse(&e.to_string(), right))? {
        match row.numbers() {
            Some(n) if NUMBERS.contains(&n.len()) => {
                let get = |i: usize| n.get(i).copied().unwrap_or(0.0);
                let point =
                    ContourPoint { z_mm: n[0], diameter_mm: n[1], chamfer_mm: get(2), radius_mm: get(3) };
                points.push(point);
            }
            _ if points.is_empty() && row.fields.iter().any(|f| f.starts_with(char::is_alphabetic)) => {}
            _ => {
                let found = format!("line {}: '{}'", row.line, row.shown());
                return Err(refuse(
                    &found,
                    "must be 2 to 4 finite numbers, z_mm,diameter_mm[,chamfer_mm,radius_mm]",
                ));
            }
        }
    }
    if points.is_empty() {
        return Err(refuse("no point", "must hold at least one point of the contour"));
    }
    Ok(points)
}

/// The profile of a contour.
///
/// # Errors
/// As [`contour::profile`].
pub(crate) fn contour_knots(points: &[ContourPoint]) -> Result<Vec<ProfileKnot>, RenderError> {
    Ok(contour::profile(points, SAGITTA_MM)?)
}
