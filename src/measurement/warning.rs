//! What a frame's measurement warns of.

use std::fmt;

use serde::{Serialize, Serializer};

use crate::gauge::calibration::BenchError;
use crate::gauge::{FrameEdges, ShadowsSeen, Which};
use crate::profile::Reason;

/// Share of the columns, 1 in so many, above which steep flanks are warned of: fewer are the ends
/// of a part.
const STEEP: usize = 20;

/// A warning on a frame. Its JSON is its text.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// A shadow as large as the measured one was left out.
    LeftOut {
        /// The shadows.
        seen: ShadowsSeen,
        /// Whether the one measured was stated.
        stated: bool,
    },
    /// Light inside the measured shadow.
    LightInside(ShadowsSeen),
    /// Flanks that are too steep to be measured.
    Steep {
        /// Columns with such flanks.
        steep: usize,
        /// Columns of the frame.
        columns: usize,
    },
    /// The frame was measured as crests and roots.
    Crests {
        /// Their pitch, px.
        pitch_px: f64,
    },
    /// The blur differs from the masters'.
    Blur(BenchError),
    /// The largest diameter or its uncertainty is no number.
    NoNumber,
}

impl Warning {
    /// Whether it is about the image, not about the diameter in millimetres.
    pub(crate) fn is_of_image(&self) -> bool {
        !matches!(self, Self::Blur(_) | Self::NoNumber)
    }

    /// The warnings on other shadows and on light inside the part.
    pub(super) fn of_shadows(seen: &ShadowsSeen, which: Option<Which>) -> impl Iterator<Item = Self> + use<> {
        let left_out = Self::LeftOut { seen: *seen, stated: which.is_some() };
        let beside = (seen.left_out_px > 0.0).then_some(left_out);
        beside.into_iter().chain((seen.joined > 1).then_some(Self::LightInside(*seen)))
    }

    /// The warning on steep flanks.
    pub(super) fn of_flanks(edges: &FrameEdges) -> Option<Self> {
        let is_steep =
            |c: &usize| [&edges.top[*c], &edges.bottom[*c]].iter().any(|e| e.reason() == Some(Reason::Steep));
        let steep = (0..edges.columns()).filter(is_steep).count();
        (steep * STEEP > edges.columns()).then(|| Self::Steep { steep, columns: edges.columns() })
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LeftOut { seen, stated } => left_out(f, seen, *stated),
            Self::LightInside(seen) => write!(
                f,
                "{} dark strips with about {:.0} px of light between them were measured as one part, from the first edge to the last; \
                 --which 1, 2 ... measures one of them",
                seen.joined, seen.light_inside_px
            ),
            Self::Steep { steep, columns } => write!(
                f,
                "{steep} of {columns} columns show flanks steeper than 45° (threads, shoulders, chamfers), which are not measured; crests and \
                 cylinders between them are"
            ),
            Self::Crests { pitch_px } => write!(
                f,
                "crests and roots every {pitch_px:.1} px (a thread, a knurl): the largest diameter is that of the crests, the distance of their \
                 tangents; no column was refused as dirt"
            ),
            Self::Blur(error) => error.fmt(f),
            Self::NoNumber => f.write_str("its diameter or uncertainty is no number: it has no diameter"),
        }
    }
}

fn left_out(f: &mut fmt::Formatter<'_>, seen: &ShadowsSeen, stated: bool) -> fmt::Result {
    let (row, size) = (seen.left_out_row_px, seen.left_out_px);
    write!(
        f,
        "{} shadows lie in the field and number {} from the top was measured; one about {size:.0} px thick at row {row:.0} was left out",
        seen.seen, seen.measured
    )?;
    if stated {
        return Ok(());
    }
    f.write_str(
        "; --which largest, nearest-centre, outermost or 1, 2 ... (from the top) states which is meant",
    )
}

impl Serialize for Warning {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
