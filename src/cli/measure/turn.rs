//! The form over a revolution as `measure --turn` prints it.

use serde_json::{Value, json};

use crate::gauge::axis_line::{AxisLine, STILL_TOWARDS_CAMERA};
use crate::gauge::diameter::sections::{PartForm, SectionForm};
use crate::gauge::stated::stated;

/// A revolution in the JSON document; `common_mm` is the common standard uncertainty of a section's
/// sizes as a function of z, mm.
pub(super) fn turn_json(form: &PartForm, common_mm: impl Fn(f64) -> Option<f64>) -> Value {
    let mut all = json!(form);
    all["filter"] = json!(filter_text(form));
    all["of"] = json!("the silhouette: sizes and roundness of the sections' convex hulls");
    all["refused"] = form.refused.iter().map(|(z, why)| json!({ "z_mm": z, "why": why })).collect();
    if let Some(sections) = all["sections"].as_array_mut() {
        for section in sections {
            let [lsci, mzci, mici, mcci] = [0, 1, 2, 3].map(|k| section["roundness_mm"][k].clone());
            let common = section["z_mm"].as_f64().and_then(&common_mm);
            let random = section["u_gg_random_mm"].as_f64().unwrap_or(f64::NAN);
            section["u_gg_mm"] = json!(common.map(|common| random.hypot(common)));
            section["u_gg_common_mm"] = json!(common);
            if section["half_turn"] == true {
                // With half a revolution the spindle is assumed free of error motion: its even
                // harmonics are not determined.
                section["harmonics"]["even_spindle"] = Value::Null;
            }
            section["roundness_mm"] = json!({ "lsci": lsci, "mzci": mzci, "mici": mici, "mcci": mcci });
        }
    }
    all
}

/// The axis over the revolution in the JSON document.
pub(super) fn axis_json(axis: &AxisLine) -> Value {
    let bend = axis.bend_mm();
    let stations: Vec<Value> = axis
        .stations
        .iter()
        .zip(&bend)
        .map(|(s, (_, bend_x_mm, u_bend_x_mm))| {
            let turning = s.turning.map(|t| {
                json!({ "x_mm": t.x_mm, "y_mm": t.y_mm, "u_mm": t.u_mm, "run_out_mm": t.run_out_mm() })
            });
            json!({
                "z_mm": s.z_mm, "x_mm": s.x_mm, "u_x_mm": s.u_mm(), "bend_x_mm": bend_x_mm, "u_bend_x_mm": u_bend_x_mm,
                "turning": turning, "angles": s.angles,
            })
        })
        .collect();
    let gaps: Vec<Value> =
        axis.gaps.iter().map(|(z, why)| json!({ "z_mm": z, "why": why.as_str() })).collect();
    json!({ "stations": stations, "gaps": gaps, "still_towards_camera": STILL_TOWARDS_CAMERA })
}

/// The axis in words: its largest bend and run-out.
fn axis_words(axis: &Value) -> String {
    let stations = || axis["stations"].as_array().into_iter().flatten();
    let largest = |value: &dyn Fn(&Value) -> Option<f64>| {
        stations()
            .filter_map(|s| Some((s["z_mm"].as_f64()?, value(s)?, s)))
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    };
    let um = |mm: f64| format!("{:.3}", 1e3 * mm);
    let Some((z, bend, s)) = largest(&|s| s["bend_x_mm"].as_f64()) else { return String::new() };
    let u = s["u_bend_x_mm"].as_f64().unwrap_or(f64::NAN);
    let turning = largest(&|s| s["turning"]["run_out_mm"].as_f64()).map_or_else(
        || "what turns is not told from what stands still: the angles span too little of a turn".to_owned(),
        |(z, out, s)| {
            let u = 2.0 * s["turning"]["u_mm"].as_f64().unwrap_or(f64::NAN);
            format!("run-out up to {} um at z = {z:.3} mm (u {} um)", um(out), um(u))
        },
    );
    format!(
        "axis: bends by {} um at z = {z:.3} mm in the image plane (u {} um); {turning}; what stands still towards the camera is {STILL_TOWARDS_CAMERA}\n",
        um(bend),
        um(u)
    )
}

