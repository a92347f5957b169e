//! The results of a stepped shaft by section: cylinders with their verdict, tapers with their own
//! values, and what is excluded with the reason.

use serde::Serialize;

use super::parquet_file::DiameterRow;
use super::tables::{StationRow, profile_of};
use crate::closed_loop::section_verdict;
use crate::conformity::part_verdict::PartConformity;
use crate::job::LoopJob;
use crate::numerics::line::Line;
use crate::plan::{Contour, Section, Taper};

/// A cylinder after a pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct SectionResult {
    /// Its name.
    pub name: String,
    /// Its corners along z, mm.
    pub from_mm: f64,
    pub to_mm: f64,
    /// Its diameter on the drawing, mm.
    pub nominal_mm: f64,
    /// Diameter that this pass aims at, mm.
    pub aimed_mm: f64,
    /// Limits of size, mm; none without a tolerance.
    pub lower_mm: Option<f64>,
    pub upper_mm: Option<f64>,
    /// Stations, and those with a reading.
    pub stations: usize,
    pub stations_measured: usize,
    /// Mean of the readings, mm.
    pub mean_mm: Option<f64>,
    /// Largest |measured − aimed|, mm.
    pub max_abs_error_mm: f64,
    /// Largest |true − aimed|, mm, for comparison only; left out where the truth is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub true_max_abs_error_mm: Option<f64>,
    /// Largest |measured − true|, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_measured_minus_true_mm: Option<f64>,
    /// Verdict on a finished section; none without a tolerance, or before the last pass.
    pub judged: Option<PartConformity>,
}

/// A taper after a pass: a line through its readings. It judges nothing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct TaperResult {
    /// Its name.
    pub name: String,
    /// Between these z it is evaluated, mm.
    pub from_mm: f64,
    pub to_mm: f64,
    /// Diameters there after this pass by the drawing, mm.
    pub nominal_from_mm: f64,
    pub nominal_to_mm: f64,
    /// Diameters there by the line through the readings, mm.
    pub measured_from_mm: f64,
    pub measured_to_mm: f64,
    /// Largest deviation of the readings (their mean over the angles at a z) from the drawing's
    /// line, mm.
    pub max_abs_deviation_mm: f64,
}

/// A length without stations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Excluded {
    /// Its ends, mm.
    pub from_mm: f64,
    pub to_mm: f64,
    /// `taper`, `shoulder` (with its chamfer, fillet and blur) or `not_measured`.
    pub reason: &'static str,
}

/// The results of a stepped shaft after a pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct SectionResults {
    /// Cylinders along z.
    pub sections: Vec<SectionResult>,
    /// Tapers along z.
    pub tapers: Vec<TaperResult>,
    /// What no station lies in.
    pub excluded: Vec<Excluded>,
}

/// Results of pass `pass` by section; none for a plain shaft.
pub(crate) fn section_results(
    order: &LoopJob,
    pass: u32,
    stations: &[StationRow],
    diameters: &[DiameterRow],
) -> Option<SectionResults> {
    let contour = order.turned_contour()?;
    let nominal_mm = order.part.target_mm(pass);
    let allowance_mm = nominal_mm - order.part.target_mm(order.part.passes() as u32);
    let rows: Vec<&StationRow> = stations.iter().filter(|s| s.pass == pass).collect();
    let finished = pass as usize == order.part.passes();
    let section = |s: &Section| SectionResult {
        judged: if finished { section_verdict(order, s, &profile_of(pass, stations)) } else { None },
        ..of_section(s, nominal_mm, &rows)
    };
    let taper = |t: &Taper| of_taper(t, allowance_mm, pass, diameters);
    Some(SectionResults {
        sections: contour.sections.iter().map(section).collect(),
        tapers: contour.tapers.iter().filter_map(taper).collect(),
        excluded: excluded(&contour, order.part.length_mm),
    })
}

