//! Of a drawn silhouette: shoulder, cylinder, 24° cone, cylinder, arc, end face.

use glam::DVec2;

use super::expected::{ExpectedPiece, HalfSilhouette, Placement};
use super::found::FoundPiece;
use super::measurement::{GeneratrixError, measure_generatrix};
use crate::frame::{FrameView, PixelFormat, Pixels};
use crate::numerics::distributions::phi_cdf;
use crate::outline::{Arc, Piece};

const ROWS: usize = 400;
const COLUMNS: usize = 440;
const MM: f64 = 0.05;
const SIGMA_PX: f64 = 1.0;
const AT: Placement = Placement { axis_row_px: 199.3, zero_column_px: 20.4, mm_per_px: MM };
const CONE_RAD: f64 = 24.0 * std::f64::consts::PI / 180.0;
const RIGHT: f64 = std::f64::consts::FRAC_PI_2;

/// Corners (X, Z) in mm; the arc of 3 mm follows the last.
fn corners() -> [DVec2; 6] {
    let cone = 9.0 + 2.0 / CONE_RAD.tan();
    [[9.0, -9.0], [9.0, 4.0], [6.0, 4.0], [6.0, 9.0], [4.0, cone], [4.0, 16.0]].map(DVec2::from)
}

/// Distance of a point (X ≥ 0, Z) from the contour towards the light, mm.
fn distance(p: DVec2, cone_off_mm: f64) -> f64 {
    let mut corners = corners();
    // a cone that stands off along X, for a part that is not as drawn
    (corners[3].x, corners[4].x) = (corners[3].x + cone_off_mm, corners[4].x + cone_off_mm);
    let (centre, radius) = (DVec2::new(1.0, 16.0), 3.0);
    let segment = |a: DVec2, b: DVec2| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a + t * (b - a))
    };
    let mut nearest = corners.windows(2).map(|w| segment(w[0], w[1])).fold(f64::INFINITY, f64::min);
    nearest = nearest.min(segment(DVec2::new(1.0, 19.0), DVec2::new(-9.0, 19.0)));
    if p.x >= centre.x && p.y >= centre.y {
        nearest = nearest.min((p.distance(centre) - radius).abs());
    }
    let linear = |w: &[DVec2]| w[0].x + (w[1].x - w[0].x) * (p.y - w[0].y) / (w[1].y - w[0].y);
    let along = corners.windows(2).find(|w| w[0].y <= p.y && p.y < w[1].y);
    let height = along.map_or_else(
        || if p.y > 19.0 { -1.0 } else { 1.0 + (9.0 - (p.y - 16.0).powi(2)).max(0.0).sqrt() },
        linear,
    );
    if p.x < height { -nearest } else { nearest }
}

/// The frame in counts, 12 bit; `speck` is a shadow of contamination (column, row, radius).
fn drawn(cone_off_mm: f64, speck: Option<[f64; 3]>) -> Vec<u16> {
    let light = |column: f64, row: f64| {
        let x = (AT.axis_row_px - row).abs() * MM;
        let d = distance(DVec2::new(x, (column - AT.zero_column_px) * MM), cone_off_mm) / MM;
        let beside = speck.map_or(f64::INFINITY, |[c, r, radius]| (column - c).hypot(row - r) - radius);
        phi_cdf(d.min(beside) / SIGMA_PX)
    };
    let pixel = |k: usize| {
        let (row, column) = ((k / COLUMNS) as f64, (k % COLUMNS) as f64);
        let middle = light(column, row);
        // subsamples where the edge is near
        let whole = if (1e-9..1.0 - 1e-9).contains(&middle) {
            let at = |i: usize| (i as f64 + 0.5) / 4.0 - 0.5;
            (0..16).map(|i| light(column + at(i % 4), row + at(i / 4))).sum::<f64>() / 16.0
        } else {
            middle
        };
        let noise = ((k as f64 * 0.618_033_988_7).fract() - 0.5) * 40.0;
        (300.0 + 2800.0 * whole + noise) as u16
    };
    (0..ROWS * COLUMNS).map(pixel).collect()
}

/// Cone, cylinder, shoulder and arc in both halves.
fn expected() -> Vec<ExpectedPiece> {
    let c = corners();
    let arc = Arc { centre: DVec2::new(1.0, 16.0), radius_mm: 3.0 };
    let pieces = [
        Piece::line(c[3], c[4], CONE_RAD).between(0.1, 0.9),
        Piece::line(c[3], c[2], 0.0).between(0.1, 0.8),
        Piece::line(c[2], c[1], RIGHT).between(0.15, 0.85),
        Piece::arc(arc, 0.1, RIGHT - 0.1),
    ];
    [HalfSilhouette::Above, HalfSilhouette::Below]
        .into_iter()
        .flat_map(|half| pieces.map(|piece| ExpectedPiece { piece, half }))
        .collect()
}

