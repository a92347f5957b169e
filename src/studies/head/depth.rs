//! Depth of field: how far from the plane of focus a part may stand.
//!
//! Out of focus the diameter changes by 2·δ(y) + D·t·y: δ the displacement of the edge that is
//! fitted as one in focus, t the telecentricity error of the lens (by `optics.telecentricity_mrad`,
//! otherwise the limit of a good telecentric lens that a calibration assumes). The first distance
//! at which that reaches the limit is the depth; a limit of a quarter of U widens it by √(1 +
//! 1/16), 3 %, where it is added as a standard uncertainty at the same k. Beside it the distance at
//! which the 10-90 % width of the edge has doubled.

use serde::Serialize;

use super::displacement::displacement;
use super::edge::OpticalEdge;
use super::error::HeadError;
use super::setup::HeadSetup;
use crate::gauge::calibration::LensLimits;
use crate::render::RenderError;
use crate::render::settings::Esf;

/// Growth of the distance from one look to the next.
const GROWTH: f64 = std::f64::consts::SQRT_2;
/// Distances looked at, from an eighth of the optics' own unit on: up to 22 of them.
const LOOKS: i32 = 16;
/// Halvings of the interval in which a limit is crossed: to 1 % of the distance.
const HALVINGS: usize = 5;

/// What ends the depth of field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum DepthEnd {
    /// The diameter moves by the limit.
    Diameter,
    /// The gauge no longer accepts the edge: its blur, or its residual.
    Gauge,
    /// No limit within the distances that were looked at, or that the edge's table covers.
    Beyond,
}

/// Depth of field of a head.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct DepthOfField {
    /// By how much a diameter may move, µm.
    pub limit_um: f64,
    /// ± distance from the plane of focus, mm.
    pub depth_mm: f64,
    /// What ends it.
    pub ended_by: DepthEnd,
    /// ± distance at which the blur has doubled, mm; none within the distances looked at.
    pub blur_doubles_mm: Option<f64>,
    /// Angle of chief rays at the corner of the field, mrad, that was taken for the lens.
    pub telecentricity_mrad: f64,
    /// Distance, mm, and change of the diameter there, µm, for a chart.
    pub curve: Vec<(f64, f64)>,
}

/// One distance from the plane of focus.
struct Look {
    change_um: f64,
    accepted: bool,
}

impl DepthOfField {
    /// Of a head whose diameter may move by `limit_um`.
    ///
    /// # Errors
    /// Optics whose table in focus cannot be computed.
    pub(super) fn of(head: &HeadSetup, limit_um: f64) -> Result<Self, HeadError> {
        let focused = head.optics.at(0.0)?;
        let (telecentricity_mrad, per_mm) = telecentricity(head);
        let look = |y_mm: f64| look(head, &focused, y_mm, per_mm);
        let passes = |l: &Look| l.accepted && l.change_um.abs() < limit_um;
        let farthest_mm = limit_um / (1e3 * head.diameter_mm * per_mm);
        let unit_mm = unit_mm(head);
        let mut curve = vec![(0.0, 0.0)];
        let (mut good_mm, mut end) = (0.0, (f64::INFINITY, DepthEnd::Beyond));
        for k in 0..LOOKS {
            let y_mm = (0.125 * unit_mm * GROWTH.powi(k)).min(farthest_mm);
            let Ok(seen) = look(y_mm) else { break };
            curve.push((y_mm, seen.change_um));
            if passes(&seen) && y_mm < farthest_mm {
                good_mm = y_mm;
                continue;
            }
            end = crossing((good_mm, y_mm), &look, &passes);
            break;
        }
        let blur_doubles_mm = blur_doubles(head, &focused, unit_mm);
        let (depth_mm, ended_by) = if end.0.is_finite() { end } else { (good_mm, DepthEnd::Beyond) };
        Ok(Self { limit_um, depth_mm, ended_by, blur_doubles_mm, telecentricity_mrad, curve })
    }
}

