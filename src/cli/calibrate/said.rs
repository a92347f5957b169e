//! What `calibrate` prints: parameters with u, sensor, the check pin's verdict; or JSON.

use serde_json::json;

use crate::gauge::calibration::SetupCalibration;
use crate::gauge::stated::stated;
use crate::studies::calibration::{Calibrated, edge_model_line, parameter_table};

/// The document of `--json`.
fn summary(calibrated: &Calibrated, setup: &SetupCalibration) -> serde_json::Value {
    let calibration = &calibrated.calibration;
    let residual_um = rms(setup.residuals.iter().map(|r| 1e3 * r.residual_mm));
    json!({
        // Without a check pin only the masters support the calibration.
        "accepted": setup.check.map(|c| c.accepted),
        "optics_id": calibration.optics_id,
        "scale_mm_per_px": calibration.scale_mm_per_px,
        "offset_mm": calibration.offset_mm,
        "lens": setup.lens,
        "birge_ratio": setup.birge_ratio,
        "rms_residual_um": residual_um,
        "check": setup.check,
        "edge_model": calibration.edge_model,
        "unlearnt_frames": calibrated.unlearnt_frames,
        "misfit_chi2": calibration.systematic_residual().map(|m| m.chi2),
        "expires": setup.validity.expires(),
        "sensor": setup.sensor.as_ref().map(|s| json!({
            "gain_counts_per_electron": s.gain_counts_per_electron,
            "read_noise_electrons": s.read_noise_electrons,
            "prnu": s.prnu,
            "black_counts": s.black_counts,
        })),
        "defective_pixels": setup.flat_field.as_ref().map(|f| f.defects.len()),
        // For one version also under the name that the list has in the calibration file.
        "defects": setup.flat_field.as_ref().map(|f| f.defects.len()),
        "response": setup.flat_field.as_ref().and_then(|f| f.response),
    })
}

/// Prints a calibration, as JSON where that is asked for.
pub(super) fn say(json: bool, calibrated: &Calibrated) {
    let calibration = &calibrated.calibration;
    let Some(setup) = &calibration.setup else { return };
    if json {
        say_line!("{}", summary(calibrated, setup));
        return;
    }
    say_line!("{:<42} {:>14} {:>12}", calibration.optics_id, "value", "u");
    for [name, value, u] in parameter_table(calibration) {
        say_line!("{name:<42} {value:>14} {u:>12}");
    }
    say_line!("{}", edge_model_line(calibrated));
    if let Some(systematic_residual) = calibration.systematic_residual() {
        say_line!(
            "edge model misfits the masters' edges: chi2 {:.2} times the noise, {:.2} and {:.2} % of the contrast left; absorbed by the offset",
            systematic_residual.chi2,
            1e2 * systematic_residual.norm(0),
            1e2 * systematic_residual.norm(1)
        );
    }
    say_line!("Birge ratio {:.3}, valid until {}", setup.birge_ratio, setup.validity.expires());
    say_sensor(setup);
    say_check(setup);
    if let Some(budget) = &calibrated.example {
        say!("\nbudget of a part like the master of {:.3} mm\n{}", budget.diameter_mm, budget.to_table(None));
    }
}

/// Results of photon transfer and flat field for the sensor.
fn say_sensor(setup: &SetupCalibration) {
    if let Some(sensor) = &setup.sensor {
        say_line!(
            "sensor: {:.4} electrons a count, read noise {:.2} e, PRNU {:.3} %",
            1.0 / sensor.gain_counts_per_electron,
            sensor.read_noise_electrons,
            1e2 * sensor.prnu
        );
    }
    if let Some(field) = &setup.flat_field {
        say_line!(
            "flat field: {} defective pixels, light falls by {:.2} %",
            field.defects.len(),
            1e2 * field.fall_off
        );
    }
    if let Some(response) = setup.flat_field.as_ref().and_then(|f| f.response) {
        say_line!(
            "response: departs from a line by {:.1} % of full scale, undone (exponent {:.3}, curvature {:.3}, {:.2} % left)",
            1e2 * response.departure,
            response.exponent,
            response.curvature,
            1e2 * response.residual
        );
    }
}

/// Whether the check pin agrees.
fn say_check(setup: &SetupCalibration) {
    if setup.check.is_none() {
        say_line!("no check pin: nothing but the masters themselves speaks for this calibration");
    }
    if let Some(check) = setup.check {
        let [error_um, expanded_um] = stated(1e3 * check.error_mm, 1e3 * check.expanded_u_mm);
        say_line!(
            "check pin: {}{error_um} um off, U = {expanded_um} um (k = {:.2}), E_n = {:.2}: {}",
            if check.error_mm < 0.0 { "" } else { "+" },
            check.coverage_factor,
            check.e_n,
            if check.accepted { "accepted" } else { "REFUSED" }
        );
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0_f64), |(s, n), v| (s + v * v, n + 1.0));
    (sum / n.max(1.0)).sqrt()
}
