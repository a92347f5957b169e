//! The sensor after EMVA 1288: photons to counts, noise, patterns, dark current.
//!
//! In: the `[sensor]` table. Out: [`Sensor`], whose levels and noise `scene` gives the kernel.
//! `data_sheet` has the figures of a sensor and the published presets, `dark_current` what gathers
//! over an exposure. One more figure is a key of [`Sensor`]; what follows from several is a file.

mod dark_current;
mod data_sheet;

#[cfg(test)]
pub(crate) use self::dark_current::DarkCurrent;
pub(crate) use self::data_sheet::Sensor;
