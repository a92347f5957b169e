//! The charts of `measure`'s report: the largest diameter of every frame with U and limits, and the
//! stations along z.

use super::measured_frames::{MeasuredFrames, StationRow};
use super::measured_values::{Group, MeasuredValues, Seen, Value};
use super::plot::{Chart, Mark, Series, band, bars};
use crate::measurement::Verdict;

/// Most frames whose stations are a line each: as many as there are colours.
const MOST_LINES: usize = 8;
/// Colours of limits and of frames without a judgement.
const LIMITS: usize = 1;
const VALUES: usize = 0;

/// Frames of a kind of judgement: name, severity, colour with its own shape.
const KINDS: [(&str, u8, usize); 3] = [("GO", 0, 0), ("HI, LO or not proven", 1, 4), ("HH or LL", 2, 6)];

/// The chart of the frames in their order; `limits_mm` are those of a tolerance.
pub(super) fn diameter_chart(values: &MeasuredValues, limits_mm: Option<(f64, f64)>) -> Chart {
    let mut series = values.single().map_or_else(|| grouped(values.groups()), single);
    if let (Some((lower, upper)), count) = (limits_mm, values.frames.max(2)) {
        let level = |mm: f64| vec![(1.0, mm), (count as f64, mm)];
        series.push(Series::new("limits", Mark::Dashed, LIMITS, level(upper)));
        series.push(Series::new("", Mark::Dashed, LIMITS, level(lower)));
    }
    Chart {
        x_label: "frame, in their order".to_owned(),
        y_label: "largest diameter / mm".to_owned(),
        series,
        x_labels: Some(values.frames.clamp(1, 11)),
        ..Chart::default()
    }
}

/// A dot and a bar a frame, in a series a kind of judgement.
fn single(found: &[Seen]) -> Vec<Series> {
    let ends = bars(found.iter().map(|(x, v, _)| (*x, v.d_mm, v.expanded_mm)));
    let mut series = vec![Series::new("U", Mark::Bars, VALUES, ends)];
    let of = |wanted: &dyn Fn(Verdict) -> bool| -> Vec<(f64, f64)> {
        found.iter().filter(|f| wanted(f.2)).map(|(x, v, _)| (*x, v.d_mm)).collect()
    };
    series.push(Series::new("not judged", Mark::Dots, VALUES, of(&|v| v == Verdict::NotJudged)));
    for (name, severity, colour) in KINDS {
        let kind = of(&|v| v != Verdict::NotJudged && v.severity() == severity);
        series.push(Series::new(name, Mark::Dots, colour, kind));
    }
    series.retain(|s| !s.points.is_empty());
    // A single kind needs no name beside its judgement in the table.
    for s in series.iter_mut().filter(|s| s.name == "not judged") {
        s.name = "diameter".to_owned();
    }
    series
}

/// Groups of neighbouring frames: from the least end of their U to the greatest, and their mean.
fn grouped(groups: &[Group]) -> Vec<Series> {
    let ends = groups.iter().map(|g| (g.x(), 0.5 * (g.low_mm + g.high_mm), 0.5 * (g.high_mm - g.low_mm)));
    let means = groups.iter().map(|g| (g.x(), g.mean_mm())).collect();
    vec![
        Series::new("all values with U", Mark::Band, VALUES, band(ends)),
        Series::new("mean", Mark::Line, VALUES, means),
    ]
}

/// The chart of the stations along z; `k` is the coverage factor of their U. `None` without a
/// value.
pub(super) fn station_chart(frames: &MeasuredFrames, k: f64, limits_mm: Option<(f64, f64)>) -> Option<Chart> {
    let value = |s: &StationRow| {
        let value = s.station.reading.value().map(|d| Value::of(d, k));
        (s.station.z_mm, value.map_or(f64::NAN, |v| v.d_mm), value.map_or(f64::NAN, |v| v.expanded_mm))
    };
    let of = |frame: usize| frames.stations.iter().filter(move |s| s.frame == frame).map(value);
    let mut own: Vec<usize> = frames.stations.iter().map(|s| s.frame).collect();
    own.dedup();
    let mut series = Vec::new();
    if own.len() <= MOST_LINES {
        for (colour, &frame) in own.iter().enumerate() {
            let name = frames.station_frames.get(frame).map_or("", String::as_str);
            let line = of(frame).map(|(z, d, _)| (z, d)).collect();
            series.push(Series::new("", Mark::Bars, colour, bars(of(frame))));
            series.push(Series::new(name, Mark::LineDots, colour, line));
        }
    } else {
        let all = frames.stations.iter().map(value).map(|(z, d, _)| (z, d));
        series.push(Series::new("stations of all frames", Mark::Dots, VALUES, all.collect()));
    }
    let zs = || frames.stations.iter().map(|s| s.station.z_mm);
    if let Some((lower, upper)) = limits_mm {
        let (from, to) = (zs().fold(f64::INFINITY, f64::min), zs().fold(f64::NEG_INFINITY, f64::max));
        for (name, mm) in [("limits", upper), ("", lower)] {
            series.push(Series::new(name, Mark::Dashed, LIMITS, vec![(from, mm), (to, mm)]));
        }
    }
    let has_value = frames.stations.iter().any(|s| s.station.reading.value().is_some());
    has_value.then(|| Chart {
        x_label: "z / mm".to_owned(),
        y_label: "diameter of the station / mm".to_owned(),
        series,
        ..Chart::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::measured_values::MOST_GROUPS;

    fn values(values: impl IntoIterator<Item = (f64, Verdict)>) -> MeasuredValues {
        let mut all = MeasuredValues::default();
        let value = |d_mm| Value { d_mm, expanded_mm: 0.01 };
        values.into_iter().for_each(|(d_mm, verdict)| all.add(Some(value(d_mm)), verdict));
        all
    }

    #[test]
    fn kinds_of_judgements_are_series_of_their_own_between_limits() {
        use crate::conformity::Judgement;
        let judged = [Judgement::GO, Judgement::HI, Judgement::HH].map(|j| (25.0, Verdict::Is(j)));
        let chart = diameter_chart(&values(judged), Some((24.9, 25.1)));
        let names: Vec<&str> = chart.series.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["U", "GO", "HI, LO or not proven", "HH or LL", "limits", ""]);
        let svg = chart.to_svg().unwrap();
        assert!(svg.contains("limits: 25.1 to 25.1"), "{svg}");
        let plain = diameter_chart(&values([(25.0, Verdict::NotJudged)]), None);
        let names: Vec<&str> = plain.series.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["U", "diameter"]);
    }

    #[test]
    fn a_long_series_is_a_band_of_bounded_size() {
        let chart = diameter_chart(
            &values((0..5000).map(|i| (25.0 + f64::from(i % 7) * 1e-3, Verdict::NotJudged))),
            None,
        );
        assert!(chart.series.iter().all(|s| s.points.len() <= 2 * MOST_GROUPS));
        let band = &chart.series[0].points;
        assert!(
            band.iter().any(|p| (p.1 - 25.016).abs() < 1e-9)
                && band.iter().any(|p| (p.1 - 24.99).abs() < 1e-9)
        );
        assert!(chart.to_svg().unwrap().len() < 40_000);
    }
}
