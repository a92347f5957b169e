//! What sectors and blur hide of a corner of the contour: the end of a flat, the rim of a chip.
//!
//! A sector's radius is a mean over it. Of two straight pieces whose slopes differ by s (per
//! sector) that meet anywhere within a sector, the hull of the sectors' smooth contour stands below
//! the corner: by 0.12 s where the edge is sharp, and by more where it is blurred, since a blurred
//! corner is rounded. Over all places of the corner within its sector and all directions between
//! the two pieces, by σ' over the sector's width ρ from 0 to 1.2:
//!
//! ```text
//! mean (0.115 + 0.085 ρ)·s, standard deviation (0.045 + 0.035 ρ)·s
//! ```
//!
//! s is the sum of three second differences of the radii, but for what the neighbours' second
//! differences show to be curvature. The crossing of the lines through four sectors on either side
//! finds the corner without that mean error, but needs them straight: flanks of chips are shorter.

use nalgebra::DVector;

use super::limits::NoseLimits;

/// What is hidden of a corner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Hidden {
    /// Height of the corner above the smooth contour's hull, px.
    pub(super) by_px: f64,
    /// Standard uncertainty of that, px.
    pub(super) u_px: f64,
}

/// The corners of a contour.
pub(super) struct Corners(Vec<Hidden>);

impl Corners {
    /// Of the sectors' departures from the nominal radius and their own u, px; `blur` is σ' over a
    /// sector's width.
    pub(super) fn new(departures: &DVector<f64>, u_px: &[f64], blur: f64) -> Self {
        let limits = NoseLimits::get();
        let n = departures.len();
        // > 0 where the contour is convex; 0 at the ends, where the edges go on
        let bent = |k: isize| match k {
            k if k < 1 || k + 1 >= n as isize => 0.0,
            k => {
                let k = k as usize;
                2.0 * departures[k] - departures[k - 1] - departures[k + 1]
            }
        };
        let hidden = |k: usize| {
            let at = k as isize;
            let all = bent(at - 1) + bent(at) + bent(at + 1);
            let beside = bent(at - 2).max(bent(at + 2)).max(0.0);
            let corner = (all - 3.0 * beside).max(0.0);
            // the sum of three has the variance of four radii
            let least = limits.corner_u * 2.0 * u_px[k];
            let corner = corner * (1.0 - (least / corner.max(f64::MIN_POSITIVE)).powi(2)).max(0.0);
            let curved = (all.max(0.0) - corner - least).max(0.0) / 24.0;
            let u_corner = (limits.corner_u_sharp + limits.corner_u_blur * blur) * corner;
            let by_px = (limits.corner_sharp + limits.corner_blur * blur) * corner;
            Hidden { by_px, u_px: u_corner.hypot(curved) }
        };
        Self((0..n).map(hidden).collect())
    }

    /// What is hidden where the hull touches sector k: a corner in it or beside it.
    pub(super) fn at(&self, k: usize) -> Hidden {
        let beside = &self.0[k.max(1) - 1..=(k + 1).min(self.0.len() - 1)];
        let larger = |a: Hidden, b: &Hidden| Hidden { by_px: a.by_px.max(b.by_px), u_px: a.u_px.max(b.u_px) };
        beside.iter().fold(Hidden::default(), larger)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means over sectors of two straight pieces, slopes ±½ per sector, that meet at `corner`.
    fn sectors(corner: f64) -> DVector<f64> {
        let mean = |k: usize| {
            let fine = (0..1000).map(|i| -0.5 * (k as f64 - 0.5 + (f64::from(i) + 0.5) / 1e3 - corner).abs());
            fine.sum::<f64>() / 1e3
        };
        DVector::from_iterator(31, (0..31).map(mean))
    }

    #[test]
    fn a_corner_anywhere_in_a_sector_has_the_same_size() {
        for corner in [14.5, 14.8, 15.0, 15.3] {
            let found = Corners::new(&sectors(corner), &[1e-4; 31], 0.0).at(15);
            assert!((found.by_px - 0.115).abs() < 0.005, "{corner}: {found:?}");
        }
    }

    #[test]
    fn curvature_and_noise_are_no_corners() {
        let circle = DVector::from_iterator(31, (0..31).map(|k| -0.05 * (f64::from(k) - 15.0).powi(2)));
        assert!(Corners::new(&circle, &[1e-4; 31], 0.4).at(15).by_px < 1e-9);
        let scatter = |k: i32| 0.02 * ((f64::from(k) * 0.618_033_988_7).fract() - 0.5);
        let flat = DVector::from_iterator(31, (0..31).map(scatter));
        for k in 3..28 {
            assert_eq!(Corners::new(&flat, &[0.02; 31], 0.4).at(k).by_px, 0.0);
        }
    }
}
