//! The sensor after EMVA 1288: photons to counts, noise, patterns, dark current, readout.
//!
//! In: the `[sensor]` table. Out: [`Sensor`], whose levels and noise `scene` gives the kernel.
//! `data_sheet` has the figures of a sensor and the published presets, `dark_current` what gathers
//! over an exposure, `spatial` what rows and columns share of the pattern, `readout` row noise,
//! non-linearity and cross-talk, `emva_results` a measured sensor's file. One more figure is a key
//! of [`Sensor`]; what follows from several is a file.

mod dark_current;
mod data_sheet;
mod emva_results;
mod readout;
mod spatial;

#[cfg(test)]
pub(crate) use self::dark_current::DarkCurrent;
pub(crate) use self::data_sheet::{Sensor, SensorFile};
pub(crate) use self::emva_results::EmvaResults;
#[cfg(test)]
pub(crate) use self::readout::Readout;
#[cfg(test)]
pub(crate) use self::spatial::SpatialShares;
