//! The `[gauge]` table: what a user may choose about the instrument. Nothing here describes the
//! scene.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::gauge::limit::limits;
use crate::setting::{SettingError, within};

limits! {
    /// Settings that no image can have.
    SettingLimits = "settings";
    /// Farthest sample of a table, px: twice the half of the longest window.
    farthest_px: f64 = 256.0;
}

/// Settings of the gauge. Blur, levels and noise are estimated from each frame unless given here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GaugeSettings {
    /// Whether the part is darker or brighter than its surroundings.
    pub polarity: Polarity,
    /// Smallest shadow taken for a part, px across; anything smaller is dirt. At least 4.
    pub min_diameter_px: f64,
    /// Which of several shadows is the part; without it the largest, a bright line inside it
    /// spanned, and a frame in which two equal shadows may be the walls of one tube refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub which: Option<Which>,
    /// Least contrast A/σ_n at mid-edge for which edges are measured. At least 4.
    pub min_snr: f64,
    /// Steepest edge measured, as |d row / d column|. Above 0, at most 3.
    pub max_slope: f64,
    /// Probability that a good column fails the residual test. 1e-12 ..= 0.01.
    pub residual_false_alarm: f64,
    /// Largest departure of an edge from its neighbours' local line, px, beyond six standard
    /// uncertainties. It must exceed the roughness of the surfaces measured. Above 0.
    pub outlier_px: f64,
    /// Largest rms residual that the edge model may leave in the best fitting fifth of a frame's
    /// columns, as a share of the contrast, where noise does not explain it; beyond it the frame is
    /// refused. Above 0, at most 1.
    pub max_residual_rel: f64,
    /// Whether contaminated columns are refused.
    pub rejection: Rejection,
    /// The edge-spread function that is fitted.
    pub esf: EsfModel,
    /// How bright and dark levels are found.
    pub levels: Levels,
    /// How the edge blur is found.
    pub blur: Blur,
    /// How the noise is found.
    pub noise: Noise,
    /// What a station needs to be given a diameter.
    pub station: StationSettings,
    /// What a station may depart from earlier turns and passes.
    pub plausibility: PlausibilitySettings,
}

impl Default for GaugeSettings {
    fn default() -> Self {
        Self {
            polarity: Polarity::DarkOnBright,
            min_diameter_px: 24.0,
            which: None,
            min_snr: 6.0,
            max_slope: 1.0,
            residual_false_alarm: 1e-5,
            outlier_px: 1.5,
            max_residual_rel: 0.08,
            rejection: Rejection::default(),
            esf: EsfModel::default(),
            levels: Levels::default(),
            blur: Blur::default(),
            noise: Noise::default(),
            station: StationSettings::default(),
            plausibility: PlausibilitySettings::default(),
        }
    }
}

/// Which side of the edge is the part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Polarity {
    /// A shadow in back light.
    #[default]
    DarkOnBright,
    /// A lit part before a dark ground.
    BrightOnDark,
}

/// Which of several shadows is measured. All count that have both edges in the field, run along
/// half of the largest one's columns or more, and are at least `min_diameter_px` thick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Which {
    /// The one of the largest area; a bright line parts it from its other half.
    Largest,
    /// The one whose middle lies nearest to the middle of the field.
    NearestCentre,
    /// From the first edge of the first one to the last edge of the last one: the walls of a tube.
    Outermost,
    /// The n-th from the top. 1 or more.
    Number(#[schemars(range(min = 1))] u16),
}

/// What becomes of columns whose edge noise and neighbours do not explain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rejection {
    /// Refused by residual, levels, neighbours along the shaft and the axis: an edge that leaves
    /// its place while the other one does not is contamination of the part. Where the part itself
    /// is one-sided (keyways, flats, threads), take `by_edge`.
    #[default]
    Full,
    /// Refused by residual, levels and neighbours, each edge by itself.
    ByEdge,
    /// Kept, whatever they show: for comparisons.
    Off,
}

/// The edge-spread function that is fitted to every edge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum EsfModel {
    /// Gaussian blur.
    Gaussian {},
    /// As measured or computed: light over the distance from the geometric edge. Its width is
    /// scaled to the frame's blur.
    Table(EsfSamples),
    /// That of the job's own optics (`[optics.esf]`), in focus on the finished part: a table is
    /// made of it where a job or a calibration with `[simulate]` is read; a gauge by itself has no
    /// optics to ask.
    Optics {},
    /// Learnt from the first frame of a stream, where both edges travel through all sub-pixel
    /// phases; else the Gaussian. It has no absolute zero: calibrate with it.
    Learnt {},
}

impl EsfModel {
    /// Its name, as in `[gauge.esf]`.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Gaussian {} => "gaussian",
            Self::Table(_) => "table",
            Self::Learnt {} => "learnt",
            Self::Optics {} => "optics",
        }
    }
}

impl Default for EsfModel {
    fn default() -> Self {
        Self::Gaussian {}
    }
}

/// An edge-spread function as samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EsfSamples {
    /// Distances from the geometric edge into the light, px, rising. 8 or more.
    pub distance_px: Vec<f64>,
    /// Light there as a share of the bright field: 0 at the first and 1 at the last distance,
    /// within 0.02.
    pub light: Vec<f64>,
}

