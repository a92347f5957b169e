//! The pooled fit of a band in light that is not even, and with grey values that are clipped.

use std::borrow::Cow;

use super::edge_fit::{Begun, EdgeFit};
use super::edge_pixels::Band;
use super::fit::{fit_edge, fit_edge_from, fit_edge_nearly};
use crate::gauge::edge::estimation::light_field::{LightField, Lit};
use crate::numerics::robust::median_of;

/// The field of an uneven light and the shadow's level, of a band that reaches beyond `half_px`
/// towards the light; `None` of an even light.
pub(in crate::gauge) fn light_of(band: &Band, half_px: f64) -> Option<(LightField, f64)> {
    let all = || band.sectors.iter().flatten();
    let dark = all().filter(|p| p.distance < -0.7 * half_px).map(|p| p.value).collect();
    let dark = median_of(dark);
    let lit = all().filter(|p| p.distance > half_px).map(|p| {
        let at = band.place(p);
        Lit { x: at.x, y: at.y, contrast: p.value - dark }
    });
    Some((LightField::fit(&lit.collect::<Vec<_>>())?, dark))
}

/// The fit of a band, levelled by its light; `whole` is whether grey values are whole counts,
/// `begun` where a fit of the same edge ended. Without that it is near only: another one along the
/// contour that it finds must follow.
///
/// # Errors
/// The reason for which no edge fits.
pub(in crate::gauge) fn fit_levelled(
    raw: &Band,
    light: Option<&(LightField, f64)>,
    whole: bool,
    begun: Option<Begun>,
) -> Result<EdgeFit, String> {
    let least_variance = if whole { 1.0 / 12.0 } else { 1e-6 };
    let mut band = Cow::Borrowed(raw);
    if let Some((field, dark)) = light {
        band.to_mut().level(field, *dark);
    }
    let fitted = match begun {
        Some(begun) => fit_edge_from(&band, least_variance, f64::MAX.sqrt(), begun),
        None => fit_edge_nearly(&band, least_variance, f64::MAX.sqrt()),
    };
    let flank = fitted.as_ref().map_or(f64::INFINITY, |fit| fit.noise);
    match raw.ends(flank, whole) {
        None => fitted,
        ends => fit_edge(raw, least_variance, f64::MAX.sqrt(), ends),
    }
}