/// Where between a good and a bad distance the limit is crossed, and by what.
fn crossing(
    (mut good, mut bad): (f64, f64),
    look: &dyn Fn(f64) -> Result<Look, RenderError>,
    passes: &dyn Fn(&Look) -> bool,
) -> (f64, DepthEnd) {
    let mut end = DepthEnd::Diameter;
    let mut judge = |y_mm: f64| match look(y_mm) {
        Ok(seen) if passes(&seen) => true,
        Ok(seen) => {
            end = if seen.accepted { DepthEnd::Diameter } else { DepthEnd::Gauge };
            false
        }
        Err(_) => false,
    };
    judge(bad);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (good + bad);
        if judge(middle) { good = middle } else { bad = middle }
    }
    (0.5 * (good + bad), end)
}

/// The larger change of the diameter at ± a distance.
fn look(
    head: &HeadSetup,
    focused: &OpticalEdge,
    y_mm: f64,
    telecentricity_per_mm: f64,
) -> Result<Look, RenderError> {
    let by_lens_um = 1e3 * head.diameter_mm * telecentricity_per_mm * y_mm;
    let mut worst = Look { change_um: by_lens_um, accepted: true };
    // The sign counts for light that nears its sensor, and for light that grazed a limb.
    let has_sign = matches!(head.job.optics.esf, Esf::Fresnel(_) | Esf::Cylinder(_));
    let sides: &[f64] = if has_sign { &[-1.0, 1.0] } else { &[1.0] };
    for side in sides {
        let half_px = head.most_half_px();
        let seen = head.optics.at(side * y_mm)?.over_pixels(half_px, 1.0, 0.0);
        let Some(found) = displacement(focused, &seen, half_px, &head.levels) else {
            return Ok(Look { change_um: f64::NAN, accepted: false });
        };
        let change_um = 2.0 * found.into_light_px * head.um_per_px();
        worst.accepted &= is_accepted(head, found.blur_factor, found.residual_rel);
        worst.change_um = worst.change_um.max(change_um.abs() + by_lens_um);
    }
    Ok(worst)
}

/// Whether the gauge accepts an edge of that blur and residual.
pub(super) fn is_accepted(head: &HeadSetup, blur_factor: f64, residual_rel: f64) -> bool {
    let [least, most] = head.room.blur_range_px;
    let blur_px = head.room.blur_px * blur_factor;
    (least..=most).contains(&blur_px) && residual_rel <= head.gauge.max_residual_rel
}

/// Angle of chief rays at the corner, mrad, and the change of scale it makes, 1/mm.
fn telecentricity(head: &HeadSetup) -> (f64, f64) {
    let optics = &head.job.optics;
    let camera = &head.job.camera;
    let half_mm = 0.5 * f64::from(camera.rows).hypot(f64::from(camera.columns)) * head.optics.pixel_mm;
    if let Some(lens) = optics.entocentric {
        return (1e3 * (half_mm / lens.distance_mm).atan(), lens.distance_mm.recip());
    }
    let mrad = match optics.telecentricity_mrad.abs() {
        0.0 => 1e3 * LensLimits::default().telecentricity_deg.to_radians(),
        stated => stated,
    };
    (mrad, (1e-3 * mrad).tan() / half_mm)
}

/// The distance at which the optics' edge changes by as much as it is wide, mm: λ/NA², blur over
/// aperture, a twentieth of a laser's path.
fn unit_mm(head: &HeadSetup) -> f64 {
    let optics = &head.job.optics;
    let blur_mm = head.room.blur_px * head.optics.pixel_mm;
    match &optics.esf {
        Esf::PartiallyCoherent(p) => 1e-3 * p.unit_um() / p.na,
        Esf::Cylinder(c) => 1e-3 * c.unit_um() / c.na,
        Esf::Fresnel(f) => 0.05 * f.distance_mm,
        _ if optics.defocus_na > 0.0 => blur_mm / optics.defocus_na,
        // Focus is left out: only the telecentricity is left.
        _ => head.diameter_mm,
    }
}

