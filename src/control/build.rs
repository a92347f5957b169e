//! Builds a controller from settings, and assesses the stability of its loop.

use super::compensator::{Compensator, NoCompensation};
use super::controller::Controller;
use super::controller_name::ControllerName;
use super::error::ControlError;
use super::law::{DoubleEwmaLaw, EwmaLaw, IlcLaw, Law, LsqLaw, ModelLaw, PidLaw, nominal_gain};
use super::settings::{ControlSettings, OffsetForm, Spatial};
use super::stability::{
    Plant, StabilityReport, Transfer, double_ewma_transfer, integral_transfer, judge, model_transfer,
    pid_transfer,
};
use crate::plan::{CuttingData, StationLayout};

/// Cutting data and depth at which the model's own plant gain is stated: paper 003, section 3.3.
const REFERENCE_CUT: (f64, CuttingData) = (0.25, CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 });

/// Builds the controller named in the settings for these stations (middles, mm, ascending, of a
/// plain shaft; or those of a stepped one with its contour).
///
/// # Errors
/// A setting out of range, stations that do not ascend or are too few for the shapes, and a loop
/// that is unstable at `plant_gain` with error copying, unless `allow_unstable` is set.
pub(crate) fn build(
    settings: &ControlSettings,
    stations: impl Into<StationLayout>,
) -> Result<Box<dyn Controller + Send>, ControlError> {
    settings.validate()?;
    let stations = stations.into();
    check_stations(&stations.z_mm)?;
    refuse_unstable(settings)?;
    let count = stations.z_mm.len();
    Ok(match settings.controller {
        ControllerName::None => Box::new(NoCompensation),
        ControllerName::Pid => guarded(settings, PidLaw::new(&settings.pid, &stations)?),
        ControllerName::Lsq => guarded(settings, LsqLaw::new(&settings.lsq, &stations)?),
        ControllerName::Ewma => guarded(settings, EwmaLaw::new(&settings.ewma, count)),
        ControllerName::Dewma => guarded(settings, DoubleEwmaLaw::new(&settings.dewma, count)),
        ControllerName::Ilc => guarded(settings, IlcLaw::new(&settings.ilc, &stations)),
        ControllerName::Model => guarded(settings, ModelLaw::new(&settings.model, &stations)),
    })
}

fn guarded<L: Law + Send + 'static>(settings: &ControlSettings, law: L) -> Box<dyn Controller + Send> {
    Box::new(Compensator::new(settings, law))
}

/// Assesses the loop of the controller in the settings, with `plant` at `plant_gain`; `None` for a
/// controller without feedback.
pub(crate) fn assess(settings: &ControlSettings, plant: Plant) -> Option<StabilityReport> {
    let transfer = transfer(settings)?;
    Some(judge(&describe(settings), &transfer, plant, settings.plant_gain))
}

/// The controller's transfer function per station or shape; `None` without feedback.
///
/// Iterative learning is assessed where its filter passes everything (Q = 1, the least stable
/// case), the model-based controller where it follows every deviation at once (its filter gain 1).
pub(crate) fn transfer(settings: &ControlSettings) -> Option<Transfer> {
    let s = settings;
    match s.controller {
        ControllerName::None => None,
        ControllerName::Pid => Some(pid_transfer(&s.pid)),
        ControllerName::Lsq => Some(integral_transfer(s.lsq.gain)),
        ControllerName::Ewma => Some(integral_transfer(s.ewma.weight / s.ewma.gain_estimate)),
        ControllerName::Dewma => Some(double_ewma_transfer(&s.dewma)),
        ControllerName::Ilc => Some(integral_transfer(s.ilc.learning_gain)),
        ControllerName::Model => {
            Some(model_transfer(nominal_gain(&s.model, REFERENCE_CUT.0, &REFERENCE_CUT.1), 1.0))
        }
    }
}

/// Controller and form in words.
pub(crate) fn describe(settings: &ControlSettings) -> String {
    let s = settings;
    match s.controller {
        ControllerName::None => "none".into(),
        ControllerName::Pid => {
            let form = match s.pid.form {
                OffsetForm::Absolute => "absolute",
                OffsetForm::Accumulated => "accumulated",
            };
            let spatial = match s.pid.spatial {
                Spatial::Station => "per station".to_owned(),
                Spatial::Modal(shapes) => format!("modal, {}", shapes.describe()),
            };
            format!("pid ({form}, {spatial}, Kp {} Ki {} Kd {})", s.pid.kp, s.pid.ki, s.pid.kd)
        }
        ControllerName::Lsq => format!("lsq ({}, gain {})", s.lsq.shapes.describe(), s.lsq.gain),
        ControllerName::Ewma => format!("ewma (λ {}, b̂ {})", s.ewma.weight, s.ewma.gain_estimate),
        ControllerName::Dewma => format!(
            "dewma (λ₁ {}, λ₂ {}, b̂ {})",
            s.dewma.level_weight, s.dewma.trend_weight, s.dewma.gain_estimate
        ),
        ControllerName::Ilc => format!("ilc (L {}, Q {} mm)", s.ilc.learning_gain, s.ilc.q_cutoff_mm),
        ControllerName::Model => "model".into(),
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
    if settings.allow_unstable {
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

fn check_stations(station_z_mm: &[f64]) -> Result<(), ControlError> {
    if station_z_mm.is_empty() {
        return Err(ControlError::TooFewStations { stations: 0, shapes: 1 });
    }
    let ascends = |i: usize| i == 0 || station_z_mm[i] > station_z_mm[i - 1];
    match (0..station_z_mm.len()).find(|&i| !(ascends(i) && station_z_mm[i].is_finite())) {
        Some(index) => Err(ControlError::StationOrder { index, z_mm: station_z_mm[index] }),
        None => Ok(()),
    }
}
