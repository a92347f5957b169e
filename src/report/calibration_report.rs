//! The report of a calibration: parameters, residuals, sources of uncertainty, sensor, check pin.

use super::budget_words::{BUDGET_HEADER, budget_rows, budget_words};
use super::error::ReportError;
use super::html::{Page, Tone};
use super::plot::{Chart, Mark, Series};
use crate::gauge::SystematicResidual;
use crate::gauge::calibration::{Residual, SetupCalibration};
use crate::gauge::stated::stated;
use crate::studies::calibration::{Calibrated, CalibrationPlan, edge_model_line, parameter_table};

/// The page of a calibration.
///
/// # Errors
/// Where a chart cannot be drawn.
pub(crate) fn calibration_report(
    plan: &CalibrationPlan,
    calibrated: &Calibrated,
) -> Result<String, ReportError> {
    let calibration = &calibrated.calibration;
    let mut page = Page::new(format!("Calibration of {}", plan.optics_id));
    let Some(setup) = &calibration.setup else { return Ok(page.finish()) };
    page.text(&format!(
        "Made on {}, valid until {}. Frames of {} rows x {} columns. Masters at {} ± {} °C.{}",
        setup.validity.date,
        setup.validity.expires(),
        setup.rows,
        setup.columns,
        plan.thermometer.temperature_c,
        plan.thermometer.limit_temperature_k,
        if plan.simulate.is_some() { " The frames were rendered, not recorded." } else { "" }
    ));
    verdict(&mut page, setup);
    let rows: Vec<Vec<String>> = parameter_table(calibration).into_iter().map(Vec::from).collect();
    page.heading("Bench").table(&["parameter", "value", "standard uncertainty"], &rows).text(&format!(
        "√(χ²/ν) = {:.3}: {}",
        setup.birge_ratio,
        if setup.birge_ratio > 1.0 {
            "the edges' own uncertainties were multiplied by it."
        } else {
            "the residuals scatter no more than the edges' own uncertainties say."
        }
    ));
    residuals(&mut page, plan, &setup.residuals)?;
    page.heading("Edge model").text(&format!("{}.", edge_model_line(calibrated)));
    systematic_residual(&mut page, calibration.systematic_residual())?;
    if let Some(budget) = &calibrated.example {
        page.heading(&format!("Budget of a part like the master of {:.3} mm", budget.diameter_mm))
            .text(&budget_words(budget, budget.factor_or(None)));
        page.table(&BUDGET_HEADER, &budget_rows(budget));
    }
    sensor(&mut page, setup)?;
    Ok(page.finish())
}

fn verdict(page: &mut Page, setup: &SetupCalibration) {
    let Some(check) = setup.check else {
        page.verdict(
            Tone::Open,
            "No check pin was measured: nothing but the masters themselves speaks for this calibration.",
        );
        return;
    };
    let [error_um, expanded_um] = stated(1e3 * check.error_mm, 1e3 * check.expanded_u_mm);
    let mm = |value: f64| stated(value, check.expanded_u_mm)[0].clone();
    let text = format!(
        "Check pin: certified {} mm, measured {} mm, error {error_um} µm, U = {expanded_um} µm (k = {:.2}), E_n = {:.2}: {}.",
        mm(check.certified_mm),
        mm(check.measured_mm),
        check.coverage_factor,
        check.e_n,
        if check.accepted { "accepted" } else { "REFUSED, no calibration was written" }
    );
    page.verdict(if check.accepted { Tone::Good } else { Tone::Bad }, &text);
}

/// Label, abscissa and caption of a residual chart.
type Axis = (&'static str, fn(&Residual) -> f64, &'static str);

