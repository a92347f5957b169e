//! The paper's nose: edge image, two lines, forced angle, centre, mean radius.

use glam::DVec2;

use super::centres::{Line, centres};
use super::edges::{edge_image, places};
use super::forced::{EdgeOfPaper, force, included_deg};
use super::limits::PaperNoseLimits;
use super::segment::Segment;
use super::segments::segments;
use crate::frame::FrameView;
use crate::gauge::nose::contour;
use crate::gauge::nose::error::NoseImageError;
use crate::gauge::nose::expected::check_direction;
use crate::gauge::nose::limits::NoseLimits;
use crate::gauge::nose::settings::ExpectedNose;

/// What the paper takes from the insert's data sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PaperSettings {
    /// Radius R0 of the new nose, px.
    pub nominal_radius_px: f64,
    /// Included angle of the insert, degrees.
    pub epsilon_deg: f64,
    /// Where the nose should point, where that is checked.
    pub expected: Option<ExpectedNose>,
}

/// A nose by the paper's way; places are (column, −row), px.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PaperNose {
    /// Included angle after one line was turned, degrees.
    pub angle_deg: f64,
    /// Included angle of the two lines as found, degrees.
    pub found_angle_deg: f64,
    /// Centre.
    pub centre: DVec2,
    /// Directions of the outward normals of both lines, counter-clockwise, degrees.
    pub normals_deg: [f64; 2],
    /// R0, px.
    pub nominal_radius_px: f64,
    /// Mean distance of the nose's edge pixels from the centre, px.
    pub mean_radius_px: f64,
    /// Middle of each degree of the nose, degrees, and the mean distance there, px; degrees without
    /// a pixel are left out.
    pub sectors: Vec<(f64, f64)>,
    /// The edge pixels of the nose.
    pub nose: Vec<DVec2>,
}

