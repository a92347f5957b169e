//! Values that a camera sends with every frame (GenICam chunk data).
//!
//! Angle and z come under the names of our published head, in degrees and mm. An encoder by the
//! SFNC alone (`ChunkEncoderValue`) gives counts, whose angle no camera states: not taken here.
//! `ChunkDeviceTemperature` is a feature of some vendors; without it the temperature is read from
//! the register.

use viva_genicam::genapi::RegisterIo;
use viva_genicam::{Camera, Frame as Block};

use super::error::CameraError;
use super::features::Features as _;
use super::guard::Restore;
use crate::source::live::{Known, Provenance};

/// Entries of `ChunkSelector` that are taken, where the camera has them.
const ENTRIES: [&str; 6] =
    ["ExposureTime", "Gain", "EncoderValue", "SpindleAngle", "CarriageZ", "DeviceTemperature"];

/// Exposure time, gain, spindle angle, carriage z and temperature by their features.
const FEATURES: [&str; 5] =
    ["ChunkExposureTime", "ChunkGain", "ChunkSpindleAngle", "ChunkCarriageZ", "ChunkDeviceTemperature"];

/// Chunk features of a camera that are read from every frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chunks {
    has: [bool; 5],
}

/// The values of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ChunkValues {
    /// Exposure time, µs.
    pub exposure_us: Option<Known<f64>>,
    /// Gain, dB.
    pub gain_db: Option<Known<f64>>,
    /// Spindle angle, degrees.
    pub angle_deg: Option<Known<f64>>,
    /// Carriage z, mm.
    pub z_mm: Option<Known<f64>>,
    /// Temperature of the head, °C.
    pub head_c: Option<Known<f64>>,
}

impl Chunks {
    /// Switches the chunks on that are read; a camera that has none is left alone.
    ///
    /// # Errors
    /// A camera that states a chunk and does not send it.
    pub(super) fn enable<T: RegisterIo>(
        camera: &mut Camera<T>,
        restore: &mut Restore,
    ) -> Result<Self, CameraError> {
        let has = FEATURES.map(|name| camera.nodemap().node(name).is_some());
        let all = camera.entries("ChunkSelector");
        let wanted: Vec<&str> =
            ENTRIES.into_iter().filter(|entry| all.iter().any(|known| known == entry)).collect();
        if !has.contains(&true) || wanted.is_empty() || camera.value("ChunkModeActive").is_none() {
            return Ok(Self::default());
        }
        // Entries can be enabled in the chunk mode alone (SFNC 2.7, ChunkEnable).
        restore.set(camera, "ChunkModeActive", "true")?;
        for entry in wanted {
            restore.set_selected(camera, ("ChunkSelector", entry), ("ChunkEnable", "true"))?;
        }
        Ok(Self { has })
    }

    /// The values of a frame.
    pub(super) fn values<T: RegisterIo>(&self, camera: &mut Camera<T>, block: &Block) -> ChunkValues {
        if block.chunks.is_none() || !self.has.contains(&true) {
            return ChunkValues::default();
        }
        camera.with_chunks(block, |camera| {
            ChunkValues::read(|k| self.has[k].then(|| camera.get_float(FEATURES[k]).ok())?)
        })
    }
}

impl ChunkValues {
    /// The values of [`FEATURES`] by their places; what is not finite is not known.
    fn read(value: impl Fn(usize) -> Option<f64>) -> Self {
        let known = |k: usize| {
            let value = value(k).filter(|value| value.is_finite())?;
            Some(Known { value, provenance: Provenance::Chunk })
        };
        let [exposure_us, gain_db, angle_deg, z_mm, head_c] = [0, 1, 2, 3, 4].map(known);
        Self { exposure_us, gain_db, angle_deg, z_mm, head_c }
    }

    /// Temperature of the head: the frame's own, else as `register` reads it.
    pub(super) fn head_c_or(&self, register: impl FnOnce() -> Option<Known<f64>>) -> Option<Known<f64>> {
        self.head_c.or_else(register)
    }
}

#[cfg(test)]
#[path = "../../../fuzz/received.rs"]
mod received;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{ChunkValues, FEATURES, received};
    use crate::source::live::{Known, Provenance};

    /// The seeds of the fuzz target `receiver`.
    fn seed(name: &str) -> Vec<u8> {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/receiver");
        std::fs::read(folder.join(name)).unwrap()
    }

    #[test]
    fn packets_and_chunks_are_taken_apart() {
        for name in ["leader", "payload", "trailer", "short_ids"] {
            assert!(received::packet(&seed(name)), "{name}");
        }
        let whole = seed("chunks");
        assert!(received::chunks(&whole));
        // 64 bytes of pixels, two f64 and a chunk without bytes, each with its tag of 8: cut behind
        // a tag, or behind an f64 that reads as the tag of an empty chunk, it is whole
        let refused = (1..whole.len()).filter(|cut| !received::chunks(&whole[..*cut])).count();
        assert!(refused > 100, "{refused} of {} cuts are refused", whole.len() - 1);
    }

    #[test]
    fn the_temperature_of_a_frame_comes_before_that_of_the_register() {
        let register = Some(Known { value: 31.0, provenance: Provenance::Register });
        let of = |head_c: f64| {
            ChunkValues::read(|k| match FEATURES[k] {
                "ChunkDeviceTemperature" => Some(head_c),
                "ChunkCarriageZ" => Some(-2.5),
                _ => None,
            })
        };
        let values = of(33.5);
        assert_eq!(values.z_mm.map(|z| z.value), Some(-2.5));
        assert_eq!((values.angle_deg, values.gain_db, values.exposure_us), (None, None, None));
        let head_c = values.head_c_or(|| unreachable!("the register is read for nothing")).unwrap();
        assert_eq!((head_c.value, head_c.provenance), (33.5, Provenance::Chunk));
        assert_eq!(of(f64::NAN).head_c_or(|| register), register);
    }

    proptest! {
        /// Whatever comes from the network, damaged payloads of chunks included.
        #[test]
        fn whatever_comes_is_taken_apart_or_refused(
            bytes in prop::collection::vec(any::<u8>(), 0..200),
            at in 0_usize..112,
            with: u8,
        ) {
            received::packet(&bytes);
            received::chunks(&bytes);
            let mut damaged = seed("chunks");
            damaged[at] = with;
            received::chunks(&damaged);
        }
    }
}
