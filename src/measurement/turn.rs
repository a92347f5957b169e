//! The form over a revolution.

use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use super::turn_angles::{Coverage, Smear};
use super::turn_sizes::TurnJudged;
use crate::gauge::axis_line::{AxisLine, STILL_TOWARDS_CAMERA};
use crate::gauge::diameter::sections::{PartForm, SectionForm};
use crate::gauge::plausibility::Jump;

/// Form, sizes and axis of a part over a revolution. Its JSON is the `turn` of the document.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnForm {
    /// Form and sizes, section by section.
    pub form: PartForm,
    /// What the sizes of a section share.
    pub common: Vec<SectionUncertainty>,
    /// Angles that the diameters cover, place by place.
    pub coverage: Vec<Coverage>,
    /// Largest angle that the spindle turned during an exposure, degrees; 0 where it stood.
    pub sweep_deg: f64,
    /// Diameters that contradicted earlier turns.
    pub implausible: Vec<Jump>,
    /// The axis along z.
    pub axis: AxisLine,
    /// The judgement of a size over the revolution, where the tolerance applies to one.
    pub judged: Option<TurnJudged>,
}

/// Common standard uncertainty of the sizes of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionUncertainty {
    /// Middle of the section, mm.
    pub z_mm: f64,
    /// Common standard uncertainty, mm; `None` where no column of it has a diameter.
    pub u_mm: Option<f64>,
}

impl TurnForm {
    /// The common standard uncertainty of the section at `z_mm`, mm.
    fn common_mm(&self, z_mm: f64) -> Option<f64> {
        self.common.iter().find(|c| c.z_mm == z_mm)?.u_mm
    }

    /// What the exposure took from the lobes of a section.
    fn smear(&self, form: &SectionForm) -> Smear {
        Smear::of(form.harmonics.section.iter().map(|h| (h.lobes, h.amplitude_mm)), self.sweep_deg)
    }

    fn to_json(&self) -> Value {
        let mut all = json!(self.form);
        all["filter"] = json!(filter_text(&self.form));
        all["of"] = json!("the silhouette: sizes and roundness of the sections' convex hulls");
        all["refused"] = self.form.refused.iter().map(|(z, why)| json!({ "z_mm": z, "why": why })).collect();
        all["sections"] = self.form.sections.iter().map(|section| self.section_json(section)).collect();
        all["coverage"] = json!(self.coverage);
        all["implausible"] = json!(self.implausible);
        all["axis"] = axis_json(&self.axis);
        if let Some(judged) = &self.judged {
            all["judged"] = json!(judged);
        }
        all
    }

    fn section_json(&self, form: &SectionForm) -> Value {
        let mut section = json!(form);
        let [lsci, mzci, mici, mcci] = form.roundness_mm;
        let common = self.common_mm(form.z_mm);
        section["u_gg_mm"] = json!(common.map(|common| form.u_gg_random_mm.hypot(common)));
        section["u_gg_common_mm"] = json!(common);
        if self.sweep_deg > 0.0 {
            section["exposure"] = json!(self.smear(form));
        }
        if form.half_turn {
            // With half a revolution the spindle is assumed free of error motion: its even
            // harmonics are not determined.
            section["harmonics"]["even_spindle"] = Value::Null;
        }
        section["roundness_mm"] = json!({ "lsci": lsci, "mzci": mzci, "mici": mici, "mcci": mcci });
        section
    }
}

impl Serialize for TurnForm {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.to_json().serialize(serializer)
    }
}

/// The axis over the revolution in the JSON document.
fn axis_json(axis: &AxisLine) -> Value {
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