fn residuals(page: &mut Page, plan: &CalibrationPlan, residuals: &[Residual]) -> Result<(), ReportError> {
    page.heading("Residuals");
    let axes: [Axis; 3] = [
        (
            "middle of the shadow from the field's centre / px",
            |r| r.middle_px,
            "Calibrated minus certified diameter over the height in the field: a slope would be keystone, an arch distortion left over.",
        ),
        (
            "column from the field's centre / px",
            |r| r.column_px,
            "Over the place along the pin: a slope would be a tapered pin or keystone along the shaft.",
        ),
        (
            "distance from the masters' plane / mm",
            |r| r.axis_y_mm,
            "Over the distance from the plane: a slope would be telecentricity left over.",
        ),
    ];
    for (x_label, x, caption) in axes {
        let series = plan
            .masters
            .iter()
            .enumerate()
            .map(|(index, pin)| {
                let points = residuals
                    .iter()
                    .filter(|r| r.master == index)
                    .map(|r| (x(r), 1e3 * r.residual_mm))
                    .collect();
                Series::new(pin.name.clone(), Mark::Dots, index, points)
            })
            .collect();
        let chart =
            Chart { x_label: x_label.into(), y_label: "residual / µm".into(), series, ..Chart::default() };
        page.figure(&chart.to_svg().map_err(ReportError::Draw)?, caption);
    }
    Ok(())
}

/// Systematic residual of the masters' edges against the edge model.
fn systematic_residual(
    page: &mut Page,
    systematic_residual: Option<&SystematicResidual>,
) -> Result<(), ReportError> {
    let Some(systematic_residual) = systematic_residual else {
        page.text("The edge model fits the masters' edges as well as their noise lets it be told.");
        return Ok(());
    };
    page.text(&format!(
        "The edge model misfits the masters' edges: χ² is {:.2} times what noise explains, with {:.2} and {:.2} % of the contrast (root sum square over the \
         pixels) above and below. The edge offset has swallowed what that moves edges by. A part whose edges leave the same is measured as if the model \
         fitted; what departs from it widens its u or is refused. An edge-spread function (gauge.esf) would remove it.",
        systematic_residual.chi2,
        1e2 * systematic_residual.norm(0),
        1e2 * systematic_residual.norm(1)
    ));
    let series = [("upper edges", 0), ("lower edges", 1)].map(|(name, side)| {
        let values = &systematic_residual.residual[side];
        let middle = (values.len() / 2) as f64;
        let points = values
            .iter()
            .enumerate()
            .map(|(k, r)| ((k as f64 - middle) * systematic_residual.step_px, 1e2 * r))
            .collect();
        Series::new(name, Mark::Line, side, points)
    });
    let chart = Chart {
        x_label: "distance from the edge into the light / px".into(),
        y_label: "residual / % of the contrast".into(),
        series: series.into(),
        ..Chart::default()
    };
    page.figure(&chart.to_svg().map_err(ReportError::Draw)?, "Mean grey values minus the model fitted.");
    Ok(())
}

fn sensor(page: &mut Page, setup: &SetupCalibration) -> Result<(), ReportError> {
    if setup.flat_field.is_none() && setup.sensor.is_none() {
        return Ok(());
    }
    page.heading("Sensor and light");
    if let Some(field) = &setup.flat_field {
        page.text(&format!(
            "{} defective pixels; the light falls by {:.2} % over the field ({}); PRNU {:.3} %, DSNU {:.2} counts, black {:.2} counts. \
             Pixel-to-pixel response is not divided out: over columns it averages as noise does.",
            field.defects.len(),
            1e2 * field.fall_off,
            if field.corrects_light() { "corrected" } else { "even enough to be left alone" },
            1e2 * field.prnu_rel,
            field.dsnu_counts,
            field.black_counts
        ));
    }
    let Some(sensor) = &setup.sensor else { return Ok(()) };
    page.text(&format!(
        "Photon transfer (EMVA 1288): {:.4} electrons a count (± {:.2} %), read noise {:.2} e, PRNU {:.3} %, linearity error {:.2} %.",
        1.0 / sensor.gain_counts_per_electron,
        1e2 * sensor.u_gain_relative,
        sensor.read_noise_electrons,
        1e2 * sensor.prnu,
        1e2 * sensor.linearity_error
    ));
    let points: Vec<(f64, f64)> =
        sensor.curve.iter().map(|p| (p.signal_counts, p.variance_counts2)).collect();
    let line = points.iter().map(|p| (p.0, sensor.gain_counts_per_electron * p.0)).collect();
    let chart = Chart {
        x_label: "signal above dark / counts".into(),
        y_label: "temporal variance above dark / counts²".into(),
        series: vec![
            Series::new("gain", Mark::Dashed, 1, line),
            Series::new("exposures", Mark::Dots, 0, points),
        ],
        ..Chart::default()
    };
    page.figure(&chart.to_svg().map_err(ReportError::Draw)?, "Photon transfer.");
    Ok(())
}
