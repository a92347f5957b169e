//! How much of the sensor's pattern whole rows and whole columns share (EMVA 1288 release 4.0,
//! spatial variances):
//!
//! ```text
//! DSNU² = DSNU_row² + DSNU_col² + DSNU_pixel²      PRNU² = PRNU_row² + PRNU_col² + PRNU_pixel²
//! ```
//!
//! `dsnu_e` and `prnu_rel` of the sensor are the totals, as in a data sheet; what rows and columns
//! do not have of them, the pixels have for themselves.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::render::error::{RenderError, within};

/// The `[sensor.spatial]` table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpatialShares {
    /// Standard deviation of the rows' offsets, electrons: a share of `sensor.dsnu_e`.
    pub dsnu_row_e: f64,
    /// Standard deviation of the columns' offsets, electrons: a share of `sensor.dsnu_e`.
    pub dsnu_column_e: f64,
    /// Relative standard deviation of the rows' gains: a share of `sensor.prnu_rel`.
    pub prnu_row_rel: f64,
    /// Relative standard deviation of the columns' gains: a share of `sensor.prnu_rel`.
    pub prnu_column_rel: f64,
}

impl SpatialShares {
    /// Checks every value against its range and the totals that it is a share of.
    ///
    /// # Errors
    /// Names the key that is wrong and what would be right.
    pub(super) fn check(&self, dsnu_e: f64, prnu_rel: f64) -> Result<(), RenderError> {
        within("sensor.spatial.dsnu_row_e", self.dsnu_row_e, 0.0, 1e5)?;
        within("sensor.spatial.dsnu_column_e", self.dsnu_column_e, 0.0, 1e5)?;
        within("sensor.spatial.prnu_row_rel", self.prnu_row_rel, 0.0, 0.5)?;
        within("sensor.spatial.prnu_column_rel", self.prnu_column_rel, 0.0, 0.5)?;
        let pairs = [
            ("sensor.dsnu_e", dsnu_e, [self.dsnu_row_e, self.dsnu_column_e]),
            ("sensor.prnu_rel", prnu_rel, [self.prnu_row_rel, self.prnu_column_rel]),
        ];
        for (key, total, [row, column]) in pairs {
            if remainder(total, [row, column]).is_none() {
                let least = row.hypot(column);
                let right = format!(
                    "is the total of rows, columns and pixels: at least {least} beside the shares of sensor.spatial"
                );
                return Err(RenderError::setting(key, &total, right));
            }
        }
        Ok(())
    }

    /// The pixels' own offsets, electrons, of a total.
    pub(super) fn pixel_dsnu_e(&self, dsnu_e: f64) -> f64 {
        remainder(dsnu_e, [self.dsnu_row_e, self.dsnu_column_e]).unwrap_or(0.0)
    }

    /// The pixels' own relative gains of a total.
    pub(super) fn pixel_prnu_rel(&self, prnu_rel: f64) -> f64 {
        remainder(prnu_rel, [self.prnu_row_rel, self.prnu_column_rel]).unwrap_or(0.0)
    }

    /// Whether rows and columns have no share.
    pub(super) fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// Share of a total that remains beside others, in quadrature; none where they exceed it by more
/// than a data sheet's rounding (1e-9 of it).
pub(super) fn remainder(total: f64, shares: [f64; 2]) -> Option<f64> {
    let rest = total * total - shares.iter().map(|s| s * s).sum::<f64>();
    (rest >= -1e-9 * total * total).then(|| rest.max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_in_quadrature_and_more_than_the_total_is_refused() {
        let shares = SpatialShares {
            dsnu_row_e: 2.0,
            dsnu_column_e: 3.0,
            prnu_row_rel: 0.003,
            prnu_column_rel: 0.004,
        };
        shares.check(7.0, 0.013).unwrap();
        assert!((shares.pixel_dsnu_e(7.0) - 6.0).abs() < 1e-12);
        assert!((shares.pixel_prnu_rel(0.013) - 0.012).abs() < 1e-15);
        // All of it in rows and columns leaves the pixels nothing.
        assert!(shares.check(7.0, 0.005).is_ok() && shares.pixel_prnu_rel(0.005) < 1e-6);
        let refused = shares.check(3.0, 0.013).unwrap_err().to_string();
        assert!(refused.contains("sensor.dsnu_e") && refused.contains("at least 3.6"), "{refused}");
        assert!(SpatialShares::default().is_none());
        assert_eq!(SpatialShares::default().pixel_dsnu_e(0.7), 0.7);
    }
}
