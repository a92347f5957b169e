//! A camera as a live source: frame after frame, and opened again where it was away.

use std::time::{Duration, Instant};

use viva_genicam::Frame as Block;

use super::error::CameraError;
use super::guard::Restore;
use super::ids::Ids;
use super::image::ImageLayout;
use super::latched_angle::{Latched, LatchedAngles};
use super::link::{Link, Presence};
use super::session::Session;
use super::settings::{CameraSettings, WhenGone};
use super::watchdog::{Watch, Watchdog};
use crate::frame::{CameraBinding, Frame, FrameMeta};
use crate::source::host_clock::host_t_ns;
use crate::source::live::{Clock, Known, LiveMeta, NewFrame, Produced, Producer, Remarks, Timestamp};
use crate::source::spare::Spare;

/// Pause between two searches for a camera that is away: half of the time within which it must
/// measure again, less the time to open it.
const PAUSE: Duration = Duration::from_millis(250);
/// Memory of frames that is kept: one that is made and one that comes back.
const SPARE: usize = 2;

/// A GigE Vision camera.
pub(crate) type Camera = LiveCamera<Session>;

/// A camera by one kind of link.
pub(crate) struct LiveCamera<L: Link> {
    device: L::Device,
    settings: CameraSettings,
    session: Option<L>,
    restore: Restore,
    /// Size and format of all frames, and what else a calibration is bound to: a camera that
    /// returns with others is refused.
    layout: ImageLayout,
    binding: CameraBinding,
    ids: Ids,
    /// Angles of the last frames, by which the next ones are moved to mid-exposure.
    spindle: LatchedAngles,
    watchdog: Watchdog,
    /// Why it ended, where it is not looked for again.
    ended: Option<String>,
    /// When a camera that is away is looked for next.
    next_look: Instant,
    spare: Spare,
}

impl<L: Link> LiveCamera<L> {
    /// Finds a camera by its name (GigE Vision: IPv4 address, serial number or user-defined name)
    /// and opens it.
    ///
    /// # Errors
    /// No such camera, one that is busy, and one that is set to what is not measured.
    pub(crate) fn open(name: &str, settings: CameraSettings) -> Result<Self, CameraError> {
        let device = L::find(name)?;
        let mut restore = Restore::default();
        let session = L::open(&device, &settings, &mut restore)?;
        let now = Instant::now();
        introduce(&device, &session);
        Ok(Self {
            device,
            settings,
            layout: session.setup().layout.clone(),
            binding: session.setup().binding.clone(),
            watchdog: Watchdog::new(session.setup().period, now),
            session: Some(session),
            restore,
            ids: L::ids(),
            spindle: LatchedAngles::default(),
            ended: None,
            next_look: now,
            spare: Spare::of(SPARE),
        })
    }

    /// A block as a frame with its metadata.
    fn made(&mut self, block: Block) -> Produced {
        let host_ns = host_t_ns();
        let (Some(number), Some(session)) = (self.ids.number(block.block_id), &mut self.session) else {
            tracing::debug!("a block of id {} is left out", block.block_id);
            return Produced::Nothing;
        };
        let (clock, roi) = (session.setup().clock, session.setup().roi);
        let device_ns = block
            .ts_dev
            .and_then(|ticks| clock.map_or(L::TICKS_ARE_NS.then_some(ticks), |clock| Some(clock.ns(ticks))));
        let values = session.values(&block);
        let at = values.angle_deg.map(|angle_deg| {
            let exposure_us = values.exposure_us.map(|known| known.value);
            let stated_deg_per_s = session.spindle_deg_per_s();
            let latched = Latched { angle_deg, device_ns, exposure_us, stated_deg_per_s };
            let (moved, why) = self.spindle.moved(&latched);
            if let Some(why) = why {
                tracing::warn!("frame {number}: angles are those at the start of exposure: {why}");
            }
            (moved, Known { value: moved.angle_deg, ..angle_deg })
        });
        let (moved, angle_deg) = at.unzip();
        let sweep_deg = moved.and_then(|moved| moved.sweep_deg);
        let head_c = values.head_c_or(|| session.head_c());
        let value = |known: Option<Known<f64>>| known.map_or(0.0, |known| known.value);
        let meta = FrameMeta {
            frame_id: number,
            t_ns: device_ns.unwrap_or(host_ns),
            exposure_us: value(values.exposure_us),
            angle_deg: value(angle_deg),
            sweep_deg: sweep_deg.unwrap_or(0.0),
            z_mm: value(values.z_mm),
            roi,
            ..FrameMeta::default()
        };
        let frame = match self.layout.frame(block, meta, &self.spare) {
            Ok(frame) => frame,
            Err(why) => return Produced::Incomplete(number, why),
        };
        let on = |clock, t_ns| Timestamp { t_ns, clock };
        let meta = LiveMeta {
            sequence: number,
            device_t: device_ns.map(|ns| on(Clock::Device, ns)),
            exposed_t: device_ns.and_then(|ns| clock?.host_ns(ns)).map(|ns| on(Clock::Host, ns)),
            host_t: Some(on(Clock::Host, host_ns)),
            exposure_us: values.exposure_us,
            gain_db: values.gain_db,
            angle_deg,
            u_angle_deg: moved.and_then(|moved| moved.u_deg),
            z_mm: values.z_mm,
            head_c,
        };
        Produced::Frame(Box::new(NewFrame { frame, meta, remarks: Remarks::default() }))
    }

    /// What no frame means: too early, a camera that is gone, or a stream that does not arrive.
    fn silent(&mut self) -> Produced {
        match self.watchdog.look(Instant::now()) {
            Watch::Quiet => Produced::Nothing,
            Watch::Ask => self.ask(),
            Watch::Blocked => self.blocked(),
        }
    }

