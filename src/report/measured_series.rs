//! What the report of `measure` shows of the series as a whole: statistics and capability, form
//! over a turn.

use super::form_report::polar_plot;
use super::html::Page;
use crate::gauge::stated::stated;
use crate::measurement::{Statistics, TurnForm};

/// The statistics of the mean diameters and the capability.
pub(super) fn statistics(page: &mut Page, statistics: Option<&Statistics>) {
    let Some(s) = statistics.filter(|s| s.count > 1) else { return };
    let [mean, u] = stated(s.mean.d_mm, s.mean.u_mm());
    let spread = s.sd_mm.unwrap_or(f64::NAN);
    let mm = |value: f64| stated(value, spread)[0].clone();
    let mut rows = vec![
        ["frames with a diameter".to_owned(), s.count.to_string()],
        ["mean / mm".to_owned(), mean],
        ["standard uncertainty of the mean / mm".to_owned(), u],
        ["standard deviation / mm".to_owned(), mm(spread)],
        ["least / mm".to_owned(), mm(s.min_mm)],
        ["greatest / mm".to_owned(), mm(s.max_mm)],
    ];
    match &s.capability {
        Some(Ok((cp, cpk))) => {
            for (name, index) in [("Cp", cp), ("Cpk", cpk)] {
                let text = format!("{:.2} (95 %: {:.2} to {:.2})", index.index, index.lower, index.upper);
                rows.push([name.to_owned(), text]);
            }
        }
        Some(Err(why)) => rows.push(["Cp and Cpk".to_owned(), format!("none: {why}")]),
        None => {}
    }
    page.heading("Mean diameters of the frames")
        .table(&["quantity", "value"], &rows.into_iter().map(Vec::from).collect::<Vec<_>>());
}

/// Form and sizes over the revolution.
pub(super) fn turn(page: &mut Page, turn: Option<&TurnForm>) {
    let Some(turn) = turn else { return };
    let um = |mm: f64| format!("{:.3}", 1e3 * mm);
    let rows: Vec<Vec<String>> = turn
        .form
        .sections
        .iter()
        .map(|s| {
            let common = turn.common.iter().find(|c| c.z_mm == s.z_mm).and_then(|c| c.u_mm).unwrap_or(0.0);
            let u_mm = s.u_gg_random_mm.hypot(common);
            let mm = |value: f64| stated(value, u_mm)[0].clone();
            let [lsci, mzci, mici, mcci] = s.roundness_mm.map(um);
            let sizes = [mm(s.gg_mm), stated(u_mm, u_mm)[1].clone(), mm(s.gn_mm), mm(s.gx_mm)];
            let form = [um(s.run_out_mm), lsci, mzci, mici, mcci];
            [vec![format!("{:.3}", s.z_mm)], sizes.into(), form.into()].concat()
        })
        .collect();
    page.heading("Form over the turn")
        .text("Sizes and roundness of the sections' convex hulls, which is what silhouettes show.");
    let header = [
        "z / mm",
        "GG / mm",
        "u of GG / mm",
        "GN / mm",
        "GX / mm",
        "run-out / µm",
        "roundness LSCI / µm",
        "MZCI / µm",
        "MICI / µm",
        "MCCI / µm",
    ];
    page.table(&header, &rows);
    part_form(page, turn);
    if let Some(section) = turn.form.sections.get(turn.form.sections.len() / 2) {
        let caption = format!(
            "Section at z = {:.3} mm about its least-squares circle, {} angles{}.",
            section.z_mm,
            section.angles,
            if section.half_turn { " over half a turn" } else { "" }
        );
        page.figure(&polar_plot(&section.profile_mm), &caption);
    }
}

/// What the whole part has over the revolution: form, a judged size, sections left out.
fn part_form(page: &mut Page, turn: &TurnForm) {
    let um = |mm: Option<f64>| mm.map(|mm| format!("{:.3}", 1e3 * mm));
    let figures = [
        ("total run-out / µm", um(turn.form.total_run_out_mm)),
        ("cylindricity / µm", um(turn.form.cylindricity_mm)),
        ("straightness of the axis / µm", um(turn.form.axis_straightness_mm)),
        ("straightness of the flanks / µm", um(turn.form.generatrix_straightness_mm)),
        ("taper / (µm/mm)", um(turn.form.taper)),
    ];
    let rows: Vec<Vec<String>> =
        figures.into_iter().filter_map(|(name, value)| Some(vec![name.to_owned(), value?])).collect();
    if !rows.is_empty() {
        page.table(&["quantity", "value"], &rows);
    }
    if let Some(judged) = &turn.judged {
        let text = match &judged.size {
            Ok(size) => format!(
                "{} of {} mm: {}, {}.",
                judged.what,
                stated(size.d_mm, size.u_mm)[0],
                size.judgement.as_str(),
                size.judgement.meaning()
            ),
            Err(why) => format!("{}: not proven: {why}.", judged.what),
        };
        page.text(&text);
    }
    for (z_mm, why) in &turn.form.refused {
        page.text(&format!("No section at z = {z_mm:.3} mm: {why}."));
    }
}
