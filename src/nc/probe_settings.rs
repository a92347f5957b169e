//! The `[nc.probe]` table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::setting::{SettingError, require};

/// A length beyond all dimensions of a lathe, mm.
pub(super) const FAR_MM: f64 = 1e4;

/// `[nc.probe]`: what a program needs to know of the probe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NcProbe {
    /// Tool number of the probe, 1-99; on fanuc and gsk its offset has the same number.
    pub tool: u32,
    /// X that a touch reads on a master less the master's diameter, mm: setting and pre-travel,
    /// from a calibration at the measuring feed.
    pub correction_mm: f64,
    /// Expanded uncertainty (k = 2) of a probed diameter, mm: taken off both limits of the
    /// tolerance (ISO 14253-1).
    pub expanded_u_mm: f64,
    /// Diameter of the ball, mm.
    #[serde(default = "ball")]
    pub ball_mm: f64,
    /// Measuring feed, mm/min.
    #[serde(default = "feed")]
    pub feed_mm_per_min: f64,
    /// How far below the expected surface a probing move ends where nothing is touched, mm
    /// (radial): less than the stylus may be deflected.
    #[serde(default = "reach")]
    pub reach_mm: f64,
    /// Diameter of the stem, mm.
    #[serde(default = "stem")]
    pub stem_mm: f64,
    /// From the lowest point of the ball to the probe's body, mm (radial).
    #[serde(default = "stylus")]
    pub stylus_mm: f64,
    /// Diameter of the body, mm.
    #[serde(default = "body")]
    pub body_mm: f64,
    /// Variable in which the control leaves X of the touch: #5061 of fanuc; gsk has no default;
    /// 5061 of linuxcnc is fixed.
    #[serde(default)]
    pub skip_variable: Option<u32>,
    /// Whether programs take the correction that the qualification left in #880, instead of
    /// `correction_mm`, and stop where no qualification of this probe has run.
    #[serde(default)]
    pub stored_correction: bool,
    /// The reference that the qualification (`--form qualify`) touches.
    #[serde(default)]
    pub reference: Option<ProbeReference>,
}

/// `[nc.probe.reference]`: a ring, disc or cylinder of known diameter in the part's place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeReference {
    /// Certified outer diameter, mm.
    pub diameter_mm: f64,
    /// From the face that clamps it to its end face, mm.
    pub length_mm: f64,
    /// Where it is touched; half its length by default, mm.
    #[serde(default)]
    pub z_mm: Option<f64>,
    /// Touches at an angle of the spindle, 2 to 9.
    #[serde(default = "touches")]
    pub touches: u32,
}

fn touches() -> u32 {
    // the relative uncertainty of a standard deviation of five is about a third, 1/√(2(n − 1))
    5
}

impl ProbeReference {
    fn validate(&self) -> Result<(), SettingError> {
        let lengths = [
            ("nc.probe.reference.diameter_mm", self.diameter_mm),
            ("nc.probe.reference.length_mm", self.length_mm),
        ];
        for (key, value) in lengths {
            require(value > 0.0 && value < FAR_MM, key, value, "a length above 0 mm")?;
        }
        let (z, touches) = (self.z_mm(), f64::from(self.touches));
        let right = "within the reference's length";
        require(z > 0.0 && z < self.length_mm, "nc.probe.reference.z_mm", z, right)?;
        require((2.0..=9.0).contains(&touches), "nc.probe.reference.touches", touches, "2 to 9")
    }

    /// Where it is touched, mm.
    pub(super) fn z_mm(&self) -> f64 {
        self.z_mm.unwrap_or(0.5 * self.length_mm)
    }
}

fn ball() -> f64 {
    6.0
}

fn feed() -> f64 {
    50.0
}

fn reach() -> f64 {
    1.0
}

fn stem() -> f64 {
    4.0
}

fn stylus() -> f64 {
    50.0
}

fn body() -> f64 {
    40.0
}

impl NcProbe {
    pub(super) fn validate(&self, turning_tool: u32, correction_limit_mm: f64) -> Result<(), SettingError> {
        let tool = f64::from(self.tool);
        let other = (1..=99).contains(&self.tool) && self.tool != turning_tool;
        require(other, "nc.probe.tool", tool, "a number of 1 to 99 that is not nc.tool")?;
        let size = self.correction_mm.abs();
        let small = "a length of -1 to 1 mm: set the probe's X nearer";
        require(size <= 1.0, "nc.probe.correction_mm", self.correction_mm, small)?;
        let u = self.expanded_u_mm;
        require(u > 0.0 && u <= 0.1, "nc.probe.expanded_u_mm", u, "a length above 0 up to 0.1 mm")?;
        let right = "a feed of 1 to 2000 mm/min";
        let feed = self.feed_mm_per_min;
        require((1.0..=2000.0).contains(&feed), "nc.probe.feed_mm_per_min", feed, right)?;
        // a move without a touch must end outside the range in which a result is accepted
        let least = 0.75 * correction_limit_mm;
        let right = "at least 0.75 of nc.correction_limit_mm, at most 5 mm";
        let reach = self.reach_mm;
        require(reach >= least && reach <= 5.0, "nc.probe.reach_mm", reach, right)?;
        let lengths = [
            ("nc.probe.ball_mm", self.ball_mm),
            ("nc.probe.stem_mm", self.stem_mm),
            ("nc.probe.body_mm", self.body_mm),
        ];
        for (key, value) in lengths {
            require(value > 0.0 && value <= 200.0, key, value, "a length above 0 up to 200 mm")?;
        }
        self.reference.map_or(Ok(()), |reference| reference.validate())?;
        let long = self.stylus_mm > self.ball_mm && self.stylus_mm <= 500.0;
        require(long, "nc.probe.stylus_mm", self.stylus_mm, "a length above nc.probe.ball_mm")
    }
}
