//! A head that puts before its camera by itself what a calibration looks at: the light without a
//! part, no light, master pins.

use std::collections::BTreeMap;

use super::wire_frames::{Numbers, Stop, WireFrames};
use crate::frame::{Frame, FrameSource as _};
use crate::source::commanded::{CommandedHead, HeadError};

/// Features by which a head is ordered what to put before its camera, besides triggers and clock.
const FEATURES: [&str; 3] = ["HeadObject", "MasterIndex", "HeadFrame"];

/// What stands before the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Placed {
    /// No light.
    Dark,
    /// The light without a part.
    Flat,
    /// A master pin by its number in the head's config, from 0.
    Master(usize),
}

impl Placed {
    /// Its entry of `HeadObject`.
    fn entry(self) -> &'static str {
        match self {
            Self::Dark => "Dark",
            Self::Flat => "Flat",
            Self::Master(_) => "Master",
        }
    }
}

/// A head that places what is looked at.
pub(crate) struct PlacedHead {
    head: Box<dyn CommandedHead>,
    /// What the head is called in errors.
    name: String,
    is_acquiring: bool,
    /// Number of the next frame of the fields, and of every pin, from 0: noise follows from it, and
    /// a look at the same pin again goes on.
    of_fields: u64,
    of_pin: BTreeMap<usize, u64>,
}

/// Whether a head places by itself what it is to look at.
pub(crate) fn places(head: &dyn CommandedHead) -> bool {
    FEATURES.into_iter().all(|name| head.value(name).is_some())
}

impl PlacedHead {
    /// A head that [`places`]; `name` is what it is called in errors.
    ///
    /// # Errors
    /// A head that takes no software triggers, or is gone.
    pub(crate) fn new(mut head: Box<dyn CommandedHead>, name: &str) -> Result<Self, HeadError> {
        for (feature, entry) in
            [("TriggerSelector", "FrameStart"), ("TriggerSource", "Software"), ("TriggerMode", "On")]
        {
            head.set_until_end(feature, entry)?;
        }
        let (name, of_pin) = (name.to_owned(), BTreeMap::new());
        Ok(Self { head, name, is_acquiring: false, of_fields: 0, of_pin })
    }

    /// Sets the exposure time, µs; it has its own back at the end.
    ///
    /// # Errors
    /// A head that refuses it, or is gone.
    pub(crate) fn expose(&mut self, exposure_us: f64) -> Result<(), HeadError> {
        self.head.set_until_end("ExposureTime", &exposure_us.to_string())
    }

    /// Exposure time, µs, where the head states it.
    pub(crate) fn exposure_us(&self) -> Option<f64> {
        self.head.number("ExposureTime")
    }

    /// Frames of what the head is to place, each by a trigger of its own; one that is lost is taken
    /// again.
    ///
    /// # Errors
    /// What the head cannot place, a frame that does not come, a head that is gone: as text.
    pub(crate) fn frames(&mut self, what: Placed, count: usize) -> Result<Vec<Frame>, String> {
        self.place(what).map_err(|why| format!("{}: {why}", self.name))?;
        let next = match what {
            Placed::Master(index) => self.of_pin.entry(index).or_default(),
            Placed::Dark | Placed::Flat => &mut self.of_fields,
        };
        let stops = vec![Stop { z_mm: 0.0, angle_deg: 0.0 }; count];
        let numbers = Numbers { first_id: 0, next };
        let mut source = WireFrames::new(self.head.as_mut(), &self.name, stops, numbers);
        let mut frames = Vec::with_capacity(count);
        while let Some(frame) = source.next_frame().map_err(|why| why.what)? {
            frames.push(frame);
        }
        Ok(frames)
    }

    /// `HeadObject` is set at rest, and writing the index clamps the pin anew.
    fn place(&mut self, what: Placed) -> Result<(), HeadError> {
        if std::mem::take(&mut self.is_acquiring) {
            self.head.stop()?;
        }
        self.head.set_until_end("HeadObject", what.entry())?;
        if let Placed::Master(index) = what {
            self.head.set_until_end("MasterIndex", &index.to_string())?;
        }
        self.head.start()?;
        self.is_acquiring = true;
        Ok(())
    }
}