impl PaperNose {
    /// How far the nose reaches from the centre in a direction as seen, px.
    pub(crate) fn reach_px(&self, direction_deg: f64) -> f64 {
        let n = DVec2::from_angle(direction_deg.to_radians());
        self.nose.iter().map(|p| n.dot(*p - self.centre)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Measures a nose by the paper's way.
///
/// # Errors
/// No insert or several, no two lines at the insert's angle, no pixels on the nose, a direction
/// that is not the tool's.
pub(crate) fn measure_paper_nose(
    view: &FrameView<'_>,
    settings: &PaperSettings,
) -> Result<PaperNose, NoseImageError> {
    let limits = PaperNoseLimits::get();
    // one insert, as the other mode asks for
    contour::runs(view)?;
    let image = edge_image(view)?;
    let pixels = places(&image);
    let found = segments(&image);
    // on the nose a region of directions within ±τ has a chord of 2·R·sin τ at most
    let chord_px = 2.0 * settings.nominal_radius_px * limits.tolerance_deg.to_radians().sin();
    let least_px = NoseLimits::get().least_edge_px.max(chord_px);
    let (first, second, apex) =
        edges(&found, settings.epsilon_deg, least_px).ok_or(NoseImageError::NoNose {
            found: found.len(),
            least: least_px,
            low: settings.epsilon_deg - limits.angle_deg,
            high: settings.epsilon_deg + limits.angle_deg,
        })?;
    let mut lines = [first, second].map(|s| EdgeOfPaper::new(&s, apex, &pixels));
    let found_angle_deg = included_deg(&lines);
    force(&mut lines, settings.epsilon_deg);
    let r = settings.nominal_radius_px;
    let centre = centre(&lines, r).ok_or_else(|| NoseImageError::Fit("its edges are parallel".to_owned()))?;
    let normals = outward(&lines, centre);
    let nose = on_nose(&pixels, centre, normals, r);
    if nose.is_empty() {
        let why = format!("no edge pixel lies within {:.0} % of R0 on its nose", 1e2 * limits.nose_share);
        return Err(NoseImageError::Fit(why));
    }
    let normals_deg = normals.map(|n| n.to_angle().to_degrees().rem_euclid(360.0));
    settings.expected.iter().try_for_each(|expected| check_direction(normals_deg, 0.0, expected))?;
    let radii = nose.iter().map(|p| p.distance(centre));
    Ok(PaperNose {
        angle_deg: included_deg(&lines),
        found_angle_deg,
        centre,
        normals_deg,
        nominal_radius_px: r,
        mean_radius_px: radii.sum::<f64>() / nose.len() as f64,
        sectors: sectors(&nose, centre, normals),
        nose,
    })
}

/// The two longest segments, of `least` px at least, that enclose about the insert's angle, and
/// where they meet.
fn edges(found: &[Segment], epsilon_deg: f64, least: f64) -> Option<(Segment, Segment, DVec2)> {
    let limits = PaperNoseLimits::get();
    let long: Vec<Segment> =
        found.iter().copied().filter(|s| s.length() >= least).take(limits.longest).collect();
    let mut best: Option<(f64, (Segment, Segment, DVec2))> = None;
    for (k, first) in long.iter().enumerate() {
        for second in &long[k + 1..] {
            let Some(apex) = meeting(first, second) else { continue };
            let between = (first.middle() - apex).angle_to(second.middle() - apex).abs().to_degrees();
            let score = first.length().min(second.length());
            if (between - epsilon_deg).abs() <= limits.angle_deg && best.as_ref().is_none_or(|b| score > b.0)
            {
                best = Some((score, (*first, *second, apex)));
            }
        }
    }
    best.map(|b| b.1)
}

/// Where the lines of two segments meet; none of parallel ones.
fn meeting(a: &Segment, b: &Segment) -> Option<DVec2> {
    let (u, v) = (a.ends[1] - a.ends[0], b.ends[1] - b.ends[0]);
    let share = (b.ends[0] - a.ends[0]).perp_dot(v) / u.perp_dot(v);
    share.is_finite().then(|| a.ends[0] + share * u)
}

/// Equation 10: of the four points at R0 from both lines the one between the edges.
fn centre(lines: &[EdgeOfPaper; 2], radius_px: f64) -> Option<DVec2> {
    let of = |l: &EdgeOfPaper| {
        let normal = l.along.perp();
        Line { normal, constant: -normal.dot(l.at) }
    };
    let inwards = lines[0].along + lines[1].along;
    let four = centres([of(&lines[0]), of(&lines[1])], radius_px)?;
    four.into_iter().max_by(|p, q| inwards.dot(*p).total_cmp(&inwards.dot(*q)))
}

/// Outward unit normals, counter-clockwise over the nose.
fn outward(lines: &[EdgeOfPaper; 2], centre: DVec2) -> [DVec2; 2] {
    let [a, b] = lines.each_ref().map(|l| {
        let n = l.along.perp();
        if n.dot(l.at - centre) > 0.0 { n } else { -n }
    });
    if a.perp_dot(b) > 0.0 { [a, b] } else { [b, a] }
}

fn on_nose(pixels: &[DVec2], centre: DVec2, [from, to]: [DVec2; 2], radius_px: f64) -> Vec<DVec2> {
    let share = PaperNoseLimits::get().nose_share;
    let within = |p: &&DVec2| {
        let arm = **p - centre;
        let off = (arm.length() - radius_px).abs();
        off <= share * radius_px && from.perp_dot(arm) >= 0.0 && arm.perp_dot(to) >= 0.0
    };
    pixels.iter().filter(within).copied().collect()
}

fn sectors(nose: &[DVec2], centre: DVec2, [from, to]: [DVec2; 2]) -> Vec<(f64, f64)> {
    let sweep_deg = from.angle_to(to).to_degrees();
    let count = sweep_deg.round().max(1.0) as usize;
    let step = sweep_deg / count as f64;
    let mut sums = vec![(0.0, 0_usize); count];
    for p in nose {
        let arm = *p - centre;
        let sum = &mut sums[((from.angle_to(arm).to_degrees() / step).max(0.0) as usize).min(count - 1)];
        *sum = (sum.0 + arm.length(), sum.1 + 1);
    }
    let first = from.to_angle().to_degrees();
    let row = |(k, (sum, n)): (usize, (f64, usize))| {
        let direction = (first + (k as f64 + 0.5) * step).rem_euclid(360.0);
        (n > 0).then(|| (direction, sum / n as f64))
    };
    sums.into_iter().enumerate().filter_map(row).collect()
}