fn of_section(section: &Section, nominal_mm: f64, rows: &[&StationRow]) -> SectionResult {
    let (from_mm, to_mm) = section.ends_mm;
    let own: Vec<&&StationRow> = rows.iter().filter(|s| (from_mm..=to_mm).contains(&s.z_mm)).collect();
    let read: Vec<f64> = own.iter().filter_map(|s| s.d_mm).collect();
    let aimed_mm = nominal_mm + section.relative_mm;
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    let is_true_known = own.iter().any(|s| s.true_d_mm.is_some());
    let mean_mm = (!read.is_empty()).then(|| read.iter().sum::<f64>() / read.len() as f64);
    SectionResult {
        name: section.name.clone(),
        from_mm,
        to_mm,
        nominal_mm: section.drawn_mm,
        aimed_mm,
        lower_mm: section.limits_mm.map(|l| l.0),
        upper_mm: section.limits_mm.map(|l| l.1),
        stations: own.len(),
        stations_measured: read.len(),
        mean_mm,
        max_abs_error_mm: largest(&mut read.iter().map(|d| d - aimed_mm)),
        true_max_abs_error_mm: is_true_known
            .then(|| largest(&mut own.iter().filter_map(|s| Some(s.true_d_mm? - aimed_mm)))),
        worst_measured_minus_true_mm: is_true_known
            .then(|| largest(&mut own.iter().filter_map(|s| Some(s.d_mm? - s.true_d_mm?)))),
        judged: None,
    }
}

/// Readings at one z over the angles are averaged; a line is fitted to their deviations from the
/// drawing's.
fn of_taper(taper: &Taper, allowance_mm: f64, pass: u32, diameters: &[DiameterRow]) -> Option<TaperResult> {
    let (from_mm, to_mm) = taper.clear_mm;
    let (d0, d1) = (taper.drawn_mm.0 + allowance_mm, taper.drawn_mm.1 + allowance_mm);
    let drawn = |z: f64| d0 + (d1 - d0) * (z - from_mm) / (to_mm - from_mm);
    let mut read: Vec<(f64, f64)> = diameters
        .iter()
        .filter(|r| r.pass == pass && r.d_mm.is_finite() && (from_mm..=to_mm).contains(&r.z_mm))
        .map(|r| (r.z_mm, r.d_mm - drawn(r.z_mm)))
        .collect();
    read.sort_by(|a, b| a.0.total_cmp(&b.0));
    let means: Vec<(f64, f64)> = read
        .chunk_by(|a, b| (a.0 - b.0).abs() < 1e-6)
        .map(|at| (at[0].0, at.iter().map(|r| r.1).sum::<f64>() / at.len() as f64))
        .collect();
    if means.len() < 2 {
        return None;
    }
    let line = Line::through(means.iter().copied());
    Some(TaperResult {
        name: taper.name.clone(),
        from_mm,
        to_mm,
        nominal_from_mm: d0,
        nominal_to_mm: d1,
        measured_from_mm: d0 + line.at(from_mm),
        measured_to_mm: d1 + line.at(to_mm),
        max_abs_deviation_mm: means.iter().map(|m| m.1.abs()).fold(0.0, f64::max),
    })
}

/// Everything between what is clear of the sections.
fn excluded(contour: &Contour, length_mm: f64) -> Vec<Excluded> {
    let mut between = Vec::new();
    let mut reached = 0.0;
    for s in &contour.sections {
        between.push((reached, s.clear_mm.0));
        reached = s.clear_mm.1;
    }
    between.push((reached, length_mm));
    let reason = |from: f64, to: f64| {
        let inside = |ends: (f64, f64)| ends.0 >= from && ends.1 <= to;
        if contour.tapers.iter().any(|t| inside(t.ends_mm)) {
            return "taper";
        }
        let at_ends = contour.sections.iter().any(|s| s.ends_mm.1 > from && s.ends_mm.1 < to);
        let next = contour.sections.iter().any(|s| s.ends_mm.0 > from && s.ends_mm.0 < to);
        if at_ends && next { "shoulder" } else { "not_measured" }
    };
    between
        .into_iter()
        .filter(|(from, to)| to - from > 1e-6)
        .map(|(from_mm, to_mm)| Excluded { from_mm, to_mm, reason: reason(from_mm, to_mm) })
        .collect()
}
