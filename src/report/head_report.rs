//! Heads side by side, as a page that is read before one is bought.

use super::error::ReportError;
use super::head_rows::{EXPOSURE_HEADER, exposure_rows, head_sections, three};
use super::html::{Page, Tone};
use super::plot::{Chart, Mark, Series};
use crate::studies::head::{HeadFigures, HeadStudy};

/// What each section of the table is, in a sentence or two.
const EXPLANATIONS: [&str; 7] = [
    "From the configs: what a data sheet has. Blur: the standard deviation of a Gaussian as steep as the edge.",
    "Noise alone, from contrast, photons, read noise, rounding and blur. The bound (Cramér and Rao) is what no estimate can be below, with levels \
     and blur given; the rows beneath it have them found from the same frame. Frames of the part in use were rendered and measured to check it: the \
     ratios should be 1 within their 95 % intervals and the deviations of a head as built ([departures]).",
    "Measured less true diameter of the same frames, without any calibration: by the edge of the head's own optics ([gauge.esf.optics]) and by the \
     plain Gaussian. The common error is the edge model's; masters take out what they share with the part.",
    "How far the part may stand from the plane of focus until its diameter has moved by the limit: by telecentricity, and by an edge out of focus \
     that is fitted as one in focus.",
    "Smallest by the pixels that the gauge needs across a shadow, largest by the field less the light beside either edge and the run-out.",
    "By masters that were rendered and measured, through the adjustment of the optical setup, as `study uncertainty` does; U covers 95.45 %. In use: \
     with the motion of the part during the exposure. The rows beneath are the sources in use, µm.",
    "The largest row of the budget in use: that is what to buy next.",
];

/// The page.
///
/// # Errors
/// Where a chart cannot be drawn.
pub(crate) fn head_page(study: &HeadStudy) -> Result<String, ReportError> {
    let heads = &study.heads;
    let names: Vec<&str> = heads.iter().map(|h| h.name.as_str()).collect();
    let mut page =
        Page::new(format!("Heads before a part of {} mm", heads.first().map_or(0.0, |h| h.diameter_mm)));
    let tone = if study.verdict.best.is_some() { Tone::Good } else { Tone::Bad };
    page.verdict(tone, &study.verdict.words);
    page.figure(&dots(heads)?, "Expanded uncertainty U of each head at rest and in use.");
    let header: Vec<&str> = std::iter::once("quantity").chain(names).collect();
    for (section, explanation) in head_sections(heads).into_iter().zip(EXPLANATIONS) {
        page.heading(section.title).text(explanation).table(&header, &section.rows);
        if section.title == "Depth of field" {
            page.figure(
                &depth_chart(heads)?,
                "Change of the diameter over the distance from the plane of focus.",
            );
        }
    }
    exposures(&mut page, heads)?;
    notes(&mut page, heads);
    Ok(page.finish())
}

fn drawn(chart: &Chart) -> Result<String, ReportError> {
    chart.to_svg().map_err(ReportError::Draw)
}

/// Dots of U at rest and in use at the number of every head.
fn dots(heads: &[HeadFigures]) -> Result<String, ReportError> {
    let at = |k: usize| (k + 1) as f64;
    let in_use = heads.iter().enumerate();
    let in_use = in_use.filter_map(|(k, h)| Some((at(k), h.in_use.as_ref()?.expanded_u_um))).collect();
    let at_rest = heads.iter().enumerate().map(|(k, h)| (at(k), h.at_rest.expanded_u_um)).collect();
    drawn(&Chart {
        x_label: format!("head ({})", numbered(heads)),
        y_label: "U / µm".to_owned(),
        x_labels: Some(heads.len()),
        series: vec![
            Series::new("at rest", Mark::Dots, 0, at_rest),
            Series::new("in use", Mark::Dots, 1, in_use),
        ],
        y_range: Some((0.0, 1.15 * heads.iter().map(largest_u_um).fold(0.0, f64::max))),
        ..Chart::default()
    })
}

fn largest_u_um(head: &HeadFigures) -> f64 {
    head.in_use.as_ref().map_or(0.0, |b| b.expanded_u_um).max(head.at_rest.expanded_u_um)
}

fn numbered(heads: &[HeadFigures]) -> String {
    let names: Vec<String> =
        heads.iter().enumerate().map(|(k, h)| format!("{}: {}", k + 1, h.name)).collect();
    names.join(", ")
}

/// A series of lines, the second and further ones dashed in turn.
fn line(k: usize, name: &str, points: Vec<(f64, f64)>) -> Series {
    let mark = if k.is_multiple_of(2) { Mark::Line } else { Mark::Dashed };
    Series::new(name, mark, k, points)
}

fn depth_chart(heads: &[HeadFigures]) -> Result<String, ReportError> {
    let series = heads.iter().enumerate().map(|(k, h)| line(k, &h.name, h.depth.curve.clone()));
    drawn(&Chart {
        x_label: "distance from the plane of focus / mm".to_owned(),
        y_label: "change of the diameter / µm".to_owned(),
        series: series.collect(),
        ..Chart::default()
    })
}

/// The longest exposure over the speed, both by their logarithm.
fn exposures(page: &mut Page, heads: &[HeadFigures]) -> Result<(), ReportError> {
    page.heading("Exposure against speed");
    page.text(
        "The longest exposure at which blur by run-out stays below its share of u, travel along z below a pixel, and lobes lose no more of their \
         amplitude than stated; * marks which of them it is. Both edges of one exposure run out alike, so that the first is strict: what motion \
         does to the diameter at the speed asked for stands under Uncertainty. Times the light: how much more of it the configured grey level \
         needs at that exposure.",
    );
    let series = heads.iter().enumerate().map(|(k, h)| {
        let points = h.exposures.iter().map(|e| (e.rpm.log10(), e.longest_us)).collect();
        line(k, &h.name, points)
    });
    let mut series: Vec<Series> = series.collect();
    for (k, h) in heads.iter().enumerate() {
        let points = h.exposures.iter().map(|e| (e.rpm.log10(), h.optics.exposure_us)).collect();
        series.push(Series::new(format!("{}, configured", h.name), Mark::Faint, k, points));
    }
    let svg = drawn(&Chart {
        x_label: "log10 of the speed in rev/min".to_owned(),
        y_label: "longest exposure / µs".to_owned(),
        series,
        log_y: true,
        ..Chart::default()
    })?;
    page.figure(&svg, "Longest exposure of each head over the speed, and the configured one.");
    page.table(&EXPOSURE_HEADER, &exposure_rows(heads));
    Ok(())
}

/// What was taken for granted.
fn notes(page: &mut Page, heads: &[HeadFigures]) {
    page.heading("Assumed");
    let rows = heads.iter().map(|h| {
        let masters: Vec<String> = h.masters_mm.iter().map(|mm| three(*mm)).collect();
        vec![h.name.clone(), h.config.clone(), masters.join(", "), h.notes.join("; ")]
    });
    page.table(&["head", "config", "masters / mm", "assumed"], &rows.collect::<Vec<_>>());
}
