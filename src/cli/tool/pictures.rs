//! Charts of `tool compensate`: what each way leaves along the outline, and the path.

use glam::DVec2;

use crate::outline::{Outline, Piece};
use crate::report::plot::{Chart, Mark, Series};
use crate::tool::{Compensated, Remainder, Way};

/// Largest sagitta of the chords of a drawn arc, mm: below a tenth of a pixel.
const SAGITTA_MM: f64 = 0.002;

/// What each way leaves over the length of the outline.
///
/// # Errors
/// Where the drawing fails, as text.
pub(super) fn left(all: &[(Way, &[Remainder])], outline: &Outline) -> Result<String, String> {
    let lengths: Vec<f64> = outline.pieces.iter().map(Piece::length_mm).collect();
    let along = |r: &Remainder| {
        let piece = &outline.pieces[r.source];
        lengths[..r.source].iter().sum::<f64>() + piece.share_of(r.at) * lengths[r.source]
    };
    let series = |(i, (way, left)): (usize, &(Way, &[Remainder]))| {
        let shown = |r: &Remainder| (along(r), if r.reached { 1e3 * r.left_mm } else { f64::NAN });
        Series::new(way.as_str().replace('_', " "), Mark::Line, i, left.iter().map(shown).collect())
    };
    let chart = Chart {
        x_label: "along the outline, from its first corner / mm".into(),
        y_label: "left along the normal / µm".into(),
        series: all.iter().enumerate().map(series).collect(),
        ..Chart::default()
    };
    chart.to_svg()
}

/// The part, what is programmed, and the path of the tool point.
///
/// # Errors
/// Where the drawing fails, as text.
pub(super) fn path(outline: &Outline, done: &Compensated) -> Result<String, String> {
    let points = |pieces: &mut dyn Iterator<Item = Piece>| -> Vec<(f64, f64)> {
        let all: Vec<DVec2> = pieces.flat_map(|p| p.points(SAGITTA_MM)).collect();
        all.into_iter().map(|p| (p.y, p.x)).collect()
    };
    let part = points(&mut outline.pieces.iter().copied());
    let programmed = points(&mut done.programmed.iter().map(|e| e.piece));
    let tool = points(&mut done.path.iter().map(|e| e.piece));
    let chart = Chart {
        x_label: "Z / mm".into(),
        y_label: "distance from the axis / mm".into(),
        series: vec![
            Series::new("part", Mark::Line, 0, part),
            Series::new("programmed", Mark::Dashed, 1, programmed),
            Series::new("tool point", Mark::Faint, 2, tool),
        ],
        equal_axes: true,
        ..Chart::default()
    };
    chart.to_svg()
}
