//! What the frames were measured with, as rows of a table: calibration, conditions of the part,
//! tolerance and rule.

use crate::conformity::Tolerance;
use crate::gauge::Calibration;
use crate::gauge::calibration::{Conditions, Date};
use crate::gauge::diameter::reading_series::Averaging;
use crate::gauge::stated::stated;
use crate::measurement::MeasureSettings;

/// Digits of a limit or a condition that is written as it was stated.
const AS_STATED: usize = 6;

/// What is known before the first frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeasureSetup<'a> {
    /// The inputs as they were named.
    pub inputs: &'a [String],
    /// The day of the report.
    pub date: Date,
    /// Scale and edge offset.
    pub calibration: &'a Calibration,
    /// Conditions of the part.
    pub conditions: &'a Conditions,
    /// What was asked of the measurement.
    pub settings: &'a MeasureSettings,
}

/// A number without the zeros at its end.
pub(super) fn plain(value: f64) -> String {
    let text = format!("{value:.AS_STATED$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Whether scale and edge offset have no uncertainty: a scale alone.
pub(super) fn is_uncalibrated(calibration: &Calibration) -> bool {
    calibration.setup.is_none() && calibration.masters.is_empty() && calibration.covariance == [0.0; 3]
}

/// The rows: what, and its value.
pub(super) fn facts(setup: &MeasureSetup<'_>) -> Vec<Vec<String>> {
    let version = concat!("shadowgauge ", env!("CARGO_PKG_VERSION"));
    let mut rows = vec![
        ["Frames from".to_owned(), setup.inputs.join(", ")],
        ["Measured by".to_owned(), format!("{version}, report of {}", setup.date)],
    ];
    rows.extend(calibration_facts(setup.calibration));
    rows.extend(condition_facts(setup.conditions));
    rows.extend(judging_facts(setup.settings));
    rows.into_iter().map(Vec::from).collect()
}

fn calibration_facts(calibration: &Calibration) -> Vec<[String; 2]> {
    let um_per_px = 1e3 * calibration.scale_mm_per_px;
    if is_uncalibrated(calibration) {
        return vec![[
            "Calibration".to_owned(),
            format!(
                "none: a scale of {} µm/px was stated; U does not hold the uncertainty of scale and edge offset",
                plain(um_per_px)
            ),
        ]];
    }
    let id = if calibration.optics_id.is_empty() { "without a name" } else { &calibration.optics_id };
    let [scale, u_scale] = stated(um_per_px, 1e3 * calibration.covariance[0].max(0.0).sqrt());
    let [offset, u_offset] =
        stated(1e3 * calibration.offset_mm, 1e3 * calibration.covariance[2].max(0.0).sqrt());
    let mut rows =
        vec![["Calibration".to_owned(), format!("{id}, by {} masters", calibration.masters.len())]];
    if let Some(own) = &calibration.setup {
        let dates = format!("{}, valid until {}", own.validity.date, own.validity.expires());
        rows.push(["Calibrated on".to_owned(), dates]);
    }
    rows.push(["Scale".to_owned(), format!("{scale} µm/px (standard uncertainty {u_scale})")]);
    rows.push(["Offset of both edges".to_owned(), format!("{offset} µm (standard uncertainty {u_offset})")]);
    if let Some(check) = calibration.setup.as_ref().and_then(|own| own.check) {
        let [error_um, expanded_um] = stated(1e3 * check.error_mm, 1e3 * check.expanded_u_mm);
        let text = format!("error {error_um} µm, U = {expanded_um} µm, E_n = {:.2}", check.e_n);
        rows.push(["Check pin".to_owned(), text]);
    }
    rows
}

fn condition_facts(conditions: &Conditions) -> Vec<[String; 2]> {
    let presumed = |is_unstated: bool| if is_unstated { " (limits presumed, none were stated)" } else { "" };
    let temperature = format!(
        "{} ± {} °C{}; diameters are those at 20 °C",
        plain(conditions.temperature_c),
        plain(conditions.limit_temperature_k),
        presumed(conditions.unstated.temperature)
    );
    let expansion = format!(
        "{} ± {} µm/(m·K){}",
        plain(conditions.expansion_um_per_m_k),
        plain(conditions.limit_expansion_um_per_m_k),
        presumed(conditions.unstated.expansion)
    );
    let edges =
        format!("± {} µm an edge{}", plain(conditions.limit_edge_um), presumed(conditions.unstated.edge));
    let limb = conditions.limb.map(|limb| {
        format!(
            "corrected for Ø{} to Ø{} mm; what is not known of each cause is a row of the budget",
            plain(limb.from_mm),
            plain(limb.to_mm)
        )
    });
    let stated = [
        ("Temperature of the part", Some(temperature)),
        ("Expansion of the part", Some(expansion)),
        ("Edges of the part against the masters'", Some(edges)),
        ("Limbs of the part against the masters'", limb),
    ];
    stated.into_iter().filter_map(|(what, text)| Some([what.to_owned(), text?])).collect()
}

fn judging_facts(settings: &MeasureSettings) -> Vec<[String; 2]> {
    let factor = settings.coverage_factor.map_or_else(
        || "k for 95.45 % at the effective degrees of freedom".to_owned(),
        |k| format!("k = {}", plain(k)),
    );
    let mut rows = vec![["Expanded uncertainty U".to_owned(), format!("k·u, {factor}")]];
    match settings.tolerance {
        Some(tolerance) => {
            rows.push(["Tolerance".to_owned(), tolerance_words(&tolerance)]);
            let rule = format!(
                "ISO 14253-1: accepted or rejected where that is proven with a probability of {} %",
                plain(100.0 * settings.conformance_probability)
            );
            rows.push(["Rule".to_owned(), rule]);
        }
        None => rows.push(["Tolerance".to_owned(), "none given".to_owned()]),
    }
    let average = match settings.average {
        Averaging::Off => None,
        Averaging::Moving { readings } => Some(format!("moving mean of {readings} frames")),
        Averaging::Median { readings } => Some(format!("median of {readings} frames")),
        Averaging::Recursive { weight } => {
            Some(format!("recursive, weight {} of the newest frame", plain(weight)))
        }
    };
    rows.extend(average.map(|text| ["Average".to_owned(), text]));
    rows.extend(settings.station_mm.map(|mm| ["Stations".to_owned(), format!("{} mm long", plain(mm))]));
    rows
}

fn tolerance_words(tolerance: &Tolerance) -> String {
    let (lower, upper) = tolerance.limits_mm();
    format!(
        "{} mm to {} mm (nominal {} mm, {:+.4} / {:+.4} mm), for {}",
        plain(lower),
        plain(upper),
        plain(tolerance.nominal_mm),
        // No −0 of a fundamental deviation.
        tolerance.upper_mm + 0.0,
        tolerance.lower_mm + 0.0,
        tolerance.criterion.words()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_written_as_they_were_stated() {
        assert_eq!([24.987, 25.0, -0.0, 100.0].map(plain), ["24.987", "25", "0", "100"].map(String::from));
        let words = tolerance_words(&"25 h6".parse().unwrap());
        assert!(words.starts_with("24.987 mm to 25 mm (nominal 25 mm, +0.0000 / -0.0130 mm)"), "{words}");
    }

    #[test]
    fn a_scale_alone_is_named_as_such() {
        let scale = Calibration::from_scale(5.2);
        let setup = MeasureSetup {
            inputs: &["a.png".to_owned()],
            date: "2026-01-31".parse().unwrap(),
            calibration: &scale,
            conditions: &Conditions::default(),
            settings: &MeasureSettings::default(),
        };
        let text = facts(&setup).concat().join("\n");
        assert!(text.contains("a scale of 5.2 µm/px was stated") && text.contains("2026-01-31"), "{text}");
        assert!(!text.contains("Scale") && text.contains("none given"), "{text}");
    }
}
