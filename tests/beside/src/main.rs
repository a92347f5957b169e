//! The instrument in somebody else's program: a lathe and a controller of its own close the loop
//! from frames that this program draws; with an argument, a series of frames is measured. Prints
//! JSON.

mod cell;
mod controller;
mod drawing;
#[path = "../../support/drawn_frames.rs"]
mod drawn_frames;
mod frames;

use std::error::Error;

use serde_json::{Value, json};
use shadowgauge::closed_loop::{ClosedLoop, PassResult};
use shadowgauge::job::{FieldOfView, LoopJob, Part, Tolerance};

/// A part of Ø12 × 28 mm in four fields under a camera of 128 columns.
fn job() -> LoopJob {
    let mut job = LoopJob {
        name: "beside".to_owned(),
        part: Part {
            length_mm: 28.0,
            stock_diameter_mm: 12.6,
            nominal_diameter_mm: vec![12.4, 12.2, 12.0],
            station_mm: 4.0,
            tolerance: Some(Tolerance::new(12.0, 0.01, -0.01)),
            ..Part::default()
        },
        field: FieldOfView {
            columns: drawing::COLUMNS as u32,
            rows: drawing::ROWS as u32,
            mm_per_px: drawing::MM_PER_PX,
            rows_about_axis: drawing::ROWS as f64,
            ..FieldOfView::default()
        },
        ..LoopJob::default()
    };
    (job.scan.fields, job.scan.angles) = (4, 4);
    job.masters.frames_each = 4;
    for (pin, diameter_mm) in job.masters.pins.iter_mut().zip([10.5, 13.0]) {
        pin.diameter_mm = diameter_mm;
    }
    job
}

fn pass_json(pass: &PassResult) -> Value {
    let read = pass.profile.stations.iter().filter_map(|s| s.reading.value());
    let errors_mm: Vec<f64> = read.map(|d| d.d_mm - pass.plan.nominal_mm).collect();
    let truth = pass.truth_mm.iter().flatten();
    let off_mm = pass
        .profile
        .stations
        .iter()
        .zip(truth)
        .filter_map(|(station, truth_mm)| station.reading.value().map(|d| (d.d_mm - truth_mm).abs()));
    json!({
        "pass": pass.plan.pass,
        "stations": pass.profile.stations.len(),
        "valid": errors_mm.len(),
        "max_abs_error_mm": errors_mm.iter().fold(0.0, |most: f64, e| most.max(e.abs())),
        "measured_minus_true_mm": off_mm.fold(0.0, f64::max),
        "frames": pass.frames,
        "refused": pass.refused,
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    if std::env::args().len() > 1 {
        println!("{}", frames::measured()?);
        return Ok(());
    }
    let job = job();
    let lathe = cell::Lathe::new(&job);
    let controller = Box::new(controller::StationByStation::default());
    let mut turning = ClosedLoop::with_controller(job, Box::new(lathe), None, controller)?;
    let mut passes = Vec::new();
    while turning.next_pass().is_some() {
        passes.push(pass_json(&turning.run_pass(&mut |_, _| {})?));
    }
    println!("{}", json!({ "passes": passes }));
    Ok(())
}
