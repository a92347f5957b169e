//! What a measured frame shows beside its numbers: a part or none, the value that counts, its
//! alarm, and the diameters along it.

use crate::gauge::FrameEdges;
use crate::gauge::stated::stated;
use crate::measurement::Measurement;
use crate::measurement::watch::{FrameValue, Profile, Seen, profile};
use crate::profile::Reason;

/// Coverage factor of values in pixels, whose freedom is not stated.
const K: f64 = 2.0;
/// Cells of the profile: as many as are read at a glance beside the other figures.
const CELLS: usize = 32;
/// Standard uncertainties of a cell's mean that a profile must differ by to fill its height: of 32
/// cells the range by noise is four of them in the mean.
const NOISE: f64 = 4.0;

/// Whether a field is refused for having no part in it.
pub(super) fn is_empty(reason: Reason) -> bool {
    matches!(reason, Reason::NoEdge | Reason::LowContrast)
}

/// Whether the diameter is good by its course in time; true where that is not asked for.
pub(super) fn is_settled(measurement: &Measurement) -> bool {
    measurement.settled.is_none_or(|settled| settled.u_trend_mm().is_some())
}

/// The value of a measured frame, and whether a part is in it.
pub(super) fn seen(measurement: &Measurement, sequence: u64) -> (Option<FrameValue>, Seen) {
    let millimetres = measurement.diameter.as_ref().map(|d| (d.diameter.d_mm, d.expanded_u_mm));
    let pixels = measurement.largest.as_ref().map(|l| (l.diameter_px, K * l.u_px));
    if let Some(refusal) = &measurement.refusal {
        return (None, if is_empty(refusal.reason) { Seen::Empty } else { Seen::Unclear });
    }
    let value = millimetres.or(pixels).filter(|(value, _)| value.is_finite());
    let Some((value, expanded_u)) = value else { return (None, Seen::Unclear) };
    let (severity, word) = (measurement.judgement.severity(), measurement.judgement.word());
    let is_settled = is_settled(measurement);
    let value = FrameValue { sequence, value, expanded_u, severity, word, is_settled };
    (Some(value), Seen::Part(value))
}

/// Why a frame's value raises the alarm: a tolerance exceeded.
pub(super) fn alarm_of(frame: &str, value: FrameValue) -> Option<String> {
    if value.severity < 2 {
        return None;
    }
    let [d, u] = stated(value.value, value.expanded_u);
    Some(format!("frame {frame}: {} at {d} mm, U {u} mm", value.word))
}

/// Diameters along a frame, as a terminal shows them; `scale` in mm per px, or 1 in pixels.
pub(super) fn diameters_along(edges: &FrameEdges, scale: f64) -> Option<Profile> {
    let in_cell = (edges.columns() / CELLS).max(1) as f64;
    let (top, bottom) = edges.top.iter().zip(&edges.bottom).find(|(t, b)| t.is_usable() && b.is_usable())?;
    let u_px = |own: f32, shared: f32| (f64::from(own).powi(2) / in_cell + f64::from(shared).powi(2)).sqrt();
    let u = u_px(top.u_own_px, top.u_shared_px).hypot(u_px(bottom.u_own_px, bottom.u_shared_px));
    let widths = (0..edges.columns()).map(|column| edges.width_px(column).map(|width| scale * width));
    profile(widths, CELLS, NOISE * scale * u)
}
