//! The turning process: force law, beam deflection, and the pass that turns one shaft into the
//! next.
//!
//! [`TurningProcess`] holds the workpiece. `TurningProcess::cut` takes the commanded diameters
//! b(z) and returns the shaft that remains: the shaft yields by u(z), D(z) = b(z) + 2u(z), and the
//! force that bends it follows from the actual depth of cut. Measured diameters have no part in it.
//!
//! From the tool to the part: `tool` and `tool_factors`, `material`, the force laws (`force`,
//! `kienzle`, with `force_components`), the beam (`beam`, `line`, `fem`, `stepped`: different
//! methods), `bending` (the supported shaft under all loads), `disturbance`, `texture`, `grid` (the
//! nodes along plain and stepped shafts), `envelope` (the surface that a measured nose leaves on
//! its path), `path_displacement` (a lathe's errors, by interface) and `turning`, which joins them
//! in a pass. `settings` is the `[process]` table. A new force law is a variant of `ForceLaw`; a
//! new cause of error a table of `settings` and a term in `turning`.

pub(crate) mod beam;
pub(crate) mod bending;
mod check;
mod cut;
mod disturbance;
mod envelope;
pub(crate) mod fem;
pub(crate) mod fit;
mod force;
mod force_components;
pub(crate) mod geometry;
mod grid;
pub(crate) mod kienzle;
pub(crate) mod line;
pub(crate) mod material;
mod path_displacement;
mod random;
mod section;
mod settings;
pub(crate) mod stepped;
mod texture;
mod tool;
pub(crate) mod tool_factors;
mod turning;

pub use self::{
    bending::BendingSettings,
    disturbance::{DisturbanceSettings, GuidewayPoint},
    force::{FittedRange, ForceLaw, PowerLaw},
    settings::{BelowMinimumChip, MaterialSettings, ProcessSettings, SteadyRestSettings, SupportSettings},
    tool::ToolSettings,
    turning::{BaseForm, ProcessError, Stock, TurningProcess},
};
pub(crate) use crate::plan::FeedDirection;
pub(crate) use envelope::NosePath;
#[cfg(test)]
pub(crate) use force::DepthLaw;
pub(crate) use force::FITTED_TO;
pub(crate) use force_components::Components;
pub(crate) use path_displacement::{PathDisplacement, PathPlace};
pub(crate) use section::Section;
pub(crate) use turning::followed::{Contributions, FollowedPass};
