//! The probe as the loop's instrument: touches of the stations and of a master.

use std::time::{Duration, Instant};

use super::ClosedLoop;
use super::error::LoopError;
use super::evidence::Stamp;
use super::instrument::Calibrated;
use super::scan::{FrameReading, Progress, Scanned, Tally};
use crate::frame::FrameMeta;
use crate::gauge::axis_line::AxisLine;
use crate::gauge::diameter::sections::TurnAverager;
use crate::gauge::form::Cutoff;
use crate::plan::Side;
use crate::probe::{self, ProbeCalibration, ProbeSettings, Touch, TouchOrder};
use crate::profile::{Diameter, Reading, Reason};

impl ClosedLoop<'_> {
    /// The probe and its calibration, where the job measures with one.
    pub(super) fn by_probe(&self) -> Option<(ProbeSettings, ProbeCalibration)> {
        match (&self.calibration, &self.job.probe) {
            (Calibrated::Probe(probe), Some(settings)) => Some((settings.clone(), *probe)),
            _ => None,
        }
    }

    /// Touches the stations, one after another.
    pub(super) fn touch_part(
        &mut self,
        pass: u32,
        settings: &ProbeSettings,
        calibration: &ProbeCalibration,
        progress: Progress<'_>,
    ) -> Result<Scanned, LoopError> {
        let start = Instant::now();
        let part = &self.job.part;
        let (z_mm, count) = (self.job.station_z_mm(), settings.angles);
        let expected = if pass == 0 { part.stock_diameter_mm } else { part.target_mm(pass) };
        let orders = self.along_contour(probe::orders(settings, &z_mm, count, expected));
        let touches = self.cell.touch(None, &orders)?;
        progress(touches.len(), orders.len());
        let waited = start.elapsed();
        let pairs = probe::pairs(&touches);
        let profile = probe::profile(settings, calibration, &pairs, count, pass);
        let one_u = (2.0 * settings.touch_variance_mm2()).sqrt();
        let readings = pairs.iter().map(|pair| FrameReading {
            frame_id: pair.id,
            t_ns: pair.t_ns,
            angle_deg: pair.angle_deg,
            z_mm: pair.z_mm,
            reading: match pair.read_mm {
                Some(read) => Reading::Value(Diameter {
                    d_mm: probe::corrected(settings, calibration, read),
                    u_random_mm: one_u,
                    u_common_mm: calibration.u_correction_mm,
                }),
                None => Reading::Gap(Reason::NotScanned),
            },
        });
        let missed = touches.iter().filter(|t| t.x_mm.is_none());
        let said = |t: &Touch| {
            format!(
                "touch {}: nothing at Z {} mm, {}° within probe.reach_mm",
                t.id, t.order.z_mm, t.order.angle_deg
            )
        };
        let stamp =
            |t: &Touch| Stamp::of(&FrameMeta { frame_id: t.id, t_ns: t.t_ns, ..FrameMeta::default() });
        Ok(Scanned {
            profile,
            form: TurnAverager::new(z_mm, part.station_mm).finish(Cutoff::default()),
            // Two-point diameters do not determine the axis.
            axis: AxisLine::default(),
            readings: readings.collect(),
            sample: None,
            tally: Tally {
                frames: touches.len(),
                refused: missed.map(said).collect(),
                waited,
                measured: Duration::ZERO,
            },
            ends: touches.first().map(stamp).zip(touches.last().map(stamp)),
        })
    }

    /// Orders with the diameters of a stepped shaft expected where they touch.
    fn along_contour(&self, mut orders: Vec<TouchOrder>) -> Vec<TouchOrder> {
        if let Some(contour) = self.job.turned_contour() {
            let at = |z_mm: f64| contour.relative_mm(z_mm, Side::Chuck);
            orders.iter_mut().for_each(|order| order.expected_mm += at(order.z_mm));
        }
        orders
    }

    /// Touches the first master pin again: its diameter less the certified one, mm; `None` where
    /// the job does not check a master.
    pub(super) fn touch_master(
        &mut self,
        settings: &ProbeSettings,
        calibration: &ProbeCalibration,
    ) -> Result<Option<f64>, LoopError> {
        let Some(pin) = self.job.masters.pins.first().filter(|_| self.job.masters.check_frames > 0) else {
            return Ok(None);
        };
        let orders = probe::orders(settings, &[0.0], settings.master_diameters, pin.diameter_mm);
        let pairs = probe::pairs(&self.cell.touch(Some(0), &orders)?);
        let read: Vec<f64> = pairs.iter().filter_map(|p| p.read_mm).collect();
        // a pin that cannot be touched reads 0 mm, a deviation beyond every limit
        let mean = read.iter().sum::<f64>() / read.len().max(1) as f64;
        Ok(Some(probe::of_master(settings, calibration, mean) - pin.diameter_mm))
    }
}
