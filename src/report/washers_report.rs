//! Rings of known size: the table of the methods, and a picture of every part that departs.

use std::fmt::Write as _;

use super::html::{Page, base64, escape};
use super::picture::{encode, thumbnail};
use crate::gauge::ring::{EdgeCircle, PointOrigin};
use crate::studies::washers::{Comparison, MethodFigures, Outlier, Part, SIDES, WashersStudy};

/// Width of a picture, px.
const WIDTH: usize = 820;
/// Magnification of departures from the circle.
const MAGNIFIED: f64 = 60.0;

/// The page, and the pictures beside it by their names.
///
/// # Errors
/// Where a picture cannot be encoded.
pub(crate) fn washers_page(
    study: &WashersStudy,
    parts: &[Part],
) -> Result<(String, Vec<(String, String)>), String> {
    let mut page = Page::new("Rings beside a coordinate-measuring machine");
    page.text(
        "One scale and one edge offset for outline and bore, fitted on all parts but one and tried on that one. Robust: 1.4826 times the \
         median departure. A machine's ball feels burrs that an optical edge can refuse; its size is not told, so the ball that \
         ISO 12181-2 allows at 50 upr counts, and common ones stand beside it.",
    );
    let methods = [&study.ours, &study.level_crossing, &study.optical].into_iter().chain(&study.balls);
    let header = [
        "method",
        "outer sd / µm",
        "robust",
        "inner sd / µm",
        "robust",
        "scale / (µm/px)",
        "offset an edge / px",
    ];
    page.table(&header, &methods.map(method_row).collect::<Vec<_>>());
    page.heading("Is there a difference?");
    page.text(
        "Split by number (every second part): scale and offset from one half, residuals of the other. The intervals are a bootstrap's over \
         the parts and hold together at 95 %; where one holds zero, these parts show no difference between the gauge and a level crossing.",
    );
    let header = ["figure", "ours / µm", "level crossing / µm", "difference / µm", "verdict"];
    page.table(&header, &study.comparisons.iter().map(comparison_row).collect::<Vec<_>>());
    page.heading("Parts");
    let rows: Vec<Vec<String>> = (0..study.names.len()).map(|k| part_row(study, k)).collect();
    page.table(
        &[
            "picture",
            "outer: ours / µm",
            "level crossing",
            "inner: ours / µm",
            "level crossing",
            "roundness outer / µm",
            "inner",
            "calipers refused",
        ],
        &rows,
    );
    page.heading("Parts that depart");
    if study.outliers.is_empty() {
        page.text("None beyond 3 robust standard deviations.");
    }
    let mut files = Vec::new();
    for outlier in &study.outliers {
        let svg = picture(study, outlier, &parts[outlier.part])?;
        page.figure(&svg, &caption(outlier));
        let stem = outlier.name.rsplit_once('.').map_or(outlier.name.as_str(), |(stem, _)| stem);
        files.push((format!("{stem}_{}.svg", SIDES[outlier.side]), svg));
    }
    Ok((page.finish(), files))
}

fn caption(outlier: &Outlier) -> String {
    format!(
        "{}, {} diameter: machine − gauge {:+.1} µm, machine − level crossing {:+.1} µm. Departures from the circle {MAGNIFIED} times \
         larger; the line goes through every point, dots are what was refused as burr or dirt (the ball feels it).",
        outlier.name, SIDES[outlier.side], outlier.residual_um[0], outlier.residual_um[1]
    )
}

fn method_row(m: &MethodFigures) -> Vec<String> {
    let number = |v: f64| format!("{v:.2}");
    vec![
        m.name.clone(),
        number(m.sd_um[0]),
        number(m.robust_sd_um[0]),
        number(m.sd_um[1]),
        number(m.robust_sd_um[1]),
        format!("{:.4}", m.um_per_px),
        format!("{:+.3}", m.edge_offset_px),
    ]
}

fn comparison_row(c: &Comparison) -> Vec<String> {
    vec![
        format!("{} {}", SIDES[c.side], c.figure),
        format!("{:.2}", c.ours_um),
        format!("{:.2}", c.plain_um),
        format!("{:+.2} to {:+.2}", c.difference_um[0], c.difference_um[1]),
        c.verdict.word().to_owned(),
    ]
}

fn part_row(study: &WashersStudy, k: usize) -> Vec<String> {
    let (ours, plain) = (study.ours.residual_um[k], study.level_crossing.residual_um[k]);
    let ring = &study.rings[k];
    let inner = ring.inner.as_ref();
    let um = |px: f64| format!("{:.1}", study.ours.um_per_px * px);
    vec![
        study.names[k].clone(),
        format!("{:+.1}", ours[0]),
        format!("{:+.1}", plain[0]),
        format!("{:+.1}", ours[1]),
        format!("{:+.1}", plain[1]),
        um(ring.outer.roundness_px),
        inner.map_or_else(String::new, |i| um(i.roundness_px)),
        format!("{} + {}", ring.outer.refused, inner.map_or(0, |i| i.refused)),
    ]
}

/// The part's picture with the outline of the edge in question, departures magnified.
fn picture(study: &WashersStudy, outlier: &Outlier, part: &Part) -> Result<String, String> {
    let ring = &study.rings[outlier.part];
    let edge = match (outlier.side, &ring.inner) {
        (1, Some(inner)) => inner,
        _ => &ring.outer,
    };
    let view = part.frame.view();
    let step = view.rows().max(view.columns()).div_ceil(WIDTH).max(1);
    let image = thumbnail(&view, WIDTH);
    let png = base64(&encode(&image)?);
    let (width, height) = image.dimensions();
    let name = escape(&outlier.name);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"{name}: outline of the {} edge\" \
         viewBox=\"0 0 {width} {height}\" width=\"{width}\" font-family=\"sans-serif\" font-size=\"13\">\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\
         <image href=\"data:image/png;base64,{png}\" width=\"{width}\" height=\"{height}\" opacity=\"0.2\"/>",
        SIDES[outlier.side]
    );
    let scale = 1.0 / step as f64;
    let [x, y] = edge.centre_px.map(|v| (v + 0.5) * scale);
    let _ = write!(
        svg,
        "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{:.2}\" fill=\"none\" stroke=\"#333\" stroke-dasharray=\"4 3\"/>{}",
        0.5 * edge.diameter_px * scale,
        outline(edge, scale)
    );
    let _ = write!(
        svg,
        "<text x=\"8\" y=\"18\" style=\"fill:#222222\" stroke=\"#ffffff\" stroke-width=\"4\" paint-order=\"stroke\">{name}: {} {:+.1} µm</text></svg>",
        SIDES[outlier.side], outlier.residual_um[0]
    );
    Ok(svg)
}

fn outline(edge: &EdgeCircle, scale: f64) -> String {
    let base = 0.5 * edge.diameter_px;
    let points = &edge.outline.points;
    let at = |k: usize| {
        let radius = base + MAGNIFIED * (points[k].radius_px - base);
        let (s, c) = edge.outline.angle(k).sin_cos();
        [edge.centre_px[0] + radius * c, edge.centre_px[1] + radius * s].map(|v| (v + 0.5) * scale)
    };
    let (mut line, mut dots) = (String::new(), String::new());
    for (k, point) in points.iter().enumerate() {
        let [x, y] = at(k);
        let _ = write!(line, "{x:.1},{y:.1} ");
        if point.origin != PointOrigin::Fitted {
            let _ = write!(dots, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.2\" fill=\"#a02c00\"/>");
        }
    }
    format!("<polygon points=\"{line}\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\"1.2\"/>{dots}")
}
