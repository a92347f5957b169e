//! A frame of a wire: the fit of [`crate::gauge::edge::wire::joint_fit`], with the tests of other
//! edges.

use super::clipped::clipped_share;
use super::joint_fit::Wire;
use crate::gauge::edge::acceptance::AcceptanceLimits;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::locate::PartLocation;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edge::refusals::explain;
use crate::gauge::edge::rejection::neighbour_test::{self, OutlierScratch};
use crate::gauge::edge::rejection::residual_test;
use crate::gauge::edges::{Edge, FrameEdges, FrameFigures, FrameRefused};
use crate::gauge::limit::limits;
use crate::gauge::settings::{GaugeSettings, Rejection};
use crate::numerics::distributions::{chi2_ratio_limit, upper_normal_quantile};
use crate::profile::Reason;

limits! {
    /// What a frame of a wire must show.
    WireFrameLimits = "wire_frame";
    /// Width of a wire in blurs below which its shadow hardly reaches its own level: at three of
    /// them the middle still has 2Φ(−1.5) = 13 % of the light.
    least_in_blurs: f64 = 3.0;
}

/// Measures the wire that the coarse search found into `out`.
///
/// # Errors
/// Refuses wires too near the border, too faint, clipped, too blurred for their width, or that the
/// edge model does not fit.
pub(crate) fn measure<T: Sample>(
    plane: &Plane<'_, T>,
    part: &PartLocation,
    (shape, settings): (&EdgeSpreadFunction, &GaugeSettings),
    out: &mut FrameEdges,
) -> Result<(), FrameRefused> {
    let limits = WireFrameLimits::get();
    let scale = part.scale;
    if let Some(share) = clipped_share(plane, part) {
        return Err(explain::clipped_wire(share));
    }
    let fitted = Wire::fit(plane, (&part.top, &part.bottom), shape, scale.floor(1.0));
    let wire = fitted.map_err(explain::no_wire)?;
    let (dark, [above, below]) = wire.levels();
    let light = 0.5 * (above + below);
    let noise = wire.noise();
    let mid = (0.5 * (noise[0].powi(2) + noise[1].powi(2))).sqrt();
    let snr = (light - dark) / mid;
    let (width, sigma) = (wire.width_px(), wire.sigma());
    if !(snr >= settings.min_snr) {
        return Err(explain::too_faint((dark, light), snr, settings.min_snr));
    }
    if !(width >= limits.least_in_blurs * sigma) {
        return Err(explain::blurred_wire(width, sigma, limits.least_in_blurs));
    }
    lay_out(part, out);
    wire.write(&mut out.top, &mut out.bottom);
    let reduced_chi2 = judge(settings, wire.freedom(), out);
    let step = scale.step();
    let rounding_px = match step > 0.0 {
        true => wire.rounding(step).state(|columns| wire.equations(columns), [&mut out.top, &mut out.bottom]),
        false => 0.0,
    };
    out.shared_length = [plane.columns as f32; 2];
    out.clipped_px = [0.0; 2];
    out.figures = FrameFigures {
        sigma_px: [sigma; 2],
        position_ambiguity_px: [0.0; 2],
        dark: [dark; 2],
        light: [above, below],
        noise,
        snr,
        reduced_chi2,
        quantised: scale.floor > 0.0,
        rounding_px: [rounding_px; 2],
        shadows: part.shadows,
    };
    let acceptance = AcceptanceLimits::get();
    let valid = out.valid();
    if valid < acceptance.least_valid {
        return Err(explain::too_few(out, valid, acceptance.least_valid));
    }
    let residual = reduced_chi2.sqrt() / snr;
    if reduced_chi2 > acceptance.least_chi2 && residual > settings.max_residual_rel {
        return Err(explain::no_fit(residual, snr.recip(), settings.max_residual_rel));
    }
    Ok(())
}

/// Gaps with the coarse search's reasons; columns with both edges that are not fitted lie too near
/// the border.
fn lay_out(part: &PartLocation, out: &mut FrameEdges) {
    out.top.clear();
    out.bottom.clear();
    for (top, bottom) in part.top.iter().zip(&part.bottom) {
        let reason = top.err().or(bottom.err()).unwrap_or(Reason::Border);
        out.top.push(Edge::gap(reason));
        out.bottom.push(Edge::gap(reason));
    }
}

/// Refuses edges by residual, uncertainty and neighbours, and adds the model uncertainty to u;
/// returns the larger reduced χ².
fn judge(settings: &GaugeSettings, freedom: f64, out: &mut FrameEdges) -> f64 {
    let z = upper_normal_quantile(settings.residual_false_alarm);
    let mut most = 1.0_f64;
    for (line, stated) in [&mut out.top, &mut out.bottom].into_iter().zip(&mut out.model_uncertainty_px) {
        let reduced_chi2 = residual_test::reduced_chi2(line, freedom, &mut Vec::new());
        most = most.max(reduced_chi2);
        let scale = if reduced_chi2 > 1.2 { reduced_chi2 } else { 1.0 };
        if settings.rejection != Rejection::Off {
            residual_test::refuse_residuals(line, (chi2_ratio_limit(freedom, z) * scale) as f32);
        }
        residual_test::add_model_uncertainty(line, freedom, 0.0, stated);
        line.iter_mut().for_each(|edge| edge.u_own_px *= (scale as f32).sqrt());
        if settings.rejection != Rejection::Off {
            residual_test::reject_uncertain(line);
            neighbour_test::refuse_outliers(line, settings.outlier_px, &mut OutlierScratch::default());
        }
    }
    most
}
