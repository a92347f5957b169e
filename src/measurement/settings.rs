//! What is asked of a measurement beside the edges: the options of `shadowgauge measure`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::MeasureError;
use crate::conformity::Tolerance;
use crate::gauge::diameter::reading_series::Averaging;
use crate::gauge::{Calibration, LEAST_STRETCH};
use crate::setting::positive;

/// Settings of a measurement. Which of several shadows is measured and how columns are refused are
/// the gauge's own ([`crate::gauge::GaugeSettings`]: `which`, `rejection`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MeasureSettings {
    /// The shaft's axis stands upright in the images.
    pub vertical: bool,
    /// Rows of the sensor between two windows that each frame was read out as, the one around the
    /// upper edge first; frames that state their windows have their own.
    pub rows_between: u32,
    /// Measures a frame that is refused for its outline again as crests and roots (threads,
    /// knurls).
    pub crests: bool,
    /// Least width of a stretch that counts for the largest diameter, columns; without it 5.
    pub stretch_columns: Option<u16>,
    /// The same in mm along the axis, where it is not stated in columns. Above 0.
    pub stretch_mm: Option<f64>,
    /// Tolerance that every value must be proven to lie in.
    pub tolerance: Option<Tolerance>,
    /// Probability of conformity to both limits behind GO (ISO 14253-1). At least 0.5, below 1.
    pub conformance_probability: f64,
    /// Length of the stations that are given and judged, mm. Above 0.
    pub station_mm: Option<f64>,
    /// Average of successive frames' mean diameters.
    pub average: Averaging,
    /// Coverage factor k of the expanded uncertainties; without it that of 95.45 % at the effective
    /// degrees of freedom. Above 0.
    pub coverage_factor: Option<f64>,
    /// Gives the uncertainty budget of every frame's largest diameter.
    pub budget: bool,
    /// Takes the frames as one turn, which gives sizes, roundness, run-out and harmonics.
    pub turn: bool,
    /// Spindle angles of the frames of a turn in their order, degrees from one to the next; without
    /// it the frames' own. Above 0.
    pub angle_step_deg: Option<f64>,
    /// Largest change of a diameter from one turn to the next that is accepted, µm. Above 0.
    pub turn_limit_um: f64,
    /// Takes every frame as another part: the statistics have Cp and Cpk.
    pub parts: bool,
    /// Gives diameters of frames, too, that are blurred otherwise than the masters were, with a
    /// warning.
    pub accept_blur: bool,
    /// Seconds over which readings must agree before a diameter is good; without it every frame
    /// stands for itself. Above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settle_s: Option<f64>,
    /// Gaussian filter of roundness, undulations per revolution (15, 50, 150). Above 0.
    pub cutoff_upr: f64,
}

impl Default for MeasureSettings {
    fn default() -> Self {
        Self {
            vertical: false,
            rows_between: 0,
            crests: true,
            stretch_columns: None,
            stretch_mm: None,
            tolerance: None,
            // ISO 14253-1, 5.2.
            conformance_probability: 0.95,
            station_mm: None,
            average: Averaging::Off,
            coverage_factor: None,
            budget: false,
            turn: false,
            angle_step_deg: None,
            // Heat moves a diameter by less within a turn: 5 K at Ø 80.
            turn_limit_um: 5.0,
            parts: false,
            accept_blur: false,
            settle_s: None,
            // The middle one of the filters of ISO 12181-2.
            cutoff_upr: 50.0,
        }
    }
}

impl MeasureSettings {
    /// Checks the ranges that no other check holds.
    ///
    /// # Errors
    /// Names the first setting out of its range.
    pub(crate) fn validate(&self) -> Result<(), MeasureError> {
        let given = [
            ("measure.stretch_mm", self.stretch_mm),
            ("measure.station_mm", self.station_mm),
            ("measure.coverage_factor", self.coverage_factor),
            ("measure.angle_step_deg", self.angle_step_deg),
            ("measure.turn_limit_um", Some(self.turn_limit_um)),
            ("measure.settle_s", self.settle_s),
        ];
        for (key, value) in given {
            value.map_or(Ok(()), |value| positive(key, value))?;
        }
        Ok(())
    }

    /// The first setting given that needs millimetres.
    pub(crate) fn needs_scale(&self) -> Option<&'static str> {
        [
            (self.tolerance.is_some(), "tolerance"),
            (self.station_mm.is_some(), "station_mm"),
            (self.stretch_mm.is_some(), "stretch_mm"),
            (self.averages(), "average"),
            (self.budget, "budget"),
            (self.turn, "turn"),
            (self.settle_s.is_some(), "settle_s"),
        ]
        .into_iter()
        .find_map(|(given, name)| given.then_some(name))
    }

    /// Least width of a stretch that counts for the largest diameter, columns.
    pub(crate) fn least_stretch(&self, calibration: Option<&Calibration>) -> usize {
        let columns = self.stretch_mm.zip(calibration).map(|(mm, c)| (mm / c.scale_mm_per_px).ceil());
        match (self.stretch_columns, columns) {
            (Some(columns), _) => usize::from(columns),
            (None, Some(columns)) => columns.clamp(1.0, 1e6) as usize,
            (None, None) => LEAST_STRETCH,
        }
    }

    /// Coverage factor k of means, averages and stations, whose u has many degrees of freedom: the
    /// one given, else 2, for 95.45 % of a normal distribution.
    pub(crate) fn factor_of_means(&self) -> f64 {
        self.coverage_factor.unwrap_or(2.0)
    }

    /// Whether successive frames are averaged.
    pub(crate) fn averages(&self) -> bool {
        self.average != Averaging::Off
    }
}
