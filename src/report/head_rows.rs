//! Figures of heads as rows of a table, a column a head: the same on the terminal and on a page.

use crate::gauge::stated::stated;
use crate::studies::head::{
    DepthEnd, ExposureEnd, FrameCheck, HeadBudget, HeadFigures, HeadLimit, ModelErrors,
};

/// A section of the table: its title and its rows, each with its name before a cell a head.
pub(crate) struct HeadSection {
    /// Title.
    pub(crate) title: &'static str,
    /// Rows.
    pub(crate) rows: Vec<Vec<String>>,
}

/// What a cell without a value shows.
const NONE: &str = "–";

/// All sections.
pub(crate) fn head_sections(heads: &[HeadFigures]) -> Vec<HeadSection> {
    let section = |title, rows| HeadSection { title, rows };
    vec![
        section("Optics", optics(heads)),
        section("Repeatability by noise (standard deviation)", repeatability(heads)),
        section("Accuracy in rendered frames, before calibration", accuracy(heads)),
        section("Depth of field", depth(heads)),
        section("Diameters", range(heads)),
        section("Uncertainty", uncertainty(heads)),
        section("What limits it", limit(heads)),
    ]
}

/// A row of one name and a cell a head.
fn row(name: &str, heads: &[HeadFigures], cell: impl Fn(&HeadFigures) -> String) -> Vec<String> {
    std::iter::once(name.to_owned()).chain(heads.iter().map(cell)).collect()
}

/// A value to three significant digits.
pub(crate) fn three(value: f64) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.decimals$}")
}

fn maybe(value: Option<f64>) -> String {
    value.map_or_else(|| NONE.to_owned(), three)
}

fn optics(heads: &[HeadFigures]) -> Vec<Vec<String>> {
    vec![
        row("edge", heads, |h| h.optics.edge.replace('_', " ")),
        row("magnification", heads, |h| three(h.optics.magnification)),
        row("pixel on the part / µm", heads, |h| three(h.optics.um_per_px)),
        row("NA", heads, |h| maybe(h.optics.numerical_aperture)),
        row("wavelength / nm", heads, |h| maybe(h.optics.wavelength_nm)),
        row("coherence S", heads, |h| maybe(h.optics.coherence_ratio)),
        row("blur σ / px", heads, |h| three(h.optics.blur_px)),
        row("blur σ on the part / µm", heads, |h| three(h.optics.blur_um)),
        row("field across × along / mm", heads, |h| {
            format!("{} × {}", three(h.optics.field_mm[0]), three(h.optics.field_mm[1]))
        }),
        row("telecentricity at the corner / mrad", heads, |h| three(h.depth.telecentricity_mrad)),
        row("distortion at the corner / %", heads, |h| three(h.optics.distortion_percent)),
        row("grey levels, shadow and light", heads, |h| {
            let [dark, light] = h.optics.grey_counts;
            format!("{dark:.0}, {light:.0}{}", if h.optics.clipped { " (clipped)" } else { "" })
        }),
        row("contrast over noise", heads, |h| three(h.optics.snr)),
        row("exposure / µs", heads, |h| three(h.optics.exposure_us)),
    ]
}

fn repeatability(heads: &[HeadFigures]) -> Vec<Vec<String>> {
    vec![
        row("bound, one column / µm", heads, |h| three(h.repeatability.bound_um)),
        row("one column of a frame / µm", heads, |h| three(h.repeatability.column_um)),
        row("a frame / µm", heads, |h| {
            format!("{} ({} columns)", three(h.repeatability.frame_um), h.repeatability.columns)
        }),
        row("a station / µm", heads, |h| {
            format!("{} ({} columns)", three(h.repeatability.station_um), h.repeatability.station_columns)
        }),
        row("a station over a turn / µm", heads, |h| {
            format!("{} ({} angles)", three(h.repeatability.turn_um), h.repeatability.angles)
        }),
        row("bound, one column in use / µm", heads, |h| {
            h.frames.as_ref().map_or_else(|| NONE.to_owned(), |_| three(h.repeatability_in_use.bound_um))
        }),
        row("columns of rendered frames in use / µm", heads, |h| {
            maybe(h.frames.as_ref().and_then(|f| f.own.column_sd_um))
        }),
        row("  over the bound", heads, |h| ratio(h, &|f| Some((f.column_ratio?, f.u_column_ratio?)))),
        row("  means of frames over the prediction", heads, |h| {
            ratio(h, &|f| Some((f.frame_ratio?, f.u_frame_ratio?)))
        }),
    ]
}

