//! Names of the controllers, as on the command line and in files.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which controller decides the offsets of the next pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ControllerName {
    /// No correction: the offsets stay zero.
    None,
    /// Proportional-integral-derivative, `[control.pid]`.
    #[default]
    Pid,
    /// Least-squares shape, `[control.lsq]`.
    Lsq,
    /// Run-to-run EWMA per station, `[control.ewma]`.
    Ewma,
    /// Double EWMA with trend per station, `[control.dewma]`.
    Dewma,
    /// Iterative learning with a Q filter along z, `[control.ilc]`.
    Ilc,
    /// Model-based, `[control.model]`.
    Model,
}

impl ControllerName {
    /// Every controller, in the order in which comparisons list them.
    pub(crate) const ALL: [Self; 7] =
        [Self::None, Self::Pid, Self::Lsq, Self::Ewma, Self::Dewma, Self::Ilc, Self::Model];

    /// The word used on the command line and in files.
    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Pid => "pid",
            Self::Lsq => "lsq",
            Self::Ewma => "ewma",
            Self::Dewma => "dewma",
            Self::Ilc => "ilc",
            Self::Model => "model",
        }
    }
}

impl std::fmt::Display for ControllerName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}
