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

/// Second differences of a contour's radii, px: a corner beside each sector, and curvature.
struct Bends<'a> {
    departures: &'a DVector<f64>,
    /// +1 for convex corners, −1 for concave ones.
    sign: f64,
}

impl Bends<'_> {
    /// > 0 where the contour bends that way; 0 at the ends, where the edges go on.
    fn at(&self, k: isize) -> f64 {
        let d = self.departures;
        if k < 1 || k + 1 >= d.len() as isize {
            return 0.0;
        }
        let k = k as usize;
        self.sign * (2.0 * d[k] - d[k - 1] - d[k + 1])
    }

    /// Change of the slope at a corner in sector k or beside it, px per sector, and the rest of
    /// what bends there; `u_px` is a sector's own.
    fn corner(&self, k: usize, u_px: f64) -> (f64, f64) {
        let at = k as isize;
        let all = self.at(at - 1) + self.at(at) + self.at(at + 1);
        let beside = self.at(at - 2).max(self.at(at + 2)).max(0.0);
        let corner = (all - 3.0 * beside).max(0.0);
        // the sum of three has the variance of four radii
        let least = NoseLimits::get().corner_u * 2.0 * u_px;
        let corner = corner * (1.0 - (least / corner.max(f64::MIN_POSITIVE)).powi(2)).max(0.0);
        (corner, (all.max(0.0) - corner - least).max(0.0))
    }
}

/// Scatter of what is hidden, over the change of the slope per sector; `blur` is σ' over a sector's
/// width.
fn scatter(blur: f64) -> f64 {
    let limits = NoseLimits::get();
    limits.corner_u_sharp + limits.corner_u_blur * blur
}

/// Standard uncertainty of each sector's radius by a corner in it or beside it, px: the contour in
/// the middle of a sector stands off the sector's mean by what depends on the corner's place, as
/// the hull does.
pub(super) fn u_of_corners(departures: &DVector<f64>, u_px: &[f64], blur: f64) -> Vec<f64> {
    let size = |k: usize, sign: f64| Bends { departures, sign }.corner(k, u_px[k]).0;
    (0..departures.len()).map(|k| scatter(blur) * size(k, 1.0).max(size(k, -1.0))).collect()
}

/// The corners of a contour.
pub(super) struct Corners(Vec<Hidden>);

impl Corners {
    /// Of the sectors' departures from the nominal radius and their own u, px; `blur` is σ' over a
    /// sector's width.
    pub(super) fn new(departures: &DVector<f64>, u_px: &[f64], blur: f64) -> Self {
        let limits = NoseLimits::get();
        let bends = Bends { departures, sign: 1.0 };
        let hidden = |k: usize| {
            let (corner, rest) = bends.corner(k, u_px[k]);
            let by_px = (limits.corner_sharp + limits.corner_blur * blur) * corner;
            Hidden { by_px, u_px: (scatter(blur) * corner).hypot(rest / 24.0) }
        };
        Self((0..departures.len()).map(hidden).collect())
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
    fn the_radius_of_a_sector_is_uncertain_at_corners_of_either_way_alone() {
        let convex = sectors(15.2);
        for contour in [&convex, &(-&convex)] {
            let u = u_of_corners(contour, &[1e-4; 31], 0.0);
            // the middle of the sector stands off its mean by up to an eighth of the change of
            // slope
            assert!((u[15] - 0.08).abs() < 0.005, "{u:?}");
            assert!((3..12).chain(19..28).all(|k| u[k] < 1e-6), "{u:?}");
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
