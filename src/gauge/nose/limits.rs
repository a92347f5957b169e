//! Thresholds of the nose measurement.

use crate::gauge::limit::limits;

limits! {
    /// When a frame shows the nose of an insert, and which of its calipers count.
    NoseLimits = "nose";
    /// Least area of a silhouette, px: a nose of 16 px radius with edges as long as it.
    least_area: usize = 2000;
    /// Area of a further shadow over the insert's from which it is a second part, not
    /// contamination: chips and specks of tenths of a millimetre beside an insert of some
    /// millimetres cover a hundredth.
    second_part: f64 = 0.1;
    /// Cells over the shorter side of a frame that is searched by cells: the least insert, of
    /// `least_area`, still covers hundreds of them where a cell is 4 px wide.
    cells_across: usize = 400;
    /// Largest side of a cell, px: an insert's edge of `least_edge_px` is ten cells.
    most_side: usize = 4;
    /// Least area within a contour over that of the cells found: less is a hole's contour, or that
    /// of one of two parts that touch in cells alone, the other of which has a tenth of its area
    /// (`second_part`), 1/1.1 = 0.91.
    enclosed: f64 = 0.9;
    /// Distance from a line of the coarse contour, px, within which a place lies on it: the contour
    /// of whole pixels, smoothed, scatters by a third of a pixel.
    coarse_px: f64 = 0.8;
    /// Least length of a cutting edge on the coarse contour, px: its angle is then found to 2°.
    least_edge_px: f64 = 40.0;
    /// Least and largest included angle of an insert, degrees (ISO 1832: 35 to 90; grooving and
    /// rhombic corners beside them).
    least_angle_deg: f64 = 20.0;
    /// As `least_angle_deg`.
    most_angle_deg: f64 = 150.0;
    /// Length of a caliper along an edge, px: as much edge as a sector of 1° of a nose of 460 px.
    caliper_px: f64 = 8.0;
    /// Share of the radius beyond the nose's end at which the calipers of an edge begin: a nose's
    /// end that wear has displaced by a tenth of the radius departs from the edge there by no more.
    beyond_nose: f64 = 0.3;
    /// Least length of a sector along the nose, px: within the least band it then holds a dozen
    /// pixels, twice what a caliper needs. Noses below 72 px have sectors of more than a degree.
    least_sector_px: f64 = 1.25;
    /// Distance from the frame's border, px, at which they end: a band and its surroundings.
    border_px: f64 = 4.0;
    /// Half width of the band along the contour over its blur: 4.2 standard deviations leave 1e-5
    /// of the contrast.
    band_sigmas: f64 = 4.2;
    /// Least half width of the band, px: levels are taken from its outer third.
    least_band_px: f64 = 5.0;
    /// Largest blur of an edge in focus, px: the ring's model holds to there.
    most_sigma_px: f64 = 3.0;
    /// Distance of an edge's caliper from its line, px, below which it lies on the line whatever
    /// the scatter: ground edges are straight to a micrometre.
    on_line_px: f64 = 0.15;
    /// The same in standard uncertainties and in robust spreads: noise passes it once in 16 000.
    on_line_spreads: f64 = 4.0;
    /// Least share of an edge's calipers that lie on its line: of two parts of an edge the larger
    /// one is the line; below a third it may be another.
    least_on_line: f64 = 0.35;
    /// Largest share of the nose's sectors that no edge fits: beyond it the contour is double, out
    /// of focus, or no nose.
    most_refused: f64 = 0.3;
    /// Depth of a sector below the hull, px, that is a chip, and height above the nominal circle
    /// that is adhering material: ten times a sector's u at a contrast of 70 over the noise.
    bump_px: f64 = 0.5;
    /// The same in standard uncertainties of the sector: 10⁻¹⁵ of normal deviates have more.
    bump_u: f64 = 8.0;
    /// Sectors at an end of the nose that show whether wear reaches it: a blur of 1.2 px rounds a
    /// step over three of 1.5 px, the smallest noses'.
    end_sectors: usize = 3;
    /// Standard uncertainty of a sector that no edge fits and whose grey values cross the middle
    /// between the levels, px: that of a crossing of whole pixels, √(1/12), with the disturbance.
    u_crossing_px: f64 = 0.5;
    /// The same where nothing crosses, px.
    u_bridged_px: f64 = 1.0;
    /// Root mean square of what the edge model leaves at mid-edge beyond noise, over the contrast,
    /// from which the edges are of another profile: of ten thousand pixels with a noise of 1.4 %
    /// chance leaves a fifth of it, and such an edge is displaced by a fiftieth of its blur.
    most_misfit: f64 = 0.01;
    /// Mean departure of the sectors from the nominal circle, px, from which a nose is flagged
    /// worn; a new nose stays within the form of its grinding.
    worn_px: f64 = 0.5;
    /// Departure of the measured included angle from the tool's, degrees: the tolerance of an
    /// insert's corner, and 0.5° by which a seat of −6° projects it.
    angle_deg: f64 = 1.5;
    /// Departure of the direction of an edge from the tool's, degrees: a holder set by hand to 1°,
    /// and a camera.
    direction_deg: f64 = 5.0;
    /// Departure of the coarse contour's edges from the measured ones, degrees: an edge of
    /// `least_edge_px` is found to 2°.
    coarse_deg: f64 = 2.0;
    /// Distance of the coarse nose from where the nominal circle ends, over its radius, from which
    /// a contour that cannot be followed is another nose's: wear takes a tenth of a radius, and the
    /// next radius of ISO 1832 differs by a quarter or more.
    another_radius: f64 = 0.25;
    /// Departure of the included angle and of the edges from those of a baseline, standard
    /// uncertainties: the same insert repeats it to 5 u but once in a million.
    baseline_u: f64 = 5.0;
    /// The same, degrees, below which angles are one: a lens' residual distortion in two places.
    baseline_deg: f64 = 0.02;
    /// Share of the sectors that may reach beyond a baseline by more than `baseline_u`: a nose does
    /// not grow, but for a built-up edge.
    baseline_beyond: f64 = 0.2;
    /// Share of the correction by curvature, beyond a circle's, that stays uncertain: at a corner
    /// the curvature of seven sectors is half of what the blur sees.
    u_bend: f64 = 0.5;
    /// The smoothing penalty over that of least cross-validation: what smoothing moves is then
    /// small beside the noise, which the draws include, at two and a half times the noise's
    /// variance (the variance of a smooth of second differences falls with the fourth root of the
    /// penalty).
    penalty_share: f64 = 0.03;
    /// What the hull of sectors hides of a corner, over the change of its slope per sector, of
    /// sharp edges: by trial over all places of the corner in its sector (`hidden_corner`).
    corner_sharp: f64 = 0.115;
    /// The same by the blur over the width of a sector.
    corner_blur: f64 = 0.085;
    /// Scatter of what is hidden, of sharp edges: 0.045 by that trial, of straight pieces; those of
    /// flats and chips are bent, which is given as much again.
    corner_u_sharp: f64 = 0.08;
    /// The same by the blur.
    corner_u_blur: f64 = 0.035;
    /// Uncertainty of the support by a hidden corner, px, from which it is flagged: two of it are
    /// half a micrometre at 2.4 µm a px, the most that e(a) may be off.
    most_u_corner_px: f64 = 0.1;
    /// Standard uncertainties of a change of slope below which it is noise: 0.27 % of normal
    /// deviates have more.
    corner_u: f64 = 3.0;
    /// Draws of the Monte Carlo of the support: u is known to 5 %.
    draws: usize = 200;
    /// Largest distance of the support's directions, degrees; a nose profile takes 5.
    support_step_deg: f64 = 2.0;
    /// Most rounds, each along the contour of the one before: the third moves it by thousandths.
    rounds: usize = 6;
    /// Movement of the centre and of the sectors, px, below which the band follows the contour: its
    /// pixels' distances are then right to a thousandth of the blur.
    settled_px: f64 = 0.02;
    /// Smallest nose radius, px, to which the correction of curvature holds, as for rings.
    least_radius_px: f64 = 8.0;
    /// Share of a radius of ISO 1832 within which a nose is of it: half the distance of 2.0 from
    /// 2.4.
    iso_share: f64 = 0.1;
    /// Share of the sectors that lie on the fitted circle of a new nose: noise leaves it once in 16
    /// 000 (`on_line_spreads`), so that more than a tenth off it is wear or chips, not chance.
    new_share: f64 = 0.9;
    /// Penalties that are tried, from none to a circle: powers of 4.
    penalties: usize = 12;
    /// Places a sector of the contour whose hull is taken: the sagitta of an eighth of a degree of
    /// 1000 px is 0.0006 px.
    fine: usize = 8;
    /// Pairs of places that a coarse line is drawn through, a run and length: of an edge that is a
    /// tenth of the contour two dozen pairs lie on it.
    trials: usize = 240;
    /// Most straight stretches looked for: both edges of a nose, those of the insert's other
    /// corners, and of its holder.
    most_lines: usize = 7;
    /// Half width of the mean over places of the coarse contour: eight steps of whole pixels.
    mean_half: usize = 4;
}
