//! Means of a midline over spindle angles and their opposites.
//!
//! What turns with the part (eccentricity, bow, odd lobes) comes with the other sign half a turn
//! on; what stands still stays.

use super::reading::{Reading, Row};

/// How far angles may stand from opposite, degrees: a tenth of a degree leaves 0.2 % of an
/// eccentricity.
const OPPOSITE_DEG: f64 = 0.1;

/// The readings, those at angles averaged over each position of a run.
///
/// # Errors
/// Angles beside rows without, an angle without its opposite.
pub(super) fn turn_means(rows: &[Row]) -> Result<Vec<Reading>, String> {
    let mut means: Vec<Reading> = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        if row.angle_deg.is_none() {
            means.push(row.reading);
            continue;
        }
        let same = |other: &&Row| is_same_place(&other.reading, &row.reading);
        if rows[..k].iter().any(|other| same(&other)) {
            continue;
        }
        let all: Vec<&Row> = rows.iter().filter(same).collect();
        check_opposites(&all)?;
        let mean = all.iter().map(|row| row.reading.value).sum::<f64>() / all.len() as f64;
        means.push(Reading { value: mean, rows: all.len() as u32, ..row.reading });
    }
    Ok(means)
}

fn is_same_place(a: &Reading, b: &Reading) -> bool {
    a.quantity == b.quantity
        && a.direction == b.direction
        && a.run == b.run
        && a.setup == b.setup
        && a.position_mm == b.position_mm
}

fn check_opposites(rows: &[&Row]) -> Result<(), String> {
    if let Some(row) = rows.iter().find(|row| row.angle_deg.is_none()) {
        return Err(format!("line {}: angle_deg is missing beside rows at angles", row.reading.line));
    }
    for row in rows {
        let at = |text: &str| format!("line {}: {text}", row.reading.line);
        let angle = row.angle_deg.unwrap_or(0.0);
        let is_opposite = |other: &Row| {
            let apart = (other.angle_deg.unwrap_or(angle) - angle).rem_euclid(360.0);
            (apart - 180.0).abs() <= OPPOSITE_DEG
        };
        if !rows.iter().copied().any(is_opposite) {
            let why = format!(
                "angle {angle}° at position {} mm without {}°: φ and φ + 180° together are free of what turns with the part",
                row.reading.position_mm,
                (angle + 180.0).rem_euclid(360.0)
            );
            return Err(at(&why));
        }
    }
    Ok(())
}
