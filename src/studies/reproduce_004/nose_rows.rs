//! The nose as the paper measures it: scale, radii, line detector, centre, insert.

use glam::DVec2;

use super::inputs::{Inputs, TENTH_UM_MM};
use crate::gauge::nose::paper::{self, Line};
use crate::nose::ToolGeometry;
use crate::studies::reproduction::{Accept, Row};

/// Pixel pitch of the camera by its data sheet, µm; the paper names the camera alone.
const PIXEL_UM: f64 = 2.4;
/// Columns and rows of that camera.
pub(super) const CAMERA_PX: (u32, u32) = (3072, 2048);
/// Magnifications of the two lenses of section 2 by their names, MVL-HT-07-110 and MVL-HT-1-110.
const LENSES: [f64; 2] = [0.7, 1.0];
/// Pixels of the region of the example of equation 7.
const REGION_PX: u32 = 100;

pub(super) fn rows(inputs: &Inputs, geometry: &ToolGeometry) -> Vec<Row> {
    [scale(inputs), detector(inputs), centre(inputs), insert(inputs, geometry)].concat()
}

fn scale(inputs: &Inputs) -> Vec<Row> {
    let mm = |px: f64| 1e-3 * inputs.scale_um_per_px * px;
    let printed = |names: (&str, &str, &str), paper: f64, ours: f64, reason: &str| {
        Row::printed(names, Some(paper), ours, Accept::Absolute(TENTH_UM_MM), reason)
    };
    vec![
        Row::ours(
            ("nose.magnification", "magnification of the lens", ""),
            PIXEL_UM / inputs.scale_um_per_px,
            "the camera's pixel pitch of 2.4 µm, by its data sheet, over S (section 2.2)",
        ),
        Row::in_sample(
            ("nose.lens", "magnification of the lens that this is", ""),
            Some(LENSES[1]),
            PIXEL_UM / inputs.scale_um_per_px,
            Accept::Relative(0.02),
            format!(
                "MVL-HT-1-110 by its name; MVL-HT-07-110 would have a scale of {:.3} µm/px",
                PIXEL_UM / LENSES[0]
            ),
        ),
        Row::ours(
            ("nose.field.columns", "width of the field", "mm"),
            mm(f64::from(CAMERA_PX.0)),
            "3072 pixels of the camera, by its data sheet, at S",
        ),
        Row::ours(
            ("nose.field.rows", "height of the field", "mm"),
            mm(f64::from(CAMERA_PX.1)),
            "2048 pixels",
        ),
        printed(
            ("nose.r", "mean radius r of the worn nose", "mm"),
            inputs.radius_mm,
            mm(inputs.mean_radius_px),
            "S times 154.9826 px (section 2.2)",
        ),
        printed(
            ("nose.gap", "mean gap between the worn nose and the tangents along X and Z", "mm"),
            inputs.gap_mm,
            mm(inputs.gap_px),
            "S times 5.5901 px",
        ),
        printed(
            ("nose.R1", "radius R1 after setting", "mm"),
            inputs.set_radius_mm,
            inputs.nominal_mm - mm(inputs.gap_px),
            "R0 less the gap",
        ),
        Row::ours(("nose.d", "d = R1 − r of the printed radii", "mm"), inputs.d_mm(), "section 3.1"),
        Row::ours(
            ("nose.d.pixels", "d of the figures in pixels", "mm"),
            inputs.d_of_pixels_mm(),
            "R0 less S times gap and mean radius",
        ),
        Row::ours(
            ("nose.R0.pixels", "unworn radius R0 in pixels", "px"),
            1e3 * inputs.nominal_mm / inputs.scale_um_per_px,
            "R0 over S",
        ),
    ]
}

