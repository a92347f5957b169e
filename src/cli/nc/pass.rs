//! The pass that a program cuts: its plan, the offsets before it, the part as it stands.

use crate::cli::failure::Failure;
use crate::job::Job;
use crate::nc::{Direction, Workpiece};
use crate::plan::{DiameterOffset, PassPlan};
use crate::process::FeedDirection;
use crate::run_folder::OffsetRow;

/// A pass of the run with the offsets in force before it.
pub(super) struct Pass {
    pub(super) plan: PassPlan,
    pub(super) old: DiameterOffset,
    pub(super) piece: Workpiece,
    pub(super) reason: String,
    pub(super) limits_mm: Option<(f64, f64)>,
}

/// Largest difference between stations and diameters of a table and those of the plan, mm: tables
/// are written with all digits.
const SAME_MM: f64 = 1e-6;

impl Pass {
    pub(super) fn of(job: &Job, rows: &[OffsetRow], asked: Option<u32>) -> Result<Self, Failure> {
        let Some(last) = rows.iter().map(|r| r.pass).max() else {
            return Err(Failure::refuse("offsets.csv holds no pass yet; let the run finish one"));
        };
        let number = asked.unwrap_or(last);
        let of = |pass: u32| rows.iter().filter(move |r| r.pass == pass);
        let Some(first) = of(number).next() else {
            return Err(Failure::refuse(format!("offsets.csv has no pass {number}; there are 1 to {last}")));
        };
        covers(job, number, &of(number).collect::<Vec<_>>()).map_err(Failure::refuse)?;
        let offsets = |pass: u32| DiameterOffset { o_mm: of(pass).map(|r| r.offset_mm).collect() };
        // the offsets before rounding: rounding twice would give another program than the one that
        // was used
        let asked = DiameterOffset { o_mm: of(number).map(|r| r.asked_mm.unwrap_or(r.offset_mm)).collect() };
        let plan = job.loop_job().pass_plan(number, asked);
        let finishing = number as usize == job.loop_job().passes();
        let tolerance = job.part.tolerance.filter(|_| finishing);
        let held = if first.reason.is_empty() { String::new() } else { format!(": {}", first.reason) };
        Ok(Self {
            old: offsets(number.saturating_sub(1)),
            piece: workpiece(job, number),
            reason: format!("{}{held}", first.status),
            limits_mm: tolerance.map(|t| t.limits_mm()),
            plan,
        })
    }
}

/// The part before pass `pass`, from the run's config.
pub(super) fn workpiece(job: &Job, pass: u32) -> Workpiece {
    let before_mm = if pass > 1 { job.part.target_mm(pass - 1) } else { job.part.stock_diameter_mm };
    Workpiece {
        direction: match job.process.pass.feed_direction {
            FeedDirection::TowardsChuck => Direction::TowardsChuck,
            FeedDirection::TowardsTailstock => Direction::TowardsTailstock,
        },
        contour: job.loop_job().turned_contour(),
        steady_z_mm: job.process.support.steady_rests.iter().map(|rest| rest.z_mm).collect(),
        probe_z_mm: job.part.station_z_mm.clone().unwrap_or_default(),
        tolerance_mm: job.part.tolerance.map(|t| t.limits_mm()),
        ..Workpiece::new(job.part.length_mm, job.part.stock_diameter_mm, before_mm)
    }
}

/// Whether the rows of a pass are the plan's stations, each exactly once, with consistent
/// diameters.
fn covers(job: &Job, pass: u32, rows: &[&OffsetRow]) -> Result<(), String> {
    if pass == 0 || pass as usize > job.part.passes() {
        return Err(format!("offsets.csv: pass {pass} is none of the part's {} passes", job.part.passes()));
    }
    let stations = job.loop_job().station_z_mm();
    if rows.len() != stations.len() {
        return Err(format!(
            "offsets.csv: pass {pass} has {} rows, the part has {} stations ({}); a row for each is needed",
            rows.len(),
            stations.len(),
            match job.part.station_z_mm {
                Some(_) => "part.station_z_mm".to_owned(),
                None => format!("part.station_mm = {}", job.part.station_mm),
            }
        ));
    }
    let plan = job.loop_job().pass_plan(pass, DiameterOffset::zero(stations.len()));
    for (row, z) in rows.iter().zip(&stations) {
        if !((row.z_mm - z).abs() <= SAME_MM) {
            return Err(format!(
                "offsets.csv: pass {pass} has a row at z_mm = {} where the station at {z} mm is due (ascending, each once)",
                row.z_mm
            ));
        }
        let aimed = row.commanded_mm + row.offset_mm;
        let target = plan.nominal_at_mm(*z);
        if !((aimed - target).abs() <= SAME_MM) {
            return Err(format!(
                "offsets.csv: pass {pass}, z_mm = {z}: commanded_mm + offset_mm is {aimed} mm, the pass aims at {target} mm"
            ));
        }
        if row.asked_mm.is_some_and(|o| !o.is_finite()) {
            return Err(format!("offsets.csv: pass {pass}, z_mm = {z}: asked_mm is no number"));
        }
    }
    Ok(())
}
