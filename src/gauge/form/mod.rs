//! Form: reference circles, lines and cylinders, and the form of a section from the silhouettes of
//! a revolution.
//!
//! Everything here is a pure function over points or readings; units are those of the input (mm or
//! px), and a result in mm follows from points in mm. Reference features follow ISO 12181
//! (roundness), ISO 12780 (straightness), ISO 12781 (flatness) and ISO 12180 (cylindricity); each
//! minimax feature comes with a [`Certificate`] that is computed from the points and the answer
//! alone, not by the solver. Sizes of a section by the same features (ISO 14405-1) are in `size`.
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
mod minimum_zone_cylinder;
mod plane;
mod profile_filter;
mod roundness;
mod run_out;
mod silhouette;
pub(crate) mod size;
mod taper;
mod turn;

pub use self::{
    certificate::Certificate,
    circle::{Circle, CircleFit},
    circumscribed_circle::minimum_circumscribed_circle,
    cylinder::{Cylinder, CylinderFit, circumscribed_cylinder, least_squares_cylinder, silhouette_cylinder},
    error::FormError,
    harmonics::{Origin, TurnHarmonics},
    inscribed_circle::maximum_inscribed_circle,
    least_squares_circle::{LeastSquaresCircle, least_squares_circle},
    line::{Line, LineFit, least_squares_line, minimum_zone_line},
    minimum_zone_circle::minimum_zone_circle,
    taper::{Taper, taper},
};
#[cfg(test)]
pub(crate) use circumscribed_circle::certify_circumscribed;
pub(crate) use harmonics::harmonics;
#[cfg(test)]
pub(crate) use inscribed_circle::certify_inscribed;
#[cfg(test)]
pub(crate) use least_squares_circle::certify_least_squares;
#[cfg(test)]
pub(crate) use line::certify_minimum_zone_line;
#[cfg(test)]
pub(crate) use minimum_zone_circle::certify_minimum_zone;
pub(crate) use minimum_zone_cylinder::minimum_zone_cylinder;
#[cfg(test)]
pub(crate) use plane::{Plane, certify_minimum_zone_plane};
pub(crate) use plane::{least_squares_plane, minimum_zone_plane};
#[cfg(test)]
pub(crate) use profile_filter::gaussian_transmission;
pub(crate) use profile_filter::{Cutoff, gaussian_closed};
pub(crate) use roundness::{Reference, StraightnessReference, roundness, straightness};
pub(crate) use run_out::{circular_run_out, total_run_out};
pub(crate) use silhouette::polar_profile;
#[cfg(test)]
pub(crate) use silhouette::{hull_from_support, hull_limit};
pub(crate) use turn::Turn;
