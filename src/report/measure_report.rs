//! The report of `measure` for who judges parts: what was measured with what, the verdict, values
//! with U and limits, what was refused and why, the budget, the series.
//!
//! In: a [`MeasureSetup`], then frame by frame ([`MeasureReport::add`]), then the series. Out: one
//! page ([`MeasureReport::finish`]). It keeps what it shows (`measured_frames`), so that a series
//! may be of any length.

use std::collections::BTreeSet;

use super::budget_words::{BUDGET_HEADER, budget_rows, budget_words};
use super::error::ReportError;
use super::html::{Page, Tone};
use super::measured_charts::{diameter_chart, station_chart};
use super::measured_frames::{FrameRow, MOST_PICTURES, MOST_ROWS, MeasuredFrames, StationRow};
use super::measured_series::{statistics, turn};
pub(crate) use super::measured_setup::MeasureSetup;
use super::measured_setup::{facts, is_uncalibrated, plain};
use super::measured_values::Value;
use super::reason_words::reason_words;
use crate::conformity::Judgement;
use crate::frame::Frame;
use crate::gauge::stated::{decimals, rounded, stated};
use crate::measurement::{Deciding, Judged, Measurement, Series, Verdict};
use crate::profile::{Reading, Reason};

/// A report under construction.
#[derive(Clone, Debug)]
pub(crate) struct MeasureReport {
    facts: Vec<Vec<String>>,
    title: String,
    limits_mm: Option<(f64, f64)>,
    /// Coverage factor of means, averages and stations.
    k: f64,
    uncalibrated: bool,
    frames: MeasuredFrames,
}

impl MeasureReport {
    /// A report of frames that are to come.
    pub(crate) fn begin(setup: &MeasureSetup<'_>) -> Self {
        Self {
            facts: facts(setup),
            title: format!("Diameters of {}", setup.inputs.join(", ")),
            limits_mm: setup.settings.tolerance.map(|tolerance| tolerance.limits_mm()),
            k: setup.settings.factor_of_means(),
            uncalibrated: is_uncalibrated(setup.calibration),
            frames: MeasuredFrames::default(),
        }
    }

    /// Adds a frame; its picture is kept, small, where it was refused.
    pub(crate) fn add(&mut self, measured: &Measurement, frame: Option<&Frame>) {
        self.frames.add(measured, self.k, frame);
    }

    /// The page.
    ///
    /// # Errors
    /// Where a chart cannot be drawn.
    pub(crate) fn finish(self, series: &Series) -> Result<String, ReportError> {
        let mut page = Page::new(&self.title);
        self.verdict(&mut page, series);
        let mut facts = self.facts.clone();
        facts.push(vec!["Frames".to_owned(), self.count_words()]);
        page.heading("What was measured").table(&["what", "value"], &facts);
        self.values(&mut page)?;
        self.stations(&mut page)?;
        statistics(&mut page, series.statistics.as_ref());
        turn(&mut page, series.turn.as_ref());
        self.refused(&mut page);
        self.budget(&mut page);
        if !series.warnings.is_empty() {
            page.heading("To be looked at");
            series.warnings.iter().for_each(|warning| {
                page.text(warning);
            });
        }
        Ok(page.finish())
    }

    fn count_words(&self) -> String {
        let (all, refused) = (self.frames.count, self.frames.refused_count);
        format!("{all}, of which {refused} refused")
    }

    fn verdict(&self, page: &mut Page, series: &Series) {
        let (tone, text) = match series.judgement {
            _ if self.limits_mm.is_none() => (Tone::Open, "No tolerance was given: nothing was judged."),
            Some(Judgement::GO) => {
                (Tone::Good, "In tolerance: every value is proven to lie within the limits.")
            }
            Some(Judgement::HH | Judgement::LL) => {
                (Tone::Bad, "Out of tolerance: at least one value is proven to lie beyond a limit.")
            }
            Some(Judgement::HI | Judgement::LO) | None => {
                (Tone::Open, "Not proven: not every value is proven to lie within the limits.")
            }
        };
        page.verdict(tone, text);
        if self.uncalibrated && self.limits_mm.is_some() {
            page.text("Scale and edge offset are not calibrated: U does not hold their uncertainty, and the verdict is only as good as they are.");
        }
    }