/// Levels of light and shadow beside each edge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Levels {
    /// A piecewise linear curve along the shaft with as many knots as the frame's own data support.
    Pooled {
        /// Most knots tried. 2 ..= 64.
        max_knots: usize,
    },
    /// Every column by itself: costs 12-19 % in uncertainty, assumes nothing.
    PerColumn {},
}

impl Default for Levels {
    fn default() -> Self {
        Self::Pooled { max_knots: 64 }
    }
}

/// Blur of the edge (standard deviation of its Gaussian part, without the pixel's own area).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Blur {
    /// From the frame, smoothly along the shaft where the data support it.
    Estimated {},
    /// Known beforehand.
    Given {
        /// Standard deviation, px. 0.2 ..= 6.
        sigma_px: f64,
    },
}

impl Blur {
    /// The blur where it is given, px.
    pub(crate) fn given_px(&self) -> Option<f64> {
        match self {
            Self::Given { sigma_px } => Some(*sigma_px),
            Self::Estimated {} => None,
        }
    }
}

impl Default for Blur {
    fn default() -> Self {
        Self::Estimated {}
    }
}

/// Temporal noise of the sensor as a function of the grey level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Noise {
    /// Variance in light and in shadow from the frame's own flat regions, linear in between.
    Estimated {},
    /// From a photon transfer measurement (EMVA 1288): variance = gain·(level − black) + read².
    PhotonTransfer {
        /// System gain K, counts per electron. Above 0.
        gain_counts_per_electron: f64,
        /// Noise at black, counts, quantisation included. Above 0.
        read_noise_counts: f64,
        /// Grey value without light, counts.
        black_counts: f64,
    },
}

impl Default for Noise {
    fn default() -> Self {
        Self::Estimated {}
    }
}

/// What a station needs to be given a diameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StationSettings {
    /// Least fraction of the station's columns that must be measured, averaged over its frames.
    /// Above 0, at most 1.
    pub min_fill: f64,
    /// Least number of spindle angles. At least 1.
    pub min_angles: usize,
}

impl Default for StationSettings {
    fn default() -> Self {
        Self { min_fill: 0.25, min_angles: 1 }
    }
}

impl GaugeSettings {
    /// These settings for a part whose outline goes up and down by itself (threads, knurls): flanks
    /// to 71° are measured, and nothing is refused for leaving its neighbours or the axis.
    #[must_use]
    pub(crate) fn for_crests(self) -> Self {
        Self { rejection: Rejection::Off, max_slope: 3.0, outlier_px: 1e3, ..self }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// Names the first key out of its range and what would be right.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        within("gauge.min_diameter_px", self.min_diameter_px, 4.0, 1e5, "4 or more pixels")?;
        within("gauge.min_snr", self.min_snr, 4.0, 1e6, "4 or more")?;
        within("gauge.max_slope", self.max_slope, 1e-3, 3.0, "0.001 to 3")?;
        within("gauge.residual_false_alarm", self.residual_false_alarm, 1e-12, 0.01, "1e-12 to 0.01")?;
        within("gauge.outlier_px", self.outlier_px, 1e-3, 1e4, "a departure in pixels above 0.001")?;
        within("gauge.max_residual_rel", self.max_residual_rel, 1e-9, 1.0, "a share above 0, at most 1")?;
        within("gauge.station.min_fill", self.station.min_fill, 1e-6, 1.0, "a fraction above 0, at most 1")?;
        within("gauge.station.min_angles", self.station.min_angles as f64, 1.0, 1e9, "1 or more")?;
        if let Levels::Pooled { max_knots } = self.levels {
            within("gauge.levels.pooled.max_knots", max_knots as f64, 2.0, 64.0, "2 to 64")?;
        }
        if let Blur::Given { sigma_px } = self.blur {
            within("gauge.blur.given.sigma_px", sigma_px, 0.2, 6.0, "0.2 to 6 px")?;
        }
        if let Some(Which::Number(number)) = self.which {
            within(
                "gauge.which.number",
                f64::from(number),
                1.0,
                65_535.0,
                "1 for the uppermost shadow, or more",
            )?;
        }
        self.esf.validate()?;
        self.plausibility.validate()?;
        self.noise.validate()
    }
}

