//! What the geometry of a machine does to the tool's path: the interface by which a process takes
//! it.
//!
//! A process alone cuts where it is commanded; the errors of a lathe come from another room.

/// A place on the tool's path as it is commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathPlace {
    /// Machine z, mm.
    pub z_mm: f64,
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Growth of the diameter with z; 0 on a cylinder.
    pub taper: f64,
}

/// A machine whose tool does not stand where it is commanded.
pub(crate) trait PathDisplacement: std::fmt::Debug + Send + Sync {
    /// What the machine adds to the diameter that is cut at a place, mm.
    fn cut_mm(&self, place: &PathPlace) -> f64;

    /// What the control's own compensation subtracts from the diameter commanded at a place, mm; 0
    /// without one.
    fn compensated_mm(&self, place: &PathPlace) -> f64;
}
