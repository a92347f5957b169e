//! The sensor, from photons to counts, and sensors with published EMVA 1288 figures:
//! `sensor.preset = "…"` sets the keys that the table does not set itself.
//!
//! | preset | sensor | source |
//! |---|---|---|
//! | `sony_imx900` | Sony IMX900-AMR-C, 2064 × 1552 of 2.25 µm, global shutter, 12 bit, low
//! conversion gain, 0 dB | FRAMOS EMVA 1288 (v3.1) report, 536 nm, 36 °C |
//! | `sony_imx900_high_gain` | the same, high conversion gain, 3 dB | the same report |
//! | `lucid_atx470s` | LUCID Atlas10 ATX470S-M, Sony IMX492, 8288 × 5644 of 2.315 µm, 12 bit |
//! LUCID Vision Labs, "EMVA 1288 Data" of the ATX470S-M |
//!
//! The FRAMOS figures come from a public transcription of that report (system gain, quantum
//! efficiency, temporal dark noise, saturation capacity, DSNU, PRNU, black level), the LUCID ones
//! (temporal dark noise, saturation capacity, DSNU, PRNU) in a public quotation. LUCID's system
//! gain and quantum efficiency were not found: its gain is set so that the saturation capacity
//! fills 12 bits above the black level, its quantum efficiency is the default; both are marked
//! below. DSNU and PRNU enter as white patterns: the split into rows, columns and pixels is not
//! published with them. `sensor.data_sheet = "FILE"` takes the figures from a file of results
//! instead (`emva_results`).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::dark_current::{DarkCurrent, DarkSignal};
use super::readout::Readout;
use super::spatial::SpatialShares;
use crate::frame::PixelFormat;
use crate::render::error::{RenderError, within};

/// From photons to counts (EMVA 1288 4.0: K is the system gain, its inverse is set here).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "SensorFile")]
pub struct Sensor {
    /// The published figures the rest was taken from, where it was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<SensorPreset>,
    /// A file of EMVA 1288 results beside the config; its figures take its place in the resolved
    /// config.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data_sheet: Option<String>,
    /// Pixel format; full scale follows from it.
    pub format: PixelFormat,
    /// Electrons a count stands for, 1/K.
    pub electrons_per_count: f64,
    /// Quantum efficiency: share of the photons that become electrons.
    pub quantum_efficiency: f64,
    /// Temporal dark noise σ_d, electrons.
    pub read_noise_e: f64,
    /// Grey value without a single electron, counts.
    pub black_level_counts: f64,
    /// Saturation capacity, electrons.
    pub full_well_e: f64,
    /// Photo-response non-uniformity PRNU: relative standard deviation of the pixels' gain, the
    /// same in every frame.
    pub prnu_rel: f64,
    /// Dark-signal non-uniformity DSNU: standard deviation of the pixels' offset, electrons, the
    /// same in every frame.
    pub dsnu_e: f64,
    /// Hot pixels a million.
    pub hot_pixels_ppm: f64,
    /// Extra signal of a hot pixel, electrons.
    pub hot_pixel_e: f64,
    /// Electrons that gather in the dark; absent for short exposures, where they do not count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dark_current: Option<DarkCurrent>,
    /// What rows and columns share of DSNU and PRNU; absent where every pixel has its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spatial: Option<SpatialShares>,
    /// Row noise, non-linearity and cross-talk; absent for a readout without them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readout: Option<Readout>,
}

impl Default for Sensor {
    /// A 12-bit global-shutter CMOS sensor with 10 500 electrons full well.
    fn default() -> Self {
        Self {
            preset: None,
            data_sheet: None,
            format: PixelFormat::Mono12,
            electrons_per_count: 2.6,
            quantum_efficiency: 0.6,
            read_noise_e: 2.4,
            black_level_counts: 64.0,
            full_well_e: 10_500.0,
            prnu_rel: 0.0,
            dsnu_e: 0.0,
            hot_pixels_ppm: 0.0,
            hot_pixel_e: 2000.0,
            dark_current: None,
            spatial: None,
            readout: None,
        }
    }
}