fn detector(inputs: &Inputs) -> Vec<Row> {
    let tau = inputs.tolerance_deg.to_radians();
    // a direction within ±τ by chance
    let p = inputs.tolerance_deg / 180.0;
    let aligned = |exponent: f64| {
        let tests = paper::tests(CAMERA_PX, exponent, inputs.gamma);
        paper::aligned_needed(REGION_PX, p, tests).map_or(f64::NAN, f64::from)
    };
    vec![
        Row::ours(
            ("lsd.rho", "least gradient ρ = q/sin τ", ""),
            paper::gradient_threshold(inputs.grey_error, tau),
            "q 2, τ 22.5°; the paper prints no value, and the text has lost the bar of this fraction",
        ),
        Row::identity(
            ("eq6.whole", "eq. 6, B(n, 0, p) less 1", ""),
            paper::binomial_tail(REGION_PX, 0, p) - 1.0,
            1e-9,
            "all outcomes together are certain",
        ),
        Row::ours(
            ("eq7.aligned", "pixels of 100 that must agree for one false alarm an image", ""),
            aligned(2.5),
            "eq. 7 with the exponent 5/2, γ 2, p = τ/180° and 3072 × 2048 pixels; p, the limit of the false alarms and Canny's \
             thresholds are not printed",
        ),
        Row::ours(
            ("eq7.aligned.printed", "the same with the exponent 2/5", ""),
            aligned(inputs.exponent),
            "fewer are enough, so that arcs and stains pass for lines",
        ),
    ]
}

fn centre(inputs: &Inputs) -> Vec<Row> {
    // the edges meet at the origin, the insert lies about +x
    let half = (0.5 * inputs.epsilon_r_deg).to_radians();
    let line = |side: f64| Line { normal: DVec2::new(half.sin(), side * half.cos()), constant: 0.0 };
    let lines = [line(1.0), line(-1.0)];
    let four = paper::centres(lines, inputs.nominal_mm).map_or(Vec::new(), |four| four.to_vec());
    let inside: Vec<DVec2> = four.iter().copied().filter(|p| p.to_angle().abs() < half).collect();
    let reach = inside.first().map_or(f64::NAN, |p| p.length());
    let away = four.iter().flat_map(|p| lines.map(|l| (l.distance(*p).abs() - inputs.nominal_mm).abs()));
    vec![
        Row::identity(
            ("eq10.distance", "eqs 8-10: distance of the solutions from both lines less R0, largest", "mm"),
            away.fold(0.0, f64::max),
            1e-12,
            "four points lie at R0 from two lines",
        ),
        Row::printed(
            ("eq10.inside", "solutions of eq. 10 inside the insert", ""),
            Some(1.0),
            inside.len() as f64,
            Accept::Absolute(0.0),
            "of four, for lines at 60°",
        ),
        Row::printed(
            ("eq10.discarded", "solutions of eq. 10 that are discarded", ""),
            Some(3.0),
            (four.len() - inside.len()) as f64,
            Accept::Absolute(0.0),
            "the others lie beside or behind the insert",
        ),
        Row::ours(
            ("eq10.corner", "distance of the centre from the corner of the lines", "mm"),
            reach,
            "R0/sin 30°: an error of both lines along their bisector enters the centre whole, one across each line doubled",
        ),
    ]
}

fn insert(inputs: &Inputs, geometry: &ToolGeometry) -> Vec<Row> {
    // ISO 1832: T is a triangle, the last two digits are tenths of a millimetre of the nose radius
    let digits = inputs.designation.get(8..10).and_then(|text| text.parse::<f64>().ok());
    let angle = if inputs.designation.starts_with('T') { 60.0 } else { f64::NAN };
    let (low, high) = geometry.range_rad();
    let named = "by the designation TNMG160404TSBB60 (ISO 1832)";
    let input = |names: (&str, &str, &str), paper: f64, ours: f64| {
        Row::in_sample(names, Some(paper), ours, Accept::Absolute(1e-9), named)
    };
    vec![
        input(
            ("insert.R0", "radius R0 of the unworn nose", "mm"),
            inputs.nominal_mm,
            digits.map_or(f64::NAN, |d| 0.1 * d),
        ),
        input(("insert.epsilon_r", "included angle ε_r", "°"), inputs.epsilon_r_deg, angle),
        Row::ours(
            ("insert.range.low", "steepest falling surface that the nose can cut, normal's angle", "°"),
            low.to_degrees(),
            "−κ_r' = κ_r + ε_r − 180° (ISO 3002-1)",
        ),
        Row::ours(
            ("insert.range.high", "steepest rising surface, normal's angle", "°"),
            high.to_degrees(),
            "κ_r",
        ),
    ]
}
