//! The two other values of a threshold: half of it and double.
//!
//! A share between a half and 1 has its distance to 1 halved and doubled instead: half of 0.95
//! would be no share that anyone sets, and double of it none at all. A whole number stays whole and
//! differs by at least 1. A zero has no half and is left out.

use serde::{Deserialize, Serialize};

use crate::gauge::Limit;

/// Which way a threshold is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Way {
    /// Half the value, or half its distance to 1.
    Half,
    /// Double the value, or double its distance to 1.
    Double,
}

impl Way {
    /// Both.
    pub(crate) const BOTH: [Self; 2] = [Self::Half, Self::Double];

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Half => "half",
            Self::Double => "double",
        }
    }
}

/// One threshold with another value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Variant {
    /// The threshold, as `group.field`.
    pub name: String,
    /// Its default value.
    pub default: f64,
    /// Which way it is varied.
    pub way: Way,
    /// The value that it is given.
    pub value: f64,
}

/// Both variants of a threshold; none of a zero.
pub(crate) fn variants(limit: &Limit) -> Vec<Variant> {
    let of = |way| {
        let value = varied(limit, way)?;
        Some(Variant { name: limit.name.clone(), default: limit.value, way, value })
    };
    Way::BOTH.into_iter().filter_map(of).collect()
}

/// The value of a threshold varied in one way; none of a zero, or of what is no number.
fn varied(limit: &Limit, way: Way) -> Option<f64> {
    let value = limit.value;
    if value == 0.0 || !value.is_finite() {
        return None;
    }
    let times = match way {
        Way::Half => 0.5,
        Way::Double => 2.0,
    };
    if limit.whole {
        let apart = if (way == Way::Half) == (value > 0.0) { -1.0 } else { 1.0 };
        let other = (times * value).round();
        return Some(if (other - value).abs() < 1.0 { value + apart } else { other });
    }
    if is_share(value) { Some(1.0 - times * (1.0 - value)) } else { Some(times * value) }
}

/// Whether the distance to 1 is what is varied.
pub(crate) fn is_share(value: f64) -> bool {
    value > 0.5 && value < 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(value: f64, whole: bool) -> Vec<f64> {
        let limit = Limit { name: "group.field".to_owned(), value, whole };
        variants(&limit).into_iter().map(|v| v.value).collect()
    }

    #[test]
    fn numbers_are_halved_and_doubled() {
        assert_eq!(values(3.0, false), [1.5, 6.0]);
        assert_eq!(values(0.5, false), [0.25, 1.0]);
        assert_eq!(values(1.0, false), [0.5, 2.0]);
        assert_eq!(values(-4.0, false), [-2.0, -8.0]);
        assert_eq!(values(1e-9, false), [0.5e-9, 2e-9]);
    }

    #[test]
    fn shares_keep_below_one() {
        assert_eq!(values(0.75, false), [0.875, 0.5]);
        let near = values(0.99, false);
        assert!((near[0] - 0.995).abs() < 1e-12 && (near[1] - 0.98).abs() < 1e-12, "{near:?}");
        assert!(is_share(0.51) && !is_share(0.5) && !is_share(1.0));
    }

    #[test]
    fn whole_numbers_stay_whole_and_differ() {
        assert_eq!(values(16.0, true), [8.0, 32.0]);
        assert_eq!(values(5.0, true), [3.0, 10.0]);
        // Half of 1 rounds to 1 again: the next whole number is taken.
        assert_eq!(values(1.0, true), [0.0, 2.0]);
        assert_eq!(values(-1.0, true), [0.0, -2.0]);
    }

    #[test]
    fn zero_has_no_half() {
        assert!(values(0.0, false).is_empty() && values(0.0, true).is_empty());
        assert!(values(f64::INFINITY, false).is_empty());
    }

    /// Lists them for `scripts/limits_held.py`.
    #[test]
    #[ignore = "a list, not a check"]
    fn every_variant() {
        for variant in crate::gauge::instrument::thresholds::every().iter().flat_map(variants) {
            let Variant { name, default, way, value } = &variant;
            println!("variant {name} {} {value} of {default}", way.name());
        }
    }
}
