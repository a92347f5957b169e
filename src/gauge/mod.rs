//! The instrument: frames -> edges -> calibrated diameters with uncertainty. It never sees the scene.

pub mod form;
pub mod judgement;
pub mod photon_transfer;
pub mod ring;
pub mod size;
pub mod statistics;

mod settings;

pub use settings::{Blur, GaugeSettings, GaugeSettingsError, Levels, Noise, Polarity, StationSettings};