    /// The chart and the table of the frames.
    fn values(&self, page: &mut Page) -> Result<(), ReportError> {
        page.heading("Frames");
        if !self.frames.values.is_empty() {
            let chart = diameter_chart(&self.frames.values, self.limits_mm);
            let svg = chart.to_svg().map_err(ReportError::Draw)?;
            let refused = self.frames.refused_count;
            let gaps = match refused {
                0 => String::new(),
                1 => " One refused frame has no value.".to_owned(),
                _ => format!(" {refused} refused frames have no value."),
            };
            page.figure(
                &svg,
                &format!("Largest diameter of every frame with its expanded uncertainty U.{gaps}"),
            );
        }
        let shown = self.frames.shown();
        page.filled_columns(&FRAME_HEADER, &frame_rows(&shown));
        if shown.len() < self.frames.count {
            page.text(&format!(
                "{} of {} frames: first those that are not good or were refused. Every frame stands in the file of --csv.",
                shown.len(),
                self.frames.count
            ));
        }
        self.legend(page);
        Ok(())
    }

    /// Words that stand in the table: judgements, reasons, coverage factors.
    fn legend(&self, page: &mut Page) {
        let seen = &self.frames.words;
        if let Some((low, high)) = seen.factors {
            let largest =
                if high - low < 0.005 { format!("{low:.2}") } else { format!("{low:.2} to {high:.2}") };
            page.text(&format!(
                "U = k·u with k = {largest} for the largest diameters, {} for means, averages and stations.",
                plain(self.k)
            ));
        }
        let judged = |judgement: &Judgement| {
            let is = Verdict::Is(*judgement);
            seen.has(is) || self.frames.stations.iter().any(|s| station_verdict(s) == is)
        };
        let mut words: Vec<Vec<String>> = Judgement::ALL
            .iter()
            .filter(|judgement| judged(judgement))
            .map(|judgement| vec![judgement.as_str().to_owned(), judgement.meaning().to_owned()])
            .collect();
        if seen.has(Verdict::NotProven) {
            words.push(
                ["not proven", "a size was not measured, or may be another part's"]
                    .map(str::to_owned)
                    .to_vec(),
            );
        }
        let mut reasons: BTreeSet<Reason> = seen.reasons.clone();
        reasons.extend(self.frames.stations.iter().filter_map(station_gap));
        words.extend(
            reasons
                .into_iter()
                .map(|reason| vec![reason.as_str().to_owned(), reason_words(reason).to_owned()]),
        );
        if !words.is_empty() {
            page.table(&["word", "meaning"], &words);
        }
    }

    fn stations(&self, page: &mut Page) -> Result<(), ReportError> {
        let stations = &self.frames.stations;
        if stations.is_empty() {
            return Ok(());
        }
        page.heading("Stations");
        if let Some(chart) = station_chart(&self.frames, self.k, self.limits_mm) {
            let svg = chart.to_svg().map_err(ReportError::Draw)?;
            page.figure(&svg, "Mean diameter of every station along z.");
        }
        let shown = &stations[..stations.len().min(MOST_ROWS)];
        let values = shown.iter().filter_map(|s| s.station.reading.value()).map(|d| Value::of(d, self.k));
        let places = Places::of(values);
        let rows: Vec<Vec<String>> = shown
            .iter()
            .map(|s| {
                let frame = self.frames.station_frames.get(s.frame).map_or("", String::as_str);
                let value = s.station.reading.value().map(|d| Value::of(d, self.k));
                let [d, u] = places.cells(value);
                let gap = station_gap(s).map_or_else(String::new, |reason| reason.as_str().to_owned());
                let word = station_verdict(s).word().replace('_', " ");
                vec![frame.to_owned(), format!("{:.3}", s.station.z_mm), d, u, word, gap]
            })
            .collect();
        page.filled_columns(&["frame", "z / mm", "diameter / mm", "U / mm", "judgement", "gap"], &rows);
        let left_out = stations.len() - shown.len() + self.frames.stations_left_out;
        if left_out > 0 {
            page.text(&format!("{left_out} further stations stand in the file of --csv."));
        }
        Ok(())
    }

