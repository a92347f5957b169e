//! The tool's geometry: handbook factors on the three force components, and the height of the feed
//! marks.
//!
//! A handbook's force is that of a reference tool (lead angle κ_r 45°, rake γ 10°, inclination λ_s
//! 0°, nose radius 2 mm) times one factor per parameter: K = K_κ·K_γ·K_λ·K_r. Carbide on steel: A.
//! G. Kosilova, R. K. Meshcheryakov (eds), Spravochnik tekhnologa-mashinostroitelya, vol. 2,
//! Mashinostroenie 1985, table 23; the rake of 20° from Ai Xing, Xiao Shigang, Qiexiao yongliang
//! jianming shouce (Concise handbook of cutting data), 1994, which reprints the others. λ_s is ISO
//! 3002's (the handbook's has the opposite sign). The row of nose radii is given there for
//! high-speed steel and is used for carbide too, interpolated linearly in logarithms, because no
//! other is at hand.
//!
//! The books themselves were not at hand; some entries could be checked in public text. A worked
//! example that cites table 23, p. 275 (ukrbukva.net 56407, p. 18) has the entries on F_c for 90°,
//! 10°, 0° and, interpolated in logarithms, r = 0.8 mm. No public text with the entries on F_p and
//! F_f was found. Two facts support those of F_p: the paper's Table 2 follows the handbook's law
//! with this insert's product of factors within 3 % (`reproduce 003`, row table2.handbook; the
//! paper computed its forces by such a formula), and makers of inserts give the same directions
//! (ZCC-CT catalogue 2019, p. 451: a larger lead angle and a smaller nose reduce the radial force
//! on a slender shaft). The paper's nose radius of 0.4 mm lies below the table and is extrapolated.
//!
//! Those tables have no factor for relief (α) and minor cutting edge angle (κ'_r): between 4° and
//! 15° of relief and beyond 3° of minor angle the force does not depend on them within the scatter
//! of such data (10-20 %). They are taken as 1. The minor angle shapes the feed marks instead, see
//! [`feed_mark_mm`].

use serde::Serialize;

use super::tool::ToolSettings;

/// Factors on the force components; 1 for the handbook's reference tool.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct ToolFactors {
    /// On F_c, tangential.
    pub cutting: f64,
    /// On F_f, axial.
    pub feed: f64,
    /// On F_p, radial.
    pub passive: f64,
}

/// (degrees or mm, factor on F_c, F_p, F_f).
type Line = (f64, [f64; 3]);

const LEAD: [Line; 4] = [
    (30.0, [1.08, 1.30, 0.78]),
    (45.0, [1.0, 1.0, 1.0]),
    (60.0, [0.94, 0.77, 1.11]),
    (90.0, [0.89, 0.50, 1.17]),
];
const RAKE: [Line; 4] =
    [(-15.0, [1.25, 2.0, 2.0]), (0.0, [1.1, 1.4, 1.4]), (10.0, [1.0, 1.0, 1.0]), (20.0, [0.9, 0.7, 0.7])];
const INCLINATION: [Line; 4] =
    [(-15.0, [1.0, 1.7, 0.65]), (-5.0, [1.0, 1.25, 0.85]), (0.0, [1.0, 1.0, 1.0]), (5.0, [1.0, 0.75, 1.07])];
const NOSE: [Line; 5] = [
    (0.5, [0.87, 0.66, 1.0]),
    (1.0, [0.93, 0.82, 1.0]),
    (2.0, [1.0, 1.0, 1.0]),
    (3.0, [1.04, 1.14, 1.0]),
    (5.0, [1.10, 1.33, 1.0]),
];

/// The value of a table at `x`, linear between its lines and held at its ends.
fn held(table: &[Line], x: f64) -> [f64; 3] {
    let x = x.clamp(table[0].0, table[table.len() - 1].0);
    let above = table.iter().position(|line| line.0 >= x).unwrap_or(table.len() - 1).max(1);
    let ((x0, low), (x1, high)) = (table[above - 1], table[above]);
    let share = (x - x0) / (x1 - x0);
    std::array::from_fn(|i| low[i] + share * (high[i] - low[i]))
}

