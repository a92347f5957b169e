//! The stretch of a largest diameter and the judged value in the table.

use serde_json::Value;

use crate::gauge::stated::stated;

/// The stretch of a largest diameter: its first and last column.
pub(crate) fn stretch_text(figures: &Value) -> String {
    let columns = figures["max_stretch_px"].as_array();
    columns.map_or_else(|| "-".to_owned(), |c| format!("{}..{}", c[0], c[1]))
}

/// A frame's judgement and the value that decided it.
pub(crate) fn judged_by(figures: &Value) -> String {
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
