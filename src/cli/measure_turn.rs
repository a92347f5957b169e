//! The form over a turn as `measure --turn` gives it.

use serde_json::{Value, json};

use crate::gauge::turn_form::{PartForm, SectionForm};

/// A turn as the JSON document has it; `common_mm` gives the common standard uncertainty of a section's sizes.
pub(super) fn turn_json(form: &PartForm, common_mm: impl Fn(f64) -> Option<f64>) -> Value {
    let mut all = json!(form);
    all["filter"] = json!(filter_text(form));
    all["of"] = json!("the silhouette: sizes and roundness of the sections' convex hulls");
    all["refused"] = form.refused.iter().map(|(z, why)| json!({ "z_mm": z, "why": why })).collect();
    if let Some(sections) = all["sections"].as_array_mut() {
        for section in sections {
            let [lsci, mzci, mici, mcci] = [0, 1, 2, 3].map(|k| section["roundness_mm"][k].clone());
            let (random, common) =
                (section["u_gg_mm"].clone(), section["z_mm"].as_f64().and_then(&common_mm));
            section["u_gg_random_mm"] = random;
            section["u_gg_common_mm"] = json!(common);
            if section["half_turn"] == true {
                // Half a turn takes the spindle as still: of its even motion nothing is known.
                section["harmonics"]["even_spindle"] = Value::Null;
            }
            section["roundness_mm"] = json!({ "lsci": lsci, "mzci": mzci, "mici": mici, "mcci": mcci });
        }
    }
    all
}

/// The filter and how far the angles let it reach: n tangents a revolution carry up to n/2 undulations.
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

/// The part's form for people.
pub fn turn_table(turn: &Value) -> String {
    let um = |v: &Value| v.as_f64().map_or("-".to_owned(), |x| format!("{:.3}", 1e3 * x));
    let mm = |v: &Value| v.as_f64().map_or("-".to_owned(), |x| format!("{x:.5}"));
    let mut text = format!(
        "\nform over the turn, of {}\n{}\n{:>10} {:>11} {:>11} {:>11} {:>9} {:>8} {:>8} {:>8} {:>8}\n",
        turn["of"].as_str().unwrap_or(""),
        turn["filter"].as_str().unwrap_or(""),
        "z/mm",
        "GG/mm",
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
        text += &format!(
            "{:>10.3} {:>11} {:>11} {:>11} {:>9} {:>8} {:>8} {:>8} {:>8}\n",
            s["z_mm"].as_f64().unwrap_or(f64::NAN),
            mm(&s["gg_mm"]),
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
    if let Some(judged) = turn.get("judged") {
        let word = judged["judgement"].as_str().map_or_else(
            || format!("not proven: {}", judged["why"].as_str().unwrap_or("")),
            |word| format!("{} mm: {word}", mm(&judged["d_mm"])),
        );
        text += &format!("{} {word}\n", judged["what"].as_str().unwrap_or(""));
    }
    text
}
