//! Rows of the study, and what is printed of them.

use serde::Serialize;

use super::child::{Ending, Printed};
use crate::studies::limits::{Change, Figures, Measured, Variant, Way, is_share};

/// One variant: its figures, or how it ended.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    /// The threshold, its default, which way it is varied, the value it is given.
    #[serde(flatten)]
    pub(super) variant: Variant,
    /// changed, same, crashed or timed_out.
    pub(super) status: &'static str,
    /// Last words of a process that crashed.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(super) words: String,
    /// Kinds of scenes of which any result changed.
    pub(super) kinds_changed: Vec<String>,
    /// Its figures.
    pub(super) figures: Option<Figures>,
    /// By how much they differ from the default's.
    pub(super) change: Option<Change>,
    /// CPU time over the default's.
    pub(super) cpu_relative: Option<f64>,
}

impl Row {
    pub(super) fn new(variant: &Variant, ending: Ending, default: &Printed) -> Self {
        let empty = Self {
            variant: variant.clone(),
            status: "timed_out",
            words: String::new(),
            kinds_changed: Vec::new(),
            figures: None,
            change: None,
            cpu_relative: None,
        };
        match ending {
            Ending::TimedOut => empty,
            Ending::Crashed(words) => Self { status: "crashed", words, ..empty },
            Ending::Measured(Printed { measured, cpu_s }) => {
                let kinds_changed = default.measured.kinds_unlike(&measured);
                let (before, after) = (default.measured.counts().figures(), measured.counts().figures());
                Self {
                    status: if kinds_changed.is_empty() { "same" } else { "changed" },
                    kinds_changed,
                    figures: Some(after),
                    change: Some(Change::between(&before, &after)),
                    cpu_relative: cpu_s.zip(default.cpu_s).map(|(own, of_default)| own / of_default),
                    ..empty
                }
            }
        }
    }

    fn size(&self) -> f64 {
        self.change.map_or(f64::INFINITY, |change| change.size())
    }

    fn shows(&self) -> bool {
        self.change.is_none_or(|change| change.shows())
    }
}

/// The study.
#[derive(Debug, Serialize)]
pub(super) struct Study {
    /// Seed of the scenes.
    pub(super) seed: u64,
    /// Scenes of each kind.
    pub(super) scenes: usize,
    /// Figures with every threshold at its default.
    pub(super) default: Figures,
    /// The default by kind of scene.
    pub(super) default_kinds: Measured,
    /// Thresholds that are zero: they have no half.
    pub(super) zero: Vec<String>,
    /// Every variant, in the order of the thresholds.
    pub(super) variants: Vec<Row>,
}

impl Study {
    /// Both variants of a threshold.
    fn rows_of<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Row> {
        self.variants.iter().filter(move |row| row.variant.name == name)
    }
}

/// A row of `--csv`.
#[derive(Debug, Serialize)]
pub(super) struct CsvRow<'a> {
    threshold: &'a str,
    default: f64,
    variant: &'a str,
    value: f64,
    status: &'a str,
    coverage: Option<f64>,
    rms_error_over_u: Option<f64>,
    mishandled: Option<usize>,
    lost: Option<usize>,
    refused: Option<usize>,
    rms_error_px: Option<f64>,
    cpu_relative: Option<f64>,
    kinds_changed: String,
    words: &'a str,
}

impl<'a> From<&'a Row> for CsvRow<'a> {
    fn from(row: &'a Row) -> Self {
        let f = row.figures.as_ref();
        Self {
            threshold: &row.variant.name,
            default: row.variant.default,
            variant: row.variant.way.name(),
            value: row.variant.value,
            status: row.status,
            coverage: f.map(|f| f.coverage),
            rms_error_over_u: f.map(|f| f.rms_error_over_u),
            mishandled: f.map(|f| f.mishandled),
            lost: f.map(|f| f.lost),
            refused: f.map(|f| f.refused),
            rms_error_px: f.map(|f| f.rms_error_px),
            cpu_relative: row.cpu_relative,
            kinds_changed: row.kinds_changed.join("; "),
            words: &row.words,
        }
    }
}

