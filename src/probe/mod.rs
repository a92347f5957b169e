//! A touch-trigger probe in the tool carrier as a source of diameters, beside the camera.
//!
//! ```text
//! TouchOrder -> cell -> Touch (X stored by the control) -> two-point diameters -> DiameterProfile
//! ```
//!
//! A touch yields the position of the ball's centre that the control stored, not the point of
//! contact: they differ by the pre-travel (`pretravel`), the path of the machine until the signal
//! is processed, and the ball's radius. Effects common to part and master are corrected by the
//! calibration on masters (`ProbeCalibration`); all others are in the uncertainty. Two touches
//! make a two-point diameter: from one side with the spindle turned by 180° between them, or from
//! both sides. Eccentricity and bow cancel in both; effects at rest in the machine (sag,
//! straightness of the guideway) cancel only with touches from both sides.
//!
//! `settings` is the `[probe]` table, `touch` a touch, `pairs` two of them; `profile` gives the
//! stations' diameters with u.

mod calibration;
mod pairs;
pub(crate) mod pretravel;
mod profile;
mod settings;
mod touch;

pub use self::{
    calibration::{CalibrationError, ProbeCalibration},
    settings::{ProbeSettings, ProbeTemperature, Sides, Stylus},
    touch::{Side, Touch, TouchOrder},
};
pub(crate) use calibration::{MasterTouches, calibrate};
pub(crate) use pairs::{orders, pairs};
pub(crate) use profile::{common_parts, corrected, of_master, profile};
