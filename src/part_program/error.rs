//! Why no program is written for a part.

use crate::nc::NcError;
use crate::setting::SettingError;
use crate::tool::ToolError;

/// A part, a tool and a machine that make no program.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum PartProgramError {
    /// A setting out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A tool that does not cut this part.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// A program that cannot be written.
    #[error(transparent)]
    Nc(#[from] NcError),
    /// Nothing of the part stands out of the grip.
    #[error(
        "the part's end at Z {end_mm:.3} mm lies in the grip, which reaches to Z {least_mm} mm (least_z_mm): let it stand \
         out further (--from-z)"
    )]
    InGrip {
        /// Z of its end, mm.
        end_mm: f64,
        /// Z to which the grip reaches, mm.
        least_mm: f64,
    },
    /// An outline that is no row of corners.
    #[error(
        "at Z {z_mm:.3} mm: {why}; [shaft] contour takes lines, and arcs tangent to a line on both sides. `nc` writes a \
         program of this part all the same"
    )]
    NoCorners {
        /// Where, mm.
        z_mm: f64,
        /// Why.
        why: &'static str,
    },
    /// The bar is cut below the part.
    #[error("the program would cut {depth_mm:.4} mm of radius into the part at Z {z_mm:.3} mm")]
    Gouge {
        /// Where, mm.
        z_mm: f64,
        /// How deep, mm of radius.
        depth_mm: f64,
    },
}
