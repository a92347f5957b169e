//! A touch: the order and the result.

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

/// A touch to be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchOrder {
    /// Machine z of the ball, mm.
    pub z_mm: f64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
    /// The side.
    pub side: Side,
    /// Diameter at which the surface is expected, mm: the probing move ends `probe.reach_mm` beyond
    /// it.
    pub expected_mm: f64,
}

/// A touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// The order.
    pub order: TouchOrder,
    /// Running number.
    pub id: u64,
    /// Time of the signal, ns.
    pub t_ns: u64,
    /// X of the ball's centre as stored by the control, from the nominal axis of the spindle, mm
    /// (radius); none where nothing was touched within reach.
    pub x_mm: Option<f64>,
}
