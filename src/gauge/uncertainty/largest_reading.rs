//! The largest diameter of a frame as a reading, input of its budget.

use super::budget::{EdgesUncertainty, WidthReading, quantisation_share};
use super::form_scatter::{FormScatterLimits, Scatter};
use crate::gauge::calibration::gauge_calibration::Calibration;
use crate::gauge::edges::FrameEdges;
use crate::gauge::width::blur_sensitivity::u_blur_px;
use crate::gauge::width::largest_caliper::{LargestCaliper, largest_caliper_over, largest_caliper_where};
use crate::gauge::width::reused::Reused;

impl WidthReading {
    /// The largest caliper diameter of a frame over stretches of `least_columns` or more, as
    /// [`crate::gauge::largest_caliper`] finds it, behind the lens of a calibration.
    pub(crate) fn of_largest(
        edges: &FrameEdges,
        calibration: &Calibration,
        least_columns: usize,
    ) -> Option<Self> {
        let largest = match &calibration.setup {
            Some(setup) => largest_caliper_where(edges, least_columns, |column, top_px, bottom_px| {
                let row = |row_px| setup.lens.ideal_row(column as f64, row_px);
                row(bottom_px) - row(top_px)
            }),
            None => largest_caliper_over(edges, least_columns),
        }?;
        Self::of_caliper(edges, &largest)
    }

    /// Of a largest caliper diameter of the frame that is known.
    pub(crate) fn of_caliper(edges: &FrameEdges, largest: &LargestCaliper) -> Option<Self> {
        let form_scatter_limits = FormScatterLimits::get();
        let half = 0.5 * largest.diameter_px;
        let near = largest.column_px.round().clamp(0.0, edges.columns() as f64 - 1.0) as usize;
        let (from, to) = (near.saturating_sub(32), (near + 33).min(edges.columns()));
        let used: Reused<usize> = (from..to).filter(|c| edges.width_px(*c).is_some()).collect();
        if used.is_empty() {
            return None;
        }
        let n = used.len() as f64;
        let mean = |f: &dyn Fn(usize) -> f64| used.iter().map(|c| f(*c)).sum::<f64>() / n;
        let square = |v: f32| f64::from(v).powi(2);
        let middle = mean(&|c| 0.5 * (edges.top[c].row_px + edges.bottom[c].row_px));
        let own_u = largest.u_own_px.powi(2);
        let noise = match largest.end_on {
            // Variance of a robust vertex over that of a mean; few columns scatter less than their
            // noise by chance.
            true => {
                let own = mean(&|c| square(edges.top[c].u_own_px) + square(edges.bottom[c].u_own_px));
                let noise = std::f64::consts::FRAC_PI_2 * own / n;
                if used.len() < form_scatter_limits.few_columns() { noise } else { noise.min(own_u) }
            }
            false => largest.u_noise_px.powi(2).min(own_u),
        };
        let (blur_px, sigma_px) = u_blur_px(edges, &used);
        let shared = (largest.u_px.powi(2) - own_u).max(0.0);
        let misfit = mean(&|c| edges.model_variance(c)).min(shared);
        let clipped = edges.clipped_variance().min(shared - misfit);
        let rounding = edges.figures.rounding_variance().min(shared - misfit - clipped);
        // A shaft's scatter is read from all of its columns' fourth differences, three to a degree
        // of freedom.
        let freedom = if largest.end_on { n - 1.0 } else { edges.valid() as f64 / 3.0 };
        Some(Self {
            column_px: largest.column_px,
            column_variance_px2: 0.0,
            rows_px: (middle - half, middle + half),
            chord: 1.0,
            u: EdgesUncertainty {
                noise_px: noise.sqrt(),
                quantisation_share: quantisation_share(edges),
                levels_px: (shared - misfit - clipped - rounding).max(0.0).sqrt(),
                misfit_px: misfit.sqrt(),
                clipped_px: clipped.sqrt(),
                rounding_px: rounding.sqrt(),
                blur_px,
                sigma_px,
            },
            figures: edges.figures,
            form: Scatter::Known { u_px: (own_u - noise).max(0.0).sqrt(), freedom: freedom.max(1.0) },
        })
    }
}
