//! The turning process: force law, beam deflection, the pass that leaves a shaft behind.
//!
//! [`TurningProcess`] keeps the workpiece. [`TurningProcess::cut`] takes what is commanded and gives what remains:
//! the tool stands at b(z), the shaft yields by u(z), D(z) = b(z) + 2u(z), and the force that bends it follows
//! the depth really cut. Nothing here knows what was measured.

pub mod beam;
mod force;
mod section;
mod settings;
mod texture;
mod turning;

pub use force::DepthLaw;
pub use section::Section;
pub use settings::{
    ForceLaw, MaterialSettings, PassSettings, PowerLaw, ProcessSettings, SettingsError, SupportSettings,
    TextureSettings,
};
pub use turning::{BaseForm, CutSummary, ProcessError, Stock, TurningProcess};
