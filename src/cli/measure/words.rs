//! The place of a largest diameter and the judged value, for JSON and for the table.

use serde_json::{Value, json};

use crate::frame::FrameMeta;
use crate::gauge::stated::stated;
use crate::gauge::{Calibration, LargestCaliper};

/// The place of the largest diameter and its stretch.
pub fn place(
    (meta, columns): (&FrameMeta, usize),
    largest: &LargestCaliper,
    calibration: Option<&Calibration>,
    figures: &mut Value,
) {
    figures["max_column_px"] = json!(largest.column_px);
    figures["max_stretch_columns"] = json!(largest.stretch_columns());
    figures["max_stretch_px"] = json!([largest.stretch.0, largest.stretch.1]);
    figures["max_of"] = json!(match (largest.end_on, largest.tangents) {
        (true, _) => "disc",
        (_, true) => "tangents",
        _ => "widths",
    });
    if let Some(calibration) = calibration {
        let pitch_mm = calibration.scale_mm_per_px;
        let off = largest.column_px - 0.5 * (columns as f64 - 1.0);
        figures["max_z_mm"] = json!(meta.z_mm + off * pitch_mm);
        figures["max_stretch_mm"] = json!(largest.stretch_columns() as f64 * pitch_mm);
    }
}

/// The stretch of a largest diameter: its first and last column.
pub fn stretch_text(figures: &Value) -> String {
    let columns = figures["max_stretch_px"].as_array();
    columns.map_or_else(|| "-".to_owned(), |c| format!("{}..{}", c[0], c[1]))
}

/// A frame's judgement and the value that decided it.
pub fn judged_by(figures: &Value) -> String {
    let Some(judgement) = figures.get("judgement") else { return String::new() };
    let judged = &figures["judged"];
    let what = judged["what"].as_str().unwrap_or("frame");
    match (judgement.as_str(), judged["d_mm"].as_f64()) {
        (Some(judgement), Some(d_mm)) => {
            let u_mm = judged["u_mm"].as_f64().unwrap_or(f64::NAN);
            format!("{judgement} {what} {} mm", stated(d_mm, u_mm)[0])
        }
        _ => match judged["z_mm"].as_f64() {
            Some(z_mm) => format!("- {what} at z {z_mm:.2} unmeasured"),
            None => format!("- {what} unmeasured"),
        },
    }
}
