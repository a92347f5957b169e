//! What a user writes about a shaft: the `[shaft]` table.

use super::body::{AxialWave, Eccentricity, Flat, Keyway, Lobe, Pose, SpindleMotion};

/// Roughness and waviness to be drawn by seed: a Gaussian random field over z and θ.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TextureForm {
    /// Root mean square of the heights, µm.
    pub rms_um: f64,
    /// Distance along z over which the autocorrelation falls to 1/e, mm.
    pub correlation_z_mm: f64,
    /// Angle over which the autocorrelation falls to 1/e, degrees.
    pub correlation_theta_deg: f64,
    /// Spectrum along z.
    pub spectrum: TextureSpectrum,
}

/// Power spectral density of a surface profile along z, before it is scaled to the rms.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum TextureSpectrum {
    /// Gaussian autocorrelation exp(-(Δz/l)²), l = `correlation_z_mm`.
    #[default]
    Gaussian,
    /// Exponential autocorrelation exp(-|Δz|/l): S(f) ∝ 1/(1 + (2πlf)²).
    Exponential,
    /// S(f) ∝ f^-exponent between two wavelengths, level above the longest, nothing below the
    /// shortest.
    PowerLaw {
        /// Exponent: 0 white, 2 a random walk.
        exponent: f64,
        /// Longest wavelength, mm.
        longest_mm: f64,
        /// Shortest wavelength, mm.
        shortest_mm: f64,
    },
    /// S(f) linear between given points, nothing beyond them.
    Points {
        /// Frequencies along z, 1/mm, rising.
        per_mm: Vec<f64>,
        /// Density there, any unit.
        density: Vec<f64>,
    },
}

/// A corner of the shaft's contour, as on a drawing.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, default)]
pub struct ContourPoint {
    /// Machine z, mm; two points at the same z make a shoulder.
    pub z_mm: f64,
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Length cut off either line at this corner, mm: a chamfer.
    pub chamfer_mm: f64,
    /// Radius of the arc between both lines at this corner, mm: a rounding or a fillet.
    pub radius_mm: f64,
}

/// A thread cut into the shaft; the diameter it is cut into is its major diameter.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Thread {
    /// Where it begins, mm.
    pub from_mm: f64,
    /// Where it ends, mm.
    pub to_mm: f64,
    /// Distance of neighbouring turns, mm.
    pub pitch_mm: f64,
    /// Starts.
    pub starts: u32,
    /// Whether it climbs the other way.
    pub left_handed: bool,
    /// Angle between the flanks, degrees.
    pub included_angle_deg: f64,
    /// Width of the crest, mm; pitch/8 (ISO 68-1) when absent.
    pub crest_mm: Option<f64>,
    /// Depth, mm; 5/8 of the sharp triangle's height (ISO 68-1) when absent.
    pub depth_mm: Option<f64>,
}

impl Default for Thread {
    fn default() -> Self {
        Self {
            from_mm: 0.0,
            to_mm: 0.0,
            pitch_mm: 1.0,
            starts: 1,
            left_handed: false,
            included_angle_deg: 60.0,
            crest_mm: None,
            depth_mm: None,
        }
    }
}

/// The helix that a tool of round nose leaves: heights s²/2r over the radius, f²/8r at the crests.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FeedMarks {
    /// Feed f, mm per revolution.
    pub feed_mm: f64,
    /// Nose radius r, mm.
    pub nose_radius_mm: f64,
}

/// Thermal growth over 20 °C: radii and lengths from the chuck face on grow with the local rise.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Thermal {
    /// Rise at the chuck face, K.
    pub rise_at_chuck_k: f64,
    /// Rise at the part's end, K; linear between.
    pub rise_at_end_k: f64,
    /// Coefficient of linear expansion, µm/(m·K).
    pub expansion_um_per_m_k: f64,
}

impl Default for Thermal {
    /// Steel at 20 °C.
    fn default() -> Self {
        Self { rise_at_chuck_k: 0.0, rise_at_end_k: 0.0, expansion_um_per_m_k: 11.5 }
    }
}

impl Default for TextureForm {
    fn default() -> Self {
        Self {
            rms_um: 0.4,
            correlation_z_mm: 0.5,
            correlation_theta_deg: 2.0,
            spectrum: TextureSpectrum::Gaussian,
        }
    }
}

/// A bow of the body's own axis, half a sine wave over the part's length; turns with the spindle.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, default)]
pub struct Bow {
    /// Largest offset of the axis, mm.
    pub sagitta_mm: f64,
    /// Body angle of the offset, degrees.
    pub phase_deg: f64,
}

/// A deflection of the axis in the machine's frame, half a sine wave over the part's length; does
/// not turn.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, default)]
pub struct Deflection {
    /// Largest offset along x (up in the image), mm.
    pub sagitta_x_mm: f64,
    /// Largest offset along y (towards the camera), mm.
    pub sagitta_y_mm: f64,
}

/// Form errors and lie of a shaft as a user writes them: the `[shaft]` table.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShaftForm {
    /// Lobing terms, constant along z.
    pub lobes: Vec<Lobe>,
    /// Offset that turns with the spindle.
    pub eccentricity: Eccentricity,
    /// How the axis of rotation lies in the field.
    pub pose: Pose,
    /// Bow of the body's own axis.
    pub bow: Bow,
    /// Deflection of the axis in the machine's frame.
    pub deflection: Deflection,
    /// Roughness and waviness; none leaves the surface smooth.
    pub texture: Option<TextureForm>,
    /// Corners of the contour along z: steps, tapers, shoulders, chamfers, radii, grooves; none
    /// draws, and turns, a plain cylinder.
    pub contour: Vec<ContourPoint>,
    /// CSV file `z_mm,diameter_mm[,chamfer_mm,radius_mm]` beside the config; its points take its
    /// place in the resolved config.
    pub contour_file: Option<String>,
    /// Threads.
    pub threads: Vec<Thread>,
    /// Feed marks over the whole length.
    pub feed_marks: Option<FeedMarks>,
    /// Waves along z.
    pub waviness: Vec<AxialWave>,
    /// Flats.
    pub flats: Vec<Flat>,
    /// Keyways.
    pub keyways: Vec<Keyway>,
    /// Thermal growth.
    pub thermal: Thermal,
    /// Error motion of the spindle.
    pub spindle: SpindleMotion,
}

impl ShaftForm {
    /// The first key that describes a finished part beyond its contour rather than how a shaft lies
    /// in the machine: what a turning pass would cut away.
    pub(crate) fn finished_key(&self) -> Option<&'static str> {
        let keys = [
            (!self.threads.is_empty(), "shaft.threads"),
            (self.feed_marks.is_some(), "shaft.feed_marks"),
            (!self.waviness.is_empty(), "shaft.waviness"),
            (!self.flats.is_empty(), "shaft.flats"),
            (!self.keyways.is_empty(), "shaft.keyways"),
            (self.thermal != Thermal::default(), "shaft.thermal"),
        ];
        keys.into_iter().find(|(set, _)| *set).map(|(_, key)| key)
    }
}
