//! What is expected of a nose, beside what was found: angle, directions, radius, and light on dark.

use glam::DVec2;

use super::contour;
use super::corner::{self, Corner};
use super::error::NoseImageError;
use super::limits::NoseLimits;
use super::settings::{ExpectedNose, NoseSettings};
use crate::frame::{FrameView, PixelFormat, Pixels};

/// Compares angle and directions of a nose's edges with those of the tool that it should be of;
/// `wider_deg` is how far they may be off beyond that, of edges that are found coarsely.
pub(super) fn check(
    (angle_deg, normals_deg): (f64, [f64; 2]),
    wider_deg: f64,
    expected: &ExpectedNose,
) -> Result<(), NoseImageError> {
    let limits = NoseLimits::get();
    if (angle_deg - expected.epsilon_deg).abs() > limits.angle_deg + wider_deg {
        return Err(NoseImageError::Angle {
            found_deg: angle_deg,
            tool_deg: expected.epsilon_deg,
            most_deg: limits.angle_deg,
        });
    }
    check_direction(normals_deg, wider_deg, expected)
}

/// Compares the directions of both edges' normals with those expected; names the turn or the mirror
/// image that would explain a difference.
pub(super) fn check_direction(
    found_deg: [f64; 2],
    wider_deg: f64,
    expected: &ExpectedNose,
) -> Result<(), NoseImageError> {
    let limits = NoseLimits::get();
    let off = |a: f64, b: f64| (a - b + 180.0).rem_euclid(360.0) - 180.0;
    let fits = |normals: [f64; 2]| {
        (0..2).all(|k| off(normals[k], expected.normals_deg[k]).abs() <= limits.direction_deg + wider_deg)
    };
    if fits(found_deg) {
        return Ok(());
    }
    let middle = |n: [f64; 2]| n[0] + 0.5 * (n[1] - n[0]).rem_euclid(360.0);
    let (found, right) = (middle(found_deg), middle(expected.normals_deg));
    let across = [180.0 - found_deg[1], 180.0 - found_deg[0]];
    let down = [-found_deg[1], -found_deg[0]];
    let how = if fits(across) {
        "mirrored left to right".to_owned()
    } else if fits(down) {
        "mirrored top to bottom".to_owned()
    } else {
        format!("rotated by {:.1} degrees", off(found, right))
    };
    Err(NoseImageError::Orientation {
        how,
        found_deg: turned(found),
        by: expected.by,
        expected_deg: turned(right),
        remedy: if expected.by == "baseline" {
            "take it as the baseline was taken"
        } else {
            "turn the camera or the image, or state how it lies by [image] plus_x_deg and plus_z_deg"
        },
    })
}

/// A direction of 0 to 360 degrees.
pub(super) fn turned(deg: f64) -> f64 {
    deg.rem_euclid(360.0)
}

/// Why a contour cannot be followed: where the coarse corner is not the one that is expected, that
/// is the cause, whatever failed by it.
pub(super) fn cause(error: NoseImageError, corner: &Corner, settings: &NoseSettings) -> NoseImageError {
    let limits = NoseLimits::get();
    let normals_deg = corner.edges.each_ref().map(|e| turned(e.normal.to_angle().to_degrees()));
    let angle_deg = corner.epsilon_rad.to_degrees();
    let other = settings.expected.map(|e| check((angle_deg, normals_deg), limits.coarse_deg, &e));
    if let Some(Err(other)) = other {
        return other;
    }
    let (found_px, um_per_px) = (round_px(corner), settings.um_per_px);
    let short = |nominal_px: f64| (found_px - nominal_px) * beyond_circle(corner) / nominal_px;
    match settings.nominal_radius_px {
        Some(nominal_px) if short(nominal_px).abs() > limits.another_radius => {
            NoseImageError::Radius { found_px, nominal_px, um_per_px }
        }
        _ => error,
    }
}

/// Radius of the circle between both edges that reaches as far towards their corner as the coarse
/// contour, px.
pub(super) fn round_px(corner: &Corner) -> f64 {
    let gap = corner.nose.iter().map(|p| p.distance(corner.apex)).fold(f64::INFINITY, f64::min);
    gap / beyond_circle(corner)
}

/// Distance of the corner of both edges from the circle between them, over its radius.
fn beyond_circle(corner: &Corner) -> f64 {
    (0.5 * corner.epsilon_rad).sin().recip() - 1.0
}

/// Whether a frame that shows no nose shows one with light and shadow exchanged: a lit insert
/// before a dark ground.
pub(super) fn swapped(view: &FrameView<'_>, settings: &NoseSettings) -> Option<NoseImageError> {
    let (rows, columns) = (view.rows(), view.columns());
    let at = |k: usize| view.get(k / columns, k % columns).map_or(f32::NAN, |v| -v);
    let values: Vec<f32> = (0..rows * columns).map(at).collect();
    let turned = FrameView::new(Pixels::F32(&values), PixelFormat::F32, rows, columns, columns).ok()?;
    let corner = corner::find(&contour::runs(&turned).ok()?, (rows, columns), settings).ok()?;
    let nose: DVec2 = corner.nose.iter().sum::<DVec2>() / corner.nose.len().max(1) as f64;
    Some(NoseImageError::Swapped { row: -nose.y, column: nose.x })
}
