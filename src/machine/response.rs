//! What a cut, a probe and a head make of a pose: the change of a diameter, mm.
//!
//! A tool at u cuts D + 2·u_x + 2h·u_y/R − D′·u_z (h: its tip above the axis, D′ = dD/dz), a probe
//! at u reads the negative of that, the same with its side turned over. A two-sided head faces
//! −y from its entrance pupil at the distance ℓ of the axis (infinite: telecentric) and images
//! the angle between the tangents; scaled at its nominal distance, it reads to first order
//!
//! ```text
//! ΔD = −D·u_y/ℓ + D·b²/2 + D′·(u_z + a·R²/ℓ) + 2κ·D·u_x − b·Δz + c·Δy
//! ```
//!
//! with a, b, c its turns, κ the keystone of its image and Δz, Δy how far the two edges of a pair
//! of single-sided heads stand apart. Its midline is −u_x. The functions are exact for a cylinder
//! in u, first order in the taper; a turn b counts before the gauge takes out cos b.

use super::chain::Pose;

/// The part where it is machined or measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Growth of the diameter with z.
    pub taper: f64,
}

/// Which side of the axis a probe touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// The tool's, x above 0.
    Tool,
    /// The other, x below 0.
    Opposite,
}

/// A head that images both edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TwoSided {
    /// From the axis to the entrance pupil along y, mm; infinite for a telecentric lens.
    pub pupil_mm: f64,
    /// Keystone: growth of the scale along x, 1/mm.
    pub keystone_per_mm: f64,
    /// How far the upper edge's head stands from the lower edge's, [y, z], mm; 0 for one head.
    pub pair_mm: [f64; 2],
}

/// Change of the diameter that a tool cuts; `tip_mm` is its height above the axis.
pub(crate) fn cut_mm(part: &Part, tip_mm: f64, pose: &Pose) -> f64 {
    let radius = 0.5 * part.diameter_mm;
    let u = pose.shift_mm;
    let set = (radius * radius - tip_mm * tip_mm).sqrt();
    hypotenuse_change(radius, [set, tip_mm], [u.x, u.y]) - part.taper * u.z
}

/// Change of the diameter that a probe reads whose tip stands `tip_mm` above the axis; its ball
/// counts as a point.
pub(crate) fn probe_mm(part: &Part, tip_mm: f64, side: Side, pose: &Pose) -> f64 {
    let radius = 0.5 * part.diameter_mm;
    let u = pose.shift_mm;
    let height = tip_mm + u.y;
    // The contact's x at the height of the tip, against that at the nominal height.
    let set = (radius * radius - tip_mm * tip_mm).sqrt();
    let contact = -(2.0 * tip_mm + u.y) * u.y / (set + (radius * radius - height * height).sqrt());
    let towards = match side {
        Side::Tool => -u.x,
        Side::Opposite => u.x,
    };
    hypotenuse_change(radius, [set, tip_mm], [contact + towards, 0.0]) + part.taper * u.z
}

/// 2·(|p + d| − |p|) with |p| = r, without the difference of close numbers.
fn hypotenuse_change(r: f64, p: [f64; 2], d: [f64; 2]) -> f64 {
    let after = (p[0] + d[0]).hypot(p[1] + d[1]);
    2.0 * (2.0 * (p[0] * d[0] + p[1] * d[1]) + d[0] * d[0] + d[1] * d[1]) / (after + r)
}

impl TwoSided {
    /// Change of the diameter that the head reads.
    pub(crate) fn read_mm(&self, part: &Part, pose: &Pose) -> f64 {
        let (d, u, turn) = (part.diameter_mm, pose.shift_mm, pose.turn_rad);
        let radius = 0.5 * d;
        let turned = d * (1.0 / turn.y.cos() - 1.0);
        // The rays touch at y = R²/ℓ; the image grows with the radius by 1/(1 − R²/ℓ²).
        let sine = radius / self.pupil_mm;
        let tapered = part.taper * (u.z + turn.x * radius * sine) / (1.0 - sine * sine);
        let keystone = 2.0 * self.keystone_per_mm * d * u.x;
        let pair = turn.z * self.pair_mm[0] - turn.y * self.pair_mm[1];
        self.perspective_mm(radius, [u.x, u.y]) + turned + tapered + keystone + pair
    }

    /// What the change of distance and the offset across do to the angle between the tangents.
    fn perspective_mm(&self, radius: f64, [across, away]: [f64; 2]) -> f64 {
        if !self.pupil_mm.is_finite() {
            return 0.0;
        }
        let nominal = width(self.pupil_mm, radius, [0.0, 0.0]);
        let moved = width(self.pupil_mm, radius, [across, away]);
        2.0 * radius * (moved - nominal) / nominal
    }

    /// The height of the midline of both edges in the head's image, mm.
    pub(crate) fn midline_mm(pose: &Pose) -> f64 {
        -pose.shift_mm.x
    }
}

/// Width of a disc's image at the nominal distance ℓ, for a pupil moved by [across, away]: the
/// tangents lie at β ± α with β towards the centre and sin α = R over the distance, and
/// tan(β + α) − tan(β − α) = sin 2α/(cos² β − sin² α).
fn width(pupil_mm: f64, radius: f64, [across, away]: [f64; 2]) -> f64 {
    let distance = (pupil_mm + away).hypot(across);
    let sine = radius / distance;
    let towards = (pupil_mm + away) / distance;
    pupil_mm * 2.0 * sine * (1.0 - sine * sine).sqrt() / (towards * towards - sine * sine)
}
