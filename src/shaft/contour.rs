//! Contours as on a drawing: corners with chamfers and radii, turned into a profile of straight
//! pieces.
//!
//! At a corner between the directions d1 and d2 with the turn φ a chamfer c removes the length c
//! from both lines; an arc of radius r is tangent to them r·tan(φ/2) from the corner and is divided
//! into chords whose sagitta r(1 - cos(δ/2)) stays below a limit.

use glam::DVec2;

use super::body::ProfileKnot;
use super::form::ContourPoint;
use crate::setting::SettingError;

/// Most knots of an arc.
const MOST_CHORDS: f64 = 20_000.0;

const KEY: &str = "shaft.contour";

fn refuse(found: &str, right: &str) -> SettingError {
    SettingError { found: Some(found.to_owned()), ..SettingError::at(KEY, right) }
}

/// Refuses a number that is not finite or outside `low..=high`.
fn within(key: &str, value: f64, low: f64, high: f64) -> Result<(), SettingError> {
    if value.is_finite() && (low..=high).contains(&value) {
        return Ok(());
    }
    let right = format!("must lie in {low} to {high}");
    Err(SettingError { found: Some(value.to_string()), ..SettingError::at(key, right) })
}

/// Length along z that chamfer or arc of every corner removes from the lines on either side, mm:
/// beyond it the lines are the drawing's.
pub(crate) fn cut_lengths_mm(points: &[ContourPoint]) -> Vec<f64> {
    let corners = corners(points);
    (0..points.len()).map(|i| cut(points, &corners, i)).collect()
}

fn corners(points: &[ContourPoint]) -> Vec<DVec2> {
    points.iter().map(|p| DVec2::new(p.z_mm, 0.5 * p.diameter_mm)).collect()
}

/// The profile of a contour; chords of arcs have a sagitta of at most `sagitta_mm`.
///
/// # Errors
/// Refuses contours that turn back in z, chamfers and radii that do not fit their lines, values out
/// of range.
pub(crate) fn profile(points: &[ContourPoint], sagitta_mm: f64) -> Result<Vec<ProfileKnot>, SettingError> {
    for (i, p) in points.iter().enumerate() {
        within("shaft.contour.z_mm", p.z_mm, -1e6, 1e6)?;
        within("shaft.contour.diameter_mm", p.diameter_mm, 1e-6, 1e5)?;
        within("shaft.contour.chamfer_mm", p.chamfer_mm, 0.0, 1e4)?;
        within("shaft.contour.radius_mm", p.radius_mm, 0.0, 1e4)?;
        let outer = i == 0 || i + 1 == points.len();
        if p.chamfer_mm > 0.0 && p.radius_mm > 0.0 || outer && p.chamfer_mm + p.radius_mm > 0.0 {
            let right = "has one of chamfer_mm and radius_mm, and lines on both sides";
            return Err(refuse(&format!("point {}", i + 1), right));
        }
        if i > 0 && p.z_mm < points[i - 1].z_mm {
            let found = format!("point {}: z {} mm after {} mm", i + 1, p.z_mm, points[i - 1].z_mm);
            return Err(refuse(&found, "makes the profile intersect itself: z must not fall"));
        }
    }
    let (corners, cuts) = (corners(points), cut_lengths_mm(points));
    for i in 1..corners.len() {
        let length = corners[i].distance(corners[i - 1]);
        if cuts[i - 1] + cuts[i] > length * (1.0 + 1e-9) {
            let found = format!("points {i} and {}: {length} mm apart", i + 1);
            let right = &format!(
                "makes the profile intersect itself: chamfers and radii there need {:.4} mm",
                cuts[i - 1] + cuts[i]
            );
            return Err(refuse(&found, right));
        }
    }
    let mut knots = Vec::new();
    for (i, point) in points.iter().enumerate() {
        corner((point, sagitta_mm), &corners, &cuts, i, &mut knots);
    }
    Ok(knots.into_iter().map(|k: DVec2| ProfileKnot { z_mm: k.x, radius_mm: k.y }).collect())
}

/// Directions of the lines before and after a corner; none where they have no length or the corner
/// is an end.
fn directions(corners: &[DVec2], i: usize) -> Option<(DVec2, DVec2)> {
    let before = (corners[i] - *corners.get(i.checked_sub(1)?)?).try_normalize()?;
    let behind = (*corners.get(i + 1)? - corners[i]).try_normalize()?;
    Some((before, behind))
}

/// Length that a corner's chamfer or arc removes from each line.
fn cut(points: &[ContourPoint], corners: &[DVec2], i: usize) -> f64 {
    if points[i].radius_mm == 0.0 {
        return points[i].chamfer_mm;
    }
    directions(corners, i).map_or(0.0, |(a, b)| points[i].radius_mm * (0.5 * a.angle_to(b).abs()).tan())
}

fn corner(
    (point, sagitta_mm): (&ContourPoint, f64),
    corners: &[DVec2],
    cuts: &[f64],
    i: usize,
    knots: &mut Vec<DVec2>,
) {
    let (Some((before, behind)), true) = (directions(corners, i), cuts[i] > 0.0) else {
        knots.push(corners[i]);
        return;
    };
    let (start, end) = (corners[i] - cuts[i] * before, corners[i] + cuts[i] * behind);
    knots.push(start);
    let radius = point.radius_mm;
    if radius > 0.0 {
        let turn = before.angle_to(behind);
        let centre = start + radius * turn.signum() * before.perp();
        let chord = 2.0 * (2.0 * sagitta_mm / radius).min(1.0).sqrt();
        let chords = (turn.abs() / chord).ceil().clamp(1.0, MOST_CHORDS);
        for k in 1..chords as usize {
            let angle = turn * k as f64 / chords;
            knots.push(centre + DVec2::from_angle(angle).rotate(start - centre));
        }
    }
    knots.push(end);
}