/// A warning where sections scatter by more than their form and their u explain.
pub(super) fn scatter_word(form: &PartForm) -> Option<String> {
    let beyond: Vec<&SectionForm> =
        form.sections.iter().filter(|s| s.scatter.is_some_and(|test| test.beyond_u)).collect();
    let (worst, test) = beyond
        .iter()
        .filter_map(|s| s.scatter.map(|test| (s, test)))
        .max_by(|a, b| a.1.ratio().total_cmp(&b.1.ratio()))?;
    Some(format!(
        "{} of {} sections scatter over the turn by more than their form and their u explain, at z = {:.3} mm {:.1} times (chi2 {:.4} at {} degrees \
         of freedom, limit {:.4} at a false alarm of {} %): vibration, drift, dirt or texture; u is taken from the scatter",
        beyond.len(),
        form.sections.len(),
        worst.z_mm,
        test.ratio(),
        test.chi2,
        test.freedom,
        test.chi2_limit,
        100.0 * test.false_alarm_probability
    ))
}

/// The filter and the highest harmonic that the angles resolve: n tangents per revolution resolve
/// up to n/2 undulations.
fn filter_text(form: &PartForm) -> String {
    let tangents = |s: &SectionForm| if s.half_turn { 2 * s.angles } else { s.angles };
    let Some(section) = form.sections.iter().min_by_key(|s| tangents(s)) else { return String::new() };
    let (cutoff, n) = (section.cutoff_upr, tangents(section));
    if cutoff > 0.5 * n as f64 {
        format!(
            "Gaussian filter {cutoff} upr as far as the angles reach: {n} tangents a revolution, {} upr",
            n / 2
        )
    } else {
        format!("Gaussian filter {cutoff} upr")
    }
}

/// The part's form as a table of text.
pub fn turn_table(turn: &Value) -> String {
    let um = |v: &Value| v.as_f64().map_or("-".to_owned(), |x| format!("{:.3}", 1e3 * x));
    let mut text = format!(
        "\nform over the turn, of {}\n{}\n{:>10} {:>11} {:>9} {:>11} {:>11} {:>9} {:>8} {:>8} {:>8} {:>8}\n",
        turn["of"].as_str().unwrap_or(""),
        turn["filter"].as_str().unwrap_or(""),
        "z/mm",
        "GG/mm",
        "u/mm",
        "GN/mm",
        "GX/mm",
        "run-out",
        "LSCI",
        "MZCI",
        "MICI",
        "MCCI um"
    );
    for s in turn["sections"].as_array().into_iter().flatten() {
        let r = &s["roundness_mm"];
        let u = s["u_gg_mm"].as_f64().unwrap_or(f64::NAN);
        let mm = |v: &Value| v.as_f64().map_or("-".to_owned(), |x| stated(x, u)[0].clone());
        text += &format!(
            "{:>10.3} {:>11} {:>9} {:>11} {:>11} {:>9} {:>8} {:>8} {:>8} {:>8}\n",
            s["z_mm"].as_f64().unwrap_or(f64::NAN),
            mm(&s["gg_mm"]),
            stated(u, u)[1],
            mm(&s["gn_mm"]),
            mm(&s["gx_mm"]),
            um(&s["run_out_mm"]),
            um(&r["lsci"]),
            um(&r["mzci"]),
            um(&r["mici"]),
            um(&r["mcci"])
        );
    }
    text += &format!(
        "total run-out {}, cylindricity {}, straightness of axis {}, of flanks {} um; taper {} um/mm\n",
        um(&turn["total_run_out_mm"]),
        um(&turn["cylindricity_mm"]),
        um(&turn["axis_straightness_mm"]),
        um(&turn["generatrix_straightness_mm"]),
        um(&turn["taper"])
    );
    text += &axis_words(&turn["axis"]);
    if let Some(judged) = turn.get("judged") {
        let word = judged["judgement"].as_str().map_or_else(
            || format!("not proven: {}", judged["why"].as_str().unwrap_or("")),
            |word| {
                format!(
                    "{} mm: {word}",
                    judged["d_mm"].as_f64().map_or("-".to_owned(), |d| stated(
                        d,
                        judged["u_mm"].as_f64().unwrap_or(f64::NAN)
                    )[0]
                    .clone())
                )
            },
        );
        text += &format!("{} {word}\n", judged["what"].as_str().unwrap_or(""));
    }
    text
}
