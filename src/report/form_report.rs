//! Form over a revolution in the report of a run: a polar plot of one section, sizes and roundness
//! along z.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::error::ReportError;
use super::html::Page;
use super::plot::{Chart, Mark, Series};
use crate::gauge::diameter::sections::PartForm;
use crate::run_folder::{FormRow, PartFormRow};

/// One row per pass: the worst section and the axis.
fn pass_table(rows: &[FormRow], parts: &[PartFormRow]) -> Vec<Vec<String>> {
    let um = |v: Option<f64>| v.map_or("–".to_owned(), |v| format!("{:.3}", 1e3 * v));
    parts
        .iter()
        .map(|p| {
            let worst = rows.iter().filter(|r| r.pass == p.pass).map(|r| r.mzci_mm).fold(0.0, f64::max);
            vec![
                p.pass.to_string(),
                p.sections.to_string(),
                um(Some(worst)),
                um(p.total_run_out_mm),
                um(p.cylindricity_mm),
                um(p.axis_straightness_mm),
                um(p.generatrix_straightness_mm),
                um(p.taper.map(|t| 100.0 * t)),
            ]
        })
        .collect()
}

/// Sizes of a pass along z about the least-squares size.
fn sizes_chart(rows: &[FormRow], pass: u32) -> Chart {
    let of_pass = |f: &dyn Fn(&FormRow) -> f64| -> Vec<(f64, f64)> {
        rows.iter().filter(|r| r.pass == pass).map(|r| (r.z_mm, f(r))).collect()
    };
    let base = |r: &FormRow| r.gg_mm;
    Chart {
        x_label: "z from the chuck / mm".into(),
        y_label: "size − GG / µm".into(),
        series: vec![
            Series::new("GN, circumscribed", Mark::Line, 1, of_pass(&|r| 1e3 * (r.gn_mm - base(r)))),
            Series::new("greatest caliper", Mark::Faint, 1, of_pass(&|r| 1e3 * (r.max_caliper_mm - base(r)))),
            Series::new("least caliper", Mark::Faint, 0, of_pass(&|r| 1e3 * (r.min_caliper_mm - base(r)))),
            Series::new("GX, inscribed", Mark::Line, 0, of_pass(&|r| 1e3 * (r.gx_mm - base(r)))),
        ],
        ..Chart::default()
    }
}

/// Adds the section.
///
/// # Errors
/// Where a chart cannot be drawn.
pub(crate) fn form_section(
    page: &mut Page,
    rows: &[FormRow],
    parts: &[PartFormRow],
    last: Option<&PartForm>,
) -> Result<(), ReportError> {
    let Some(pass) = parts.iter().map(|p| p.pass).max() else { return Ok(()) };
    page.heading("Form over a turn").text(
        "Sizes and roundness of the sections' convex hulls, which is what silhouettes show (ISO 14405 sizes of the hull; \
         Gaussian filter 50 upr as far as the angles reach). Angles over half a turn take the spindle as still: odd lobes are form + spindle.",
    );
    let header = [
        "pass",
        "sections",
        "worst roundness (MZCI) / µm",
        "total run-out / µm",
        "cylindricity / µm",
        "straightness of axis / µm",
        "of flanks / µm",
        "taper / (µm/100 mm)",
    ];
    page.table(&header, &pass_table(rows, parts));
    let chart = sizes_chart(rows, pass);
    let svg = chart.to_svg().map_err(ReportError::Draw)?;
    page.figure(&svg, &format!("Sizes of the sections after pass {pass} about their least-squares size GG."));
    let Some(section) = last.and_then(|f| f.sections.get(f.sections.len() / 2)) else { return Ok(()) };
    page.figure(
        &polar_plot(&section.profile_mm),
        &format!(
            "Section at z = {:.1} mm about its least-squares circle, {} angles{}: roundness {:.3} (LSCI), {:.3} (MZCI), {:.3} (MICI), {:.3} µm (MCCI).",
            section.z_mm,
            section.angles,
            if section.half_turn { " over half a turn" } else { "" },
            1e3 * section.roundness_mm[0],
            1e3 * section.roundness_mm[1],
            1e3 * section.roundness_mm[2],
            1e3 * section.roundness_mm[3]
        ),
    );
    Ok(())
}

