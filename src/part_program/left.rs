//! What a program leaves of the bar, compared with the drawing.

use super::error::PartProgramError;
use crate::nc::replay::TurnedStock;
use crate::outline::Outline;
use crate::tool::{LeftOut, OutOfReach};

/// Why material stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Reason {
    /// The tool's edges do not reach there.
    OutOfReach,
    /// A concave arc or corner is sharper than the nose.
    NoseRadius,
    /// It lies in the grip.
    Grip,
}

/// A place at which material stays.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct LeftPlace {
    /// Why.
    pub reason: Reason,
    /// Z between which it lies, mm.
    pub z_mm: [f64; 2],
    /// Most that stays, mm of radius.
    pub most_mm: f64,
    /// Its volume, mm³.
    pub volume_mm3: f64,
}

/// Excess of the radius that is listed, mm: above the step of the replay on any surface but a wall.
const LISTED_MM: f64 = 0.02;
/// Length along Z from which it is listed, mm: walls are known to two steps of the replay.
const LISTED_LENGTH_MM: f64 = 0.08;
/// Depth below the drawing that is refused, mm: rounding of a program's numbers and the chords of
/// its arcs.
const GOUGE_MM: f64 = 0.005;
/// Largest sagitta of the drawing's chords, mm.
const SAGITTA_MM: f64 = 5e-4;

/// Least and largest radius of an outline within each place of a bar, mm; none beyond its ends.
fn drawn_radii(outline: &Outline, left: &TurnedStock) -> Vec<Option<(f64, f64)>> {
    let points: Vec<glam::DVec2> = outline.pieces.iter().flat_map(|p| p.points(SAGITTA_MM)).collect();
    let places: Vec<(f64, f64)> = left.places().collect();
    let half = left.step_mm();
    let mut radii: Vec<Option<(f64, f64)>> = vec![None; places.len()];
    let first = places.first().map_or(0.0, |p| p.0);
    for pair in points.windows(2) {
        let (a, b) = if pair[0].y <= pair[1].y { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
        let number = |z: f64| ((z - first) / left.step_mm()).max(0.0) as usize;
        for i in number(a.y - half)..=number(b.y + half).min(places.len().saturating_sub(1)) {
            let z = places[i].0;
            let (low, high) = ((z - half).max(a.y), (z + half).min(b.y));
            if low > high {
                continue;
            }
            let at =
                |z: f64| if b.y > a.y { a.x + (b.x - a.x) * (z - a.y) / (b.y - a.y) } else { a.x.max(b.x) };
            let other = if b.y > a.y { at(high) } else { a.x.min(b.x) };
            let (least, most) = (at(low).min(other), at(low).max(other));
            let now = radii[i].unwrap_or((f64::INFINITY, 0.0));
            radii[i] = Some((now.0.min(least), now.1.max(most)));
        }
    }
    radii
}

/// The places at which material stays, by Z.
///
/// # Errors
/// A place at which the part is cut into.
pub(super) fn places(
    drawn: &Outline,
    left: &TurnedStock,
    left_out: &[LeftOut],
    gripped_to_mm: Option<f64>,
) -> Result<Vec<LeftPlace>, PartProgramError> {
    let radii = drawn_radii(drawn, left);
    let mut found: Vec<LeftPlace> = Vec::new();
    let mut open: Option<LeftPlace> = None;
    for ((z, r), radii) in left.places().zip(radii) {
        let Some((least, most)) = radii else { continue };
        if r < least - GOUGE_MM {
            return Err(PartProgramError::Gouge { z_mm: z, depth_mm: least - r });
        }
        let gripped = gripped_to_mm.is_some_and(|to| z < to);
        let excess = r - most;
        let goes_on = excess > LISTED_MM && open.is_none_or(|p| (p.reason == Reason::Grip) == gripped);
        if !goes_on {
            found.extend(open.take());
        }
        if excess > LISTED_MM {
            let half = 0.5 * left.step_mm();
            let reason = if gripped { Reason::Grip } else { Reason::NoseRadius };
            let place =
                open.get_or_insert(LeftPlace { reason, z_mm: [z - half, z], most_mm: 0.0, volume_mm3: 0.0 });
            place.z_mm[1] = z + half;
            place.most_mm = place.most_mm.max(excess);
            place.volume_mm3 += std::f64::consts::PI * (r * r - most * most) * left.step_mm();
        }
    }
    found.extend(open);
    found.retain(|p| p.z_mm[1] - p.z_mm[0] > LISTED_LENGTH_MM);
    for place in found.iter_mut().filter(|p| p.reason != Reason::Grip) {
        let edge = |out: &LeftOut| {
            out.why != OutOfReach::NoseRadius && out.z_mm.0 < place.z_mm[1] && out.z_mm.1 > place.z_mm[0]
        };
        if left_out.iter().any(edge) {
            place.reason = Reason::OutOfReach;
        }
    }
    Ok(found)
}
