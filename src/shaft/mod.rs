//! A shaft: radius over z and θ, form errors, axis and pose. Data only: no computation here gives
//! an instrument access to true values.
//!
//! r(z,θ) = R(z) + Σ_{k≥2} a_k cos(k(θ - θ_k)) + texture(z,θ), θ the body angle from x towards y;
//! eccentricity (k = 1), bow and deflection move the axis c(z,φ), φ the spindle angle: a body point
//! θ is at machine angle θ + φ. Eccentricity and bow turn with the body; deflection, spindle error
//! and pose do not. Threads and feed marks are heights over the phase of a helix, flats and keyways
//! cut the slice. `form` is the `[shaft]` table of a config, `contour` turns its corners into a
//! profile.
//!
//! `body` is the input of renderer and process; a new form of the body is a field of [`Shaft`] or
//! `Features`, a table in `form`, and its place in `render::form` and `render::silhouette`.

mod body;
pub(crate) mod contour;
pub(crate) mod form;

pub use self::{
    body::{
        AxialWave, AxisKnot, Eccentricity, Features, Flat, Helix, HelixPiece, Keyway, Lobe, Pose,
        ProfileKnot, Shaft, SpindleHarmonic, SpindleMotion, SurfaceTexture,
    },
    form::{
        Bow, ContourPoint, Deflection, FeedMarks, ShaftForm, TextureForm, TextureSpectrum, Thermal, Thread,
    },
};
