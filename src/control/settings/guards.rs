//! `[control.guards]`: limits of the guards.

use crate::control::error::require_limit;
use crate::setting::{SettingError, require};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What an alarm does: no further pass is safe until someone has looked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnAlarm {
    /// The run ends there: the next pass is not cut.
    #[default]
    Stop,
    /// The next pass is cut with the offsets held, to see what would have come of it. Not for a
    /// real lathe.
    GoOn,
}

/// Limits of what is released: `[control.guards]`. At a refusal the last offsets hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GuardSettings {
    /// Largest |D − r| that is believed, mm.
    pub plausible_error_mm: f64,
    /// Largest combined standard uncertainty of a station that is acted on, mm.
    pub uncertainty_limit_mm: f64,
    /// Largest scatter (robust standard deviation) from station to station about a smooth profile,
    /// mm.
    pub scatter_limit_mm: f64,
    /// A station further than this, and than 5 times the scatter, from what its neighbours say is
    /// an outlier, mm.
    pub outlier_limit_mm: f64,
    /// Oldest measurement that is used, s since the end of its scan.
    pub age_limit_s: f64,
    /// Largest deviation of a master read in the same scan, mm.
    pub master_limit_mm: f64,
    /// Changes of an offset smaller than this are not made, mm of diameter.
    pub deadband_mm: f64,
    /// Changes of an offset smaller than this many standard uncertainties of its reading are not
    /// made; 0 unless set.
    pub deadband_uncertainties: f64,
    /// Largest change of an offset at any station, mm of diameter. The first correction of a
    /// slender shaft takes 60 µm.
    pub step_limit_mm: f64,
    /// Largest offset at any station, mm of diameter.
    pub cumulative_limit_mm: f64,
    /// Above this change of an offset two scans of the same pass must agree, mm of diameter.
    pub confirm_above_mm: f64,
    /// Largest difference of the two scans at any station, mm.
    pub agreement_limit_mm: f64,
    /// Least ratio of observed change of diameter over commanded change.
    pub response_min: f64,
    /// Largest ratio of observed change of diameter over commanded change.
    pub response_max: f64,
    /// The response is judged where the commanded change (root mean square over the stations)
    /// reaches this, mm.
    pub response_from_mm: f64,
    /// What an alarm does.
    pub on_alarm: OnAlarm,
    /// Lower limit of the part's diameter, mm: no offset is released with which the next pass is
    /// predicted below it. A run takes the lower limit of the part's tolerance where none is given.
    pub lower_limit_mm: Option<f64>,
    /// Standard uncertainties that the predicted diameter keeps from the lower limit.
    pub coverage: f64,
    /// Least depth of cut (minimum chip), mm of radius.
    pub min_depth_mm: f64,
    /// Largest depth of cut, mm of radius.
    pub max_depth_mm: f64,
    /// Largest relative difference of feed and speed between the pass measured and the pass
    /// corrected.
    pub cutting_tolerance: f64,
}

impl Default for GuardSettings {
    fn default() -> Self {
        Self {
            plausible_error_mm: 0.25,
            uncertainty_limit_mm: 0.005,
            scatter_limit_mm: 0.006,
            outlier_limit_mm: 0.004,
            age_limit_s: 900.0,
            master_limit_mm: 0.002,
            deadband_mm: 0.0002,
            deadband_uncertainties: 0.0,
            step_limit_mm: 0.1,
            cumulative_limit_mm: 0.3,
            confirm_above_mm: 0.08,
            agreement_limit_mm: 0.003,
            response_min: 0.6,
            response_max: 1.2,
            response_from_mm: 0.02,
            on_alarm: OnAlarm::default(),
            lower_limit_mm: None,
            coverage: 2.0,
            min_depth_mm: 0.05,
            max_depth_mm: 2.0,
            cutting_tolerance: 1e-3,
        }
    }
}

impl GuardSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// [`SettingError`] names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let limits = [
            ("control.guards.plausible_error_mm", self.plausible_error_mm),
            ("control.guards.uncertainty_limit_mm", self.uncertainty_limit_mm),
            ("control.guards.scatter_limit_mm", self.scatter_limit_mm),
            ("control.guards.outlier_limit_mm", self.outlier_limit_mm),
            ("control.guards.master_limit_mm", self.master_limit_mm),
            ("control.guards.step_limit_mm", self.step_limit_mm),
            ("control.guards.cumulative_limit_mm", self.cumulative_limit_mm),
            ("control.guards.confirm_above_mm", self.confirm_above_mm),
            ("control.guards.agreement_limit_mm", self.agreement_limit_mm),
            ("control.guards.response_from_mm", self.response_from_mm),
            ("control.guards.max_depth_mm", self.max_depth_mm),
        ];
        for (key, limit) in limits {
            require_limit(key, Some(limit))?;
        }
        require_limit("control.guards.lower_limit_mm", self.lower_limit_mm)?;
        let not_negative = [
            ("control.guards.age_limit_s", self.age_limit_s),
            ("control.guards.deadband_mm", self.deadband_mm),
            ("control.guards.deadband_uncertainties", self.deadband_uncertainties),
            ("control.guards.coverage", self.coverage),
            ("control.guards.min_depth_mm", self.min_depth_mm),
            ("control.guards.cutting_tolerance", self.cutting_tolerance),
        ];
        for (key, value) in not_negative {
            require(value >= 0.0, key, value, "0 or more")?;
        }
        let (low, high) = (self.response_min, self.response_max);
        require(low > 0.0 && low < 1.0, "control.guards.response_min", low, "a ratio above 0 and below 1")?;
        require(high > 1.0, "control.guards.response_max", high, "a ratio above 1")
    }
}
