//! The components of the cutting force in the directions of a lathe.

use serde::Serialize;

/// The three components of the cutting force (ISO 3002-4), N.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Components {
    /// F_c, tangential, along the cutting speed.
    pub cutting_n: f64,
    /// F_f, axial, against the feed.
    pub feed_n: f64,
    /// F_p, radial: what bends the shaft out of size.
    pub passive_n: f64,
}