impl Sensor {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        within("sensor.electrons_per_count", self.electrons_per_count, 1e-4, 1e5)?;
        within("sensor.quantum_efficiency", self.quantum_efficiency, 1e-3, 1.0)?;
        within("sensor.read_noise_e", self.read_noise_e, 0.0, 1e4)?;
        within("sensor.black_level_counts", self.black_level_counts, 0.0, 65535.0)?;
        within("sensor.full_well_e", self.full_well_e, 1.0, 1e8)?;
        within("sensor.prnu_rel", self.prnu_rel, 0.0, 0.5)?;
        within("sensor.dsnu_e", self.dsnu_e, 0.0, 1e5)?;
        within("sensor.hot_pixels_ppm", self.hot_pixels_ppm, 0.0, 1e6)?;
        within("sensor.hot_pixel_e", self.hot_pixel_e, 0.0, 1e7)?;
        if let Some(name) = &self.data_sheet {
            let right = "was not read: a config is loaded from a file to find the ones it names";
            return Err(RenderError::setting("sensor.data_sheet", name, right));
        }
        self.dark_current.map_or(Ok(()), |dark| dark.check())?;
        self.spatial.map_or(Ok(()), |shares| shares.check(self.dsnu_e, self.prnu_rel))?;
        self.readout.map_or(Ok(()), |readout| readout.check(self.read_noise_e))
    }

    /// Refuses what only frames of shafts show: rows and columns that share noise or pattern, and a
    /// readout of its own.
    ///
    /// # Errors
    /// Names the table.
    pub(crate) fn check_plain(&self) -> Result<(), RenderError> {
        let right = "is drawn in frames of shafts only (`render`, `run`): leave it out here";
        if self.spatial.is_some() {
            return Err(RenderError::setting("sensor.spatial", "a table", right));
        }
        if self.readout.is_some() {
            return Err(RenderError::setting("sensor.readout", "a table", right));
        }
        Ok(())
    }

    /// Whether a frame needs more than the noise and pattern of single pixels.
    pub(crate) fn is_plain(&self) -> bool {
        self.spatial.is_none_or(|s| s.is_none()) && self.readout.is_none_or(|r| r.is_none())
    }

    /// What rows and columns share of the pattern.
    pub(crate) fn shares(&self) -> SpatialShares {
        self.spatial.unwrap_or_default()
    }

    /// What the readout does.
    pub(crate) fn read_out(&self) -> Readout {
        self.readout.unwrap_or_default()
    }

    /// The pixels' own relative gains.
    pub(crate) fn pixel_prnu_rel(&self) -> f64 {
        self.spatial.map_or(self.prnu_rel, |shares| shares.pixel_prnu_rel(self.prnu_rel))
    }

    /// The pixels' own offsets, electrons.
    pub(crate) fn pixel_dsnu_e(&self) -> f64 {
        self.spatial.map_or(self.dsnu_e, |shares| shares.pixel_dsnu_e(self.dsnu_e))
    }

    /// The pixels' own temporal dark noise, electrons.
    pub(crate) fn pixel_noise_e(&self) -> f64 {
        self.readout.map_or(self.read_noise_e, |readout| readout.pixel_noise_e(self.read_noise_e))
    }

    /// What gathers in the dark over an exposure.
    pub(crate) fn dark_signal(&self, exposure_us: f64) -> DarkSignal {
        self.dark_current.map_or(DarkSignal::default(), |dark| dark.over(exposure_us))
    }
}

/// A sensor with published figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SensorPreset {
    /// Sony IMX900, low conversion gain.
    #[serde(rename = "sony_imx900")]
    SonyImx900,
    /// Sony IMX900, high conversion gain.
    #[serde(rename = "sony_imx900_high_gain")]
    SonyImx900HighGain,
    /// LUCID ATX470S-M (Sony IMX492).
    #[serde(rename = "lucid_atx470s")]
    LucidAtx470s,
}

impl SensorPreset {
    /// Pitch of its pixels, µm.
    pub(crate) fn pixel_um(self) -> f64 {
        match self {
            Self::SonyImx900 | Self::SonyImx900HighGain => 2.25,
            Self::LucidAtx470s => 2.315,
        }
    }

