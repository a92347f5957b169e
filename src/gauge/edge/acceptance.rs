//! Whether a frame is fit to be measured, and accepted as a whole after fitting and rejection.

use super::refusals::explain::{self, refused};
use super::rejection::neighbour_test;
use crate::frame::FrameView;
use crate::gauge::edge::image::plane::all_finite;
use crate::gauge::edge::image::window_layout::LayoutLimits;
use crate::gauge::edges::{FrameEdges, FrameRefused};
use crate::gauge::limit::limits;
use crate::gauge::settings::GaugeSettings;
use crate::profile::Reason;

limits! {
    /// When a frame as a whole is accepted.
    AcceptanceLimits = "acceptance";
    /// Fewest columns with both edges that make a frame or a mean over columns: the standard
    /// deviation of eight is known to 27 % (1/√(2·7)).
    least_valid: usize = 8;
    /// Share of the columns with both edges that must lie on unbroken contours: a part has all of
    /// them there, blobs of noise a tenth. Below a half most of what would be measured is no
    /// contour.
    least_coherent: f64 = 0.5;
    /// χ² ratio above which a residual is compared with the largest one of the settings. Noise
    /// alone gives 1; at 2 the model leaves as much as the noise.
    least_chi2: f64 = 2.0;
    /// Blur, px, up to which a residual refuses no frame: no lens makes such edges, a drawn step
    /// does, and no edge-spread function fits a hard step to noise. The area of a pixel alone has a
    /// standard deviation of 1/√12 = 0.29 px.
    sharp_px: f64 = 0.4;
}

/// Refuses views too small for any window, or with values that are none.
///
/// # Errors
/// Fewer rows than the shortest window, a grey value that is not finite.
pub(crate) fn check(view: &FrameView<'_>) -> Result<(), FrameRefused> {
    let least = LayoutLimits::get().least_width;
    if view.rows() < least {
        return Err(explain::too_small((view.rows(), view.columns()), least));
    }
    if !all_finite(view) {
        return Err(refused(Reason::Unreadable, explain::NOT_FINITE.to_owned()));
    }
    Ok(())
}

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
    let limits = AcceptanceLimits::get();
    if valid < limits.least_valid {
        return Err(explain::too_few(out, valid, limits.least_valid));
    }
    let jump_px = jump_px(settings);
    let coherence = if contours { 1.0 } else { neighbour_test::coherence(&out.top, &out.bottom, jump_px) };
    if coherence < limits.least_coherent {
        return Err(explain::no_contour(coherence, limits.least_coherent, jump_px));
    }
    let residual = out.figures.reduced_chi2.sqrt() / out.figures.snr;
    let blurred = out.figures.sigma_px.iter().any(|sigma| *sigma > limits.sharp_px);
    if blurred && out.figures.reduced_chi2 > limits.least_chi2 && residual > settings.max_residual_rel {
        let (noise, most) = (out.figures.snr.recip(), settings.max_residual_rel);
        return Err(explain::no_fit(residual, noise, most));
    }
    Ok(())
}
