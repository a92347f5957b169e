//! Contours as on a drawing, read from tables and turned into a profile of straight pieces.

use std::io::Read;

use crate::render::error::RenderError;
use crate::shaft::{ContourPoint, ProfileKnot, contour};

/// Largest sagitta of a chord, mm: below what an edge is measured to by a factor of ten.
const SAGITTA_MM: f64 = 1e-6;

/// Reads `z_mm,diameter_mm[,chamfer_mm,radius_mm]` lines; with an optional header line; lines that
/// start with `#` are skipped.
///
/// # Errors
/// Names the line and the valid form.
pub(crate) fn read_contour(from: impl Read) -> Result<Vec<ContourPoint>, RenderError> {
    let refuse = |found: &str, right: &str| RenderError::setting("shaft.contour_file", found, right);
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(from);
    let mut points = Vec::new();
    for record in reader.records() {
        let right = "must be text with the columns z_mm,diameter_mm[,chamfer_mm,radius_mm]";
        let record = record.map_err(|e| refuse(&e.to_string(), right))?;
        let line = record.position().map_or(0, csv::Position::line);
        let numbers: Result<Vec<f64>, _> = record.iter().map(str::parse::<f64>).collect();
        match numbers {
            Ok(n) if (2..=4).contains(&n.len()) && n.iter().all(|v| v.is_finite()) => {
                let get = |i: usize| n.get(i).copied().unwrap_or(0.0);
                let point =
                    ContourPoint { z_mm: n[0], diameter_mm: n[1], chamfer_mm: get(2), radius_mm: get(3) };
                points.push(point);
            }
            _ if points.is_empty() && record.iter().any(|f| f.starts_with(char::is_alphabetic)) => {}
            _ => {
                let found = format!("line {line}: '{}'", record.iter().collect::<Vec<_>>().join(","));
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