/// The value of a table at `x`, linear in logarithms between its lines and beyond both ends.
fn power(table: &[Line], x: f64) -> [f64; 3] {
    let above = table.iter().position(|line| line.0 >= x).unwrap_or(table.len() - 1).max(1);
    let ((x0, low), (x1, high)) = (table[above - 1], table[above]);
    let share = (x / x0).ln() / (x1 / x0).ln();
    std::array::from_fn(|i| low[i] * (high[i] / low[i]).powf(share))
}

impl ToolFactors {
    /// All factors 1.
    pub(crate) const ONE: Self = Self { cutting: 1.0, feed: 1.0, passive: 1.0 };

    /// All factors of a tool relative to the handbook's reference tool. Angles outside the tables
    /// (κ_r 30-90°, γ -15 to 20°, λ_s -15 to 5°) take the table's end.
    pub(crate) fn of(tool: &ToolSettings) -> Self {
        let all = [
            held(&LEAD, tool.lead_angle_deg),
            held(&RAKE, tool.rake_deg),
            held(&INCLINATION, tool.inclination_deg),
            power(&NOSE, tool.nose_radius_mm),
        ];
        Self::product(&all)
    }

    /// The factors of a tool whose edge is integrated (Kienzle): lead angle and nose radius are in
    /// the integral, rake and inclination remain, relative to the 6° and 0° of the tabulated kc1.1.
    pub(crate) fn beside_the_edge(tool: &ToolSettings) -> Self {
        let at = |rake: f64, inclination: f64| {
            Self::product(&[held(&RAKE, rake), held(&INCLINATION, inclination)])
        };
        at(tool.rake_deg, tool.inclination_deg).over(&at(TABULATED_RAKE_DEG, 0.0))
    }

    /// These factors relative to another tool's; exactly 1 for the same tool.
    #[must_use]
    pub(crate) fn over(&self, other: &Self) -> Self {
        Self {
            cutting: self.cutting / other.cutting,
            feed: self.feed / other.feed,
            passive: self.passive / other.passive,
        }
    }

    fn product(all: &[[f64; 3]]) -> Self {
        let of = |i: usize| all.iter().map(|factors| factors[i]).product();
        Self { cutting: of(0), passive: of(1), feed: of(2) }
    }
}

/// Rake of the tools behind the tabulated kc1.1 (see `process::material`), degrees.
const TABULATED_RAKE_DEG: f64 = 6.0;

/// Theoretical height of the feed marks, mm: f²/8r where the nose alone draws them (f ≤ 2r·sin
/// κ'_r, exact form), beyond that the nose and the straight minor edge (G. Boothroyd, W. Knight,
/// Fundamentals of Machining and Machine Tools, chapter on roughness).
pub(crate) fn feed_mark_mm(feed_mm_per_rev: f64, tool: &ToolSettings) -> f64 {
    let (f, r) = (feed_mm_per_rev, tool.nose_radius_mm);
    let (sin, cos) = tool.minor_angle_deg.to_radians().sin_cos();
    if f <= 2.0 * r * sin {
        return f * f / (8.0 * r);
    }
    r * (1.0 - cos) + f * sin * cos - (sin * sin * sin * (2.0 * f * r - f * f * sin)).max(0.0).sqrt()
}

