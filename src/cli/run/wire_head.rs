//! A head on the wire as the place where the frames of a run come from, where the program has
//! cameras at all.

use crate::cell::TurningCell;
use crate::cli::failure::Failure;
use crate::frame::CameraBinding;
use crate::job::Job;
use crate::setting::SettingError;

#[cfg(feature = "camera")]
use std::sync::{Mutex, PoisonError};

#[cfg(feature = "camera")]
use crate::cell::wire::{Unfit, WireCell, check};
#[cfg(feature = "camera")]
use crate::source::camera::CommandedCamera;
#[cfg(feature = "camera")]
use crate::source::commanded::CommandedHead as _;

/// A head under control, held against the job of a run.
#[cfg(feature = "camera")]
pub(crate) struct WireHead {
    name: String,
    shown: String,
    /// What a calibration of its frames is bound to.
    binding: Option<CameraBinding>,
    /// Until the cell takes it.
    head: Mutex<Option<CommandedCamera>>,
}

#[cfg(feature = "camera")]
impl WireHead {
    /// Opens the head of an address or a name; nothing is cut yet.
    ///
    /// # Errors
    /// Exit 2 for a key of the job that the head contradicts, by `refused`; 3 for a head that is
    /// absent, busy or set to what is not measured.
    pub(super) fn open(
        job: &Job,
        name: &str,
        refused: &dyn Fn(SettingError) -> Failure,
    ) -> Result<Self, Failure> {
        if job.camera.windows.is_some() {
            let right = "a head on the wire sends one window: leave it out";
            return Err(refused(SettingError::at("camera.windows", right)));
        }
        let failed = |why: &dyn std::fmt::Display| Failure::fail(format!("gige:{name}: {why}"));
        let mut head = CommandedCamera::open(name).map_err(|why| failed(&why))?;
        match check(&mut head, &job.loop_job()) {
            Ok(()) => {}
            Err(Unfit::Job(key)) => return Err(refused(key)),
            Err(Unfit::Head(why)) => return Err(failed(&why)),
        }
        let (name, shown, binding) = (format!("gige:{name}"), head.shown(), head.binding().cloned());
        // what other clients may have left is taken as it is
        let of = |feature: &str| format!("{feature} {}", head.value(feature).unwrap_or_default());
        let set = ["PixelFormat", "ExposureTime", "Gain", "Contamination"].map(of).join(", ");
        tracing::info!("{name}: {shown}; {set}");
        Ok(Self { name, shown, binding, head: Mutex::new(Some(head)) })
    }

    /// What a calibration of its frames is bound to.
    pub(super) fn camera(&self) -> Option<&CameraBinding> {
        self.binding.as_ref()
    }

    /// Maker, model, serial number and address.
    pub(super) fn shown(&self) -> &str {
        &self.shown
    }

    /// The cell, with a new blank clamped.
    ///
    /// # Errors
    /// Exit 3 for a head that refuses, and for a second cell on it.
    pub(super) fn cell<'a>(&self, job: &Job) -> Result<Box<dyn TurningCell + 'a>, Failure> {
        let head = self.head.lock().unwrap_or_else(PoisonError::into_inner).take();
        let head = head.ok_or_else(|| Failure::fail(format!("{}: one run has it already", self.name)))?;
        Ok(Box::new(WireCell::new(Box::new(head), &self.name, &job.name).map_err(Failure::fail)?))
    }
}

/// There is no client in this build.
#[cfg(not(feature = "camera"))]
pub(crate) enum WireHead {}

#[cfg(not(feature = "camera"))]
impl WireHead {
    /// Refuses.
    ///
    /// # Errors
    /// Always, by `refused`.
    pub(super) fn open(
        _job: &Job,
        name: &str,
        refused: &dyn Fn(SettingError) -> Failure,
    ) -> Result<Self, Failure> {
        let right = "build it with it, or give the folder with the frames of the passes";
        let why = format!("gige:{name}: this program was built without the feature camera; {right}");
        Err(refused(SettingError::at("source", why)))
    }

    /// There is none.
    pub(super) fn camera(&self) -> Option<&CameraBinding> {
        match *self {}
    }

    /// There is none.
    pub(super) fn shown(&self) -> &str {
        match *self {}
    }

    /// There is none.
    ///
    /// # Errors
    /// Never.
    pub(super) fn cell<'a>(&self, _job: &Job) -> Result<Box<dyn TurningCell + 'a>, Failure> {
        match *self {}
    }
}