/// The first distance at which the edge is twice as wide as in focus, on either side.
fn blur_doubles(head: &HeadSetup, focused: &OpticalEdge, unit_mm: f64) -> Option<f64> {
    let half_px = head.most_half_px();
    let in_focus = focused.width_10_90_px(half_px)?;
    let is_wide = |y_mm: f64| -> Option<bool> {
        let edge = head.optics.at(y_mm).ok()?;
        Some(edge.width_10_90_px(half_px).is_none_or(|width| width >= 2.0 * in_focus))
    };
    let mut good = 0.0;
    for k in 0..LOOKS {
        let mut bad = 0.125 * unit_mm * GROWTH.powi(k);
        if !is_wide(bad)? {
            good = bad;
            continue;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            if is_wide(middle)? { bad = middle } else { good = middle }
        }
        return Some(0.5 * (good + bad));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::calibration::Date;
    use crate::job::Job;
    use crate::render::optics::edge_spread::PartiallyCoherentEdge;
    use crate::studies::head::settings::{ExposureLimits, HeadSettings};
    use crate::studies::head::setup::HeadConfig;

    fn head(change: impl FnOnce(&mut Job)) -> HeadSetup {
        let mut job = Job::default();
        (job.camera.columns, job.camera.rows) = (128, 512);
        job.optics.magnification = 1.0;
        change(&mut job);
        let settings = HeadSettings {
            diameter_mm: Some(0.5),
            rpm: None,
            eccentricity_mm: Some(0.01),
            conditions: None,
            depth_limit_um: None,
            exposure: ExposureLimits { undulations_upr: 15.0, amplitude_loss: 0.01, share_of_u: 0.3 },
            frames: 2,
            seed: 1,
            date: Date::of(std::time::SystemTime::UNIX_EPOCH),
        };
        let config = HeadConfig { name: "head".to_owned(), file: "head.toml".to_owned(), job };
        HeadSetup::new(&config, &settings).unwrap()
    }

    /// A Gaussian edge is not displaced: the lens alone moves the diameter, by D·tan(θ)/h a mm. Its
    /// width doubles at y = 2·√3·σ/NA.
    #[test]
    fn a_gaussian_has_the_closed_forms() {
        let head = head(|job| {
            (job.optics.defocus_na, job.optics.telecentricity_mrad) = (0.05, 1.0);
        });
        let found = DepthOfField::of(&head, 0.02).unwrap();
        let half_mm = 0.5 * 512.0_f64.hypot(128.0) * 3.45e-3;
        let wanted = 2e-5 / (0.5 * 1e-3_f64.tan() / half_mm);
        assert!((found.depth_mm / wanted - 1.0).abs() < 0.02, "{found:?} {wanted}");
        assert_eq!(found.ended_by, DepthEnd::Diameter);
        let doubles = 2.0 * 3.0_f64.sqrt() * 1.2 * 3.45e-3 / 0.05;
        let at = found.blur_doubles_mm.unwrap();
        assert!((at / doubles - 1.0).abs() < 0.03, "{at} {doubles}");
    }

    /// At the depth found, the model's diameter has moved by the limit, and nearer by less.
    #[test]
    fn at_the_depth_the_diameter_has_moved_by_the_limit() {
        let head = head(|job| {
            job.optics.telecentricity_mrad = 1e-6;
            job.optics.esf = Esf::PartiallyCoherent(PartiallyCoherentEdge {
                na: 0.05,
                coherence_ratio: 0.7,
                ..PartiallyCoherentEdge::default()
            });
        });
        let limit_um = 0.1;
        let found = DepthOfField::of(&head, limit_um).unwrap();
        let focused = head.optics.at(0.0).unwrap();
        let change = |y_mm: f64| look(&head, &focused, y_mm, 0.0).unwrap().change_um.abs();
        assert_eq!(found.ended_by, DepthEnd::Diameter, "{found:?}");
        assert!((change(found.depth_mm) / limit_um - 1.0).abs() < 0.1, "{}", change(found.depth_mm));
        assert!(change(0.7 * found.depth_mm) < limit_um);
    }
}