    /// The sensor with the published figures.
    pub(crate) fn sensor(self) -> Sensor {
        let sensor = Sensor {
            preset: Some(self),
            format: PixelFormat::Mono12,
            hot_pixels_ppm: 0.0,
            ..Sensor::default()
        };
        match self {
            Self::SonyImx900 => Sensor {
                electrons_per_count: 2.505,
                quantum_efficiency: 0.9125,
                read_noise_e: 5.560,
                black_level_counts: 240.0,
                full_well_e: 9458.0,
                dsnu_e: 3.7,
                prnu_rel: 0.007,
                ..sensor
            },
            Self::SonyImx900HighGain => Sensor {
                electrons_per_count: 0.598,
                quantum_efficiency: 0.8847,
                read_noise_e: 1.954,
                black_level_counts: 240.0,
                full_well_e: 2183.0,
                dsnu_e: 1.3,
                prnu_rel: 0.008,
                ..sensor
            },
            Self::LucidAtx470s => Sensor {
                // Not published with these figures: the full well is set to fill the scale above
                // the black level.
                electrons_per_count: 15_655.0 / (4095.0 - 64.0),
                read_noise_e: 7.83,
                black_level_counts: 64.0,
                full_well_e: 15_655.0,
                dsnu_e: 0.97,
                prnu_rel: 0.0062,
                ..sensor
            },
        }
    }
}

/// The `[sensor]` table as written: a preset and keys that override it.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, rename = "Sensor")]
pub(crate) struct SensorFile {
    /// A sensor with published EMVA 1288 figures; keys beside it override single figures.
    preset: Option<SensorPreset>,
    /// A file of EMVA 1288 results beside the config, in the XML of the standard's reference
    /// implementation or in YAML; keys beside it override single figures.
    data_sheet: Option<String>,
    /// Pixel format; full scale follows from it.
    format: Option<PixelFormat>,
    /// Electrons a count stands for, 1/K.
    electrons_per_count: Option<f64>,
    /// Share of the photons that become electrons, 0..=1.
    quantum_efficiency: Option<f64>,
    /// Temporal dark noise σ_d, electrons.
    read_noise_e: Option<f64>,
    /// Grey value without a single electron, counts.
    black_level_counts: Option<f64>,
    /// Saturation capacity, electrons.
    full_well_e: Option<f64>,
    /// Photo-response non-uniformity PRNU: relative standard deviation of the pixels' gain.
    prnu_rel: Option<f64>,
    /// Dark-signal non-uniformity DSNU: standard deviation of the pixels' offset, electrons.
    dsnu_e: Option<f64>,
    /// Hot pixels a million.
    hot_pixels_ppm: Option<f64>,
    /// Extra signal of a hot pixel, electrons.
    hot_pixel_e: Option<f64>,
    /// Electrons that gather in the dark.
    dark_current: Option<DarkCurrent>,
    /// What rows and columns share of DSNU and PRNU.
    spatial: Option<SpatialShares>,
    /// Row noise, non-linearity and cross-talk.
    readout: Option<Readout>,
}

impl SensorFile {
    /// What stands below the keys of this table: its preset, in its format.
    pub(super) fn base(&self) -> Sensor {
        let base = self.preset.map_or_else(Sensor::default, SensorPreset::sensor);
        Sensor { format: self.format.unwrap_or(base.format), ..base }
    }

    /// A sensor with the keys of this table over it.
    pub(super) fn on(self, base: &Sensor) -> Sensor {
        let file = self;
        Sensor {
            preset: file.preset,
            data_sheet: file.data_sheet,
            format: file.format.unwrap_or(base.format),
            electrons_per_count: file.electrons_per_count.unwrap_or(base.electrons_per_count),
            quantum_efficiency: file.quantum_efficiency.unwrap_or(base.quantum_efficiency),
            read_noise_e: file.read_noise_e.unwrap_or(base.read_noise_e),
            black_level_counts: file.black_level_counts.unwrap_or(base.black_level_counts),
            full_well_e: file.full_well_e.unwrap_or(base.full_well_e),
            prnu_rel: file.prnu_rel.unwrap_or(base.prnu_rel),
            dsnu_e: file.dsnu_e.unwrap_or(base.dsnu_e),
            hot_pixels_ppm: file.hot_pixels_ppm.unwrap_or(base.hot_pixels_ppm),
            hot_pixel_e: file.hot_pixel_e.unwrap_or(base.hot_pixel_e),
            dark_current: file.dark_current.or(base.dark_current),
            spatial: file.spatial.or(base.spatial),
            readout: file.readout.or(base.readout),
        }
    }
}

impl From<SensorFile> for Sensor {
    fn from(file: SensorFile) -> Self {
        let base = file.base();
        file.on(&base)
    }
}
