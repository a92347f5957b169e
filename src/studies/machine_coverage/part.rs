//! Whether the part of a job is the bar that a set of midline readings states: the identification
//! takes sag and tailstock from the statement, the frames show the job's.

use crate::identification::reading_set::{Held, MidlinePart};
use crate::job::Job;
use crate::setting::SettingError;

/// How far lengths may lie apart: the sag goes with their fourth power, and 1 % of it is a fifth of
/// its own relative standard uncertainty (5 % where none is stated).
const LENGTH_RELATIVE: f64 = 0.0025;
/// How far moduli and densities may: the sag goes with the first power of either.
const MATERIAL_RELATIVE: f64 = 0.01;
/// How far the cosines of gravity may lie apart: half a degree of a level axis.
const GRAVITY: f64 = 0.01;

/// Refuses a job whose part is not that of `readings[number]`.
///
/// # Errors
/// The first key of the set that the job contradicts.
pub(super) fn check(job: &Job, part: &MidlinePart, number: usize) -> Result<(), SettingError> {
    let differs = |key: &str, stated: String, own: String| {
        let key = format!("readings[{number}].part.{key}");
        let why = format!(
            "{stated} is not that of the job of --frames: {own}; state the job's part, or take its job"
        );
        Err(SettingError::at(key, why))
    };
    let of = &job.part;
    if apart(part.length_mm, of.length_mm) > LENGTH_RELATIVE {
        return differs("length_mm", mm(part.length_mm), format!("part.length_mm = {}", of.length_mm));
    }
    let least = of.nominal_diameter_mm.iter().copied().fold(of.stock_diameter_mm, f64::min);
    if !(least..=of.stock_diameter_mm).contains(&part.diameter_mm) {
        let own = format!("{} mm of stock, {} at the last pass", of.stock_diameter_mm, least);
        return differs("diameter_mm", mm(part.diameter_mm), own);
    }
    let bending = &job.process.bending;
    let own = if bending.self_weight { bending.gravity_deg.to_radians().cos() } else { 0.0 };
    if (part.gravity_x - own).abs() > GRAVITY {
        let own = format!("gravity bends it by {own:.3} along X (process.bending)");
        return differs("gravity_x", part.gravity_x.to_string(), own);
    }
    if bending.is_straight() {
        return Ok(()); // however it is held, and whatever it is made of
    }
    let has_tailstock = job.process.support.tailstock_n_per_um > 0.0;
    if (part.held != Held::Overhung) != has_tailstock {
        let own = if has_tailstock { "a tailstock holds its end" } else { "its end is free" };
        let stated = if has_tailstock { "overhung" } else { "with a second support" };
        return differs("held", stated.to_owned(), own.to_owned());
    }
    let material = job.process.material.resolve()?;
    let pairs = [
        ("youngs_modulus_n_per_mm2", part.youngs_modulus_n_per_mm2, material.youngs_modulus_n_per_mm2),
        ("density_kg_per_m3", part.density_kg_per_m3, material.density_kg_per_m3),
    ];
    match pairs.iter().find(|(_, stated, own)| apart(*stated, *own) > MATERIAL_RELATIVE) {
        Some((key, stated, own)) => differs(key, stated.to_string(), own.to_string()),
        None => Ok(()),
    }
}

fn mm(value: f64) -> String {
    format!("{value} mm")
}

fn apart(stated: f64, own: f64) -> f64 {
    (stated - own).abs() / own.abs()
}
