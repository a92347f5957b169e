//! The budget of a station that was touched by a probe.

use super::error::ReportError;
use super::html::Page;
use crate::closed_loop::Calibrated;
use crate::job::Job;
use crate::probe;
use crate::run_folder::StationRow;

/// Common contributions by source, with the median random contribution over the stations of the
/// last pass; nothing for a run with the camera.
pub(super) fn budget(
    page: &mut Page,
    job: &Job,
    calibration: &str,
    rows: &[StationRow],
) -> Result<(), ReportError> {
    let Some(settings) = &job.probe else { return Ok(()) };
    let known: Calibrated =
        serde_json::from_str(calibration).map_err(|e| ReportError::Draw(e.to_string()))?;
    let Calibrated::Probe(calibration) = known else { return Ok(()) };
    let last = rows.iter().map(|r| r.pass).max().unwrap_or(0);
    let mut random: Vec<f64> = rows.iter().filter(|r| r.pass == last).filter_map(|r| r.u_random_mm).collect();
    random.sort_by(f64::total_cmp);
    let Some(&median) = random.get(random.len() / 2) else { return Ok(()) };
    let d_mm = job.part.target_mm(last);
    let mut parts = probe::common_parts(settings, &calibration, d_mm).to_vec();
    parts.push(("touches, texture and form over the angles (type A, median station)", median));
    let together = parts.iter().fold(0.0, |u: f64, part| u.hypot(part.1));
    let um = |mm: f64| format!("{:.3}", 1e3 * mm);
    let mut table: Vec<Vec<String>> =
        parts.iter().map(|(source, u)| vec![(*source).to_owned(), um(*u)]).collect();
    table.push(vec!["together".to_owned(), um(together)]);
    page.heading("Uncertainty budget of a station").text(
        "Diameters were taken by a touch probe. Standard uncertainties; all but the last part are common to the stations.",
    );
    page.table(&["source", "u / µm"], &table);
    Ok(())
}
