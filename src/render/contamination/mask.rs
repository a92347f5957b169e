//! Truth mask: one bit for every kind of contamination that changes a pixel by more than
//! [`THRESHOLD`].

/// Loss or gain of light from which a pixel counts as affected, share of the bright field.
pub const THRESHOLD: f32 = 0.005;

/// Coolant mist.
pub const MIST: u8 = 1;
/// Droplets on the window.
pub const WINDOW_DROPLET: u8 = 2;
/// Droplets in the air.
pub const AIR_DROPLET: u8 = 4;
/// Chips.
pub const CHIP: u8 = 8;
/// A film on the shaft raises the edge here.
pub const FILM: u8 = 16;
/// Specks on the window.
pub const DIRT: u8 = 32;
/// Scratches on the window.
pub const SCRATCH: u8 = 64;

/// Names of the kinds, lowest bit first.
pub const NAMES: [&str; 7] = ["mist", "window_droplet", "air_droplet", "chip", "film", "dirt", "scratch"];
