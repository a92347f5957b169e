//! The shaft of a config: contour or plain cylinder, features, form errors, thermal growth.
//!
//! In: a [`ShaftForm`] and a seed. Out: a [`Shaft`].
//! `contour` reads profiles, `helices` makes threads and feed marks, `texture` draws roughness. A
//! new form error is a table of `[shaft]` and its draw here.

mod contour;
mod helices;
mod texture;

use std::f64::consts::PI;

pub(crate) use self::contour::{contour_knots, read_contour};
use super::error::{RenderError, within};
use crate::shaft::{AxisKnot, Bow, Deflection, Features, Helix, ProfileKnot, Shaft, ShaftForm, Thermal};

/// Knots of a half sine wave over the part: the chord errs by (π/64)²/8 = 3e-4 of the sagitta.
const ARC_KNOTS: usize = 65;

/// Pieces of a taper under a temperature gradient, which makes it curved.
const BENT_PIECES: usize = 16;

/// A shaft with the contour of `form`, or the mean radii of `profile` where it has none, over
/// `0..length_mm`.
///
/// # Errors
/// Refuses a contour that intersects itself, features that do not fit the body, a texture whose
/// lengths are not positive or whose grid would be too large, naming the key.
pub(crate) fn form_shaft(
    profile: Vec<ProfileKnot>,
    form: &ShaftForm,
    length_mm: f64,
    seed: u64,
) -> Result<Shaft, RenderError> {
    within("part.length_mm", length_mm, 1e-3, 1e5)?;
    if let Some(file) = &form.contour_file {
        let right = "was not read: a config is loaded from a file to find the ones it names";
        return Err(RenderError::setting("shaft.contour_file", file, right));
    }
    let texture = form.texture.as_ref().map(|t| texture::draw_texture(t, length_mm, seed)).transpose()?;
    let mut shaft = Shaft {
        profile: if form.contour.is_empty() { profile } else { contour_knots(&form.contour)? },
        lobes: form.lobes.clone(),
        texture,
        eccentricity: form.eccentricity,
        bow: bow_knots(&form.bow, length_mm),
        deflection: deflection_knots(&form.deflection, length_mm),
        pose: form.pose,
        features: Features {
            waves: form.waviness.clone(),
            helices: all_helices(form, length_mm)?,
            flats: form.flats.clone(),
            keyways: form.keyways.clone(),
        },
        spindle: form.spindle.clone(),
    };
    grow(&mut shaft, &form.thermal, length_mm)?;
    Ok(shaft)
}

fn all_helices(form: &ShaftForm, length_mm: f64) -> Result<Vec<Helix>, RenderError> {
    let mut helices: Vec<Helix> = form.threads.iter().map(helices::thread).collect::<Result<_, _>>()?;
    if let Some(marks) = &form.feed_marks {
        helices.push(helices::feed_marks(marks, length_mm)?);
    }
    Ok(helices)
}

/// Grows radii and lengths: R(1 + αΔT), z + α∫ΔT dz from the chuck face.
fn grow(shaft: &mut Shaft, thermal: &Thermal, length_mm: f64) -> Result<(), RenderError> {
    within("shaft.thermal.rise_at_chuck_k", thermal.rise_at_chuck_k, -300.0, 2000.0)?;
    within("shaft.thermal.rise_at_end_k", thermal.rise_at_end_k, -300.0, 2000.0)?;
    within("shaft.thermal.expansion_um_per_m_k", thermal.expansion_um_per_m_k, -100.0, 1000.0)?;
    let gradient = (thermal.rise_at_end_k - thermal.rise_at_chuck_k) / length_mm;
    if thermal.rise_at_chuck_k == 0.0 && gradient == 0.0 {
        return Ok(());
    }
    let alpha = thermal.expansion_um_per_m_k * 1e-6;
    let inside = |z: f64| z.clamp(0.0, length_mm);
    let strain = |z: f64| alpha * (thermal.rise_at_chuck_k + gradient * inside(z));
    let place = |z: f64| z + alpha * inside(z) * (thermal.rise_at_chuck_k + 0.5 * gradient * inside(z));
    if gradient != 0.0 {
        shaft.profile = divided(&shaft.profile, length_mm);
    }
    for knot in &mut shaft.profile {
        *knot = ProfileKnot { z_mm: place(knot.z_mm), radius_mm: knot.radius_mm * (1.0 + strain(knot.z_mm)) };
    }
    for helix in &mut shaft.features.helices {
        helix.pitch_mm *= 1.0 + strain(0.5 * (helix.from_mm + helix.to_mm));
        (helix.from_mm, helix.to_mm) = (place(helix.from_mm), place(helix.to_mm));
    }
    for flat in &mut shaft.features.flats {
        flat.distance_mm *= 1.0 + strain(0.5 * (flat.from_mm + flat.to_mm));
        (flat.from_mm, flat.to_mm) = (place(flat.from_mm), place(flat.to_mm));
    }
    for keyway in &mut shaft.features.keyways {
        let grown = 1.0 + strain(0.5 * (keyway.from_mm + keyway.to_mm));
        keyway.floor_mm *= grown;
        keyway.width_mm *= grown;
        (keyway.from_mm, keyway.to_mm) = (place(keyway.from_mm), place(keyway.to_mm));
    }
    Ok(())
}

/// The profile with knots at both ends of the part and within tapers.
fn divided(profile: &[ProfileKnot], length_mm: f64) -> Vec<ProfileKnot> {
    let mut knots = profile.to_vec();
    if let (Some(first), Some(last)) = (profile.first(), profile.last()) {
        if first.z_mm > 0.0 || profile.len() == 1 {
            knots.insert(0, ProfileKnot { z_mm: 0.0, ..*first });
        }
        if last.z_mm < length_mm {
            knots.push(ProfileKnot { z_mm: length_mm, ..*last });
        }
    }
    let mut out = knots[..1].to_vec();
    for pair in knots.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let pieces = if a.radius_mm == b.radius_mm || a.z_mm == b.z_mm { 1 } else { BENT_PIECES };
        out.extend((1..=pieces).map(|i| i as f64 / pieces as f64).map(|t| ProfileKnot {
            z_mm: a.z_mm + t * (b.z_mm - a.z_mm),
            radius_mm: a.radius_mm + t * (b.radius_mm - a.radius_mm),
        }));
    }
    out
}

fn bow_knots(bow: &Bow, length_mm: f64) -> Vec<AxisKnot> {
    let (sin, cos) = bow.phase_deg.to_radians().sin_cos();
    half_sine(bow.sagitta_mm * cos, bow.sagitta_mm * sin, length_mm)
}

fn deflection_knots(deflection: &Deflection, length_mm: f64) -> Vec<AxisKnot> {
    half_sine(deflection.sagitta_x_mm, deflection.sagitta_y_mm, length_mm)
}

fn half_sine(x_mm: f64, y_mm: f64, length_mm: f64) -> Vec<AxisKnot> {
    if x_mm == 0.0 && y_mm == 0.0 {
        return Vec::new();
    }
    (0..ARC_KNOTS)
        .map(|i| {
            let t = i as f64 / (ARC_KNOTS - 1) as f64;
            let arc = (PI * t).sin();
            AxisKnot { z_mm: t * length_mm, x_mm: x_mm * arc, y_mm: y_mm * arc }
        })
        .collect()
}
