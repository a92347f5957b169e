//! A calibration in words and rows, for reports.

use super::calibrated::Calibrated;
use crate::gauge::Calibration;
use crate::gauge::stated::stated;

/// The edge-spread function fitted to the masters' edges, in words.
pub(crate) fn edge_model_line(calibrated: &Calibrated) -> String {
    let calibration = &calibrated.calibration;
    let blur = calibration.setup.as_ref().map_or(f64::NAN, |b| b.sigma_px);
    let table = calibration.edge_table.as_ref().map_or(String::new(), |t| {
        let ends = (t.distance_um.first(), t.distance_um.last());
        let (Some(low), Some(high)) = ends else { return String::new() };
        format!(" of {} samples from {low:.2} to {high:.2} um", t.light.len())
    });
    let left_out = match calibrated.unlearnt_frames {
        0 => String::new(),
        n => format!("; {n} frame(s) that do not teach it were left out"),
    };
    let model = calibration.edge_model.as_deref().unwrap_or("unknown");
    let what = match model {
        "learnt" => "learnt, each frame's own",
        other => other,
    };
    format!("edge model fitted: {what}{table}, blur {blur:.3} px{left_out}")
}

/// The adjusted parameters by name with unit and standard uncertainty, for reports.
pub(crate) fn parameter_table(calibration: &Calibration) -> Vec<[String; 3]> {
    let Some(setup) = &calibration.setup else { return Vec::new() };
    let u = |i: usize| setup.parts.iter().map(|p| p.matrix[i][i]).sum::<f64>().max(0.0).sqrt();
    let lens = &setup.lens;
    let row = |name: &str, unit: f64, value: f64, index: usize| {
        let [value, u] = stated(unit * value, unit * u(index));
        [name.to_owned(), value, u]
    };
    vec![
        row("scale / (µm/px)", 1e3, calibration.scale_mm_per_px, 0),
        row("offset of both edges / µm", 1e3, calibration.offset_mm, 1),
        row("radial distortion at the corner / %", 1e2, lens.radial, 2),
        row("change of scale with height / %", 1e2, lens.keystone_across, 3),
        row("change of scale along the shaft / %", 1e2, lens.keystone_along, 4),
        row("telecentricity / (ppm/mm)", 1e6, lens.telecentricity_per_mm, 5),
    ]
}
