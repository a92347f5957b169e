//! The form over a revolution as `measure --turn` prints it.

use serde_json::Value;

use crate::gauge::axis_line::STILL_TOWARDS_CAMERA;
use crate::gauge::stated::stated;

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

/// The part's form as a table of text.
pub(crate) fn turn_table(turn: &Value) -> String {
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
