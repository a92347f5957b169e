//! One error as a config states it, by its unit: µm or µrad stand in the keys.
//!
//! In: the keys of `[machine.errors.exz]`. Out: a [`StatedError`], which checks them and becomes a
//! function. The parts (Fourier terms, polynomial, table, reversal, drift) add up. Four types from
//! two patterns: a slide's error or the spindle's, a length or an angle.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::stated_error::{StatedDrift, StatedError, StatedTable, StatedWave, Unit};
use super::table_file::Columns;

/// An error's settings.
pub(crate) trait ErrorSettings {
    /// The numbers, free of the names of their keys.
    fn stated(&self) -> StatedError;

    /// The file of its table, beside the config.
    fn file(&self) -> Option<&str>;

    /// Puts the columns of that file in place of its name.
    fn fill(&mut self, columns: Columns);
}

/// Declares the settings of a slide's error: its types, its keys, its unit.
macro_rules! slide_error {
    ($error:ident, $wave:ident, $polynomial:ident, $table:ident, $drift:ident,
     [$amplitude:ident, $coefficients:ident, $value:ident, $backward:ident, $reversal:ident],
     [$per_k:ident, $per_m_k:ident, $warm_up:ident], $unit:expr) => {
        /// An error of a slide over its position; what is given adds up.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub(crate) struct $error {
            /// Cosines over the position.
            pub fourier: Vec<$wave>,
            /// A polynomial over the travel.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub polynomial: Option<$polynomial>,
            /// Measured values.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub table: Option<$table>,
            /// Reversal B of ISO 230-2: the value where the position grew less that where it fell;
            /// half of it counts with the direction's sign. 0 where the table has both directions.
            pub $reversal: f64,
            /// Drift with temperature and time.
            pub drift: $drift,
        }

        /// A cosine over the position.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $wave {
            /// Wavelength, mm. Must be above 0.
            pub wavelength_mm: f64,
            /// Amplitude; peak to valley is twice that.
            pub $amplitude: f64,
            /// Phase at position 0, degrees.
            #[serde(default)]
            pub phase_deg: f64,
        }

        /// A polynomial over the travel.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $polynomial {
            /// Coefficients of 1, s, s², … with s from -1 to 1 over the travel.
            pub $coefficients: Vec<f64>,
        }

        /// Measured values: here, or in a file of the same columns.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub(crate) struct $table {
            /// A CSV file beside the config, with the columns of this table.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub file: Option<String>,
            /// Positions, mm, ascending, from one end of the travel to the other.
            pub position_mm: Vec<f64>,
            /// Values where the position grew.
            pub $value: Vec<f64>,
            /// Values where it fell, where they were measured apart.
            pub $backward: Vec<f64>,
        }

        /// Drift after ISO 230-3.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub(crate) struct $drift {
            /// Offset a kelvin above 20 °C.
            pub $per_k: f64,
            /// Slope over the position a kelvin above 20 °C, zero at position 0: a scale that
            /// expands.
            pub $per_m_k: f64,
            /// Offset once the machine is warm.
            pub $warm_up: f64,
            /// Time constant of warming up, minutes.
            pub time_constant_min: f64,
        }

        impl ErrorSettings for $error {
            fn stated(&self) -> StatedError {
                let wave = |w: &$wave| StatedWave {
                    period: w.wavelength_mm,
                    amplitude: w.$amplitude,
                    phase_deg: w.phase_deg,
                };
                let table = |t: &$table| StatedTable {
                    position: t.position_mm.clone(),
                    forward: t.$value.clone(),
                    backward: t.$backward.clone(),
                };
                StatedError {
                    unit: $unit,
                    waves: self.fourier.iter().map(wave).collect(),
                    polynomial: self.polynomial.as_ref().map(|p| p.$coefficients.clone()),
                    table: self.table.as_ref().map(table),
                    reversal: self.$reversal,
                    drift: StatedDrift {
                        per_k: self.drift.$per_k,
                        per_m_k: self.drift.$per_m_k,
                        warm_up: self.drift.$warm_up,
                        time_constant_min: self.drift.time_constant_min,
                    },
                }
            }

            fn file(&self) -> Option<&str> {
                self.table.as_ref().and_then(|table| table.file.as_deref())
            }

            fn fill(&mut self, columns: Columns) {
                let Columns { position, forward, backward } = columns;
                let table =
                    $table { file: None, position_mm: position, $value: forward, $backward: backward };
                self.table = Some(table);
            }
        }
    };
}

