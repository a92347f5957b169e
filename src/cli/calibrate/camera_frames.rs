//! The frames of a calibration from a GigE Vision camera: an operator lays the pins, or the head
//! places them itself.

use super::asked::Operator;
use super::asked_camera::AskedCamera;
use super::camera_args::CameraArgs;
use crate::cell::wire::{Placed, PlacedHead, places};
use crate::cli::failure::Failure;
use crate::cli::process::interrupt;
use crate::frame::{CameraBinding, Frame};
use crate::source::camera::CommandedCamera;
use crate::source::commanded::HeadError;
use crate::studies::calibration::{CalibrateError, CalibrationPlan, PinPlan, Position, Recordings};

/// Who puts pins before the camera.
enum Scene {
    Operator(AskedCamera),
    Head(PlacedHead),
}

/// Frames of a camera, taken once, however often they are requested.
pub(super) struct CameraFrames {
    scene: Scene,
    frames_each: usize,
    /// The camera's own exposure time, µs.
    exposure_us: Option<f64>,
    /// What was taken of each pin at each position.
    kept: Vec<(usize, Position, Vec<Frame>)>,
    has_flat: bool,
    binding: Option<CameraBinding>,
}

impl CameraFrames {
    /// Opens the camera of a plan.
    ///
    /// # Errors
    /// Exit 2 where no pin is to be asked for and the camera places none; 3 for a camera that is
    /// absent, busy or set to what is not measured.
    pub(super) fn open(plan: &CalibrationPlan, source: &str, args: &CameraArgs) -> Result<Self, Failure> {
        let failed = |why: &dyn std::fmt::Display| Failure::fail(format!("{source}: {why}"));
        let name = source.strip_prefix("gige:").unwrap_or(source);
        let camera = CommandedCamera::open_with(name, &args.settings()?).map_err(|why| failed(&why))?;
        tracing::info!("{source}: {}", camera.shown());
        let binding = camera.binding().cloned();
        let scene = match places(&camera) {
            true => Scene::Head(PlacedHead::new(Box::new(camera), source).map_err(|why| failed(&why))?),
            false if args.yes => {
                return Err(Failure::refuse(format!(
                    "--yes: {source} does not place pins itself (it has no HeadObject, MasterIndex and HeadFrame): \
                     run it on a terminal without --yes"
                )));
            }
            false => {
                let operator = Operator::new().map_err(|why| failed(&why))?;
                Scene::Operator(AskedCamera::new(Box::new(camera), source, Box::new(operator)))
            }
        };
        let exposure_us = match &scene {
            Scene::Operator(camera) => camera.exposure_us(),
            Scene::Head(head) => head.exposure_us(),
        };
        let (frames_each, kept) = (plan.frames_each(), Vec::new());
        Ok(Self { scene, frames_each, exposure_us, kept, has_flat: false, binding })
    }

    /// What a calibration of these frames is bound to.
    pub(super) fn binding(&self) -> Option<CameraBinding> {
        self.binding.clone()
    }

    /// The failure of a command that Ctrl-C ended, and no other.
    pub(super) fn interrupted(&self) -> Option<Failure> {
        let is_interrupted = matches!(&self.scene, Scene::Operator(camera) if camera.is_interrupted());
        is_interrupted.then(|| Failure {
            exit: interrupt::INTERRUPTED,
            report: miette::miette!(
                "interrupted: no calibration is written, the camera has its settings back"
            ),
        })
    }

    fn taken(&mut self, what: Placed, step: Option<&str>) -> Result<Vec<Frame>, CalibrateError> {
        let frames = match &mut self.scene {
            Scene::Operator(camera) => camera.frames(step, self.frames_each),
            Scene::Head(head) => head.frames(what, self.frames_each),
        };
        frames.map_err(CalibrateError::Frames)
    }

    fn expose(&mut self, exposure_us: f64) -> Result<(), CalibrateError> {
        let set = match &mut self.scene {
            Scene::Operator(camera) => camera.expose(exposure_us),
            Scene::Head(head) => head.expose(exposure_us),
        };
        set.map_err(|why: HeadError| CalibrateError::Frames(why.to_string()))
    }
}

/// What the operator is to do for a pin at a position.
fn pin_step(pin: &PinPlan, position: &Position) -> String {
    let mut place = String::new();
    if position.height_mm != 0.0 {
        let (side, away_mm) =
            (if position.height_mm > 0.0 { "above" } else { "below" }, position.height_mm.abs());
        place += &format!(", about {away_mm} mm {side} the middle of the field");
    }
    if position.y_mm != 0.0 {
        place += &format!(", at y = {} mm towards the camera", position.y_mm);
    }
    format!("{} ({} mm): lay it{place}", pin.name, pin.diameter_mm)
}

impl Recordings for CameraFrames {
    fn pin(
        &mut self,
        index: usize,
        pin: &PinPlan,
        position: &Position,
    ) -> Result<Vec<Frame>, CalibrateError> {
        let is_it = |(of, at, _): &&(usize, Position, Vec<Frame>)| *of == index && at == position;
        if let Some((_, _, frames)) = self.kept.iter().find(is_it) {
            return Ok(frames.clone());
        }
        let step = pin_step(pin, position);
        let frames = self.taken(Placed::Master(index), Some(&step)).map_err(|why| match why {
            CalibrateError::Frames(why) => CalibrateError::Frames(format!("{}: {why}", pin.name)),
            other => other,
        })?;
        self.kept.push((index, position.clone(), frames.clone()));
        Ok(frames)
    }

    fn dark(&mut self, plan: &CalibrationPlan) -> Result<Vec<Frame>, CalibrateError> {
        if plan.fields.flats.is_empty() {
            return Ok(Vec::new());
        }
        self.taken(Placed::Dark, Some("dark field: cover the lens"))
    }

    /// The largest exposure is the camera's own.
    fn flat(&mut self, plan: &CalibrationPlan, index: usize) -> Result<Vec<Frame>, CalibrateError> {
        let exposures = plan.fields.flats.iter().map(|flat| flat.exposure);
        let share = plan.fields.flats[index].exposure / exposures.fold(f64::MIN_POSITIVE, f64::max);
        let Some(own_us) = self.exposure_us else {
            let why = "fields.flats: the camera states no ExposureTime, by which flat fields are exposed";
            return Err(CalibrateError::Frames(why.to_owned()));
        };
        self.expose(own_us * share)?;
        let step = (!std::mem::replace(&mut self.has_flat, true))
            .then_some("flat field: uncover the lens, and leave nothing in the light");
        let frames = self.taken(Placed::Flat, step)?;
        self.expose(own_us)?;
        Ok(frames)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_names_the_pin_and_its_place() {
        let pin = PinPlan {
            name: "pin 10".to_owned(),
            diameter_mm: 10.0001,
            expanded_u_mm: 3e-4,
            coverage_factor: 2.0,
            certified_by: None,
            common_expanded_u_mm: None,
            positions: Vec::new(),
        };
        let step = |height_mm, y_mm| pin_step(&pin, &Position { height_mm, y_mm, frames: None });
        assert_eq!(step(0.0, 0.0), "pin 10 (10.0001 mm): lay it");
        let right = "pin 10 (10.0001 mm): lay it, about 1.5 mm below the middle of the field, at y = 2 mm towards \
                     the camera";
        assert_eq!(step(-1.5, 2.0), right);
    }
}