impl EsfModel {
    fn validate(&self) -> Result<(), SettingError> {
        let limits = SettingLimits::get();
        let Self::Table(EsfSamples { distance_px, light }) = self else { return Ok(()) };
        let refuse = |key: &str, value: f64, right: &str| Err(SettingError::of(key, value, right));
        if distance_px.len() < 8 || distance_px.len() > 100_000 {
            let right = "8 to 100000 samples";
            return refuse("gauge.esf.table.distance_px", distance_px.len() as f64, right);
        }
        if light.len() != distance_px.len() {
            return refuse("gauge.esf.table.light", light.len() as f64, "as many values as distance_px has");
        }
        for pair in distance_px.windows(2) {
            if !(pair[1] > pair[0]
                && pair[0].abs() <= limits.farthest_px
                && pair[1].abs() <= limits.farthest_px)
            {
                return refuse(
                    "gauge.esf.table.distance_px",
                    pair[1],
                    "rising distances within 256 px of the edge",
                );
            }
        }
        if let Some(bad) = light.iter().find(|l| !(-0.5..=2.0).contains(*l)) {
            return refuse("gauge.esf.table.light", *bad, "shares of the bright field, about 0 to 1");
        }
        let (first, last) = (light[0], light[light.len() - 1]);
        if !(first.abs() <= 0.02) {
            return refuse("gauge.esf.table.light", first, "0 at the first distance, within 0.02");
        }
        within("gauge.esf.table.light", last, 0.98, 1.02, "1 at the last distance, within 0.02")?;
        let (a, b) = (distance_px[0], distance_px[distance_px.len() - 1]);
        if !(a < 0.0 && b > 0.0) {
            return refuse("gauge.esf.table.distance_px", a, "distances to both sides of the edge at 0");
        }
        Ok(())
    }
}

impl EsfSamples {
    /// Light at a distance, px: a cubic through the samples, 0 before and 1 after them.
    pub(crate) fn at(&self, distance_px: f64) -> f64 {
        let (d, l) = (&self.distance_px, &self.light);
        let n = d.len();
        if distance_px <= d[0] {
            return 0.0;
        }
        if distance_px >= d[n - 1] {
            return 1.0;
        }
        let k = d.partition_point(|x| *x <= distance_px).clamp(1, n - 1) - 1;
        // Slopes of the parabola through three neighbours.
        let slope = |i: usize| {
            if i == 0 || i == n - 1 {
                return 0.0;
            }
            let (h0, h1) = (d[i] - d[i - 1], d[i + 1] - d[i]);
            (h1 * (l[i] - l[i - 1]) / h0 + h0 * (l[i + 1] - l[i]) / h1) / (h0 + h1)
        };
        let h = d[k + 1] - d[k];
        let t = (distance_px - d[k]) / h;
        let (da, db) = (h * slope(k), h * slope(k + 1));
        let rise = l[k + 1] - l[k];
        l[k] + t * (da + t * (3.0 * rise - 2.0 * da - db + t * (da + db - 2.0 * rise)))
    }

    /// Farthest distance, px.
    pub(crate) fn reach_px(&self) -> f64 {
        self.distance_px[0].abs().max(self.distance_px[self.distance_px.len() - 1])
    }
}

impl Noise {
    fn validate(self) -> Result<(), SettingError> {
        let Self::PhotonTransfer { gain_counts_per_electron: gain, read_noise_counts: read, black_counts } =
            self
        else {
            return Ok(());
        };
        let above = "above 0";
        within("gauge.noise.photon_transfer.gain_counts_per_electron", gain, 1e-9, 1e6, above)?;
        within("gauge.noise.photon_transfer.read_noise_counts", read, 1e-9, 1e6, above)?;
        within("gauge.noise.photon_transfer.black_counts", black_counts, -1e6, 1e6, "a grey value")
    }
}

/// What a station may depart from earlier turns and passes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlausibilitySettings {
    /// Largest change of a diameter from turn to turn, mm. Nothing is cut meanwhile: 5 µm are 17 K
    /// on 25 mm of steel. Above 0.
    pub turn_limit_mm: f64,
    /// Largest departure of a diameter's change from pass to pass from the change commanded, mm: by
    /// how much more or less than before the shaft yields. Above 0.
    pub pass_limit_mm: f64,
    /// Standard uncertainties by which a change must also exceed what noise explains. 1 ..= 10.
    pub coverage: f64,
}

impl Default for PlausibilitySettings {
    fn default() -> Self {
        Self { turn_limit_mm: 0.005, pass_limit_mm: 0.05, coverage: 4.0 }
    }
}

impl PlausibilitySettings {
    /// Checks every range.
    ///
    /// # Errors
    /// Names the key.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        within("gauge.plausibility.turn_limit_mm", self.turn_limit_mm, 1e-6, 1e3, "a change above 0, mm")?;
        within("gauge.plausibility.pass_limit_mm", self.pass_limit_mm, 1e-6, 1e3, "a departure above 0, mm")?;
        within("gauge.plausibility.coverage", self.coverage, 1.0, 10.0, "1 to 10")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_survive_toml() {
        let settings = GaugeSettings::default();
        settings.validate().unwrap();
        let text = toml::to_string(&settings).unwrap();
        assert_eq!(toml::from_str::<GaugeSettings>(&text).unwrap(), settings);
    }

    #[test]
    fn a_wrong_value_is_named_and_an_unknown_key_refused() {
        let settings = GaugeSettings { min_snr: 0.5, ..GaugeSettings::default() };
        assert_eq!(settings.validate().unwrap_err().key, "gauge.min_snr");
        assert!(toml::from_str::<GaugeSettings>("sigma = 1.0").is_err());
        let given: GaugeSettings = toml::from_str("[blur.given]\nsigma_px = 0.9").unwrap();
        assert_eq!(given.blur, Blur::Given { sigma_px: 0.9 });
    }
}