/// Declares the settings of an error of the spindle: its types, its keys, its unit.
macro_rules! spindle_error {
    ($error:ident, $wave:ident, $table:ident, $drift:ident,
     [$amplitude:ident, $value:ident, $per_k:ident, $warm_up:ident], $unit:expr) => {
        /// An error of the spindle over its angle, in a fixed direction of the machine; what is
        /// given adds up.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub(crate) struct $error {
            /// Cosines over the angle: the synchronous error motion.
            pub fourier: Vec<$wave>,
            /// Measured values over a turn.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub table: Option<$table>,
            /// Drift with temperature and time.
            pub drift: $drift,
        }

        /// A cosine over the angle.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $wave {
            /// Waves a turn, a whole number. Must be at least 1.
            pub order: u32,
            /// Amplitude; peak to valley is twice that.
            pub $amplitude: f64,
            /// Phase at angle 0, degrees.
            #[serde(default)]
            pub phase_deg: f64,
        }

        /// Measured values over a turn: here, or in a file of the same columns.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub(crate) struct $table {
            /// A CSV file beside the config, with the columns of this table.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub file: Option<String>,
            /// Angles, degrees, ascending, less than a turn from the first to the last, no gap
            /// wider than 90 degrees.
            pub angle_deg: Vec<f64>,
            /// Values.
            pub $value: Vec<f64>,
        }

        /// Drift after ISO 230-3.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub(crate) struct $drift {
            /// Offset a kelvin above 20 °C.
            pub $per_k: f64,
            /// Offset once the machine is warm.
            pub $warm_up: f64,
            /// Time constant of warming up, minutes.
            pub time_constant_min: f64,
        }

        impl ErrorSettings for $error {
            fn stated(&self) -> StatedError {
                let wave = |w: &$wave| StatedWave {
                    period: f64::from(w.order),
                    amplitude: w.$amplitude,
                    phase_deg: w.phase_deg,
                };
                let table = |t: &$table| StatedTable {
                    position: t.angle_deg.clone(),
                    forward: t.$value.clone(),
                    backward: Vec::new(),
                };
                StatedError {
                    unit: $unit,
                    waves: self.fourier.iter().map(wave).collect(),
                    polynomial: None,
                    table: self.table.as_ref().map(table),
                    reversal: 0.0,
                    drift: StatedDrift {
                        per_k: self.drift.$per_k,
                        per_m_k: 0.0,
                        warm_up: self.drift.$warm_up,
                        time_constant_min: self.drift.time_constant_min,
                    },
                }
            }

            fn file(&self) -> Option<&str> {
                self.table.as_ref().and_then(|table| table.file.as_deref())
            }

            fn fill(&mut self, columns: Columns) {
                let Columns { position, forward, .. } = columns;
                self.table = Some($table { file: None, angle_deg: position, $value: forward });
            }
        }
    };
}

slide_error!(
    SlideLength,
    LengthWave,
    LengthPolynomial,
    LengthTable,
    LengthDrift,
    [amplitude_um, coefficients_um, value_um, backward_um, reversal_um],
    [offset_um_per_k, slope_um_per_m_k, warm_up_um],
    Unit::Um
);
slide_error!(
    SlideAngle,
    AngleWave,
    AnglePolynomial,
    AngleTable,
    AngleDrift,
    [amplitude_urad, coefficients_urad, value_urad, backward_urad, reversal_urad],
    [offset_urad_per_k, slope_urad_per_m_k, warm_up_urad],
    Unit::Urad
);
spindle_error!(
    SpindleLength,
    SpindleLengthWave,
    SpindleLengthTable,
    SpindleLengthDrift,
    [amplitude_um, value_um, offset_um_per_k, warm_up_um],
    Unit::Um
);
spindle_error!(
    SpindleAngle,
    SpindleAngleWave,
    SpindleAngleTable,
    SpindleAngleDrift,
    [amplitude_urad, value_urad, offset_urad_per_k, warm_up_urad],
    Unit::Urad
);
