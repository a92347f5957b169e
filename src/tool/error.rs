//! Why a nose cannot be compensated.

use glam::DVec2;

use crate::nose::NoseError;
use crate::setting::SettingError;

/// A nose, a tool and an outline that do not go together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum ToolError {
    /// A setting out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The file of a nose.
    #[error("{0}")]
    Nose(String),
    /// A row of a wear history.
    #[error("line {line}: {what}")]
    History {
        /// Its line, from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
    },
    /// Support values that are no nose.
    #[error("image {image}: {cause}")]
    Profile {
        /// Name of the image.
        image: String,
        /// Why.
        cause: NoseError,
    },
    /// A surface that the tool cannot cut.
    #[error(
        "{place}: its normal at {a_deg:.3}° cannot be the tool's: {what} from {low_deg:.3}° to {high_deg:.3}°. Cut this \
         place with a tool of other angles (kappa_r_deg, epsilon_r_deg), or change the part"
    )]
    Angle {
        /// Where.
        place: Place,
        /// Angle of the normal, degrees.
        a_deg: f64,
        /// What ends there.
        what: &'static str,
        /// Least angle, degrees.
        low_deg: f64,
        /// Largest angle, degrees.
        high_deg: f64,
    },
    /// A path that cuts into the part.
    #[error("{place}: a path that gouges: {why}")]
    Gouge {
        /// Where.
        place: Place,
        /// Why, and what would be right.
        why: String,
    },
    /// A register beyond what a control takes.
    #[error("register R = {radius_mm:.5} mm: the control takes {low_mm} to {high_mm} mm. {right}")]
    Register {
        /// Value wanted, mm.
        radius_mm: f64,
        /// Least value, mm.
        low_mm: f64,
        /// Largest value, mm.
        high_mm: f64,
        /// What would be right.
        right: &'static str,
    },
}

/// A place of an outline, for messages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place(pub DVec2);

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "at diameter {:.3} Z {:.3} mm", 2.0 * self.0.x, self.0.y)
    }
}