/// Direction in which the rings of a polar plot are labelled, degrees.
const LABEL_RAY_DEG: f64 = 67.5;

/// A polar plot of a closed profile: deviations from the mean magnified, rings a round number of µm
/// apart.
pub(super) fn polar_plot(profile_mm: &[f64]) -> String {
    let (size, base, band) = (420.0, 110.0, 70.0);
    let middle = 0.5 * size;
    let n = profile_mm.len().max(1) as f64;
    let mean = profile_mm.iter().sum::<f64>() / n;
    let deviation: Vec<f64> = profile_mm.iter().map(|r| 1e3 * (r - mean)).collect();
    let reach = deviation.iter().fold(1e-6_f64, |m, d| m.max(d.abs()));
    let decade = 10f64.powf(reach.log10().floor());
    let ring = [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * decade).find(|r| *r >= reach).unwrap_or(reach);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"Polar plot of a section, {:.3} to {:.3} µm about its mean\" \
         viewBox=\"0 0 {size} {size}\" width=\"{size}\" height=\"{size}\" font-family=\"sans-serif\" font-size=\"12\">\
         <rect class=\"paper\" width=\"{size}\" height=\"{size}\" fill=\"#ffffff\"/>",
        deviation.iter().fold(0.0_f64, |m, d| m.min(*d)),
        deviation.iter().fold(0.0_f64, |m, d| m.max(*d))
    );
    let rings = [-1.0, -0.5, 0.0, 0.5, 1.0];
    for k in rings {
        let dash = if k == 0.0 { "" } else { " stroke-dasharray=\"2 4\"" };
        let radius = base + band * k;
        let _ = write!(
            svg,
            "<circle class=\"rule\" cx=\"{middle}\" cy=\"{middle}\" r=\"{radius}\" fill=\"none\" stroke=\"#8c8c8c\" stroke-width=\".8\"{dash}/>"
        );
    }
    for degree in (0..360).step_by(45) {
        let (s, c) = f64::from(degree).to_radians().sin_cos();
        let (far, text) = (base + 1.15 * band, base + 1.25 * band);
        let _ = write!(
            svg,
            "<line class=\"rule\" x1=\"{middle}\" y1=\"{middle}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"#8c8c8c\" stroke-width=\".8\" stroke-dasharray=\"1 5\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#222222\">{degree}°</text>",
            middle + far * c,
            middle - far * s,
            middle + text * c,
            middle - text * s + 4.0
        );
    }
    let mut points = String::new();
    for (i, d) in deviation.iter().enumerate() {
        let (s, c) = (TAU * i as f64 / n).sin_cos();
        let r = base + band * d / ring;
        let _ = write!(points, "{:.2},{:.2} ", middle + r * c, middle - r * s);
    }
    let _ = write!(
        svg,
        "<polygon class=\"s0\" points=\"{points}\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\"2\"/>"
    );
    // Above the curve, with an edge of the ground's colour, on a ray between two of the angles.
    let (s, c) = LABEL_RAY_DEG.to_radians().sin_cos();
    for k in rings {
        let text = if k == 0.0 { "0".to_owned() } else { format!("{:+}", k * ring) };
        let radius = base + band * k;
        let _ = write!(
            svg,
            "<text class=\"halo\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#222222\" stroke=\"#ffffff\" stroke-width=\"4\" \
             paint-order=\"stroke\">{text} µm</text>",
            middle + radius * c,
            middle - radius * s + 4.0
        );
    }
    svg + "</svg>"
}
