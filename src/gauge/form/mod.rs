//! Form: reference circles, lines and cylinders, and the form of a section from the silhouettes of
//! a revolution.
//!
//! Everything here is a pure function over points or readings; units are those of the input (mm or
//! px), and a result in mm follows from points in mm. Reference features follow ISO 12181
//! (roundness), ISO 12780 (straightness) and ISO 12180 (cylindricity); each minimax feature comes
//! with a [`Certificate`] that is computed from the points and the answer alone, not by the solver.
//! Sizes of a section by the same features (ISO 14405-1) are in [`size`].
//!
//! One more feature is one more file: the fit, its certificate, and a test that spoils the answer
//! and must be caught.

mod certificate;
mod circle;
mod circumscribed_circle;
mod cylinder;
mod error;
mod harmonics;
mod inscribed_circle;
mod least_squares_circle;
mod line;
mod linear_program;
mod minimum_zone_circle;
mod profile_filter;
mod roundness;
mod run_out;
mod silhouette;
pub mod size;
mod taper;
mod turn;

pub use certificate::Certificate;
pub use circle::{Circle, CircleFit};
pub use circumscribed_circle::{certify_circumscribed, minimum_circumscribed_circle};
pub use cylinder::{
    Cylinder, CylinderFit, circumscribed_cylinder, least_squares_cylinder, silhouette_cylinder,
};
pub use error::FormError;
pub use harmonics::{Harmonic, Origin, TurnHarmonics, harmonics};
pub use inscribed_circle::{certify_inscribed, maximum_inscribed_circle};
pub use least_squares_circle::{LeastSquaresCircle, certify_least_squares, least_squares_circle};
pub use line::{Line, LineFit, certify_minimum_zone_line, least_squares_line, minimum_zone_line};
pub use minimum_zone_circle::{certify_minimum_zone, minimum_zone_circle};
pub use profile_filter::{Cutoff, gaussian_closed, gaussian_transmission};
pub use roundness::{Reference, Roundness, Straightness, StraightnessReference, roundness, straightness};
pub use run_out::{circular_run_out, total_run_out};
pub use silhouette::{HullPoint, hull_from_support, hull_limit, polar_profile};
pub use taper::{Taper, taper};
pub use turn::Turn;
