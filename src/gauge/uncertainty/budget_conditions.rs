//! Rows of the conditions of use in a budget: temperature, expansion, place, finish and drift of a
//! part.

use super::texts::Texts;
use crate::gauge::calibration::Conditions;
use crate::gauge::calibration::gauge_calibration::Calibration;

/// Sources of the conditions of use in every budget: temperature, expansion, place, edges, drift.
pub(crate) const OF_CONDITIONS: [&str; 5] = [
    "temperature of the part",
    "expansion of the part",
    "focus: place of the axis x telecentricity",
    "edges unlike the masters' (finish, shape)",
    "drift of the scale",
];

/// Source of the row of [`machine_row`].
const MACHINE_GEOMETRY: &str = "machine geometry: place of the head";

/// A row: limits of a rectangular distribution.
pub(crate) struct Row {
    /// One of [`OF_CONDITIONS`], or the machine's.
    pub(crate) source: &'static str,
    /// Estimate or limits of the input, with its unit.
    pub(crate) input: String,
    /// Where the limits are multiplied by a factor that is itself uncertain: its estimate over its
    /// root mean square.
    pub(crate) factor: Option<f64>,
    /// Standard uncertainty it gives the diameter, mm.
    pub(crate) u_mm: f64,
}

/// The telecentricity of a calibration and its standard uncertainty, 1/mm.
pub(crate) fn telecentricity(calibration: &Calibration) -> (f64, f64) {
    let setup = calibration.setup.as_ref();
    setup.map_or((0.0, 0.0), |b| (b.lens.telecentricity_per_mm, b.u_telecentricity_per_mm()))
}

/// The row of where a machine carries the head, normally distributed; none where no machine is
/// given. `at_t` as in [`rows`].
pub(crate) fn machine_row(
    calibration: &Calibration,
    conditions: &Conditions,
    at_t: f64,
    texts: Texts,
) -> Option<Row> {
    let place = conditions.machine?;
    let (t, u_t) = telecentricity(calibration);
    Some(Row {
        source: MACHINE_GEOMETRY,
        input: texts.of(format_args!(
            "{:.2} ± {:.2} um at z {:.1} mm",
            1e3 * place.axis_y_mm,
            1e3 * place.u_axis_y_mm,
            place.z_mm
        )),
        factor: None,
        u_mm: conditions.u_machine_mm(at_t, t, u_t),
    })
}

/// The rows of the conditions of use; `at_t` is the diameter at the part's temperature, mm.
pub(crate) fn rows(calibration: &Calibration, conditions: &Conditions, at_t: f64, texts: Texts) -> [Row; 5] {
    let (t, u_t) = telecentricity(calibration);
    let unstated = conditions.unstated;
    let said = |open: bool| if open { ", not stated" } else { "" };
    let rows = [
        (
            OF_CONDITIONS[0],
            texts.of(format_args!(
                "{} ± {} °C{}",
                conditions.temperature_c,
                conditions.limit_temperature_k,
                said(unstated.temperature)
            )),
            None,
            conditions.u_temperature_mm(at_t),
        ),
        (
            OF_CONDITIONS[1],
            texts.of(format_args!(
                "{} ± {} um/(m K){}",
                conditions.expansion_um_per_m_k,
                conditions.limit_expansion_um_per_m_k,
                said(unstated.expansion)
            )),
            None,
            conditions.u_expansion_mm(at_t),
        ),
        (
            OF_CONDITIONS[2],
            texts.of(format_args!("{} ± {} mm", conditions.axis_y_mm, conditions.limit_axis_y_mm)),
            Some(if conditions.limb.is_some() { 0.0 } else { t.abs() / t.hypot(u_t).max(f64::MIN_POSITIVE) }),
            conditions.u_focus_mm(at_t, t, u_t),
        ),
        (
            OF_CONDITIONS[3],
            texts.of(format_args!("± {} um an edge{}", conditions.limit_edge_um, said(unstated.edge))),
            None,
            conditions.u_edges_mm(),
        ),
        (
            OF_CONDITIONS[4],
            texts.of(format_args!("± {} ppm", conditions.limit_drift_ppm)),
            None,
            conditions.u_drift_mm(at_t),
        ),
    ];
    rows.map(|(source, input, factor, u_mm)| Row { source, input, factor, u_mm })
}
