//! The body: profile, lobes, texture, axis and pose, the input of the renderer.

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
    /// Tilt towards the camera: how the axis comes nearer along z, mrad, about the middle of the
    /// field (the carriage keeps the focus).
    pub tilt_to_camera_mrad: f64,
}

/// A wave of the radius along z, a·cos(2πz/λ + phase), the same all around.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxialWave {
    /// Wavelength λ, mm.
    pub wavelength_mm: f64,
    /// Amplitude a, mm.
    pub amplitude_mm: f64,
    /// Phase at z = 0, degrees.
    #[serde(default)]
    pub phase_deg: f64,
}

/// A plane cut parallel to the axis.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Flat {
    /// Where it begins, mm.
    pub from_mm: f64,
    /// Where it ends, mm.
    pub to_mm: f64,
    /// Distance of the plane from the body's axis, mm.
    pub distance_mm: f64,
    /// Body angle of its normal, degrees.
    #[serde(default)]
    pub angle_deg: f64,
}

/// A slot with parallel walls and a flat floor, along the axis.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Keyway {
    /// Where it begins, mm.
    pub from_mm: f64,
    /// Where it ends, mm.
    pub to_mm: f64,
    /// Distance of its walls, mm.
    pub width_mm: f64,
    /// Distance of its floor from the body's axis, mm.
    pub floor_mm: f64,
    /// Body angle of its middle, degrees.
    #[serde(default)]
    pub angle_deg: f64,
}

/// Part of a helix' profile: height c0 + c1 w + c2 w², mm, over the phase w past `from`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HelixPiece {
    /// Phase 0..1 at which it begins; it ends where the next one begins.
    pub from: f64,
    /// c0, c1, c2, mm.
    pub height_mm: [f64; 3],
}

/// Heights that climb along a helix: a thread (below the radius), feed marks (above it).
///
/// The phase is u = z/pitch ∓ starts·θ/2π modulo 1, minus for a right-handed helix.
#[derive(Clone, Debug, PartialEq)]
pub struct Helix {
    /// Where it begins, mm.
    pub from_mm: f64,
    /// Where it ends, mm.
    pub to_mm: f64,
    /// Distance of neighbouring turns along z, mm.
    pub pitch_mm: f64,
    /// Starts.
    pub starts: u32,
    /// Whether it climbs the other way.
    pub left_handed: bool,
    /// Pieces of one turn, ascending from phase 0.
    pub pieces: Vec<HelixPiece>,
}

/// Everything on a shaft beyond profile, lobes and texture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// Waves along z.
    pub waves: Vec<AxialWave>,
    /// Threads and feed marks; their heights add up.
    pub helices: Vec<Helix>,
    /// Flats.
    pub flats: Vec<Flat>,
    /// Keyways.
    pub keyways: Vec<Keyway>,
}

/// One harmonic of the synchronous error motion: x(φ) = x_um·cos(order·φ + x_phase), y likewise.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, default)]
pub struct SpindleHarmonic {
    /// Cycles per revolution.
    pub order: u32,
    /// Amplitude along x (up in the image), µm.
    pub x_um: f64,
    /// Phase of x at φ = 0, degrees.
    pub x_phase_deg: f64,
    /// Amplitude along y (towards the camera), µm.
    pub y_um: f64,
    /// Phase of y at φ = 0, degrees.
    pub y_phase_deg: f64,
}

/// Radial error motion of the axis of rotation (ISO 230-7).
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpindleMotion {
    /// What repeats every revolution.
    pub synchronous: Vec<SpindleHarmonic>,
    /// What does not: standard deviation along x and along y, µm, drawn anew for every frame.
    pub asynchronous_rms_um: f64,
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
    /// Deflection of the axis in the machine's frame (sag, cutting force); does not turn. Sorted by
    /// z.
    pub deflection: Vec<AxisKnot>,
    /// How the axis of rotation lies in the field.
    pub pose: Pose,
    /// Waves, threads, feed marks, flats and keyways.
    pub features: Features,
    /// Error motion of the spindle.
    pub spindle: SpindleMotion,
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
            features: Features::default(),
            spindle: SpindleMotion::default(),
        }
    }
}
