//! A camera that has a process behind it: commanded feature by feature, frame by frame.

use std::time::Duration;

use viva_genicam::gige::DeviceInfo;

use super::error::CameraError;
use super::features::Features as _;
use super::find;
use super::guard::Restore;
use super::session::Session;
use super::settings::{CameraSettings, WhenGone};
use super::watchdog::ANSWER;
use crate::frame::{CameraBinding, Frame, FrameMeta};
use crate::source::commanded::{Arrived, CommandedHead, HeadError, HeadFrame, Place};
use crate::source::live::Known;
use crate::source::spare::Spare;

/// Memory of frames that is kept: one that is received and one that comes back.
const SPARE: usize = 2;

/// A GigE Vision camera under command.
pub(crate) struct CommandedCamera {
    device: DeviceInfo,
    /// `None` once it is closed.
    session: Option<Session>,
    restore: Restore,
    spare: Spare,
}

impl CommandedCamera {
    /// Finds a camera by its IPv4 address, serial number or user-defined name, and opens it as it
    /// is set.
    ///
    /// # Errors
    /// No such camera, one that is busy, and one that is set to what is not measured.
    pub(crate) fn open(name: &str) -> Result<Self, CameraError> {
        let settings = CameraSettings::unchanged(WhenGone::Ends);
        Self::open_with(name, &settings)
    }

    /// As [`Self::open`], with exposure and gain set where they are given.
    ///
    /// # Errors
    /// As [`Self::open`], and a setting that is refused.
    pub(crate) fn open_with(name: &str, settings: &CameraSettings) -> Result<Self, CameraError> {
        let device = find::find(name)?;
        let mut restore = Restore::default();
        let session = Some(Session::open(&device, settings, &mut restore)?);
        Ok(Self { device, session, restore, spare: Spare::of(SPARE) })
    }

    /// Maker, model, serial number and address.
    pub(crate) fn shown(&self) -> String {
        find::shown(&self.device)
    }

    /// What a calibration of its frames is bound to; `None` once it is closed.
    pub(crate) fn binding(&self) -> Option<&CameraBinding> {
        Some(&self.session.as_ref()?.setup.binding)
    }

    fn session(&mut self) -> Result<&mut Session, HeadError> {
        self.session.as_mut().ok_or_else(|| HeadError::Gone("it was closed".to_owned()))
    }

    /// Why a feature was not set: the head is gone, or refuses the value.
    fn not_set(&self, feature: &str, value: &str, why: String) -> HeadError {
        let (feature, value) = (feature.to_owned(), value.to_owned());
        self.check().err().unwrap_or(HeadError::NotSet { feature, value, why })
    }

    fn not_executed(&self, command: &str, why: String) -> HeadError {
        self.check().err().unwrap_or_else(|| HeadError::NotExecuted { command: command.to_owned(), why })
    }
}

impl CommandedHead for CommandedCamera {
    fn value(&self, feature: &str) -> Option<String> {
        self.session.as_ref()?.features().value(feature)
    }

    fn set(&mut self, feature: &str, value: &str) -> Result<(), HeadError> {
        let set = self.session()?.features_mut().set(feature, value);
        set.map_err(|why| self.not_set(feature, value, why))
    }

    fn set_until_end(&mut self, feature: &str, value: &str) -> Result<(), HeadError> {
        let Self { session: Some(session), restore, .. } = self else {
            return Err(HeadError::Gone("it was closed".to_owned()));
        };
        match restore.set(session.features_mut(), feature, value) {
            Ok(_) => Ok(()),
            Err(CameraError::NotSet { cause, .. }) => Err(self.not_set(feature, value, cause)),
            Err(other) => Err(self.not_set(feature, value, other.to_string())),
        }
    }

    fn execute(&mut self, command: &str) -> Result<(), HeadError> {
        let done = self.session()?.execute(command);
        done.map_err(|why| self.not_executed(command, why))
    }

    fn start(&mut self) -> Result<(), HeadError> {
        let started = self.session()?.start();
        started.map_err(|why| self.not_executed("AcquisitionStart", why.to_string()))
    }

    fn stop(&mut self) -> Result<(), HeadError> {
        let stopped = self.session()?.stop();
        stopped.map_err(|why| self.not_executed("AcquisitionStop", why.to_string()))
    }

    fn receive(&mut self, wait: Duration) -> Result<Arrived, HeadError> {
        let spare = self.spare.clone();
        let session = self.session()?;
        let Some(block) = session.receive(wait).map_err(HeadError::Gone)? else {
            return Ok(Arrived::Nothing);
        };
        let values = session.values(&block);
        let value = |known: Option<Known<f64>>| known.map(|known| known.value);
        let clock = session.setup.clock;
        let exposed_ns = block.ts_dev.and_then(|ticks| clock.map(|clock| clock.ns(ticks)));
        let (z_mm, angle_deg) = (value(values.z_mm), value(values.angle_deg));
        let meta = FrameMeta {
            t_ns: exposed_ns.unwrap_or(0),
            exposure_us: value(values.exposure_us).unwrap_or(0.0),
            angle_deg: angle_deg.unwrap_or(0.0),
            z_mm: z_mm.unwrap_or(0.0),
            roi: session.setup.roi,
            ..FrameMeta::default()
        };
        let place = z_mm.zip(angle_deg).map(|(z_mm, angle_deg)| Place { z_mm, angle_deg });
        Ok(match session.setup.layout.frame(block, meta, &spare) {
            Ok(frame) => Arrived::Frame(Box::new(HeadFrame { frame, place, exposed_ns })),
            Err(why) => Arrived::Incomplete(why),
        })
    }

    /// Asks twice whether it is there: a datagram may be lost.
    fn check(&self) -> Result<(), HeadError> {
        if !(0..2).any(|_| matches!(find::at(self.device.ip, ANSWER), Ok(Some(_)))) {
            return Err(HeadError::Gone("it does not answer".to_owned()));
        }
        match self.session.as_ref().is_some_and(Session::has_control) {
            true => Ok(()),
            false => {
                Err(HeadError::Gone("it was restarted, or another program has control of it now".to_owned()))
            }
        }
    }

    fn now_ns(&self) -> Option<u64> {
        self.session.as_ref()?.now_ns()
    }

    fn recycle(&mut self, frame: Frame) {
        self.spare.take_buffer(frame.into_buffer());
    }
}

impl Drop for CommandedCamera {
    /// What was set is not restored at a camera that is gone: every feature would be awaited.
    fn drop(&mut self) {
        let is_there = self.check().is_ok();
        if let Some(session) = self.session.take().filter(|_| is_there) {
            session.close(&mut self.restore);
        }
    }
}