/// The largest feed whose marks are at most `height_mm` high, mm/r, up to `most_mm_per_rev`. The
/// height grows with the feed.
pub(crate) fn largest_feed_mm_per_rev(height_mm: f64, most_mm_per_rev: f64, tool: &ToolSettings) -> f64 {
    let by_nose = (8.0 * tool.nose_radius_mm * height_mm).sqrt();
    if by_nose <= 2.0 * tool.nose_radius_mm * tool.minor_angle_deg.to_radians().sin() {
        return by_nose.min(most_mm_per_rev);
    }
    let (mut low, mut high) = (0.0, most_mm_per_rev);
    if feed_mark_mm(high, tool) <= height_mm {
        return high;
    }
    // 80 halvings exhaust the resolution of a double.
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        (low, high) = if feed_mark_mm(middle, tool) <= height_mm { (middle, high) } else { (low, middle) };
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: ToolFactors, [cutting, passive, feed]: [f64; 3]) {
        for (found, expected) in [(found.cutting, cutting), (found.passive, passive), (found.feed, feed)] {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn the_handbooks_lines_and_reference_tool() {
        let reference = ToolSettings {
            nose_radius_mm: 2.0,
            lead_angle_deg: 45.0,
            rake_deg: 10.0,
            inclination_deg: 0.0,
            ..ToolSettings::default()
        };
        assert_near(ToolFactors::of(&reference), [1.0; 3]);
        let steep = ToolSettings { lead_angle_deg: 90.0, ..reference };
        assert_near(ToolFactors::of(&steep), [0.89, 0.50, 1.17]);
        // r = 0.8 mm: 0.91 on F_c, as users of the handbook interpolate it in logarithms.
        let small = ToolSettings { nose_radius_mm: 0.8, ..reference };
        assert!((ToolFactors::of(&small).cutting - 0.91).abs() < 5e-4);
        // Half way between 0° and -5°, and beyond the end of the table.
        let down = |inclination_deg| ToolFactors::of(&ToolSettings { inclination_deg, ..reference }).passive;
        assert!((down(-2.5) - 1.125).abs() < 1e-12 && (down(-40.0) - 1.7).abs() < 1e-12);
        let sharp = ToolSettings { rake_deg: TABULATED_RAKE_DEG, inclination_deg: 0.0, ..steep };
        assert_eq!(ToolFactors::beside_the_edge(&sharp), ToolFactors::ONE);
    }

    /// The height of the marks by brute force: the profile is the lower envelope of tool tips one
    /// feed apart.
    fn by_envelope(feed: f64, tool: &ToolSettings) -> f64 {
        let (r, minor) = (tool.nose_radius_mm, tool.minor_angle_deg.to_radians());
        let edge = |x: f64| {
            // The nose up to where the minor edge is its tangent, then the straight line.
            let tangent = r * minor.sin();
            if x.abs() <= tangent {
                r - (r * r - x * x).sqrt()
            } else if x > 0.0 {
                r * (1.0 - minor.cos()) + (x - tangent) * minor.tan()
            } else if x >= -r {
                r - (r * r - x * x).sqrt()
            } else {
                f64::INFINITY
            }
        };
        let n = 200_000;
        (0..=n)
            .map(|i| feed * f64::from(i) / f64::from(n))
            .map(|x| edge(x).min(edge(x - feed)))
            .fold(0.0, f64::max)
    }

    #[test]
    fn feed_marks_are_the_envelopes() {
        for (minor_angle_deg, feed) in [(15.0, 0.1), (15.0, 0.35), (5.0, 0.2), (3.0, 0.3)] {
            let tool = ToolSettings { minor_angle_deg, ..ToolSettings::default() };
            let (ours, drawn) = (feed_mark_mm(feed, &tool), by_envelope(feed, &tool));
            // f²/8r is the circle's height with a relative error of (f/2r)²/4.
            let limit = if feed > 0.3 * tool.nose_radius_mm { 2e-3 } else { 5e-3 };
            assert!((ours / drawn - 1.0).abs() < limit, "{minor_angle_deg}° {feed}: {ours} against {drawn}");
            let back = largest_feed_mm_per_rev(ours, 1.0, &tool);
            assert!((back / feed - 1.0).abs() < 1e-9, "{back}");
        }
    }
}
