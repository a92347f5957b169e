//! Why a frame gives no diameter, in words: what was seen, the limit, and what would help. Only
//! refused frames come here.

use std::collections::BTreeMap;

use super::other_views;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::image::shadows::NoShadow;
use crate::gauge::edges::{Edge, FrameEdges, FrameRefused};
use crate::gauge::limit::limits;
use crate::gauge::settings::GaugeSettings;
use crate::numerics::robust::upper_median;
use crate::profile::Reason;

limits! {
    /// Which reason a refusal gives.
    ExplainLimits = "explain";
    /// Range of grey values over their noise up to which a frame shows one level: the extremes of a
    /// million normal values lie 9.8 standard deviations apart, and whole counts round them
    /// outwards.
    one_level: f64 = 12.0;
}

/// Text where no window holds both levels.
const NO_LEVELS: &str = "no column shows both light and shadow beside an edge, and one is needed at least: the part is hidden, blurred beyond \
    its windows or runs the other way: focus, move the part, or try --vertical";

/// Text for NaN and infinity.
pub(crate) const NOT_FINITE: &str = "grey values that are not finite numbers; every pixel must be one: write a number in place of NaN and infinity";

/// A refusal.
pub(crate) fn refused(reason: Reason, detail: String) -> FrameRefused {
    FrameRefused { reason, detail }
}

/// No side of the shadow shows its levels.
pub(crate) fn no_levels() -> FrameRefused {
    refused(Reason::NoEdge, NO_LEVELS.to_owned())
}

/// Why no shadow was chosen: by the choice itself, else by the grey values.
pub(crate) fn no_shadow<T: Sample>(
    plane: &Plane<'_, T>,
    settings: &GaugeSettings,
    none: NoShadow,
) -> FrameRefused {
    match none.detail {
        Some(detail) => FrameRefused { reason: none.reason, detail },
        None => no_part(plane, settings, none.reason),
    }
}

/// A frame of too few rows.
pub(crate) fn too_small((rows, columns): (usize, usize), least: usize) -> FrameRefused {
    refused(
        Reason::NoEdge,
        format!(
            "{rows} rows x {columns} columns; at least {least} rows are needed to tell levels and noise beside an edge: crop less, or try --vertical where the part stands upright"
        ),
    )
}

/// The coarse search found no part.
pub(crate) fn no_part<T: Sample>(
    plane: &Plane<'_, T>,
    settings: &GaugeSettings,
    reason: Reason,
) -> FrameRefused {
    let grey = GreyValues::of(plane);
    if grey.is_one_level() {
        return refused(reason, grey.one_level());
    }
    let seen = match reason {
        Reason::LowContrast => format!(
            "{}, and they do not fall into light and shadow; no shadow of {} px or more stands between light in a quarter of the columns",
            grey.range(),
            settings.min_diameter_px
        ),
        Reason::OneEdge => format!(
            "the shadow reaches the border of the field, so that only one edge is seen; both must lie inside ({})",
            grey.range()
        ),
        _ => format!(
            "no shadow of {} px or more lies in the field ({})",
            settings.min_diameter_px,
            grey.range()
        ),
    };
    let help = other_views::recommended(plane, settings).map_or_else(
        || {
            let help = match reason {
                Reason::OneEdge => "move the part or the field, or magnify less",
                _ => "move the part into the field; --min-diameter-px (gauge.min_diameter_px) sets the least size, --vertical and --bright-on-dark say how it stands",
            };
            format!(": {help}")
        },
        |words| format!("; {words}"),
    );
    refused(reason, format!("{seen}{help}"))
}

/// Grey values of a thinned frame.
struct GreyValues {
    least: f32,
    most: f32,
    noise: f64,
    full_scale: bool,
}

impl GreyValues {
    fn of<T: Sample>(plane: &Plane<'_, T>) -> Self {
        let step = (plane.rows / 256).max(1);
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        let mut differences = Vec::new();
        for row in (0..plane.rows).step_by(step) {
            for column in 0..plane.columns - 1 {
                let (value, next) = (plane.at(row, column), plane.at(row, column + 1));
                (least, most) = (least.min(value), most.max(value));
                differences.push((next - value).abs());
            }
        }
        let median = upper_median(&mut differences, f32::total_cmp).unwrap_or(0.0);
        // Without the steps at edges; the mean of |difference| of two normal values is 1.128 of
        // their standard deviation.
        let cut = 6.0 * (median + 0.5);
        let small = differences.iter().filter(|d| **d < cut);
        let (sum, count) = small.fold((0.0, 0.0_f64), |(sum, n), d| (sum + f64::from(*d), n + 1.0));
        let noise = sum / count.max(1.0) / 1.128;
        let (least, most) = if plane.sign > 0.0 { (least, most) } else { (-most, -least) };
        Self { least, most, noise, full_scale: least == most && least > 0.0 }
    }

    fn is_one_level(&self) -> bool {
        let limits = ExplainLimits::get();
        f64::from(self.most - self.least) <= limits.one_level * self.noise || self.most <= self.least
    }

    fn range(&self) -> String {
        format!("grey values from {} to {} counts, noise {:.1}", self.least, self.most, self.noise)
    }

    fn one_level(&self) -> String {
        let level = if self.full_scale {
            "every pixel has the same value: no light, light at the end of the scale, or no image of a camera"
        } else {
            "nothing but one level and its noise: no part stands in the light, or there is none"
        };
        format!(
            "{}: {level}; light and shadow must lie more than {} times the noise apart: put a part into the field, light it from behind, or set the exposure",
            self.range(),
            ExplainLimits::get().one_level
        )
    }
}