    fn refused(&self, page: &mut Page) {
        let count = self.frames.refused_count;
        if count == 0 {
            return;
        }
        page.heading("Refused frames");
        for refused in &self.frames.refused {
            match &refused.png {
                Some(png) => {
                    let shows = format!("Frame {} as the camera gave it", refused.frame);
                    page.image(png, &shows, &refused.why);
                }
                None => {
                    page.text(&refused.why);
                }
            }
        }
        if count > self.frames.refused.len() {
            page.text(&format!(
                "{} of {count} refused frames; the table of the frames names the reason of the others.",
                self.frames.refused.len().min(MOST_PICTURES)
            ));
        }
    }

    fn budget(&self, page: &mut Page) {
        let Some(worst) = &self.frames.budget else { return };
        page.heading(&format!("Uncertainty budget of frame {}", worst.frame))
            .text(&budget_words(&worst.budget, worst.k));
        page.table(&BUDGET_HEADER, &budget_rows(&worst.budget));
    }
}

/// Decimals of a column of values and of their U.
#[derive(Clone, Copy, Debug)]
struct Places(i32);

impl Places {
    /// As many as the least U needs.
    fn of(values: impl Iterator<Item = Value>) -> Self {
        let least = values.map(|v| v.expanded_mm).filter(|u| *u > 0.0).fold(f64::INFINITY, f64::min);
        Self(decimals(least))
    }

    fn cells(self, value: Option<Value>) -> [String; 2] {
        value.map_or_else(Default::default, |v| [rounded(v.d_mm, self.0), rounded(v.expanded_mm, self.0)])
    }
}

const FRAME_HEADER: [&str; 12] = [
    "frame",
    "largest diameter / mm",
    "U / mm",
    "at z / mm",
    "mean / mm",
    "U of mean / mm",
    "average / mm",
    "U of average / mm",
    "judgement",
    "judged by",
    "columns measured",
    "flags and remarks",
];

fn frame_rows(rows: &[&FrameRow]) -> Vec<Vec<String>> {
    let places = |pick: fn(&FrameRow) -> Option<Value>| Places::of(rows.iter().filter_map(|row| pick(row)));
    let (largest, mean, average) = (places(|r| r.largest), places(|r| r.mean), places(|r| r.average));
    let cells = |row: &&FrameRow| {
        let [d, u] = largest.cells(row.largest);
        let [mean_mm, u_mean] = mean.cells(row.mean);
        let [average_mm, u_average] = average.cells(row.average);
        let z = row.z_mm.map_or_else(String::new, |z| format!("{z:.3}"));
        let judged_by = row.judged.as_ref().map_or_else(String::new, judged_words);
        let word = row.verdict.word().replace('_', " ");
        let measured = format!("{} of {}", row.valid, row.columns);
        let frame = row.frame.clone();
        vec![frame, d, u, z, mean_mm, u_mean, average_mm, u_average, word, judged_by, measured, remarks(row)]
    };
    rows.iter().map(cells).collect()
}

/// The value that decided a judgement.
fn judged_words(judged: &Judged) -> String {
    let at = judged.z_mm.map_or_else(String::new, |z| format!(" at z = {z:.3} mm"));
    match judged.by {
        Deciding::Value { diameter, .. } => {
            format!("{} {} mm{at}", judged.what, stated(diameter.d_mm, diameter.u_mm())[0])
        }
        Deciding::Gap(reason) => format!("{}{at}: no value, {}", judged.what, reason.as_str()),
    }
}

