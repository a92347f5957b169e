//! A touch-trigger probe in the tool carrier as a source of diameters, beside the camera.
//!
//! ```text
//! TouchOrder -> the cell -> Touch (X that the control kept) -> two-point diameters -> DiameterProfile
//! ```
//!
//! A touch reads the ball's centre where the control kept it, not where the ball met the part: between them lie the
//! pre-travel ([`pretravel`]), the way of the machine until the signal is taken, and the ball's radius. What is common to
//! part and master is taken out on masters ([`ProbeCalibration`]); what is not is in the uncertainty. Two touches make a
//! two-point diameter: from one side with the spindle turned by 180° between them, or from both sides. Eccentricity and bow
//! cancel in both; what stands still in the machine (sag, the straightness of the guideway) cancels from both sides alone.

mod calibration;
pub mod pretravel;
mod profile;
mod settings;

pub use calibration::{CalibrationError, MasterTouches, ProbeCalibration, calibrate};
pub use profile::{Pair, common_parts, corrected, of_master, orders, pairs, profile};
pub use settings::{ProbeSettings, ProbeTemperature, SettingError, Sides, Stylus};

use serde::{Deserialize, Serialize};

/// The side of the part that is touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// From above in x: the side of the tool carrier.
    Carrier,
    /// From below in x.
    Opposite,
}

impl Side {
    /// +1 or −1: where it lies along x.
    pub fn sign(self) -> f64 {
        match self {
            Self::Carrier => 1.0,
            Self::Opposite => -1.0,
        }
    }
}

/// A touch that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchOrder {
    /// Machine z of the ball, mm.
    pub z_mm: f64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
    /// The side.
    pub side: Side,
    /// Diameter at which the surface is expected, mm: the probing move ends [`ProbeSettings::reach_mm`] beyond it.
    pub expected_mm: f64,
}

/// A touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// What was asked for.
    pub order: TouchOrder,
    /// Running number.
    pub id: u64,
    /// Time of the signal, ns.
    pub t_ns: u64,
    /// X of the ball's centre as the control kept it, from the axis of the spindle as it is set, mm (radius); none where
    /// nothing was touched within reach.
    pub x_mm: Option<f64>,
}