/// A value in as many digits as it was written with.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        rounded.to_string()
    }
}

/// Prints the study: the default, thresholds that change a figure (largest first), those that
/// change results by less than a figure shows, those without effect, those that are zero.
pub(super) fn print(study: &Study) {
    print_default(study);
    let mut names: Vec<&str> = study.variants.iter().map(|row| row.variant.name.as_str()).collect();
    names.dedup();
    let changed = |name: &&str| study.rows_of(name).any(|row| row.status != "same");
    let (mut changing, without): (Vec<&str>, Vec<&str>) = names.into_iter().partition(changed);
    let size = |name: &str| study.rows_of(name).map(Row::size).fold(0.0, f64::max);
    // Equal sizes keep the order of the thresholds.
    changing.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let (shown, below): (Vec<&str>, Vec<&str>) =
        changing.into_iter().partition(|name| study.rows_of(name).any(Row::shows));
    print_head();
    shown.iter().flat_map(|name| study.rows_of(name)).for_each(print_row);
    list("results change, by less than any figure shows", &below);
    list("not reached or without effect in these scenes: not one bit of any result differs", &without);
    let zero: Vec<&str> = study.zero.iter().map(String::as_str).collect();
    list("zero, which has no half: skipped", &zero);
    if study.variants.iter().any(|row| is_share(row.variant.default)) {
        say_line!("a share between 0.5 and 1 has its distance to 1 halved and doubled");
    }
}

fn print_default(study: &Study) {
    let (f, counts) = (&study.default, study.default_kinds.counts());
    say_line!(
        "default, {} scenes of each of {} kinds, seed {} ({} frames):",
        study.scenes,
        study.default_kinds.kinds.len(),
        study.seed,
        counts.frames
    );
    say_line!(
        "  {:.2} % of {} clean values covered, rms error/u {:.3}, rms error {:.4} px",
        1e2 * f.coverage,
        counts.clean - counts.lost,
        f.rms_error_over_u,
        f.rms_error_px
    );
    say_line!(
        "  {} of {} values beside contamination mishandled; {} of {} clean stations lost; {} frames refused",
        f.mishandled,
        counts.kept,
        f.lost,
        counts.clean,
        f.refused
    );
}

fn print_head() {
    say_line!("change of each figure, half and double against the default:");
    say_line!(
        "{:<44} {:>6} {:>11} {:>11} {:>8} {:>8} {:>8} {:>6} {:>7} {:>8} {:>5} {:>6}",
        "threshold",
        "",
        "default",
        "value",
        "cover %",
        "e/u %",
        "mishand.",
        "lost",
        "refused",
        "rms %",
        "kinds",
        "CPU"
    );
}

fn print_row(row: &Row) {
    let Variant { name, default, way, value } = &row.variant;
    let name = if *way == Way::Half { name.as_str() } else { "" };
    let start = format!("{name:<44} {:>6} {:>11} {:>11}", way.name(), short(*default), short(*value));
    let Some(c) = row.change else {
        let how = if row.status == "crashed" { "CRASHED" } else { "NOT ENDED within the time limit" };
        say_line!("{start} {how} {}", row.words);
        return;
    };
    if row.status == "same" {
        say_line!("{start} same");
        return;
    }
    say_line!(
        "{start} {:>+8.2} {:>+8.1} {:>+8} {:>+6} {:>+7} {:>+8.1} {:>5} {:>6}",
        c.coverage_percent,
        c.rms_error_over_u_percent,
        c.mishandled,
        c.lost,
        c.refused,
        c.rms_error_percent,
        row.kinds_changed.len(),
        row.cpu_relative.map_or("-".to_owned(), |times| format!("{times:.2}"))
    );
}

fn list(title: &str, names: &[&str]) {
    if names.is_empty() {
        return;
    }
    say_line!("{title} ({}):", names.len());
    names.iter().for_each(|name| say_line!("  {name}"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_short() {
        assert_eq!(short(f64::from(0.1_f32)), "0.1");
        assert_eq!((short(1e-9), short(16.0), short(2.5e7)), ("1e-9".into(), "16".into(), "2.5e7".into()));
    }
}
