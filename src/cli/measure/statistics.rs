//! Statistics of the frames' mean diameters, as `measure` prints them.

use serde_json::Value;

use crate::gauge::stated::stated;

/// The statistics as a line of text.
pub(super) fn statistics_line(s: &Value) -> String {
    let number = |key: &str| s[key].as_f64().unwrap_or(f64::NAN);
    let u = number("u_mean_mm");
    let [mean, u_text] = stated(number("mean_mm"), u);
    let [sd, _] = stated(number("sd_mm"), number("sd_mm"));
    let [min, max] = ["min_mm", "max_mm"].map(|key| stated(number(key), number("sd_mm"))[0].clone());
    let mut text = format!(
        "mean diameters of {} frames: mean {mean} mm (u {u_text}, common part included), sd {sd}, from {min} to {max}",
        s["count"]
    );
    for (key, name) in [("cp", "Cp"), ("cpk", "Cpk")] {
        if let Some(index) = s.get(key).filter(|c| c.is_object()) {
            let [value, lower, upper] = ["index", "lower", "upper"]
                .map(|k| index[k].as_f64().map_or("-".to_owned(), |x| format!("{x:.2}")));
            text += &format!(", {name} {value} (95 %: {lower} to {upper})");
        }
    }
    if let Some(why) = s.get("capability_none").and_then(Value::as_str) {
        text += &format!(", Cp and Cpk - ({why})");
    }
    text
}
