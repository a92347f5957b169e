//! The instrument: frames -> edges -> calibrated diameters with uncertainty. It never sees the scene.

mod settings;

pub use settings::{Blur, GaugeSettings, GaugeSettingsError, Levels, Noise, Polarity, StationSettings};
