//! A lathe of this program's own: the shaft yields most in the middle, and the camera's frames are
//! drawn in closed form.

use shadowgauge::cell::{CellError, TurningCell};
use shadowgauge::frame::{Frame, FrameMeta, FrameSource, SourceError};
use shadowgauge::job::LoopJob;
use shadowgauge::plan::{PassPlan, ScanPlan};

use crate::drawing::{COLUMNS, MM_PER_PX, draw};

/// Growth of the diameter where the shaft yields most, mm: beyond the tolerance.
const YIELD_MM: f64 = 0.03;
/// Time from frame to frame, ns.
const PERIOD_NS: u64 = 20_000_000;

pub struct Lathe {
    length_mm: f64,
    stock_mm: f64,
    pins_mm: Vec<f64>,
    /// The pass that was cut last.
    cut: Option<PassPlan>,
    frames: u64,
}

impl Lathe {
    pub fn new(job: &LoopJob) -> Self {
        Self {
            length_mm: job.part.length_mm,
            stock_mm: job.part.stock_diameter_mm,
            pins_mm: job.masters.pins.iter().map(|pin| pin.diameter_mm).collect(),
            cut: None,
            frames: 0,
        }
    }

    fn diameter_mm(&self, z_mm: f64) -> f64 {
        let Some(plan) = &self.cut else { return self.stock_mm };
        let s = (z_mm / self.length_mm).clamp(0.0, 1.0);
        commanded_mm(plan, z_mm) + 4.0 * YIELD_MM * s * (1.0 - s)
    }
}

/// The command between stations' middles is linear.
fn commanded_mm(plan: &PassPlan, z_mm: f64) -> f64 {
    let knots: Vec<(f64, f64)> = plan.station_z_mm.iter().copied().zip(plan.commanded_mm()).collect();
    let right = knots.partition_point(|k| k.0 < z_mm);
    match (right.checked_sub(1).map(|i| knots[i]), knots.get(right)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (z_mm - a.0) / (b.0 - a.0),
        (Some(only), None) => only.1,
        (None, Some(only)) => only.1,
        (None, None) => plan.nominal_mm,
    }
}

/// Frames of the part (`pin_mm` none) or of a pin, one a stop.
struct Drawn<'l> {
    lathe: &'l mut Lathe,
    pin_mm: Option<f64>,
    stops: std::vec::IntoIter<(f64, f64)>,
}

impl FrameSource for Drawn<'_> {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let Some((z_mm, angle_deg)) = self.stops.next() else { return Ok(None) };
        self.lathe.frames += 1;
        let frame_id = self.lathe.frames;
        let meta =
            FrameMeta { frame_id, t_ns: frame_id * PERIOD_NS, angle_deg, z_mm, ..FrameMeta::default() };
        let lathe = &*self.lathe;
        let place = |column: usize| z_mm + (column as f64 - 0.5 * (COLUMNS - 1) as f64) * MM_PER_PX;
        let diameter = |column| self.pin_mm.unwrap_or_else(|| lathe.diameter_mm(place(column)));
        // The axis never stands at the same part of a pixel.
        let axis_px = 0.37 * (frame_id % 11) as f64 - 1.7;
        let failed = |cause| SourceError { what: format!("frame {frame_id}"), cause: Some(cause) };
        draw(diameter, axis_px, meta).map(Some).map_err(failed)
    }
}

impl TurningCell for Lathe {
    fn cut(&mut self, plan: &PassPlan) -> Result<(), CellError> {
        self.cut = Some(plan.clone());
        Ok(())
    }

    fn scan(&mut self, plan: &ScanPlan) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let angles = &plan.angle_deg;
        let stops: Vec<(f64, f64)> =
            plan.field_z_mm.iter().flat_map(|z| angles.iter().map(move |angle| (*z, *angle))).collect();
        Ok(Box::new(Drawn { lathe: self, pin_mm: None, stops: stops.into_iter() }))
    }

    fn scan_master(&mut self, index: usize, frames: usize) -> Result<Box<dyn FrameSource + '_>, CellError> {
        let missing = || CellError::Refused(format!("no master pin {}", index + 1).into());
        let pin_mm = Some(*self.pins_mm.get(index).ok_or_else(missing)?);
        Ok(Box::new(Drawn { lathe: self, pin_mm, stops: vec![(0.0, 0.0); frames].into_iter() }))
    }

    /// This lathe is not real: what it turned is known.
    fn true_stations_mm(&self, stations_mm: &[(f64, f64)]) -> Option<Vec<f64>> {
        const STEPS: usize = 64;
        let mean = |&(from, to): &(f64, f64)| {
            let at = |i: usize| self.diameter_mm(from + (to - from) * (i as f64 + 0.5) / STEPS as f64);
            (0..STEPS).map(at).sum::<f64>() / STEPS as f64
        };
        Some(stations_mm.iter().map(mean).collect())
    }
}
