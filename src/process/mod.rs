//! The turning process: force law, beam deflection, and the pass that turns one shaft into the
//! next.
//!
//! [`TurningProcess`] holds the workpiece. [`TurningProcess::cut`] takes the commanded diameters
//! b(z) and returns the shaft that remains: the shaft yields by u(z), D(z) = b(z) + 2u(z), and the
//! force that bends it follows from the actual depth of cut. Measured diameters have no part in it.
//!
//! From the tool to the part: `tool` and [`tool_factors`], [`material`], the force laws (`force`,
//! [`kienzle`], with `force_components`), the beam ([`beam`], `line`, [`fem`], [`stepped`]:
//! different methods), [`bending`] (the supported shaft under all loads), `disturbance`, `texture`,
//! and `turning`, which joins them in a pass. `settings` is the `[process]` table. A new force law
//! is a variant of [`ForceLaw`]; a new cause of error a table of `settings` and a term in
//! `turning`.

pub mod beam;
pub mod bending;
mod check;
mod cut;
mod disturbance;
pub mod fem;
pub mod fit;
mod force;
mod force_components;
pub mod geometry;
pub mod kienzle;
pub mod line;
pub mod material;
mod random;
mod section;
mod settings;
pub mod stepped;
mod texture;
mod tool;
pub mod tool_factors;
mod turning;

pub use crate::plan::{CutSummary, FeedDirection};
pub use bending::BendingSettings;
pub use disturbance::{DisturbanceSettings, GuidewayPoint};
pub use force::{DepthLaw, FITTED_TO, FittedRange, ForceLaw, PowerLaw};
pub use force_components::Components;
pub use section::Section;
pub use settings::{
    BelowMinimumChip, MaterialSettings, PassSettings, ProcessSettings, SteadyRestSettings, SupportSettings,
    TextureSettings,
};
pub use tool::ToolSettings;
pub use turning::followed::{Contributions, FollowedPass};
pub use turning::{BaseForm, ProcessError, Stock, TurningProcess};