fn measured(values: &[u16]) -> Result<Vec<FoundPiece>, GeneratrixError> {
    let view = FrameView::new(Pixels::U16(values), PixelFormat::Mono12, ROWS, COLUMNS, COLUMNS).unwrap();
    measure_generatrix(&view, &expected(), &AT)
}

/// Distance of a found line from the middle of its piece, px.
fn off_px(found: &FoundPiece, wanted: &ExpectedPiece) -> f64 {
    let (normal, d) = found.line().unwrap().in_mm(&AT, 0.0);
    let turned = DVec2::from_angle(wanted.piece.from_rad);
    // 20 calipers of .02 px over 100 px determine a direction to 1e-4
    assert!(normal.perp_dot(turned).abs() < 5e-4, "{normal} {turned}");
    (d - normal.dot(wanted.piece.at(0.5))) / MM
}

#[test]
fn lines_at_any_angle_and_an_arc_are_where_they_are_drawn() {
    let found = measured(&drawn(0.0, None)).unwrap();
    for (piece, wanted) in found.iter().zip(expected()) {
        assert_eq!(piece.left_out(), 0, "{wanted:?}");
        if let Some(arc) = piece.arc() {
            let (centre, radius_mm) = arc.in_mm(&AT, 0.0);
            // drawn along the radius, without the shift σ²/2R of a lens that the measurement takes
            // off
            let lens = 0.5 * SIGMA_PX * SIGMA_PX / 60.0;
            let off = radius_mm / MM - 60.0 - lens;
            assert!(off.abs() < 0.02, "radius {off} px");
            assert!(centre.distance(DVec2::new(1.0, 16.0)) / MM < 0.03, "{centre}");
        } else {
            let off = off_px(piece, &wanted);
            assert!(off.abs() < 4e-3, "{wanted:?}: {off} px");
        }
    }
}

#[test]
fn a_cone_off_its_drawing_is_followed_and_an_edge_offset_moves_every_piece_along_its_normal() {
    let found = measured(&drawn(0.2, None)).unwrap();
    let wanted = expected();
    for (piece, wanted) in found.iter().zip(&wanted).filter(|(_, w)| w.piece.from_rad == CONE_RAD) {
        // .2 mm along X are .2·cos 24° along the normal
        let off = off_px(piece, wanted) * MM - 0.2 * CONE_RAD.cos();
        assert!(off.abs() < 2e-4, "{off} mm");
        let line = piece.line().unwrap();
        let moved = line.in_mm(&AT, 0.01).1 - line.in_mm(&AT, 0.0).1;
        assert!((moved - 0.01).abs() < 1e-12);
    }
}

#[test]
fn contamination_on_a_cone_of_24_degrees_is_left_out_by_its_distance_from_the_line() {
    let clean = measured(&drawn(0.0, None)).unwrap();
    // on the middle of the upper half's cone, 8 px in radius: it protrudes by 8 px over 16
    let place = AT.place(expected()[0].piece.at(0.5), HalfSilhouette::Above);
    let dirty = measured(&drawn(0.0, Some([place.x, -place.y, 8.0]))).unwrap();
    assert!((2..=6).contains(&dirty[0].left_out()), "{}", dirty[0].left_out());
    let (one, two) = (off_px(&clean[0], &expected()[0]), off_px(&dirty[0], &expected()[0]));
    assert!((one - two).abs() < 0.01, "{one} {two}");
    assert!((1..8).all(|k| dirty[k].left_out() == 0));
}

#[test]
fn what_is_not_there_or_too_short_is_named() {
    let values = drawn(0.0, None);
    let view = FrameView::new(Pixels::U16(&values), PixelFormat::Mono12, ROWS, COLUMNS, COLUMNS).unwrap();
    // a cone of 40° where one of 24° is
    let c = corners();
    let piece = Piece::line(c[3], c[3] + DVec2::new(-2.0, 2.4), 40f64.to_radians());
    let wrong = [ExpectedPiece { piece, half: HalfSilhouette::Above }];
    let said = measure_generatrix(&view, &wrong, &AT).unwrap_err().to_string();
    assert!(said.contains("piece 1") || said.contains("expected outline"), "{said}");
    let piece = Piece::line(c[2], c[1], RIGHT).between(0.4, 0.6);
    let short = measure_generatrix(&view, &[ExpectedPiece { piece, half: HalfSilhouette::Above }], &AT);
    assert_eq!(short.unwrap_err(), GeneratrixError::Short { piece: 1, calipers: 1, least: 5 });
}
