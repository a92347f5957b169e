//! A controller and a cell of one's own in the closed loop, without the simulator: a lathe with a
//! touch probe whose part yields by a parabola along z, and a controller that takes the mean error
//! of all stations off the next pass.
//!
//!     cargo run --example own_controller --no-default-features
//!
//! An adapter to a real lathe is the same two traits: [`TurningCell`] and, where the controllers of
//! the crate do not serve, [`Controller`].

use std::error::Error;

use shadowgauge::cell::{CellError, TurningCell};
use shadowgauge::closed_loop::ClosedLoop;
use shadowgauge::control::{Controller, PassContext};
use shadowgauge::frame::FrameSource;
use shadowgauge::job::{LoopJob, Part, Tolerance};
use shadowgauge::plan::{Decision, DiameterOffset, HeldReason, PassPlan, ScanPlan};
use shadowgauge::probe::{ProbeSettings, Touch, TouchOrder};
use shadowgauge::profile::DiameterProfile;

const LENGTH_MM: f64 = 100.0;
/// Diameter of the shaft less the commanded one where it yields most, mm.
const YIELD_MM: f64 = 0.03;
/// Distance that the probe travels on after contact, mm: calibration on a master takes it out.
const PRETRAVEL_MM: f64 = 0.012;

/// A lathe that turns too large where the shaft yields, with a touch probe.
struct Lathe {
    /// The pass that was cut last.
    cut: Option<PassPlan>,
    pins_mm: Vec<f64>,
    ball_mm: f64,
    touches: u64,
}

impl Lathe {
    fn diameter_mm(&self, z_mm: f64) -> f64 {
        let Some(plan) = &self.cut else { return f64::NAN };
        let nearest = plan.station_z_mm.iter().zip(plan.commanded_mm());
        let nearest = nearest.min_by(|a, b| (a.0 - z_mm).abs().total_cmp(&(b.0 - z_mm).abs()));
        let s = z_mm / LENGTH_MM;
        nearest.map_or(f64::NAN, |(_, commanded)| commanded) + 4.0 * YIELD_MM * s * (1.0 - s)
    }
}

impl TurningCell for Lathe {
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError> {
        self.cut = Some(plan.clone());
        Ok(())
    }

    fn scan(&mut self, _plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError> {
        Err(CellError::Refused("this lathe has no camera".into()))
    }

    fn scan_master(&mut self, _index: usize, _frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError> {
        Err(CellError::Refused("this lathe has no camera".into()))
    }

    fn touch(&mut self, master: Option<usize>, orders: &[TouchOrder]) -> Result<Vec<Touch>, CellError> {
        let mut touch = |order: &TouchOrder| {
            let diameter_mm = master.map_or_else(|| self.diameter_mm(order.z_mm), |pin| self.pins_mm[pin]);
            let centre_mm = 0.5 * (diameter_mm + self.ball_mm) - PRETRAVEL_MM;
            self.touches += 1;
            let t_ns = self.touches * 5_000_000_000;
            Touch { order: *order, id: self.touches, t_ns, x_mm: Some(order.side.sign() * centre_mm) }
        };
        Ok(orders.iter().map(&mut touch).collect())
    }

    fn true_stations_mm(&self, _stations_mm: &[(f64, f64)]) -> Option<Vec<f64>> {
        None
    }
}

/// Takes the mean error of the stations off the next pass, the same everywhere.
struct MeanError;

impl Controller for MeanError {
    fn name(&self) -> &str {
        "mean error"
    }

    fn decide_in(&mut self, plan: &PassPlan, measured: &DiameterProfile, _: &PassContext<'_>) -> Decision {
        let read = measured.stations.iter().filter_map(|s| s.reading.value());
        let errors: Vec<f64> = read.map(|d| d.d_mm - plan.nominal_mm).collect();
        if errors.is_empty() {
            return Decision::Held(HeldReason::Guard("no station has a reading".to_owned()));
        }
        let mean_mm = errors.iter().sum::<f64>() / errors.len() as f64;
        Decision::Offset(DiameterOffset { o_mm: plan.offset.o_mm.iter().map(|o| o + mean_mm).collect() })
    }
}

fn job() -> LoopJob {
    let part = Part {
        length_mm: LENGTH_MM,
        stock_diameter_mm: 27.0,
        nominal_diameter_mm: vec![26.5, 26.0],
        station_mm: 10.0,
        tolerance: Some(Tolerance::new(26.0, 0.02, -0.02)),
        ..Part::default()
    };
    LoopJob {
        name: "own lathe".to_owned(),
        part,
        probe: Some(ProbeSettings::default()),
        ..LoopJob::default()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let job = job();
    let pins_mm = job.masters.pins.iter().map(|pin| pin.diameter_mm).collect();
    let lathe = Lathe { cut: None, pins_mm, ball_mm: ProbeSettings::default().ball_mm, touches: 0 };
    let mut turning = ClosedLoop::with_controller(job, Box::new(lathe), None, Box::new(MeanError))?;
    while turning.next_pass().is_some() {
        let pass = turning.run_pass(&mut |_, _| {})?;
        let read = pass.profile.stations.iter().filter_map(|s| s.reading.value());
        let errors_um: Vec<f64> = read.map(|d| 1e3 * (d.d_mm - pass.plan.nominal_mm)).collect();
        let mean_um = errors_um.iter().sum::<f64>() / errors_um.len() as f64;
        println!("pass {}: {} stations, mean error {mean_um:.1} µm", pass.plan.pass, errors_um.len());
    }
    Ok(())
}