/// A ratio with its 95 % interval.
fn ratio(head: &HeadFigures, of: &dyn Fn(&FrameCheck) -> Option<(f64, f64)>) -> String {
    let found = head.frames.as_ref().and_then(of);
    found.map_or_else(|| NONE.to_owned(), |(ratio, u)| format!("{ratio:.3} ± {:.3}", 2.0 * u))
}

fn accuracy(heads: &[HeadFigures]) -> Vec<Vec<String>> {
    let own = |h: &HeadFigures| h.frames.as_ref().map(|f| f.own.clone());
    let plain = |h: &HeadFigures| h.frames.as_ref().map(|f| f.gaussian.clone().unwrap_or(f.own.clone()));
    vec![
        row("frames measured (refused)", heads, |h| {
            own(h).map_or_else(|| NONE.to_owned(), |m| format!("{} ({})", m.frames, m.refused))
        }),
        row("own edge, common error / µm", heads, |h| common(own(h).as_ref())),
        row("own edge, scatter of frames / µm", heads, |h| maybe(own(h).and_then(|m| m.frame_sd_um))),
        row("plain Gaussian, common error / µm", heads, |h| common(plain(h).as_ref())),
        row("plain Gaussian, scatter of frames / µm", heads, |h| {
            maybe(plain(h).and_then(|m| m.frame_sd_um))
        }),
    ]
}

/// The common error with its uncertainty, or that all frames were refused.
fn common(errors: Option<&ModelErrors>) -> String {
    match errors {
        None => NONE.to_owned(),
        Some(ModelErrors { mean_um: Some(mean), u_mean_um: Some(u), .. }) => {
            let [value, u] = stated(*mean, 2.0 * u);
            format!("{value} ± {u}")
        }
        Some(ModelErrors { mean_um: Some(mean), .. }) => three(*mean),
        Some(_) => "refused".to_owned(),
    }
}

fn depth(heads: &[HeadFigures]) -> Vec<Vec<String>> {
    vec![
        row("diameter may move by / µm", heads, |h| three(h.depth.limit_um)),
        row("± depth / mm", heads, |h| {
            let more = if h.depth.ended_by == DepthEnd::Beyond { "more than " } else { "" };
            format!("{more}{}", three(h.depth.depth_mm))
        }),
        row("ended by", heads, |h| {
            let words = match h.depth.ended_by {
                DepthEnd::Diameter => "the diameter",
                DepthEnd::Gauge => "blur or residual",
                DepthEnd::Beyond => NONE,
            };
            words.to_owned()
        }),
        row("blur doubles at ± / mm", heads, |h| maybe(h.depth.blur_doubles_mm)),
    ]
}

fn range(heads: &[HeadFigures]) -> Vec<Vec<String>> {
    vec![
        row("smallest shaft / mm", heads, |h| three(h.range.smallest_mm)),
        row("smallest wire / mm", heads, |h| maybe(h.range.smallest_wire_mm)),
        row("largest / mm", heads, |h| three(h.range.largest_mm)),
        row("largest over smallest", heads, |h| three(h.range.ratio)),
    ]
}

