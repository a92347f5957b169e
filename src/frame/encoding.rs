//! Encoding of light in the grey values of a file, before they were made proportional to it.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Difference at the quarters below which two curves are the same: half a step of an 8-bit table
/// is 0.002, and a power of 0.45455 differs from sRGB by 0.0036.
const SAME: f64 = 2.5e-3;

/// Light where the file's grey value stands at 1/4, 1/2 and 3/4 of full scale, as a share of that
/// at full scale: what distinguishes one encoding from another, whatever it is called. Linear is
/// 1/4, 1/2, 3/4.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Encoding {
    /// The three shares, each from 0 to 1.
    pub light_at_quarters: [f64; 3],
}

impl Default for Encoding {
    fn default() -> Self {
        Self::LINEAR
    }
}

impl Encoding {
    /// Grey values in proportion to the light.
    pub(crate) const LINEAR: Self = Self { light_at_quarters: [0.25, 0.5, 0.75] };
    /// sRGB (IEC 61966-2-1): ((v + .055)/1.055)^2.4 at .25, .5 and .75.
    pub(crate) const SRGB: Self = Self { light_at_quarters: [0.050_876, 0.214_041, 0.522_522] };

    /// The encoding of a curve of light over grey value, both as shares of full scale.
    pub(crate) fn of(light: impl Fn(f64) -> f64) -> Self {
        Self { light_at_quarters: [0.25, 0.5, 0.75].map(light) }
    }

    /// Whether both encode light in the same way.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let pairs = self.light_at_quarters.iter().zip(&other.light_at_quarters);
        pairs.into_iter().all(|(a, b)| (a - b).abs() <= SAME)
    }

    /// Whether grey values are proportional to the light.
    pub(crate) fn is_linear(&self) -> bool {
        self.is_same(&Self::LINEAR)
    }

    /// The first share that is outside 0 to 1 or does not increase.
    pub(crate) fn impossible(&self) -> Option<f64> {
        let [a, b, c] = self.light_at_quarters;
        let wrong = [a, b, c].into_iter().find(|l| !(0.0..=1.0).contains(l));
        wrong.or_else(|| (!(a <= b && b <= c)).then_some(b))
    }
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_linear() {
            return f.write_str("linear");
        }
        if self.is_same(&Self::SRGB) {
            return f.write_str("sRGB");
        }
        let power = self.light_at_quarters[1].ln() / 0.5_f64.ln();
        if self.is_same(&Self::of(|v| v.powf(power))) {
            return write!(f, "a power of {:.3}", power.recip());
        }
        let [a, b, c] = self.light_at_quarters;
        write!(f, "a curve (light {a:.3}, {b:.3}, {c:.3} at 1/4, 1/2, 3/4 of full scale)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_told_apart_by_what_they_do() {
        let power = Encoding::of(|v| v.powf(2.2));
        let srgb = Encoding::of(|v| ((v + 0.055) / 1.055).powf(2.4));
        assert!(srgb.is_same(&Encoding::SRGB) && !power.is_same(&srgb));
        assert!(!power.is_linear() && Encoding::of(|v| v.powf(1.0)).is_linear());
        assert_eq!(power.to_string(), "a power of 0.455");
        assert_eq!((srgb.to_string(), Encoding::default().to_string()), ("sRGB".into(), "linear".into()));
        assert_eq!(power.impossible(), None);
        assert_eq!(Encoding { light_at_quarters: [0.5, 0.2, 0.9] }.impossible(), Some(0.2));
    }
}