/// Windows that reach beyond the field: `seen` is the least distance of an edge from the border,
/// px.
pub(crate) fn too_near(needed_px: usize, seen: Option<f64>) -> FrameRefused {
    let seen = seen.map_or_else(String::new, |px| format!("; {px:.0} px are seen"));
    refused(
        Reason::Border,
        format!(
            "an edge lies too near the border of the field: {needed_px} px of light are needed beside it at this blur{seen}: move the part or the field"
        ),
    )
}

/// Contrast too small.
pub(crate) fn too_faint((dark, light): (f64, f64), snr: f64, least: f64) -> FrameRefused {
    refused(
        Reason::LowContrast,
        format!(
            "contrast is {snr:.1} times the noise (shadow at {dark:.1}, light at {light:.1} counts); at least {least} are needed: expose more, or average frames (gauge.min_snr sets the least)"
        ),
    )
}

/// Too few columns have both edges.
pub(crate) fn too_few(edges: &FrameEdges, valid: usize, needed: usize) -> FrameRefused {
    let mut counts = BTreeMap::<Reason, usize>::new();
    for (top, bottom) in edges.top.iter().zip(&edges.bottom) {
        if let Some(reason) = [top, bottom].into_iter().find(|e| !e.is_usable()).and_then(Edge::reason) {
            *counts.entry(reason).or_default() += 1;
        }
    }
    let reason = counts.iter().max_by_key(|(_, n)| **n).map_or(Reason::NoEdge, |(reason, _)| *reason);
    if reason == Reason::Saturated {
        let clipped = counts.get(&reason).copied().unwrap_or(0);
        let detail = format!(
            "in {clipped} of {} columns light or shadow is clipped at the end of the grey scale and the flanks of the edges do not state how far beyond it lies; {needed} columns are needed: expose less",
            edges.columns()
        );
        return refused(reason, detail);
    }
    let each: Vec<String> = counts.iter().map(|(reason, n)| format!("{n} {reason}")).collect();
    let help = match reason {
        Reason::Residual => {
            ": the edges fit no model at this noise: another edge than the model's (--esf learnt, or --esf FILE), a loss of focus, motion during the exposure, a ghost, or light that falls off steeply beside them"
        }
        Reason::Contaminated | Reason::Outlier => {
            ": contamination on the part, or a part that is not alike on both sides, as threads and flats are: try --rejection by_edge"
        }
        Reason::Border => ": the edges lie too near the border of the field: move the part or the field",
        Reason::Steep => ": flanks steeper than 45° are not measured: turn the camera, or try --vertical",
        Reason::LowContrast => {
            ": expose more, or average frames (gauge.min_snr sets the least contrast over noise)"
        }
        _ => ": focus, move the part into the field, or try --vertical",
    };
    refused(
        reason,
        format!(
            "only {valid} of {} columns have both edges, {needed} are needed; {}{help}",
            edges.columns(),
            if each.is_empty() { "no edge was looked for".to_owned() } else { each.join(", ") }
        ),
    )
}

/// Edges that do not join to lines.
pub(crate) fn no_contour(share: f64, least: f64, jump_px: f64) -> FrameRefused {
    refused(
        Reason::Outlier,
        format!(
            "the edges of neighbouring columns do not join to contours: {:.0} % of them lie on runs of 32 columns without a jump of {jump_px:.1} px, {:.0} % are needed; no part, or one with its axis upright (--vertical)",
            100.0 * share,
            100.0 * least
        ),
    )
}

/// Edges that no edge-spread function of the settings fits.
pub(crate) fn no_fit(residual: f64, noise: f64, most: f64) -> FrameRefused {
    refused(
        Reason::Residual,
        format!(
            "no edge-spread function fits: {:.1} % of the contrast remain even in the best columns, noise explains {:.1} % and {:.0} % are let through (gauge.max_residual_rel): another edge than the model's (--esf learnt, or --esf FILE), motion or vibration during the exposure, a loss of focus, a veil, or light that falls off steeply beside the edge",
            100.0 * residual,
            100.0 * noise,
            100.0 * most
        ),
    )
}

/// A wire that cannot be fitted.
pub(crate) fn no_wire(reason: Reason) -> FrameRefused {
    let detail = match reason {
        Reason::Border => {
            "the wire lies too near the border of the field: 7 px of light are needed on both sides of it in 8 columns or more: move the part or the field"
        }
        Reason::LowContrast => {
            "the wire is not darker than the light beside it, as a shadow must be: light it from behind, or try --bright-on-dark"
        }
        _ => {
            "both edges of the wire cannot be told apart in 8 columns or more: it is too thin for its blur: focus, or magnify more"
        }
    };
    refused(reason, detail.to_owned())
}

/// A wire whose edges run into each other.
pub(crate) fn blurred_wire(width_px: f64, sigma_px: f64, least: f64) -> FrameRefused {
    refused(
        Reason::Blurred,
        format!(
            "the wire is about {width_px:.1} px across and its edges are blurred by {sigma_px:.1} px; {least} times the blur are needed, {:.1} px: focus, or magnify more",
            least * sigma_px
        ),
    )
}

/// A wire in clipped light.
pub(crate) fn clipped_wire(share: f64) -> FrameRefused {
    refused(
        Reason::Saturated,
        format!(
            "{:.1} % of the pixels in the light stand at the largest grey value, as light does that is clipped; a wire below {} px is measured in light that is not clipped: expose less",
            100.0 * share,
            crate::gauge::edge::image::window_layout::WIDEST_PX
        ),
    )
}

/// A stuck row of the sensor beside an edge.
pub(crate) fn stuck_row(row: usize, level: f32, reach_px: usize) -> FrameRefused {
    refused(
        Reason::Residual,
        format!(
            "row {row} stands at {level} counts, apart from the rows beside it: a stuck row of the sensor within {reach_px} px of an edge; move the part by that, or correct the camera's dead pixels"
        ),
    )
}
