//! Stations that a config lists, `part.station_z_mm`.

use crate::setting::SettingError;

/// Overlap of neighbouring stations that is rounding of decimals, mm; stations may touch.
const SAME_MM: f64 = 1e-6;
/// Most stations that a list may hold.
const MOST: usize = 100_000;

/// Listed stations ascend, do not overlap and lie inside the part.
///
/// # Errors
/// Names the place of the list, its value, and what would be right.
pub(super) fn check(listed: &[f64], length: f64, station_mm: f64) -> Result<(), SettingError> {
    let key = |i: usize| format!("part.station_z_mm[{i}]");
    let half = 0.5 * station_mm;
    if listed.is_empty() || listed.len() > MOST {
        let text =
            format!("lists {} stations; give 1 to {MOST} middles in mm, or leave it out", listed.len());
        return Err(SettingError::at("part.station_z_mm", text));
    }
    for (i, &z) in listed.iter().enumerate() {
        // NaN is refused as well.
        if !(z - half >= -SAME_MM && z + half <= length + SAME_MM) {
            let text = format!(
                "{z} mm: a station of part.station_mm = {} mm must lie inside the part, its middle between {half} and {} mm",
                station_mm,
                length - half
            );
            return Err(SettingError::at(key(i), text));
        }
    }
    for (i, pair) in listed.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            let text = format!("{} mm follows {} mm: middles must ascend", pair[1], pair[0]);
            return Err(SettingError::at(key(i + 1), text));
        }
        if pair[1] - pair[0] < station_mm - SAME_MM {
            let text = format!(
                "{} mm lies {:.4} mm from the station before: stations of part.station_mm = {} mm would overlap; at least \
                 that distance, or a shorter station_mm",
                pair[1],
                pair[1] - pair[0],
                station_mm
            );
            return Err(SettingError::at(key(i + 1), text));
        }
    }
    Ok(())
}

/// The field centres whose field shows part of a listed station, with its middle at most `reach`
/// (mm) away; all of them where no station is listed.
pub(super) fn fields_that_show(listed: Option<&[f64]>, field_z_mm: Vec<f64>, reach: f64) -> Vec<f64> {
    let Some(listed) = listed else { return field_z_mm };
    field_z_mm.into_iter().filter(|field| listed.iter().any(|z| (z - field).abs() <= reach)).collect()
}
