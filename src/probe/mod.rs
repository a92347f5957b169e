//! A touch-trigger probe in the tool carrier as a source of diameters, beside the camera.
//!
//! ```text
//! TouchOrder -> the cell -> Touch (X that the control kept) -> two-point diameters -> DiameterProfile
//! ```
//!
//! A touch reads the ball's centre where the control kept it, not where the ball met the part:
//! between them lie the pre-travel ([`pretravel`]), the way of the machine until the signal is
//! taken, and the ball's radius. What is common to part and master is taken out on masters
//! ([`ProbeCalibration`]); what is not is in the uncertainty. Two touches make a two-point
//! diameter: from one side with the spindle turned by 180° between them, or from both sides.
//! Eccentricity and bow cancel in both; what stands still in the machine (sag, the straightness of
//! the guideway) cancels from both sides alone.
//!
//! `settings` is the `[probe]` table, `touch` a touch, `pairs` two of them; `profile` gives the
//! stations' diameters with u.

mod calibration;
mod pairs;
pub mod pretravel;
mod profile;
mod settings;
mod touch;

pub use calibration::{CalibrationError, MasterTouches, ProbeCalibration, calibrate};
pub use pairs::{Pair, orders, pairs};
pub use profile::{common_parts, corrected, of_master, profile};
pub use settings::{ProbeSettings, ProbeTemperature, Sides, Stylus};
pub use touch::{Side, Touch, TouchOrder};
