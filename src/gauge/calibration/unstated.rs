//! Limits of quantities that are not stated. Such a quantity is not known exactly: it has a row of
//! its own in every budget.

use crate::gauge::limit::limits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

limits! {
    /// What is assumed of conditions that are not stated.
    UnstatedLimits = "unstated";
    /// Temperature of a part or of masters where none is stated, 20 °C ± K: a heated workshop over
    /// a year, and a part some minutes after a wet cut; Ø25 of steel changes by 1.4 µm over it.
    temperature_k: f64 = 5.0;
    /// Error of a temperature that is stated without limits, ± K: a hand-held contact thermometer
    /// on metal.
    reading_k: f64 = 1.0;
    /// Error of a coefficient of expansion whose limits are not stated, ± µm/(m·K): steels lie
    /// within 11.5 ± 1 (ISO 1 practice).
    expansion_um_per_m_k: f64 = 1.0;
    /// How far an edge may stand from one like the masters' where neither limit nor finishes are
    /// stated, ± µm an edge: what the roughest of [`super::Finish`] does to a limb, and as much as
    /// the limb of a smooth cylinder of Ø2 to Ø40 itself stands off the image of a thin edge (0.9
    /// to 1.6 µm at NA 0.02 in half-coherent light).
    edge_um: f64 = 1.5;
}

/// What of some conditions nobody stated: their limits are those of this module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Unstated {
    /// The limits of the temperature.
    pub temperature: bool,
    /// The limits of the expansion.
    pub expansion: bool,
    /// How far edges may differ from the masters'.
    pub edge: bool,
}

impl Unstated {
    /// Whether all is stated.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// What either of two leaves unstated.
    #[must_use]
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            temperature: self.temperature || other.temperature,
            expansion: self.expansion || other.expansion,
            edge: self.edge || other.edge,
        }
    }
}
