//! `[probe]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::setting::{SettingError, require};

/// Direction of the stylus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stylus {
    /// Radially, towards the axis: the usual place on a turret; a diameter is touched with the
    /// stylus' tip.
    #[default]
    AlongX,
    /// Across spindle and carrier's way (a Y axis, a B axis): a diameter is touched with the ball's
    /// side.
    AlongY,
    /// Parallel to the spindle (a cranked stylus): a diameter is touched with the ball's side.
    AlongZ,
}

/// From which sides a diameter is touched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// From the carrier's side, the spindle turned by 180° between both touches.
    #[default]
    One,
    /// From both sides at one spindle angle.
    Two,
}

/// Temperatures where diameters are touched; 20 °C is the reference (ISO 1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ProbeTemperature {
    /// Of the part, °C.
    pub part_c: f64,
    /// Of the masters, °C.
    pub master_c: f64,
    /// Standard uncertainty of each, K.
    pub u_k: f64,
    /// Expansion of part and masters, µm/(m K).
    pub expansion_um_per_m_k: f64,
}

impl Default for ProbeTemperature {
    fn default() -> Self {
        Self { part_c: 20.0, master_c: 20.0, u_k: 0.5, expansion_um_per_m_k: 11.5 }
    }
}

/// A touch-trigger probe and how it is used. Where the table stands, the closed loop takes its
/// diameters from the probe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ProbeSettings {
    /// Direction of the stylus.
    pub stylus: Stylus,
    /// From which sides a diameter is touched.
    pub sides: Sides,
    /// Two-point diameters a station, at spindle angles equally spaced over half a turn.
    pub angles: usize,
    /// Two-point diameters taken of every master pin, at spindle angles equally spaced over half a
    /// turn.
    pub master_diameters: usize,
    /// Diameter of the ball, mm.
    pub ball_mm: f64,
    /// From the ball's centre to the seats that the stylus tilts on, mm.
    pub stylus_mm: f64,
    /// Diameter of the stem, mm.
    pub stem_mm: f64,
    /// Young's modulus of the stem, N/mm²; tungsten carbide unless set.
    pub modulus_n_per_mm2: f64,
    /// Force of the spring that seats the stylus, N: the force of a touch along the stylus.
    pub spring_n: f64,
    /// Radius of the circle on which the three seats lie, mm.
    pub seat_radius_mm: f64,
    /// Direction of least force in the plane across the stylus, degrees: from x towards y or z,
    /// from y towards z.
    pub lobe_deg: f64,
    /// Measuring feed, mm/min.
    pub feed_mm_per_min: f64,
    /// From the signal to the position that the control keeps, ms.
    pub delay_ms: f64,
    /// Standard deviation of a touch, µm (maker's sheets state twice of it).
    pub repeatability_um: f64,
    /// Increment in which the control keeps X, µm (radius).
    pub resolution_um: f64,
    /// How far beyond the expected surface a probing move goes on, mm (radial).
    pub reach_mm: f64,
    /// Temperatures.
    pub temperature: ProbeTemperature,
    /// Standard uncertainty of the ball's height beside the spindle's axis, µm.
    pub u_height_um: f64,
    /// Standard uncertainty of where the part's axis lies along x, beside where the masters' lay,
    /// µm: sag, tailstock. Counts where one side is touched.
    pub u_axis_um: f64,
    /// Standard uncertainty of the guideway's straightness along x between masters and part, µm.
    /// Counts where one side is touched: tool and probe ride on the same guideway, so that its
    /// error is cut and not seen.
    pub u_guideway_um: f64,
    /// Standard uncertainty of the drift of the machine's X since the calibration, µm. Counts where
    /// one side is touched.
    pub u_drift_um: f64,
    /// Compliance of the part where it is softest, µm/N: it yields to the touch, more than a master
    /// does.
    pub part_yield_um_per_n: f64,
}

impl Default for ProbeSettings {
    fn default() -> Self {
        Self {
            stylus: Stylus::default(),
            sides: Sides::default(),
            angles: 2,
            master_diameters: 6,
            ball_mm: 6.0,
            stylus_mm: 50.0,
            stem_mm: 4.0,
            modulus_n_per_mm2: 5.5e5,
            spring_n: 5.5,
            seat_radius_mm: 9.0,
            lobe_deg: 0.0,
            feed_mm_per_min: 50.0,
            delay_ms: 5.0,
            repeatability_um: 0.5,
            resolution_um: 0.5,
            reach_mm: 1.0,
            temperature: ProbeTemperature::default(),
            u_height_um: 50.0,
            u_axis_um: 0.3,
            u_guideway_um: 0.3,
            u_drift_um: 0.3,
            part_yield_um_per_n: 0.0,
        }
    }
}

impl ProbeSettings {
    /// Checks the table.
    ///
    /// # Errors
    /// Names the key and what would be right.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        let two_at_tip = self.sides == Sides::Two && self.stylus == Stylus::AlongX;
        let right =
            "one with stylus = \"along_x\": its tip does not reach the far side; along_y or along_z does";
        require(!two_at_tip, "probe.sides", 2.0, right)?;
        let count = |key, value: usize, least: usize, right| {
            require((least..=360).contains(&value), key, value as f64, right)
        };
        count("probe.angles", self.angles, 2, "2 to 360: one has no scatter to state an uncertainty by")?;
        count("probe.master_diameters", self.master_diameters, 2, "2 to 360")?;
        let lengths = [
            ("probe.ball_mm", self.ball_mm),
            ("probe.stylus_mm", self.stylus_mm),
            ("probe.stem_mm", self.stem_mm),
            ("probe.modulus_n_per_mm2", self.modulus_n_per_mm2),
            ("probe.spring_n", self.spring_n),
            ("probe.seat_radius_mm", self.seat_radius_mm),
            ("probe.feed_mm_per_min", self.feed_mm_per_min),
            ("probe.repeatability_um", self.repeatability_um),
            ("probe.reach_mm", self.reach_mm),
        ];
        for (key, value) in lengths {
            require(value > 0.0 && value.is_finite(), key, value, "above 0")?;
        }
        let t = &self.temperature;
        let not_negative = [
            ("probe.delay_ms", self.delay_ms),
            ("probe.resolution_um", self.resolution_um),
            ("probe.u_height_um", self.u_height_um),
            ("probe.u_axis_um", self.u_axis_um),
            ("probe.u_guideway_um", self.u_guideway_um),
            ("probe.u_drift_um", self.u_drift_um),
            ("probe.part_yield_um_per_n", self.part_yield_um_per_n),
            ("probe.temperature.u_k", t.u_k),
            ("probe.temperature.expansion_um_per_m_k", t.expansion_um_per_m_k),
        ];
        for (key, value) in not_negative {
            require(value >= 0.0 && value.is_finite(), key, value, "0 or more")?;
        }
        let right = "a temperature of -20 to 80 °C";
        require((-20.0..=80.0).contains(&t.part_c), "probe.temperature.part_c", t.part_c, right)?;
        require((-20.0..=80.0).contains(&t.master_c), "probe.temperature.master_c", t.master_c, right)?;
        require(self.lobe_deg.is_finite(), "probe.lobe_deg", self.lobe_deg, "an angle in degrees")
    }
}
