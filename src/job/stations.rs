//! Stations that a config lists, `part.station_z_mm`.

use super::{JobError, Part};

/// Stations may touch; what rounding leaves of a decimal list is no overlap, mm.
const SAME_MM: f64 = 1e-6;
/// Most stations that a list may hold.
const MOST: usize = 100_000;

/// Listed stations ascend, do not overlap and lie inside the part.
///
/// # Errors
/// Names the place of the list, its value, and what would be right.
pub(super) fn check(part: &Part) -> Result<(), JobError> {
    let Some(listed) = &part.station_z_mm else { return Ok(()) };
    let key = |i: usize| format!("part.station_z_mm[{i}]");
    let (length, half) = (part.length_mm, 0.5 * part.station_mm);
    if listed.is_empty() || listed.len() > MOST {
        let text =
            format!("lists {} stations; give 1 to {MOST} middles in mm, or leave it out", listed.len());
        return Err(JobError::at("part.station_z_mm", text));
    }
    for (i, &z) in listed.iter().enumerate() {
        // What is no number lies nowhere.
        if !(z - half >= -SAME_MM && z + half <= length + SAME_MM) {
            let text = format!(
                "{z} mm: a station of part.station_mm = {} mm must lie inside the part, its middle between {half} and {} mm",
                part.station_mm,
                length - half
            );
            return Err(JobError::at(key(i), text));
        }
    }
    for (i, pair) in listed.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            let text = format!("{} mm follows {} mm: middles must ascend", pair[1], pair[0]);
            return Err(JobError::at(key(i + 1), text));
        }
        if pair[1] - pair[0] < part.station_mm - SAME_MM {
            let text = format!(
                "{} mm lies {:.4} mm from the station before: stations of part.station_mm = {} mm would overlap; at least \
                 that distance, or a shorter station_mm",
                pair[1],
                pair[1] - pair[0],
                part.station_mm
            );
            return Err(JobError::at(key(i + 1), text));
        }
    }
    Ok(())
}

/// Of field centres, those whose field (`half` to both sides, mm) shows something of a listed station; all of them where
/// no station is listed.
pub(super) fn fields_that_show(part: &Part, field_z_mm: Vec<f64>, half: f64) -> Vec<f64> {
    let Some(listed) = &part.station_z_mm else { return field_z_mm };
    let reach = half + 0.5 * part.station_mm;
    field_z_mm.into_iter().filter(|field| listed.iter().any(|z| (z - field).abs() <= reach)).collect()
}
