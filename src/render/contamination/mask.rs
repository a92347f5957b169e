//! Truth mask: one bit for every kind of contamination that changes a pixel by more than
//! [`THRESHOLD`].

/// Loss or gain of light from which a pixel counts as affected, share of the bright field.
pub(crate) const THRESHOLD: f32 = 0.005;

/// Coolant mist.
pub(crate) const MIST: u8 = 1;
/// Droplets on the window.
pub(crate) const WINDOW_DROPLET: u8 = 2;
/// Droplets in the air.
pub(crate) const AIR_DROPLET: u8 = 4;
/// Chips.
pub(crate) const CHIP: u8 = 8;
/// A film on the shaft raises the edge here.
pub(crate) const FILM: u8 = 16;
/// Specks on the window.
pub(crate) const DIRT: u8 = 32;
/// Scratches on the window.
pub(crate) const SCRATCH: u8 = 64;
