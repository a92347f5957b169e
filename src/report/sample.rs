//! Figures of a frame with its edges.

use std::fmt::Write as _;

use image::GrayImage;

use super::html::{Page, base64};
use super::picture::{Stretch, encode, picture};
use super::plot::{Chart, Mark, Series};
use crate::cell::frame_of_pass;
use crate::closed_loop::Sample;
use crate::frame::FrameView;
use crate::gauge::Edge;

/// Width of the overview picture, px.
const OVERVIEW_PX: usize = 816;
/// Columns and rows of the magnified corner around the upper edge.
const CROP: (usize, usize) = (48, 24);
/// Approximate number of columns, spread over the frame, of the edge profile.
const PROFILE_COLUMNS: usize = 200;
/// Half width of the edge profile, px.
const PROFILE_REACH_PX: f64 = 7.0;

/// A frame and its edges per column, rows in px; `None` where there is a gap.
struct Picture<'a> {
    view: FrameView<'a>,
    top_px: Vec<Option<f64>>,
    bottom_px: Vec<Option<f64>>,
}

/// Adds the figures to the page; returns the files that go beside it.
///
/// # Errors
/// Where a picture cannot be encoded.
pub(crate) fn figures(page: &mut Page, sample: &Sample) -> Result<Vec<(String, Vec<u8>)>, String> {
    let rows = |line: &[Edge]| line.iter().map(|e| e.is_usable().then_some(e.row_px)).collect();
    let frame_id = sample.frame.meta.frame_id;
    let sample = Picture {
        view: sample.frame.view(),
        top_px: rows(&sample.edges.top),
        bottom_px: rows(&sample.edges.bottom),
    };
    let stretch = Stretch::of(&sample.view);
    let step = sample.view.columns().div_ceil(OVERVIEW_PX).max(1);
    let overview = picture(&sample.view, &stretch, (0, 0), (sample.view.rows(), sample.view.columns()), step);
    let png = encode(&overview)?;
    let overlay = overview_svg(&sample, &png, &overview, step);
    page.heading("A frame and its edges");
    let caption =
        format!("Frame {} of the last pass with both edges of every column.", frame_of_pass(frame_id));
    page.figure(&overlay, &caption);
    if let Some((svg, caption)) = magnified(&sample, &stretch)? {
        page.figure(&svg, &caption);
    }
    if let Some(chart) = profile(&sample) {
        page.figure(
            &chart.to_svg()?,
            "Grey values against their distance from the measured edge, about 200 columns of the frame laid over one another: \
             the edge spread sampled far below a pixel. Its width is blur, pixel area and noise.",
        );
    }
    let name = format!("{:04}", frame_id & 0xffff);
    Ok(vec![
        (format!("previews/{name}.png"), png),
        (format!("previews/{name}_edges.svg"), overlay.into_bytes()),
    ])
}

fn overview_svg(sample: &Picture<'_>, png: &[u8], image: &GrayImage, step: usize) -> String {
    let (width, height) = image.dimensions();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"Frame with the measured edges\" \
         viewBox=\"0 0 {width} {height}\" width=\"{width}\">\
         <image href=\"data:image/png;base64,{}\" width=\"{width}\" height=\"{height}\"/>",
        base64(png)
    );
    for edge in [&sample.top_px, &sample.bottom_px] {
        svg += &polyline(edge, step, 0.0, 1.0 / step as f64, 1.2);
    }
    svg + "</svg>"
}

/// Colour of an edge, visible on every grey.
const EDGE_COLOUR: &str = "#d55e00";

/// An edge as SVG lines, broken at gaps; `row0` is the picture's first row, `scale` the picture's
/// pixels per column.
fn polyline(edge: &[Option<f64>], every: usize, row0: f64, scale: f64, width: f64) -> String {
    let mut path = String::new();
    let mut pen_down = false;
    for (column, row) in edge.iter().enumerate().step_by(every) {
        let Some(row) = row else {
            pen_down = false;
            continue;
        };
        let command = if pen_down { 'L' } else { 'M' };
        let (x, y) = ((column as f64 + 0.5) * scale, (row - row0 + 0.5) * scale);
        let _ = write!(path, "{command}{x:.2} {y:.2}");
        pen_down = true;
    }
    format!("<path d=\"{path}\" fill=\"none\" stroke=\"{EDGE_COLOUR}\" stroke-width=\"{width}\"/>")
}

/// A corner of the frame around the upper edge, with visible pixels and the measured edge.
fn magnified(sample: &Picture<'_>, stretch: &Stretch) -> Result<Option<(String, String)>, String> {
    const ZOOM: f64 = 17.0;
    let column0 = (sample.view.columns() / 2).saturating_sub(CROP.0 / 2);
    let window = sample.top_px.get(column0..(column0 + CROP.0).min(sample.top_px.len())).unwrap_or_default();
    let Some(row) = window.iter().flatten().next() else { return Ok(None) };
    let row0 = (row.round() as usize).saturating_sub(CROP.1 / 2);
    let image = picture(&sample.view, stretch, (row0, column0), (CROP.1, CROP.0), 1);
    let png = encode(&image)?;
    let (width, height) = (CROP.0 as f64 * ZOOM, CROP.1 as f64 * ZOOM);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"Magnified part of the frame with the measured edge\" \
         viewBox=\"0 0 {width} {height}\" width=\"{width}\">\
         <image style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\" width=\"{width}\" height=\"{height}\"/>",
        base64(&png)
    );
    svg += &polyline(window, 1, row0 as f64, ZOOM, 2.0);
    let caption = format!(
        "The upper edge from column {column0}, row {row0}, {} × {} pixels magnified, with the measured edge.",
        CROP.0, CROP.1
    );
    Ok(Some((svg + "</svg>", caption)))
}

fn profile(sample: &Picture<'_>) -> Option<Chart> {
    let every = (sample.view.columns() / PROFILE_COLUMNS).max(1);
    let mut points = Vec::new();
    for column in (0..sample.top_px.len()).step_by(every) {
        let Some(edge) = sample.top_px[column] else { continue };
        let low = (edge - PROFILE_REACH_PX).ceil().max(0.0) as usize;
        let high = (edge + PROFILE_REACH_PX).floor().max(0.0) as usize;
        points.extend(
            (low..=high).filter_map(|r| Some((r as f64 - edge, f64::from(sample.view.get(r, column)?)))),
        );
    }
    (!points.is_empty()).then(|| Chart {
        x_label: "row − measured edge / px".into(),
        y_label: "grey value / counts".into(),
        series: vec![Series::new("", Mark::Dots, 0, points)],
        ..Chart::default()
    })
}