    /// Asks whether the camera is there.
    fn ask(&mut self) -> Produced {
        let Some(session) = &self.session else { return Produced::Nothing };
        let silent_s = self.watchdog.silent(Instant::now()).as_secs_f64();
        match session.presence(&self.device) {
            Presence::Obeys => {
                self.watchdog.answered(Instant::now());
                Produced::Nothing
            }
            Presence::Absent => {
                self.gone(format!("it does not answer, and sent no frame for {silent_s:.1} s"))
            }
            Presence::Lost => {
                self.gone("it was restarted, or another program has control of it now".to_owned())
            }
        }
    }

    fn blocked(&mut self) -> Produced {
        let Some(session) = &self.session else { return Produced::Nothing };
        let silent_s = self.watchdog.silent(Instant::now()).as_secs_f64();
        if session.setup().is_triggered {
            tracing::warn!(
                "no frame for {silent_s:.0} s: TriggerMode is On, and the camera waits for a trigger"
            );
            return Produced::Nothing;
        }
        let why = session.no_frames(silent_s);
        match self.settings.when_gone {
            WhenGone::Ends => Produced::End(Some(why)),
            WhenGone::Returns => Produced::Lost(why),
        }
    }

    /// The camera is gone. What was set cannot be restored before it is back.
    fn gone(&mut self, why: String) -> Produced {
        self.session = None;
        self.ids.restart();
        self.next_look = Instant::now() + PAUSE;
        match self.settings.when_gone {
            WhenGone::Ends => Produced::End(Some(format!("the camera is gone: {why}"))),
            WhenGone::Returns => Produced::Lost(why),
        }
    }

    /// Looks for a camera that is away, once a pause.
    fn look_again(&mut self, wait: Duration) -> Produced {
        let left = self.next_look.saturating_duration_since(Instant::now());
        std::thread::sleep(left.min(wait));
        if left > wait {
            return Produced::Nothing;
        }
        self.next_look = Instant::now() + PAUSE;
        let Some(found) = L::again(&self.device) else { return Produced::Nothing };
        if !L::is_same(&found, &self.device) {
            let (other, own) = (L::shown(&found), L::shown(&self.device));
            return Produced::End(Some(format!("another camera came in its place: {other}, not {own}")));
        }
        // Where it is plugged in again, it may have another place.
        self.device = found;
        match self.reopened() {
            Ok(()) => Produced::Nothing,
            Err(
                why @ (CameraError::Refused { .. }
                | CameraError::Format { .. }
                | CameraError::Otherwise { .. }),
            ) => Produced::End(Some(format!("it came back otherwise: {why}"))),
            Err(why) => {
                tracing::debug!("the camera is not open again: {why}");
                Produced::Nothing
            }
        }
    }

    fn reopened(&mut self) -> Result<(), CameraError> {
        let mut session = L::open(&self.device, &self.settings, &mut self.restore)?;
        if session.setup().layout != self.layout {
            let found = session.setup().layout.to_string();
            session.close(&mut self.restore);
            let why = "frames of the series have another size or format";
            let right = "what it was";
            return Err(CameraError::Refused { feature: "the image".to_owned(), found, why, right });
        }
        if let Err((feature, was, found)) = self.binding.check_unchanged(&session.setup().binding) {
            session.close(&mut self.restore);
            return Err(CameraError::Otherwise { feature, was, found });
        }
        session.start()?;
        self.watchdog = Watchdog::new(session.setup().period, Instant::now());
        tracing::info!("the camera is back");
        self.session = Some(session);
        Ok(())
    }
}

/// Features of an open camera, for tests before cameras of others.
#[cfg(test)]
impl Camera {
    pub(crate) fn set_feature(&mut self, name: &str, value: &str) -> Result<(), String> {
        use super::features::Features as _;
        let session = self.session.as_mut().ok_or("it is not open")?;
        session.features_mut().set(name, value)
    }

    pub(crate) fn execute_command(&mut self, name: &str) -> Result<(), String> {
        self.session.as_mut().ok_or("it is not open")?.execute(name)
    }
}

/// What was opened, for the log.
fn introduce<L: Link>(device: &L::Device, session: &L) {
    let (layout, introduced) = (&session.setup().layout, session.introduced());
    tracing::info!("{}: {layout}, {introduced}", L::shown(device));
}

impl<L: Link> Producer for LiveCamera<L> {
    fn produce(&mut self, spare: Option<Frame>, wait: Duration) -> Produced {
        if let Some(spare) = spare {
            self.spare.take_buffer(spare.into_buffer());
        }
        let Some(session) = &mut self.session else {
            return self.ended.take().map_or_else(|| self.look_again(wait), |why| Produced::End(Some(why)));
        };
        match session.receive(wait) {
            Ok(Some(block)) => {
                self.watchdog.frame(Instant::now());
                self.made(block)
            }
            Ok(None) => self.silent(),
            Err(why) => self.gone(why),
        }
    }

    fn start(&mut self) {
        let started = match &mut self.session {
            Some(session) => session.start(),
            None => self.reopened(),
        };
        self.watchdog.frame(Instant::now());
        if let Err(why) = started {
            self.session = None;
            match self.settings.when_gone {
                WhenGone::Ends => self.ended = Some(why.to_string()),
                WhenGone::Returns => tracing::warn!("{why}"),
            }
        }
    }

    fn stop(&mut self) {
        if let Some(session) = self.session.take() {
            session.close(&mut self.restore);
            self.ids.restart();
        }
    }

    fn camera(&self) -> Option<&CameraBinding> {
        Some(&self.binding)
    }
}

impl<L: Link> Drop for LiveCamera<L> {
    fn drop(&mut self) {
        self.stop();
    }
}
