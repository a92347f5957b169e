//! Whether a frame as a whole is accepted, after fitting and rejection.

use super::refusals::explain;
use super::rejection::neighbour_test;
use crate::gauge::edges::{FrameEdges, FrameRefused};
use crate::gauge::settings::GaugeSettings;

/// Fewest columns with both edges that make a frame acceptable.
const LEAST_VALID: usize = 8;
/// Least fraction of the measured columns that must lie on unbroken contours.
const LEAST_COHERENT: f64 = 0.5;
/// χ² ratio above which the noise cannot be what keeps the model from fitting.
const LEAST_CHI2: f64 = 2.0;
/// Blur below which a drawn step is taken for what it is: no lens makes such edges, and no
/// edge-spread function fits a hard step to noise.
const SHARP_PX: f64 = 0.4;

/// Largest step of a contour from one column to the next, px.
pub(crate) fn jump_px(settings: &GaugeSettings) -> f64 {
    settings.outlier_px + settings.max_slope
}

/// Accepts a frame with so many columns that have both edges; `contours`: neither line has a gap or
/// a larger step than a contour has.
///
/// # Errors
/// Too few columns, edges that lie on no contour, a residual that noise does not explain.
pub(crate) fn accept(
    out: &FrameEdges,
    settings: &GaugeSettings,
    valid: usize,
    contours: bool,
) -> Result<(), FrameRefused> {
    if valid < LEAST_VALID {
        return Err(explain::too_few(out, valid, LEAST_VALID));
    }
    let jump_px = jump_px(settings);
    let coherence = if contours { 1.0 } else { neighbour_test::coherence(&out.top, &out.bottom, jump_px) };
    if coherence < LEAST_COHERENT {
        return Err(explain::no_contour(coherence, LEAST_COHERENT, jump_px));
    }
    let residual = out.figures.reduced_chi2.sqrt() / out.figures.snr;
    let blurred = out.figures.sigma_px.iter().any(|sigma| *sigma > SHARP_PX);
    if blurred && out.figures.reduced_chi2 > LEAST_CHI2 && residual > settings.max_residual_rel {
        let (noise, most) = (out.figures.snr.recip(), settings.max_residual_rel);
        return Err(explain::no_fit(residual, noise, most));
    }
    Ok(())
}