fn uncertainty(heads: &[HeadFigures]) -> Vec<Vec<String>> {
    let in_use = |h: &HeadFigures, of: &dyn Fn(&HeadBudget) -> f64| {
        h.in_use.as_ref().map_or_else(|| "no reading".to_owned(), |b| three(of(b)))
    };
    let mut rows = vec![
        row("at rest: u random / µm", heads, |h| three(h.at_rest.u_random_um)),
        row("at rest: u common / µm", heads, |h| three(h.at_rest.u_common_um)),
        row("at rest: U / µm", heads, |h| expanded(&h.at_rest)),
        row("in use: speed / (rev/min)", heads, |h| three(h.motion.rpm)),
        row("in use: path of the edges / µm", heads, |h| three(h.motion.path_um)),
        row("in use: u by motion / µm", heads, |h| three(h.motion.u_um)),
        row("in use: u / µm", heads, |h| in_use(h, &|b| b.u_um)),
        row("in use: U / µm", heads, |h| {
            h.in_use.as_ref().map_or_else(|| "no reading".to_owned(), expanded)
        }),
    ];
    for source in sources(heads) {
        rows.push(row(&format!("  {source}"), heads, |h| {
            let of = h.in_use.as_ref().unwrap_or(&h.at_rest);
            maybe(of.rows.iter().find(|r| r.source == source).map(|r| r.u_um))
        }));
    }
    rows
}

fn expanded(budget: &HeadBudget) -> String {
    format!("{} (k = {:.2})", stated(0.0, budget.expanded_u_um)[1], budget.coverage_factor)
}

/// Sources of all budgets, in the order of their largest contribution to any head.
fn sources(heads: &[HeadFigures]) -> Vec<String> {
    let mut largest: Vec<(String, f64)> = Vec::new();
    for row in heads.iter().flat_map(|h| &h.in_use.as_ref().unwrap_or(&h.at_rest).rows) {
        match largest.iter_mut().find(|(source, _)| *source == row.source) {
            Some((_, u_um)) => *u_um = u_um.max(row.u_um),
            None => largest.push((row.source.clone(), row.u_um)),
        }
    }
    largest.sort_by(|a, b| b.1.total_cmp(&a.1));
    largest.into_iter().map(|(source, _)| source).collect()
}

fn limit(heads: &[HeadFigures]) -> Vec<Vec<String>> {
    let of = |h: &HeadFigures, cell: &dyn Fn(&HeadLimit) -> String| {
        h.limit.as_ref().map_or_else(|| NONE.to_owned(), cell)
    };
    vec![
        row("largest source in use", heads, |h| of(h, &|l| l.source.clone())),
        row("its u / µm", heads, |h| of(h, &|l| three(l.u_um))),
        row("what would halve it", heads, |h| of(h, &|l| l.remedy.to_owned())),
        row("U with half of it / µm", heads, |h| of(h, &|l| three(l.expanded_u_after_um))),
    ]
}

/// Columns of [`exposure_rows`].
pub(crate) const EXPOSURE_HEADER: [&str; 9] = [
    "head",
    "rev/min",
    "by run-out / µs",
    "by feed / µs",
    "by lobes / µs",
    "longest / µs",
    "grey level then",
    "contrast over noise",
    "times the light",
];

/// Exposures over speeds, a row a head and speed.
pub(crate) fn exposure_rows(heads: &[HeadFigures]) -> Vec<Vec<String>> {
    let cells = |h: &HeadFigures| {
        let name = h.name.clone();
        h.exposures
            .iter()
            .map(move |e| {
                let mark = |end: ExposureEnd| if e.limited_by == end { " *" } else { "" };
                vec![
                    name.clone(),
                    three(e.rpm),
                    three(e.run_out_us) + mark(ExposureEnd::RunOut),
                    three(e.feed_us) + mark(ExposureEnd::Feed),
                    three(e.lobes_us) + mark(ExposureEnd::Lobes),
                    three(e.longest_us),
                    format!("{:.0}", e.grey_counts),
                    three(e.snr),
                    three(e.light_factor),
                ]
            })
            .collect::<Vec<_>>()
    };
    heads.iter().flat_map(cells).collect()
}
