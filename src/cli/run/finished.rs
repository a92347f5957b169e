//! What a finished run prints: passes as a table or as JSON, and its exit code.

use crate::cli::failure::Outcome;
use crate::conformity::part_verdict::{PartConformity, Verdict};
use crate::job::Job;
use crate::run_folder::{AxisRow, PassRow, SectionResults, axis_json};

use super::waiting::Waiting;

/// Result of a finished run.
pub(crate) struct Finished {
    pub(super) job: Job,
    pub(super) backend: String,
    pub(super) adapter: String,
    pub(super) passes: Vec<PassRow>,
    pub(super) axis: Vec<AxisRow>,
    pub(super) reference: Option<Vec<PassRow>>,
    pub(super) seconds: Vec<(f64, f64)>,
    pub(super) sections: Option<SectionResults>,
    pub(super) verdict: Option<Verdict>,
    pub(super) stopped: Option<String>,
    pub(super) waits: Option<Waiting>,
}

/// The keys of a pass; those that compare with the truth are left out where it is not given.
fn pass_json(p: &PassRow, (render_s, gauge_s): (f64, f64)) -> serde_json::Value {
    let mut json = serde_json::json!({
        "pass": p.pass, "nominal_mm": p.nominal_mm, "max_abs_error_mm": p.max_abs_error_mm,
        "rms_error_mm": p.rms_error_mm, "frames": p.frames, "decision": p.decision,
        "radial_force_n": p.radial_force_n, "tangential_force_n": p.tangential_force_n,
        "feed_force_n": p.feed_force_n, "deflection_um": p.deflection_um,
        "tangential_error_um": p.tangential_error_um, "feed_mark_um": p.feed_mark_um,
        "render_s": render_s, "gauge_s": gauge_s,
    });
    for (key, value) in [
        ("true_max_abs_error_mm", p.true_max_abs_error_mm),
        ("worst_measured_minus_true_mm", p.worst_measured_minus_true_mm),
        ("rms_error_over_u", p.rms_error_over_u),
    ] {
        if let Some(value) = value {
            json[key] = value.into();
        }
    }
    json
}

impl Finished {
    pub(super) fn outcome(&self) -> Outcome {
        let proven = self.verdict.as_ref().is_none_or(|v| v.part() == PartConformity::Conforms);
        if !proven || self.stopped.is_some() { Outcome::OutOfTolerance } else { Outcome::Done }
    }

    /// Whether frames of a pass are missing, so that the run is not finished.
    pub(super) fn is_waiting(&self) -> bool {
        self.waits.is_some()
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        let rows = |rows: &[PassRow], seconds: &[(f64, f64)]| -> Vec<serde_json::Value> {
            let of = |i: usize| seconds.get(i).copied().unwrap_or((0.0, 0.0));
            rows.iter().enumerate().map(|(i, p)| pass_json(p, of(i))).collect()
        };
        let mut passes = rows(&self.passes, &self.seconds);
        for (json, row) in passes.iter_mut().zip(&self.passes) {
            json["axis"] = axis_json(&self.axis, row.pass);
        }
        let mut json = serde_json::json!({
            "controller": self.job.control.controller.as_str(),
            "backend": self.backend,
            "adapter": self.adapter,
            "passes": passes,
            "in_tolerance": self.verdict.as_ref().map(|v| v.part() == PartConformity::Conforms),
            "conformity": self.verdict.as_ref().map(Verdict::part),
            // For one version also under the name that `measure` has for GO, HI, …
            "judgement": self.verdict.as_ref().map(Verdict::part),
            "alarm": self.verdict.as_ref().and_then(|v| v.alarm.clone()),
            "stopped": self.stopped,
        });
        if let Some(results) = &self.sections {
            json["sections"] = serde_json::json!(results.sections);
            json["tapers"] = serde_json::json!(results.tapers);
            json["excluded"] = serde_json::json!(results.excluded);
        }
        if let Some(waits) = &self.waits {
            json["waits_for"] = waits.to_json();
        }
        if let Some(reference) = &self.reference {
            json["without_control"] = serde_json::json!({ "passes": rows(reference, &[]) });
        }
        json
    }

    /// The passes as a table for a terminal.
    pub(crate) fn to_table(&self) -> String {
        let mut text = format!(
            "{}: controller {}, {} ({})\n\n pass  nominal/mm  max |e|/µm  true max |e|/µm  measured-true/µm  rms(error/u)  none: true max |e|/µm\n",
            self.job.name,
            self.job.control.controller.as_str(),
            self.backend,
            self.adapter
        );
        for (i, p) in self.passes.iter().enumerate() {
            let beside = self
                .reference
                .as_ref()
                .and_then(|r| r.get(i))
                .and_then(|r| r.true_max_abs_error_mm)
                .map_or("-".to_owned(), um);
            text += &format!(
                " {:>4}  {:>10.4}  {:>10}  {:>15}  {:>16}  {:>12}  {beside:>21}\n",
                p.pass,
                p.nominal_mm,
                um(p.max_abs_error_mm),
                or_none(p.true_max_abs_error_mm.map(um)),
                or_none(p.worst_measured_minus_true_mm.map(um)),
                or_none(p.rms_error_over_u.map(|ratio| format!("{ratio:.2}"))),
            );
        }
        text += &self.sections.as_ref().map_or_else(String::new, section_table);
        if let Some(stopped) = &self.stopped {
            text += &format!("\nALARM, {stopped}\n");
        }
        if let Some(waits) = &self.waits {
            text += &format!("\n{waits}\n");
        }
        if let Some(verdict) = &self.verdict {
            text += &format!("\n{}\n", verdict.words());
        }
        text
    }
}

fn um(mm: f64) -> String {
    format!("{:.2}", mm * 1e3)
}

fn or_none(text: Option<String>) -> String {
    text.unwrap_or_else(|| "-".to_owned())
}

/// The sections of a stepped shaft as a table for a terminal.
fn section_table(results: &SectionResults) -> String {
    let width = results.sections.iter().map(|s| s.name.chars().count()).max().unwrap_or(0).max(7);
    let mut text = format!(
        "\n {:<width$}   nominal/mm  stations  mean/mm    max |e|/µm  true max |e|/µm  judged\n",
        "section"
    );
    for s in &results.sections {
        text += &format!(
            " {:<width$}  {:>11.4}  {:>8}  {:>7}  {:>12}  {:>15}  {}\n",
            s.name,
            s.nominal_mm,
            s.stations_measured,
            s.mean_mm.map_or("-".to_owned(), |d| format!("{d:.4}")),
            um(s.max_abs_error_mm),
            or_none(s.true_max_abs_error_mm.map(um)),
            s.judged.map_or("-", |judged| match judged {
                PartConformity::Conforms => "conforms",
                PartConformity::NotProven => "not proven",
                PartConformity::Violates => "violates",
            })
        );
    }
    text
}