fn remarks(row: &FrameRow) -> String {
    if let Some(reason) = row.refused {
        return format!("refused: {}", reason.as_str());
    }
    let flags = row.flags.iter().map(|(reason, columns)| format!("{} {columns}", reason.as_str()));
    flags.chain(row.warnings.iter().cloned()).collect::<Vec<_>>().join("; ")
}

fn station_verdict(s: &StationRow) -> Verdict {
    s.station
        .judged
        .map_or(Verdict::NotJudged, |judged| judged.judgement.map_or(Verdict::NotProven, Verdict::Is))
}

fn station_gap(s: &StationRow) -> Option<Reason> {
    match s.station.reading {
        Reading::Gap(reason) => Some(reason),
        Reading::Value(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::FrameMeta;
    use crate::gauge::Calibration;
    use crate::gauge::calibration::Conditions;
    use crate::measurement::{LargestDiameter, MeasureSettings, Refusal};
    use crate::profile::Diameter;

    fn begin(tolerance: Option<&str>) -> MeasureReport {
        let tolerance = tolerance.map(|text| text.parse().unwrap());
        MeasureReport::begin(&MeasureSetup {
            inputs: &["frames".to_owned()],
            date: "2026-01-31".parse().unwrap(),
            calibration: &Calibration::from_scale(10.0),
            conditions: &Conditions::default(),
            settings: &MeasureSettings { tolerance, ..MeasureSettings::default() },
        })
    }

    fn good(name: String, judgement: Verdict) -> Measurement {
        let diameter = Diameter { d_mm: 24.5, u_random_mm: 3e-4, u_common_mm: 4e-4 };
        let largest = LargestDiameter {
            diameter,
            u_mm: 5e-4,
            freedom: 50.0,
            coverage_factor: 2.4,
            expanded_u_mm: 1.2e-3,
        };
        let (mean, diameter) = (Some(diameter), Some(largest));
        Measurement {
            frame: name,
            columns: 90,
            valid: 80,
            mean,
            diameter,
            judgement,
            ..Measurement::default()
        }
    }

    fn refused(name: &str) -> Measurement {
        let refusal = Some(Refusal { reason: Reason::LowContrast, why: format!("frame {name}: dark <b>") });
        let (frame, judgement) = (name.to_owned(), Verdict::NotProven);
        Measurement { frame, columns: 90, refusal, judgement, ..Measurement::default() }
    }

    #[test]
    fn of_many_frames_those_that_are_not_good_come_first() {
        let mut report = begin(Some("24..25"));
        let white = Frame::linear(vec![1.0; 64 * 64], 64, 64, None, FrameMeta::default());
        for index in 0..1000 {
            report.add(&good(format!("good_{index}"), Verdict::Is(Judgement::GO)), None);
        }
        report.add(&refused("dark"), Some(&white));
        report.add(&good("high".to_owned(), Verdict::Is(Judgement::HI)), None);
        let series = Series { judgement: Some(Judgement::HI), ..Series::default() };
        let html = report.finish(&series).unwrap();
        for part in
            ["400 of 1002 frames", "1002, of which 1 refused", ">high</th>", ">dark</th>", "Not proven"]
        {
            assert!(html.contains(part), "{part} is not in the report");
        }
        assert!(html.contains("<figcaption>frame dark: dark &lt;b&gt;</figcaption>"));
        assert!(html.contains("<td class=\"n\">24.5000</td><td class=\"n\">0.0012</td>"), "two digits of U");
        assert!(html.contains(">good_0</th>") && !html.contains(">good_500</th>"));
        assert!(html.len() < 200_000, "{} bytes", html.len());
    }

    #[test]
    fn nothing_is_shown_that_is_not_there() {
        let mut report = begin(None);
        report.add(&good("a".to_owned(), Verdict::NotJudged), None);
        let html = report.finish(&Series::default()).unwrap();
        assert!(html.contains("nothing was judged"));
        for part in
            ["judgement</th>", "average / mm", "Stations", "Refused frames", "budget of", "To be looked at"]
        {
            assert!(!html.contains(part), "{part} is in the report");
        }
    }
}
