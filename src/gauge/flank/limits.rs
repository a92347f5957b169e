//! Thresholds of the flank measurement.

use crate::gauge::limit::limits;

limits! {
    /// Where a flank is sought, and what of it counts.
    FlankLimits = "flank";
    /// Least side of an image, px: the search's strips and a land of a tenth of a millimetre.
    least_side_px: usize = 128;
    /// Cells over the longer side of the image in which the edge is sought: an edge a sixth of the
    /// field long is a hundred cells, a flank of 0.3 mm ten cells deep in a field of 4 mm.
    cells: usize = 600;
    /// Standard deviation of the Gaussian that takes texture from shade, px: what is out of focus
    /// has no detail below it.
    detail_px: f64 = 2.0;
    /// Quantile of the cells' detail that stands for noise alone: a tenth of the field shows air,
    /// or what lies out of focus.
    noise_detail: f64 = 0.1;
    /// Detail of the flank's cells over that of noise: noise alone has 1.7 between its quantiles of
    /// 0.1 and 0.98.
    least_detail: f64 = 3.0;
    /// Quantile of the cells' detail that counts as the flank's full texture: a flank of a fiftieth
    /// of the field reaches it.
    full_detail: f64 = 0.98;
    /// Detail over that of noise from which a cell has texture: shot noise is twice as strong where
    /// the background is four times as bright.
    noise_share: f64 = 2.0;
    /// Share of the full texture from which a cell has texture: what is out of focus has less.
    least_share: f64 = 0.05;
    /// Share of the full texture that counts in full: facets behind the flank are dimmer by three
    /// times and are in focus all the same.
    enough_share: f64 = 0.25;
    /// Depth of the strip on the flank's side of a line, cells: more than a smooth land is deep, so
    /// that texture below it counts for the edge.
    side_cells: usize = 24;
    /// Depth of the strip beyond a line, cells: set by trial on the nine real flanks and sixty
    /// rendered ones of seed 1, by how many edges were found.
    beyond_cells: usize = 10;
    /// Depth below a line in which texture shows where an edge has its flank, cells: more than a
    /// smooth land is deep.
    extent_cells: usize = 60;
    /// Depth in which an edge alone shows, cells: where the flank is in the dark.
    near_cells: usize = 6;
    /// Share of that depth which has texture there, less what lies beyond: set as `beyond_cells`.
    extent_share: f64 = 0.08;
    /// Width of the sectors of direction of which the best line each is compared by its length,
    /// degrees: sides of a body are at least 20 degrees apart.
    sector_deg: usize = 10;
    /// Score over the best one that a line has at least: set as `beyond_cells`.
    likely_score: f64 = 0.6;
    /// Angle between the lines of two borders at least, degrees: neighbouring sectors find the same
    /// line up to a sector and one and a half degrees apart.
    apart_deg: f64 = 15.0;
    /// Weight of another border over the best one's from which either could be the cutting edge: of
    /// 540 rendered flanks (`tool render-flank --random`, seeds 1, 5001 and 100001) nine of the ten
    /// with a wrong edge have .83 and more, 18 of the others .8; nine real flanks have .67 at most.
    rival_share: f64 = 0.8;
    /// Weight of the best border of a stated side over the best one of all, below which the side is
    /// refused: of the same 540 flanks and the nine real ones the true side has .67 once and .85
    /// else at least, nine of ten wrong sides have less.
    side_share: f64 = 0.6;
    /// Weight of detail beyond a line over that of detail on its flank: the air beside a cutting
    /// edge is out of focus, the neighbour of a facet is not.
    beyond_weight: f64 = 3.0;
    /// Least length of a cutting edge, cells: a tenth of the longer side of the image (`cells`).
    least_cells: f64 = 60.0;
    /// Pitch of the rectified strip, µm: a land of 20 µm is ten rows.
    pitch_um: f64 = 2.0;
    /// Depth of the strip below the reference line, µm: above the limit of a notch, 600 µm, by
    /// half.
    depth_um: f64 = 900.0;
    /// Height of the strip above it, µm: three times `air_um`, so that two thirds of it show the
    /// air's level.
    above_um: f64 = 120.0;
    /// Depth from which the air's level beside the edge is taken, µm: sixteen pixels of 2.4 µm,
    /// where an edge in focus reaches thirteen (4.2 standard deviations of 3 px).
    air_um: f64 = 40.0;
    /// Least width of a worn land, µm: less is the rounding and the blur of a new edge.
    least_land_um: f64 = 6.0;
    /// Share of the typical width from which a column is worn: lands that taper to two fifths of
    /// their mean and scatter keep a quarter.
    worn_share: f64 = 0.25;
    /// Largest gap that a worn length bridges, µm: shorter than the least worn length
    /// (`least_length_um`), so that no gap is bridged that could be a land.
    bridge_um: f64 = 60.0;
    /// Least worn length, µm: twenty columns of the strip, more than one independent departure of
    /// the border (`shared_columns`).
    least_length_um: f64 = 80.0;
    /// Share of full scale from which a pixel counts as saturated: 252 of 255 counts, which leaves
    /// three counts to the noise at the end.
    saturated: f64 = 0.99;
    /// Most of the border's length that may lie in glare, %: the path bridges short ones.
    most_glare_percent: f64 = 20.0;
    /// Depth of glare about the border that hides it, µm: on both sides, or the border is one
    /// side's.
    glare_um: f64 = 12.0;
    /// Largest step of the border from one column of the strip to the next, rows: steep ends of
    /// notches pass.
    most_step: usize = 6;
    /// Cost of a step of one row in log-odds: a pixel whose class is as good as certain has 3.
    step_cost: f64 = 1.5;
    /// Share of the worn length at its far end that is zone N (ISO 3685: the last quarter).
    notch_share: f64 = 0.25;
    /// Distance of two columns of the strip over that of two rows: what counts is the width of the
    /// land, and it changes slowly along the edge.
    column_pitches: f64 = 2.0;
    /// Powers of the reference curve: ground edges of inserts are straight or slightly cambered. A
    /// cubic bends towards the lower border of a land whose upper one is dim.
    edge_powers: usize = 3;
    /// Largest standard uncertainty of the reference curve's level, µm: edges that are found have 1
    /// to 3, lines that are none of rendered flanks 15 and more.
    most_reference_u_um: f64 = 8.0;
    /// Largest sagitta of the reference curve, µm: ground edges are cambered by a few micrometres;
    /// a curve that bends more follows the border of a land, and a straight line is laid instead.
    most_sagitta_um: f64 = 80.0;
    /// Height above the first departure from the air in which the border's step begins, µm: ten
    /// pixels of 2.4 µm, as far as a blur of three pixels reaches.
    border_um: f64 = 24.0;
    /// Depth below that departure in which the step ends, µm: three standard deviations of a blur
    /// of a pixel; what shines farther below is no border.
    border_below_um: f64 = 8.0;
    /// Stretches of a trace of which the bounding curve is sought: all triples of 40 are 9880
    /// curves.
    envelope_blocks: usize = 40;
    /// Distance of a stretch from a curve on which it lies, µm: the traces of stretches scatter by
    /// a row of 2 µm.
    envelope_um: f64 = 4.0;
    /// Share of the stretches that may lie above the bounding curve: burrs, two of forty.
    envelope_above: f64 = 0.05;
    /// Share of the stretches that lie on it at least: six of forty, twice what a parabola passes
    /// through in any case.
    envelope_share: f64 = 0.15;
    /// Share of the stretches that the largest sagitta has to gain: about its vertex such a
    /// parabola stays within `envelope_um` of any straight stretch over a third of the edge, a
    /// flatter one over more.
    envelope_bend: f64 = 0.5;
    /// Rounds of reweighting of the reference curve. Tuned: see tests of flanks.
    edge_rounds: usize = 12;
    /// Log-odds of one pixel are worth no more: neighbours share what they are classified by.
    most_log_odds: f64 = 3.0;
    /// Pixels that share their features: the log-odds of a column are divided by it where the
    /// spread of the border is estimated.
    temperature: f64 = 6.0;
    /// Columns over which the border's departures are alike: half of the step of 40 µm over which
    /// features drawn out along the edge look.
    shared_columns: f64 = 12.0;
    /// Depth below the line of most detail in which steps are as sharp as an edge, µm. Tuned: see
    /// tests of flanks.
    step_um: f64 = 60.0;
    /// Share of the sharp steps about that line which the edge has at least: it may be dimly lit,
    /// what is out of focus has less than a tenth.
    sharp_share: f64 = 0.12;
    /// Steps over the 95th percentile of those in the air farthest above: set as `beyond_cells`.
    sharp_noise: f64 = 3.0;
    /// Places through which the line of the edge is laid: 1800 pairs have 1 % of scatter.
    line_places: usize = 60;
    /// Columns on each side over which the median of the first trees' border goes: 80 µm, less than
    /// a notch is wide.
    context_columns: usize = 20;
    /// Largest distance from that border which the second trees distinguish, rows: 80 µm, beyond
    /// which it is no border's.
    context_rows: usize = 40;
    /// Columns on each side over which the median of that border goes at its widest: 400 µm, twice
    /// what one reflex or lump hides, a quarter of a worn edge.
    context_wide_columns: usize = 100;
    /// Largest distance from that wider median which the second trees distinguish, rows: 300 µm.
    context_wide_rows: usize = 150;
    /// Flank that is seen below a land at least, over the land's width: its border is known from
    /// both sides, and of a land that ends just inside of the field more lies outside.
    least_below: f64 = 0.25;
    /// Error of VB by the forest that is shipped, µm: root mean square over 6852 rendered tools
    /// within 12 % of a limit (`study flank --tools 10000 --size 640x480`, seed 100001; 70), where
    /// it decides; nine real flanks with masks drawn by hand have 60 of their green channel.
    shipped_vb_um: f64 = 70.0;
    /// The same of VBmax, µm (253; 189 of the real ones): the largest width of a wide land is read
    /// 230 µm too small in half of them.
    shipped_vb_max_um: f64 = 260.0;
    /// Groups of trees whose disagreement is the model's: of 16 trees four each, which classify
    /// nearly as well as all.
    tree_groups: usize = 4;
}

