//! A shaft: radius over z and θ, form errors, axis and pose. Describes; computes nothing an instrument could peek at.
//!
//! r(z,θ) = R(z) + Σ_{k≥2} a_k cos(k(θ - θ_k)) + texture(z,θ), θ the body angle from x towards y; eccentricity
//! (k = 1), bow and deflection move the axis c(z,φ), φ the spindle angle: a body point θ stands at machine angle
//! θ + φ. Eccentricity and bow turn with the body; deflection and pose do not.

/// A point of the mean radius profile R(z); between knots R is linear, beyond the ends constant.
/// Two knots at the same z make a shoulder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileKnot {
    /// Machine z, mm from the chuck face.
    pub z_mm: f64,
    /// Mean radius R, mm.
    pub radius_mm: f64,
}

/// A lobing term a_k cos(k(θ - θ_k)) of the radius.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lobe {
    /// Undulations per revolution k, at least 2.
    pub order_upr: u32,
    /// Amplitude a_k, mm.
    pub amplitude_mm: f64,
    /// Phase θ_k, degrees.
    #[serde(default)]
    pub phase_deg: f64,
}

/// Residual heights of the surface over a regular grid in z and θ, added to the radius.
///
/// Bilinear between nodes, periodic in θ, constant beyond the ends in z.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTexture {
    /// Machine z of the first row of nodes, mm.
    pub z0_mm: f64,
    /// Distance of node rows along z, mm.
    pub step_mm: f64,
    /// Nodes around the circumference; node j stands at θ = 2πj/n.
    pub nodes_theta: usize,
    /// Heights in mm, row after row along z, `nodes_theta` a row.
    pub height_mm: Vec<f32>,
}

/// Offset of the axis at a z; linear between knots, constant beyond the ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisKnot {
    /// Machine z, mm.
    pub z_mm: f64,
    /// Offset along x (up in the image), mm.
    pub x_mm: f64,
    /// Offset along y (towards the camera), mm.
    pub y_mm: f64,
}

/// Offset of the whole body from the axis of rotation; turns with the spindle.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, default)]
pub struct Eccentricity {
    /// Amplitude, mm.
    pub amplitude_mm: f64,
    /// Body angle of the offset, degrees.
    pub phase_deg: f64,
}

/// How the axis of rotation lies in the camera's field.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, default)]
pub struct Pose {
    /// Height of the axis above the optical axis, mm.
    pub x_mm: f64,
    /// Tilt in the image plane: rise of the axis along z, mrad.
    pub tilt_mrad: f64,
}

/// A shaft as it turns in the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Shaft {
    /// Mean radius over z; sorted by z, at least one knot.
    pub profile: Vec<ProfileKnot>,
    /// Lobing terms, constant along z.
    pub lobes: Vec<Lobe>,
    /// Residual surface heights.
    pub texture: Option<SurfaceTexture>,
    /// Offset that turns with the spindle.
    pub eccentricity: Eccentricity,
    /// Bow of the body's own axis; turns with the spindle. Sorted by z; empty for a straight body.
    pub bow: Vec<AxisKnot>,
    /// Deflection of the axis in the machine's frame (sag, cutting force); does not turn. Sorted by z.
    pub deflection: Vec<AxisKnot>,
    /// How the axis of rotation lies in the field.
    pub pose: Pose,
}

impl Shaft {
    /// A perfect, straight, centred cylinder: a master pin.
    pub fn cylinder(diameter_mm: f64) -> Self {
        Self {
            profile: vec![ProfileKnot { z_mm: 0.0, radius_mm: diameter_mm / 2.0 }],
            lobes: Vec::new(),
            texture: None,
            eccentricity: Eccentricity::default(),
            bow: Vec::new(),
            deflection: Vec::new(),
            pose: Pose::default(),
        }
    }
}

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
}

impl Default for TextureForm {
    fn default() -> Self {
        Self { rms_um: 0.4, correlation_z_mm: 0.5, correlation_theta_deg: 2.0 }
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

/// A deflection of the axis in the machine's frame, half a sine wave over the part's length; does not turn.
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
}
