//! The edge-spread function that a calibration was made with, kept in its file where it was given
//! as a table.

use serde::{Deserialize, Serialize};

use crate::gauge::limit::limits;
use crate::gauge::settings::EsfSamples;

limits! {
    /// When two tables are of one edge, and how long one may be.
    EdgeTableLimits = "edge_table";
    /// Largest difference of the light of two tables of one edge, as a share of the bright field:
    /// the scale by which px became µm before the masters were fitted is known to parts in a
    /// thousand, equivalent to a few thousandths of the light on the flank; tables of other optics
    /// differ by more.
    same_light: f64 = 0.01;
    /// Most samples in a file: 1.6 MB in memory. The longest window of 256 px has 390 of them to a
    /// pixel.
    most_samples: usize = 100_000;
}

/// Light over the distance from the geometric edge, on the object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EdgeTable {
    /// Distances from the geometric edge into the light, µm, rising.
    pub distance_um: Vec<f64>,
    /// Light there as a share of the bright field.
    pub light: Vec<f64>,
}

impl EdgeTable {
    /// From samples in px at a scale, to six decimals.
    pub(crate) fn from_samples(samples: &EsfSamples, um_per_px: f64) -> Self {
        let short = |v: f64| (1e6 * v).round() / 1e6;
        Self {
            distance_um: samples.distance_px.iter().map(|d| short(d * um_per_px)).collect(),
            light: samples.light.iter().map(|l| short(*l)).collect(),
        }
    }

    /// As the gauge uses it, at a scale.
    pub(crate) fn samples(&self, um_per_px: f64) -> EsfSamples {
        EsfSamples {
            distance_px: self.distance_um.iter().map(|d| d / um_per_px).collect(),
            light: self.light.clone(),
        }
    }

    /// Light at a distance, linear between samples, the ends' beyond them.
    fn at(&self, d_um: f64) -> f64 {
        let after = self.distance_um.partition_point(|d| *d < d_um);
        let (Some(before), Some(high)) = (after.checked_sub(1), self.distance_um.get(after)) else {
            return if after == 0 { self.light[0] } else { self.light[self.light.len() - 1] };
        };
        let low = self.distance_um[before];
        let (a, b) = (self.light[before], self.light[after]);
        a + (b - a) * (d_um - low) / (high - low)
    }

    /// Whether another table is of the same edge.
    pub(crate) fn is_of_the_same_edge(&self, other: &Self) -> bool {
        let same = EdgeTableLimits::get().same_light;
        let near = |a: &Self, b: &Self| {
            a.distance_um.iter().zip(&a.light).all(|(d, light)| (b.at(*d) - light).abs() <= same)
        };
        near(self, other) && near(other, self)
    }

    /// Names what cannot be, if anything: (key, value, what would be right).
    pub(crate) fn impossible(&self) -> Option<(&'static str, f64, &'static str)> {
        let (n, m) = (self.distance_um.len(), self.light.len());
        if !(8..=EdgeTableLimits::get().most_samples).contains(&n) {
            return Some(("edge_table.distance_um", n as f64, "8 to 100000 samples"));
        }
        if n != m {
            return Some(("edge_table.light", m as f64, "as many values as distance_um has"));
        }
        let rises = |pair: &&[f64]| !(pair[1] > pair[0] && pair[0].abs() < 1e6 && pair[1].abs() < 1e6);
        if let Some(pair) = self.distance_um.windows(2).find(rises) {
            return Some(("edge_table.distance_um", pair[1], "rising distances, µm"));
        }
        let wrong = self.light.iter().find(|l| !(l.abs() <= 4.0));
        wrong.map(|l| ("edge_table.light", *l, "shares of the bright field"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaussian(sigma_um: f64, step_um: f64) -> EdgeTable {
        let n = (6.0 * sigma_um / step_um).ceil() as i32;
        let distance_um: Vec<f64> = (-n..=n).map(|k| step_um * f64::from(k)).collect();
        let light =
            distance_um.iter().map(|d| crate::numerics::distributions::phi_cdf(d / sigma_um)).collect();
        EdgeTable { distance_um, light }
    }

    #[test]
    fn one_edge_is_known_again_at_another_scale_and_step() {
        let edge = gaussian(18.0, 0.3);
        let samples = edge.samples(15.0);
        let again = EdgeTable::from_samples(&samples, 15.0 * 1.001);
        assert!(edge.is_of_the_same_edge(&again) && edge.is_of_the_same_edge(&gaussian(18.0, 0.7)));
        assert!(!edge.is_of_the_same_edge(&gaussian(19.5, 0.3)));
        let mut shifted = edge.clone();
        shifted.distance_um.iter_mut().for_each(|d| *d += 1.0);
        assert!(!edge.is_of_the_same_edge(&shifted));
    }

    #[test]
    fn impossible_tables_are_named() {
        assert!(gaussian(18.0, 1.0).impossible().is_none());
        let mut falling = gaussian(18.0, 1.0);
        falling.distance_um.swap(3, 4);
        assert_eq!(falling.impossible().unwrap().0, "edge_table.distance_um");
        let mut short = gaussian(18.0, 1.0);
        short.light.pop();
        assert_eq!(short.impossible().unwrap().0, "edge_table.light");
    }
}
