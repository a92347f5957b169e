//! The instrument that a job measures with, calibrated: the camera or the touch probe.

use serde::{Deserialize, Serialize};

use super::error::LoopError;
use super::masters;
use crate::cell::TurningCell;
use crate::gauge::{Calibration, Gauge};
use crate::job::LoopJob;
use crate::probe::{self, MasterTouches, ProbeCalibration, ProbeSettings};

/// The calibration of the instrument that a job measures with.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Calibrated {
    /// The camera's.
    Camera(Box<Calibration>),
    /// The touch probe's.
    Probe(ProbeCalibration),
}

impl From<Calibration> for Calibrated {
    fn from(calibration: Calibration) -> Self {
        Self::Camera(Box::new(calibration))
    }
}

impl Calibrated {
    /// The calibration under the conditions of the job's part.
    pub(super) fn of_part(&self, job: &LoopJob) -> Self {
        match self {
            Self::Camera(camera) => (**camera).clone().with_conditions(job.part_conditions()).into(),
            Self::Probe(_) => self.clone(),
        }
    }

    /// The calibration of the camera.
    ///
    /// # Errors
    /// Where the calibration is the probe's.
    pub(super) fn camera(&self) -> Result<&Calibration, LoopError> {
        match self {
            Self::Camera(camera) => Ok(camera),
            Self::Probe(_) => Err(LoopError::OtherInstrument("the camera")),
        }
    }
}

/// The instrument that a job measures with, calibrated on its masters unless a calibration is
/// given.
pub(super) fn instrument(
    job: &LoopJob,
    cell: &mut dyn TurningCell,
    known: Option<Calibrated>,
) -> Result<(Gauge, Calibrated), LoopError> {
    let gauge = Gauge::new(job.gauge.clone())?;
    let calibration = match (known, &job.probe) {
        (Some(known), _) => known,
        (None, Some(probe)) => Calibrated::Probe(calibrate(job, probe, cell)?),
        (None, None) => masters::calibrate(job, cell, &gauge)?.into(),
    };
    match (&calibration, &job.probe) {
        (Calibrated::Camera(camera), None) => {
            Ok((gauge.with_systematic_residual(camera.systematic_residual()), calibration))
        }
        (Calibrated::Probe(_), Some(_)) => Ok((gauge, calibration)),
        (_, None) => Err(LoopError::OtherInstrument("the camera")),
        (_, Some(_)) => Err(LoopError::OtherInstrument("the probe")),
    }
}

/// Touches every master pin.
fn calibrate(
    job: &LoopJob,
    settings: &ProbeSettings,
    cell: &mut dyn TurningCell,
) -> Result<ProbeCalibration, LoopError> {
    let mut masters = Vec::new();
    for (index, pin) in job.masters.pins.iter().enumerate() {
        let orders = probe::orders(settings, &[0.0], settings.master_diameters, pin.diameter_mm);
        let pairs = probe::pairs(&cell.touch(Some(index), &orders)?);
        let u_mm = pin.expanded_u_mm / pin.coverage_factor;
        masters.push(MasterTouches { diameter_mm: pin.diameter_mm, u_mm, pairs });
    }
    Ok(probe::calibrate(settings, &masters)?)
}
