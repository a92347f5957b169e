//! Statistics of the frames' mean diameters, as `measure` prints them.

use serde_json::{Value, json};

use crate::gauge::diameter::reading_scatter::{ScatterTest, SeriesMean};
use crate::gauge::diameter::reading_series::RunningStatistics;
use crate::gauge::stated::stated;
use crate::profile::Diameter;

/// Mean diameters of the frames in their order.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameMeans {
    series: Vec<Diameter>,
    running: RunningStatistics,
}

impl FrameMeans {
    pub(super) fn push(&mut self, mean: Diameter) {
        self.running.push(mean.d_mm);
        self.series.push(mean);
    }

    pub(super) fn running(&self) -> &RunningStatistics {
        &self.running
    }

    /// χ² of the means against their own random uncertainties.
    fn scatter(&self) -> Option<ScatterTest> {
        let readings: Vec<(f64, f64)> = self.series.iter().map(|d| (d.d_mm, d.u_random_mm)).collect();
        ScatterTest::of(&readings)
    }

    /// The `statistics` of the document; `None` without a frame.
    pub(super) fn to_json(&self) -> Option<Value> {
        let of = SeriesMean::of(&self.series)?;
        let (min, max) = self.running.extremes()?;
        let several = self.series.len() > 1;
        Some(json!({
            "count": self.series.len(),
            "mean_mm": of.mean.d_mm,
            // A single value has no scatter.
            "sd_mm": several.then_some(of.sd_mm),
            "u_mean_mm": of.mean.u_mm(),
            "u_mean_random_mm": of.mean.u_random_mm,
            "u_mean_common_mm": of.mean.u_common_mm,
            "effective_count": of.effective_number,
            "scatter": self.scatter(),
            "min_mm": min,
            "max_mm": max,
            "range_mm": max - min,
        }))
    }

    /// A warning where the frames scatter beyond their u.
    pub(super) fn word(&self) -> Option<String> {
        let test = self.scatter().filter(|test| test.beyond_u)?;
        let sd_um = 1e3 * SeriesMean::of(&self.series)?.sd_mm;
        Some(format!(
            "the mean diameters of {} frames scatter by {} um (standard deviation), {:.1} times what their u explains (chi2 {:.4} at {} degrees of \
             freedom, limit {:.4} at a false alarm of {} %): form, motion, drift or dirt between the frames; u of their mean \
             is taken from the scatter",
            self.series.len(),
            stated(sd_um, sd_um)[0],
            test.ratio(),
            test.chi2,
            test.freedom,
            test.chi2_limit,
            100.0 * test.false_alarm_probability
        ))
    }
}

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
