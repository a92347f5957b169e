//! Checks that a shaft can be drawn.

use super::features;
use crate::render::error::RenderError;
use crate::shaft::{Shaft, SurfaceTexture};

/// Refuses a shaft that cannot be drawn.
pub(super) fn check(shaft: &Shaft) -> Result<(), RenderError> {
    let refuse = |what: String| Err(RenderError::Shaft { what });
    if shaft.profile.is_empty() {
        return refuse("the profile has no knot; at least one is needed".into());
    }
    check_profile(shaft)?;
    check_features(shaft)?;
    for knots in [&shaft.bow, &shaft.deflection] {
        if !knots.is_sorted_by(|a, b| a.z_mm <= b.z_mm) {
            return refuse("the knots of bow and deflection must ascend in z".into());
        }
        if knots.iter().any(|k| !(k.z_mm.is_finite() && k.x_mm.is_finite() && k.y_mm.is_finite())) {
            return refuse("bow and deflection must be finite".into());
        }
    }
    if let Some(lobe) = shaft.lobes.iter().find(|l| l.order_upr < 2 || !l.amplitude_mm.is_finite()) {
        return refuse(format!(
            "a lobe has order {} and amplitude {} mm; orders start at 2 (1 is eccentricity)",
            lobe.order_upr, lobe.amplitude_mm
        ));
    }
    let placed = [
        shaft.pose.x_mm,
        shaft.pose.tilt_mrad,
        shaft.pose.tilt_to_camera_mrad,
        shaft.eccentricity.amplitude_mm,
        shaft.eccentricity.phase_deg,
    ];
    if placed.iter().any(|v| !v.is_finite())
        || shaft.pose.tilt_mrad.abs().max(shaft.pose.tilt_to_camera_mrad.abs()) > 500.0
    {
        return refuse("pose and eccentricity must be finite, tilts within ±500 mrad".into());
    }
    check_texture(shaft.texture.as_ref())?;
    let lobes: f64 = shaft.lobes.iter().map(|l| l.amplitude_mm.abs()).sum();
    let waves: f64 = shaft.features.waves.iter().map(|w| w.amplitude_mm.abs()).sum();
    let lowest = shaft.texture.as_ref().map_or(0.0, |t| bounds(t).0) - lobes - waves
        + features::bounds(&shaft.features).0;
    match shaft.profile.iter().find(|k| !(k.radius_mm.is_finite() && k.radius_mm + lowest > 0.0)) {
        Some(k) => refuse(format!(
            "at z = {} mm the radius {} mm less form errors of {} mm is not positive",
            k.z_mm, k.radius_mm, -lowest
        )),
        None => Ok(()),
    }
}

fn check_texture(texture: Option<&SurfaceTexture>) -> Result<(), RenderError> {
    let Some(t) = texture else { return Ok(()) };
    let fits = t.nodes_theta > 0 && !t.height_mm.is_empty() && t.height_mm.len() % t.nodes_theta == 0;
    if fits && t.step_mm > 0.0 && t.z0_mm.is_finite() && t.height_mm.iter().all(|h| h.is_finite()) {
        return Ok(());
    }
    Err(RenderError::Shaft {
        what: format!(
            "the texture has {} heights for {} nodes a turn at a step of {} mm; it needs whole rows, finite heights and a positive step",
            t.height_mm.len(),
            t.nodes_theta,
            t.step_mm
        ),
    })
}

/// A contour that turns back in z, or up and down again at one z, intersects itself.
fn check_profile(shaft: &Shaft) -> Result<(), RenderError> {
    let refuse = |z: f64, what: &str| {
        Err(RenderError::Shaft { what: format!("the profile intersects itself at z = {z} mm: {what}") })
    };
    for pair in shaft.profile.windows(2) {
        if !(pair[0].z_mm <= pair[1].z_mm) {
            return refuse(pair[0].z_mm, "its knots must ascend in z");
        }
    }
    for k in shaft.profile.windows(3) {
        let turns = (k[1].radius_mm - k[0].radius_mm) * (k[2].radius_mm - k[1].radius_mm) < 0.0;
        if k[0].z_mm == k[2].z_mm && turns {
            return refuse(k[0].z_mm, "it goes out and back without moving along z");
        }
    }
    Ok(())
}

fn check_features(shaft: &Shaft) -> Result<(), RenderError> {
    let refuse = |what: String| Err(RenderError::Shaft { what });
    let f = &shaft.features;
    let wave_is_good = |w: &crate::shaft::AxialWave| {
        w.wavelength_mm > 0.0 && [w.wavelength_mm, w.amplitude_mm, w.phase_deg].iter().all(|v| v.is_finite())
    };
    if !f.waves.iter().all(wave_is_good) {
        return refuse("a wave needs a wavelength above 0 and finite values".into());
    }
    let spans = f.flats.iter().map(|f| (f.from_mm, f.to_mm, f.distance_mm, f.angle_deg));
    let spans = spans.chain(f.keyways.iter().map(|k| (k.from_mm, k.to_mm, k.floor_mm, k.angle_deg)));
    for (from, to, distance, angle) in spans {
        if !(from < to && distance > 0.0 && distance.is_finite() && angle.is_finite()) {
            return refuse(format!(
                "a flat or keyway from {from} to {to} mm at {distance} mm from the axis: it must ascend and leave the axis inside"
            ));
        }
    }
    if let Some(k) = f.keyways.iter().find(|k| !(k.width_mm > 0.0 && k.width_mm.is_finite())) {
        return refuse(format!("a keyway {} mm wide; its width must be above 0", k.width_mm));
    }
    for h in &f.helices {
        let ascending = h.pieces.windows(2).all(|p| p[0].from < p[1].from);
        let begins = h.pieces.first().is_some_and(|p| p.from == 0.0) && h.pieces.iter().all(|p| p.from < 1.0);
        if !(h.from_mm < h.to_mm && h.pitch_mm > 0.0 && h.starts > 0 && ascending && begins) {
            return refuse("a helix needs an ascending stretch of z, a pitch above 0, starts, and pieces from phase 0 on".into());
        }
    }
    let spindle = &shaft.spindle;
    let harmonic = |h: &crate::shaft::SpindleHarmonic| [h.x_um, h.y_um, h.x_phase_deg, h.y_phase_deg];
    let finite = spindle.synchronous.iter().flat_map(harmonic).all(f64::is_finite);
    if !finite || !(0.0..=1e4).contains(&spindle.asynchronous_rms_um) {
        return refuse("spindle error motion must be finite, asynchronous_rms_um within 0 to 10000".into());
    }
    Ok(())
}

/// Lowest and highest node.
pub(super) fn bounds(texture: &SurfaceTexture) -> (f64, f64) {
    texture
        .height_mm
        .iter()
        .map(|&h| f64::from(h))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
}
