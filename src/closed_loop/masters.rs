//! The calibration at the start of a job, on its masters.

use super::error::LoopError;
use crate::cell::TurningCell;
use crate::gauge::calibration::Conditions;
use crate::gauge::{Calibration, FrameEdges, Gauge, MasterMeasurement, ResidualAccumulator, SettledStream};
use crate::job::LoopJob;

/// Calibrates on the masters; where their edges show residuals of the edge model above the noise,
/// they are scanned again with that model uncertainty.
pub(super) fn calibrate(
    job: &LoopJob,
    cell: &mut dyn TurningCell,
    gauge: &Gauge,
) -> Result<Calibration, LoopError> {
    let mut residuals = ResidualAccumulator::default();
    let mut measurements = masters(job, cell, gauge, &mut residuals)?;
    let systematic_residual = residuals.finish();
    if systematic_residual.is_some() {
        let gauge = gauge.clone().with_systematic_residual(systematic_residual.as_ref());
        measurements = masters(job, cell, &gauge, &mut ResidualAccumulator::default())?;
    }
    let calibration = Calibration::fit(&measurements)?
        .with_optics_id(&job.name)
        .with_systematic_residual(systematic_residual);
    // The cell draws part and masters at 20 °C with one finish; wear, drift and heat belong to the
    // process.
    Ok(calibration.with_edge_model(&gauge.settings().esf).with_conditions(Conditions::default()))
}

/// Scans the masters.
fn masters(
    job: &LoopJob,
    cell: &mut dyn TurningCell,
    gauge: &Gauge,
    residuals: &mut ResidualAccumulator,
) -> Result<Vec<MasterMeasurement>, LoopError> {
    let mut measurements = Vec::new();
    for (index, pin) in job.masters.pins.iter().enumerate() {
        let (frames, why) = pin_frames(job, cell, gauge, (index, job.masters.frames_each), residuals)?;
        if frames.is_empty() {
            return Err(LoopError::Master { pin: index + 1, why });
        }
        measurements.push(MasterMeasurement { certificate: *pin, frames });
    }
    Ok(measurements)
}

/// Edges of all frames of a pin that can be measured, and why the last one cannot. A line camera's
/// readings are one stream; an area camera's frames are measured each by itself, so that their
/// errors are their own.
pub(super) fn pin_frames(
    job: &LoopJob,
    cell: &mut dyn TurningCell,
    gauge: &Gauge,
    (pin, frames): (usize, usize),
    residuals: &mut ResidualAccumulator,
) -> Result<(Vec<FrameEdges>, String), LoopError> {
    let mut source = cell.scan_master(pin, frames)?;
    let (mut stream, mut found) = (SettledStream::new(gauge.stream()), FrameEdges::default());
    let mut edges = Vec::new();
    let mut why = "no frame arrived".to_owned();
    while let Some(frame) = source.next_frame()? {
        if !job.field.is_line {
            stream = SettledStream::new(gauge.stream());
        }
        match stream.measure(&frame.view(), &mut found, (), |(), settled| edges.push(settled.clone())) {
            Ok(()) => stream.accumulate(residuals, &found),
            Err(refused) => why = refused.to_string(),
        }
        source.recycle(frame);
    }
    stream.finish(|(), settled| edges.push(settled.clone()));
    Ok((edges, why))
}
