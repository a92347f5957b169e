//! From settings to a controller, and what its loop is worth.

use super::compensator::Compensator;
use super::law::{LsqLaw, Nothing, PidLaw};
use super::stability::{Plant, StabilityReport, Transfer, ewma_transfer, judge, pid_transfer};
use super::{ControlError, ControlSettings, Controller, ControllerName, OffsetForm, Spatial};

/// Builds the controller named in the settings for these stations (middles, mm, ascending).
///
/// # Errors
/// A setting out of range, stations that do not ascend or are too few for the shapes, and a loop that is unstable at
/// `plant_gain` with error copying, unless `insist_on_unstable` is set.
pub fn build(
    settings: &ControlSettings,
    station_z_mm: &[f64],
) -> Result<Box<dyn Controller + Send>, ControlError> {
    settings.validate()?;
    check_order(station_z_mm)?;
    refuse_unstable(settings)?;
    Ok(match settings.controller {
        ControllerName::None => Box::new(Compensator::new(settings, Nothing)),
        ControllerName::Pid => {
            Box::new(Compensator::new(settings, PidLaw::new(&settings.pid, station_z_mm)?))
        }
        ControllerName::Lsq => {
            Box::new(Compensator::new(settings, LsqLaw::new(&settings.lsq, station_z_mm)?))
        }
    })
}

/// Judges the loop of the controller named, with `plant` at `plant_gain`; `None` for a controller without feedback.
pub fn assess(settings: &ControlSettings, plant: Plant) -> Option<StabilityReport> {
    let transfer = transfer(settings)?;
    Some(judge(&describe(settings), &transfer, plant, settings.plant_gain))
}

/// The controller's transfer function per station or shape; `None` without feedback.
pub fn transfer(settings: &ControlSettings) -> Option<Transfer> {
    match settings.controller {
        ControllerName::None => None,
        ControllerName::Pid => Some(pid_transfer(&settings.pid)),
        ControllerName::Lsq => Some(ewma_transfer(settings.lsq.gain)),
    }
}

/// Controller and form in words.
pub fn describe(settings: &ControlSettings) -> String {
    match settings.controller {
        ControllerName::None => "none".into(),
        ControllerName::Pid => {
            let form = match settings.pid.form {
                OffsetForm::Absolute => "absolute",
                OffsetForm::Accumulated => "accumulated",
            };
            let spatial = match settings.pid.spatial {
                Spatial::Station => "per station".to_owned(),
                Spatial::Modal(shapes) => format!("modal, {}", shapes.describe()),
            };
            let s = &settings.pid;
            format!("pid ({form}, {spatial}, Kp {} Ki {} Kd {})", s.kp, s.ki, s.kd)
        }
        ControllerName::Lsq => format!("lsq ({})", settings.lsq.shapes.describe()),
    }
}

fn refuse_unstable(settings: &ControlSettings) -> Result<(), ControlError> {
    let Some(report) = assess(settings, Plant::Copying) else {
        return Ok(());
    };
    if report.stable {
        return Ok(());
    }
    let range = report.range_text();
    if settings.insist_on_unstable {
        tracing::warn!(
            controller = report.controller,
            plant_gain = settings.plant_gain,
            spectral_radius = report.spectral_radius,
            "the loop is unstable, built because control.insist_on_unstable is set; it is stable for {range}"
        );
        return Ok(());
    }
    Err(ControlError::Unstable {
        controller: report.controller,
        plant_gain: settings.plant_gain,
        range,
        spectral_radius: report.spectral_radius,
    })
}

fn check_order(station_z_mm: &[f64]) -> Result<(), ControlError> {
    let ascends = |i: usize| i == 0 || station_z_mm[i] > station_z_mm[i - 1];
    match (0..station_z_mm.len()).find(|&i| !(ascends(i) && station_z_mm[i].is_finite())) {
        Some(index) => Err(ControlError::StationOrder { index, z_mm: station_z_mm[index] }),
        None => Ok(()),
    }
}
