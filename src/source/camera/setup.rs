//! What a camera is set to before it acquires, by whatever link it is reached.

use std::time::Duration;

use viva_genicam::genapi::RegisterIo;
use viva_genicam::{Camera, Frame as Block};

use super::binding::{Identity, binding};
use super::chunks::{ChunkValues, Chunks};
use super::clock::DeviceClock;
use super::error::CameraError;
use super::features::{Features, exposure_name};
use super::guard::{Restore, guard};
use super::image::ImageLayout;
use super::settings::{CameraSettings, PACKET_SIZE};
use crate::frame::{CameraBinding, Roi};
use crate::source::live::{Known, Provenance};

/// What a camera is set to while it is open.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    /// Size and format of frames.
    pub layout: ImageLayout,
    /// The window on the sensor; `None` for all of it.
    pub roi: Option<Roi>,
    /// Exposure time, µs, and gain, dB, where the camera states them.
    pub constants: ChunkValues,
    /// Its clock.
    pub clock: Option<DeviceClock>,
    /// Time from frame to frame of a free run.
    pub period: Option<Duration>,
    /// Whether frames wait for triggers.
    pub is_triggered: bool,
    /// What a calibration of its frames is bound to.
    pub binding: CameraBinding,
    /// What it sends with every frame.
    pub chunks: Chunks,
}

impl Setup {
    /// The values that came with a frame, otherwise those that the camera is set to.
    pub(super) fn values<T: RegisterIo>(&self, camera: &mut Camera<T>, block: &Block) -> ChunkValues {
        let with_it = self.chunks.values(camera, block);
        let constants = self.constants;
        ChunkValues {
            exposure_us: with_it.exposure_us.or(constants.exposure_us),
            gain_db: with_it.gain_db.or(constants.gain_db),
            ..with_it
        }
    }
}

/// Sets a camera to what is measured with; its clock is added by what reads its registers.
///
/// # Errors
/// A camera that is set to what is not measured, or refuses a setting.
pub(super) fn set_up<T: RegisterIo>(
    camera: &mut Camera<T>,
    identity: Identity<'_>,
    settings: &CameraSettings,
    restore: &mut Restore,
) -> Result<Setup, CameraError> {
    // A camera whose last client was killed may still acquire, and takes no setting then.
    let _ = camera.acquisition_stop();
    for feature in settings.features.iter().filter(|feature| feature.name != PACKET_SIZE) {
        restore.set(camera, &feature.name, &feature.value)?;
    }
    let layout = ImageLayout::of(camera)?;
    for words in guard(camera, settings.accepts_rolling_shutter, restore)? {
        tracing::warn!("{words}");
    }
    let exposure = exposure_name(camera);
    for (feature, value) in [(exposure, settings.exposure_us), ("Gain", settings.gain_db)] {
        if let Some(value) = value {
            restore.set(camera, feature, &value.to_string())?;
        }
    }
    if camera.value("AcquisitionMode").is_some() {
        restore.set(camera, "AcquisitionMode", "Continuous")?;
    }
    let chunks = Chunks::enable(camera, restore)?;
    let is_triggered = camera.value("TriggerMode").is_some_and(|mode| mode == "On");
    let constant =
        |name: &str| camera.number(name).map(|value| Known { value, provenance: Provenance::Register });
    let constants =
        ChunkValues { exposure_us: constant(exposure), gain_db: constant("Gain"), ..ChunkValues::default() };
    let (binding, period) = (binding(camera, identity), period(camera));
    Ok(Setup { layout, roi: roi(camera), constants, clock: None, period, is_triggered, binding, chunks })
}

/// Time from frame to frame of a free run: that of the rate, not less than the exposure.
fn period(camera: &impl Features) -> Option<Duration> {
    let rate_hz = camera.number("AcquisitionFrameRate").filter(|hz| *hz > 0.0)?;
    let exposure_s = camera.number(exposure_name(camera)).unwrap_or(0.0) * 1e-6;
    Duration::try_from_secs_f64(exposure_s.max(1.0 / rate_hz)).ok()
}

/// The window on the sensor; `None` for all of it, and where the camera does not state its sensor.
fn roi(camera: &impl Features) -> Option<Roi> {
    let of = |name: &str| camera.number(name).map(|pixels| pixels as u32);
    let (rows, columns) = (of("Height")?, of("Width")?);
    let sensor = (of("SensorHeight").or(of("HeightMax"))?, of("SensorWidth").or(of("WidthMax"))?);
    let (row, column) = (of("OffsetY").unwrap_or(0), of("OffsetX").unwrap_or(0));
    ((rows, columns) != sensor).then_some(Roi { row, column, rows, columns })
}