limits! {
    /// Which pixels of a labelled flank a forest is trained on.
    FlankTrainingLimits = "flank_training";
    /// Pixels that are drawn from an image near its border: as many of a class as there are, since
    /// the border's place follows from the odds of both.
    pixels: usize = 6000;
    /// Pixels that are drawn near borders in all, so that many images give fewer each: their trees
    /// fit the cache, and pixels of one image resemble each other more than those of two.
    all_pixels: usize = 500_000;
    /// Pixels that are drawn from what is farther below: a third of those near (`pixels`), since
    /// the border's place does not follow from them.
    far_pixels: usize = 2000;
    /// Flanks that hold all widths: ten a factor of 1.3 over the two decades of widths that are
    /// rendered.
    many_flanks: usize = 100;
    /// Least depth below the land that is near its border, rows: as deep as a land of 24 µm, since
    /// as many rows as a narrower one has would show little of what lies below.
    near_rows: usize = 12;
    /// Parts of which one each is left out when the first trees are grown for the second: of as
    /// many as there are trees in a group the forests would hardly differ.
    folds: usize = 3;
    /// Depth below the land from which pixels are drawn, rows: what is far below is never near it.
    below_rows: usize = 160;
}

impl FlankTrainingLimits {
    /// Scales at which a flank of so many is shown: lands twice as wide and half as wide look
    /// alike, and a dozen flanks hold few widths.
    pub(crate) fn scales(&self, flanks: usize) -> &'static [f64] {
        if flanks < self.many_flanks { &[1.0, 0.4, 0.65, 1.5] } else { &[1.0] }
    }

    /// Share of the pixels that the limits state which an image of so many gives.
    pub(crate) fn share(&self, flanks: usize) -> f64 {
        (self.all_pixels as f64 / (self.pixels * flanks.max(1)) as f64).min(1.0)
    }
}
