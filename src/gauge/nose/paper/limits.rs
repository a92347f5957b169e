//! Figures of the paper's way: those of its detector, and ours where it has none.

use crate::gauge::limit::limits;

limits! {
    /// How the paper's way finds edges and lines.
    PaperNoseLimits = "paper_nose";
    /// Upper threshold of Canny's hysteresis, in Sobel's units at 255 grey values from shadow to
    /// light; the paper has none. Blurred by σ an edge reaches 8·255/(σ'·√(2π)) with σ'² = σ² +
    /// 1.4² (the detector's own Gaussian): 443 at 1.2 px and 246 at 3 px, the most that is in
    /// focus. Half of that passes every edge in focus; noise of 4 grey values stays below 10.
    canny_high: f64 = 120.0;
    /// Lower threshold; the paper has none. J. Canny (1986): two to three times less.
    canny_low: f64 = 48.0;
    /// Of how many pixels one is taken for the levels of light and shadow: a median of some
    /// thousands is right to a fraction of a grey value.
    levels_of: usize = 16;
    /// Scale of the image in which lines are sought (LSD and the paper).
    scale: f64 = 0.8;
    /// Standard deviation of the Gaussian before it is made smaller, px: 0.6/0.8 (LSD).
    smooth_px: f64 = 0.75;
    /// Reach of that Gaussian, px: below 1e-3 of its height (LSD).
    reach_px: f64 = 2.8;
    /// Bound q of the error of a grey value (LSD and the paper).
    grey_error: f64 = 2.0;
    /// Tolerance τ of the angles of a region, degrees (LSD and the paper).
    tolerance_deg: f64 = 22.5;
    /// Least share of its rectangle that a region fills (LSD).
    density: f64 = 0.7;
    /// Factor by which a region that is less dense is made smaller, step by step (LSD).
    radius_step: f64 = 0.75;
    /// Factor γ of the number of tests (the paper).
    gamma: f64 = 2.0;
    /// Exponent of the number of tests: LSD's 5/2, for which the paper prints 2/5 (c09 of
    /// `reproduce 004`).
    exponent: f64 = 2.5;
    /// Most false alarms an image of a line that is kept; the paper has no limit, LSD has 1.
    false_alarms: f64 = 1.0;
    /// Departure of the lines' angle from the insert's up to which two lines are its edges,
    /// degrees: the tolerance of a corner with its seat, and some for lines of pixels.
    angle_deg: f64 = 4.0;
    /// Lines among which the two edges are sought: both ridges of a nose's edges, of the insert's
    /// other corners and of its holder.
    longest: usize = 16;
    /// Distance from a line within which an edge pixel is its, px: a ridge stands a pixel beside.
    near_px: f64 = 3.0;
    /// Step by which a line is turned, degrees; the paper has none. Half of it, the most that the
    /// angle stays off, moves the end of an edge of 1000 px by .04 px.
    step_deg: f64 = 0.005;
    /// Share of the nominal radius within which an edge pixel belongs to the nose: wear that leaves
    /// less breaks the insert.
    nose_share: f64 = 0.35;
}
