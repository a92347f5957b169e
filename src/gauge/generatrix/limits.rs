//! Thresholds of the generatrix measurement.

use crate::gauge::limit::limits;

limits! {
    /// Which calipers of a piece count.
    GeneratrixLimits = "generatrix";
    /// Length of a caliper along a piece, px: as along the edges of a nose.
    caliper_px: f64 = 8.0;
    /// Fewest calipers of a piece: a circle has three unknowns, and one caliper may be refused.
    least_calipers: usize = 5;
    /// Half width of the first band, px: within it lies a contour that is expected 8 px away.
    first_half_px: f64 = 10.0;
    /// Half width of the band over its blur: 4.2 standard deviations leave 1e-5 of the contrast.
    band_sigmas: f64 = 4.2;
    /// Least half width of the band, px: levels are taken from its outer third.
    least_band_px: f64 = 5.0;
    /// Largest blur of an edge in focus, px: the ring's model holds to there.
    most_sigma_px: f64 = 3.0;
    /// Distance of an arc's caliper from the circle, standard uncertainties and robust spreads,
    /// beyond which it is not the arc's: noise passes it once in 16 000.
    on_arc_spreads: f64 = 4.0;
    /// Least share of a piece's calipers that lie on it: of two parts the larger one is the piece.
    least_on_piece: f64 = 0.5;
    /// Most rounds, each along the pieces of the one before: the third moves them by thousandths.
    rounds: usize = 6;
    /// Movement of a piece, px, below which the band follows it: as for noses (`nose.settled_px`).
    settled_px: f64 = 0.02;
}
