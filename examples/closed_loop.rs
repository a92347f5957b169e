//! The closed loop on the simulated cell: a small slender shaft is turned in three passes, measured
//! from rendered frames after each, and corrected by the least-squares controller.
//!
//!     cargo run --release --example closed_loop

use shadowgauge::cell::SimulatedCell;
use shadowgauge::closed_loop::ClosedLoop;
use shadowgauge::control::ControllerName;
use shadowgauge::job::{Job, Tolerance};
use shadowgauge::plan::Decision;
use shadowgauge::render::{BackendChoice, Renderer};

/// A shaft of Ø10 × 60 mm under a camera of 512 × 320 pixels of 0.04 mm on the object.
fn small_job() -> Job {
    let mut job = Job { name: "small shaft".to_owned(), ..Job::default() };
    job.part.length_mm = 60.0;
    job.part.stock_diameter_mm = 11.0;
    job.part.nominal_diameter_mm = vec![10.6, 10.3, 10.0];
    job.part.tolerance = Some(Tolerance::new(10.0, 0.02, -0.02));
    (job.camera.columns, job.camera.rows) = (512, 320);
    job.optics.magnification = 0.08625;
    (job.scan.fields, job.scan.angles) = (4, 4);
    job.masters.frames_each = 4;
    job.masters.pins[0].diameter_mm = 9.0;
    job.masters.pins[1].diameter_mm = 11.0;
    job.control.controller = ControllerName::Lsq;
    job
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let job = small_job();
    let renderer = Renderer::new(BackendChoice::Cpu)?;
    let cell = SimulatedCell::new(&job, &renderer)?;
    let mut turning = ClosedLoop::start(job.checked_loop()?, Box::new(cell), None)?;
    while turning.next_pass().is_some() {
        let pass = turning.run_pass(&mut |_, _| {})?;
        println!("pass {}, nominal {} mm, {} frames", pass.plan.pass, pass.plan.nominal_mm, pass.frames);
        for station in &pass.profile.stations {
            match station.reading.value() {
                Some(d) => println!("  z {:5.1} mm   {:.4} ± {:.4} mm", station.z_mm, d.d_mm, 2.0 * d.u_mm()),
                None => println!("  z {:5.1} mm   no reading", station.z_mm),
            }
        }
        if let Some(Decision::Held(reason)) = pass.decision {
            println!("  offsets held: {reason}");
        }
    }
    Ok(())
}
