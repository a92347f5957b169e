//! A frame of a wire: the fit of [`crate::gauge::edge::wire::joint_fit`], with the tests of other
//! edges.

use super::joint_fit::Wire;
use crate::gauge::edge::estimation::side_survey::GreyScaleLimits;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::locate::PartLocation;
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edge::refusals::explain;
use crate::gauge::edge::rejection::neighbour_test::{self, OutlierScratch};
use crate::gauge::edge::rejection::residual_test;
use crate::gauge::edges::{Edge, FrameEdges, FrameFigures, FrameRefused};
use crate::gauge::settings::{GaugeSettings, Rejection};
use crate::numerics::distributions::{chi2_ratio_limit, upper_normal_quantile};
use crate::profile::Reason;

/// Width of a wire in blurs below which its shadow hardly reaches its own level: at three of them
/// the middle still has 13 % of the light.
const LEAST_IN_BLURS: f64 = 3.0;
/// Share of the pixels at the largest grey value from which light may be clipped.
const CLIPPED_FRACTION: f64 = 0.01;
/// Second differences along the shadow of so many steps, and their share where there is noise: a
/// shadow that toggles between two grey values has none above two, noise of half a step has 8 %.
const TOGGLES: f32 = 2.5;
const NOISY: f64 = 0.02;
/// Share of the range of grey values that is shadow.
const SHADOW: f32 = 0.15;
/// Fewest columns, and the χ² ratio from which the noise does not explain what the model leaves, as
/// for other frames.
const LEAST_VALID: usize = 8;
const LEAST_CHI2: f64 = 2.0;

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
    let scale = part.scale;
    if let Some(share) = clipped_share(plane, scale) {
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
    if !(width >= LEAST_IN_BLURS * sigma) {
        return Err(explain::blurred_wire(width, sigma, LEAST_IN_BLURS));
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
    let valid = out.valid();
    if valid < LEAST_VALID {
        return Err(explain::too_few(out, valid, LEAST_VALID));
    }
    let residual = reduced_chi2.sqrt() / snr;
    if reduced_chi2 > LEAST_CHI2 && residual > settings.max_residual_rel {
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

/// Share of the pixels that stand at the light's largest grey value, where light is clipped there:
/// noise leaves the largest value to few pixels and the next one to more, a clip piles them up. A
/// frame without noise on the other side is not clipped but drawn.
fn clipped_share<T: Sample>(plane: &Plane<'_, T>, scale: GreyScaleLimits) -> Option<f64> {
    if !(scale.floor > 0.0) {
        return None;
    }
    let rows = || (0..plane.rows).step_by((plane.rows / 64).max(1));
    // A column of one grey value is a stuck one: the wire would show in it.
    let live: Vec<usize> = (0..plane.columns)
        .filter(|column| rows().any(|row| plane.at(row, *column) != plane.at(0, *column)))
        .collect();
    let values: Vec<f32> =
        rows().flat_map(|row| live.iter().map(move |column| plane.at(row, *column))).collect();
    let (least, most) =
        values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let count = |over: &dyn Fn(f32) -> bool| values.iter().filter(|v| over(**v)).count() as f64;
    let at_most = count(&|v| v >= most);
    let step = scale.step() as f32;
    let next = count(&|v| v >= most - step) - at_most;
    let shadow = least + SHADOW * (most - least);
    let dark = values.windows(3).filter(|w| w[0].max(w[1]).max(w[2]) < shadow);
    let scatters = |w: &[f32]| (w[0] - 2.0 * w[1] + w[2]).abs() > TOGGLES * step;
    let (noisy, all) = dark.fold((0.0, 0.0), |(u, n), w| (u + f64::from(u8::from(scatters(w))), n + 1.0));
    let share = at_most / values.len() as f64;
    (share > CLIPPED_FRACTION && at_most > 2.0 * next && noisy > NOISY * all).then_some(share)
}
