//! A nose beside the same insert new, registered on both unworn edges.

use super::error::NoseImageError;
use super::expected::check_direction;
use super::limits::NoseLimits;
use super::result::{NoseMeasurement, NoseSector};
use super::settings::ExpectedNose;

/// The same insert new.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BaselineNose {
    /// Included angle of its edges, degrees.
    pub angle_deg: f64,
    /// Its standard uncertainty, degrees.
    pub u_angle_deg: f64,
    /// Directions of the outward normals of both edges, degrees.
    pub normals_deg: [f64; 2],
    /// Distance of its centre from both edges, px.
    pub nominal_radius_px: f64,
    /// Its sectors.
    pub sectors: Vec<NoseSector>,
}

/// What a nose has lost, about the centre that both have at the same distance from both edges.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wear {
    /// Mean of the sectors, px.
    pub mean_px: f64,
    /// Largest of a sector, px.
    pub largest_px: f64,
    /// Where, degrees.
    pub largest_deg: f64,
    /// Of each sector: what is missing, px, and its standard uncertainty.
    pub sectors: Vec<(f64, f64)>,
}

impl From<&NoseMeasurement> for BaselineNose {
    fn from(m: &NoseMeasurement) -> Self {
        Self {
            angle_deg: m.angle_deg,
            u_angle_deg: m.u_angle_deg,
            normals_deg: m.normals_deg,
            nominal_radius_px: m.nominal_radius_px,
            sectors: m.sectors.clone(),
        }
    }
}

/// Compares a nose, measured with the baseline's nominal radius, with the baseline.
///
/// # Errors
/// A picture that lies otherwise, another angle, a nose that reaches beyond the baseline in many
/// sectors: not the same insert.
pub(crate) fn wear(found: &NoseMeasurement, baseline: &BaselineNose) -> Result<Wear, NoseImageError> {
    let limits = NoseLimits::get();
    let expected =
        ExpectedNose { epsilon_deg: baseline.angle_deg, normals_deg: baseline.normals_deg, by: "baseline" };
    let off = (found.angle_deg - baseline.angle_deg).abs();
    let most = (limits.baseline_u * found.u_angle_deg.hypot(baseline.u_angle_deg)).max(limits.baseline_deg);
    if off > most {
        return Err(NoseImageError::Baseline {
            why: format!(
                "its edges enclose {:.4} degrees, these {:.4}, at most {most:.4} apart they are the same",
                baseline.angle_deg, found.angle_deg
            ),
        });
    }
    check_direction(found.normals_deg, 0.0, &expected)?;
    let turn = |deg: f64, from: f64| (deg - from + 180.0).rem_euclid(360.0) - 180.0;
    let sectors: Vec<(f64, f64)> = found
        .sectors
        .iter()
        .map(|s| {
            let (radius, u) = at(baseline, turn(s.direction_deg, found.normals_deg[0]));
            (radius - s.radius_px, u.hypot(s.u_px))
        })
        .collect();
    let beyond =
        sectors.iter().filter(|(gap, u)| *gap < -(limits.baseline_u * u).max(limits.on_line_px)).count();
    if beyond as f64 > limits.baseline_beyond * sectors.len() as f64 {
        return Err(NoseImageError::Baseline {
            why: format!(
                "this nose reaches beyond it in {beyond} of {} sectors, and wear only takes away",
                sectors.len()
            ),
        });
    }
    let (mut largest_px, mut largest_deg) = (f64::NEG_INFINITY, 0.0);
    for (s, (gap, _)) in found.sectors.iter().zip(&sectors) {
        if *gap > largest_px {
            (largest_px, largest_deg) = (*gap, s.direction_deg);
        }
    }
    let mean_px = sectors.iter().map(|s| s.0).sum::<f64>() / sectors.len() as f64;
    Ok(Wear { mean_px, largest_px, largest_deg, sectors })
}

/// Radius of the baseline `turn` degrees after its first edge's normal, and its u, px: straight
/// between sectors.
fn at(baseline: &BaselineNose, turn: f64) -> (f64, f64) {
    let sectors = &baseline.sectors;
    let sweep = (baseline.normals_deg[1] - baseline.normals_deg[0]).rem_euclid(360.0);
    let place = (turn / sweep * sectors.len() as f64 - 0.5).clamp(0.0, (sectors.len() - 1) as f64);
    let k = (place as usize).min(sectors.len().saturating_sub(2));
    let t = place - k as f64;
    let (a, b) = (&sectors[k], &sectors[(k + 1).min(sectors.len() - 1)]);
    (a.radius_px + t * (b.radius_px - a.radius_px), a.u_px.hypot(b.u_px) * std::f64::consts::FRAC_1_SQRT_2)
}
