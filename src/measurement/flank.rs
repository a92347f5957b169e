//! The document of measured flanks: what `tool flank` prints.

use serde::Serialize;

use crate::gauge::flank::paper::PaperFlank;
use crate::gauge::flank::{FlankBudget, FlankMeasurement};
use crate::tool::wear::{Forecast, Land, WearClass, WearLimits, WearVerdict};

/// One image's flank.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FlankImage {
    /// The file's stem.
    pub image: String,
    /// Mean width of the land over zone B, µm.
    pub vbb_um: f64,
    /// Its standard uncertainty, µm; null in the paper's mode, and of a network that states no
    /// errors.
    pub u_vbb_um: Option<f64>,
    /// Largest width in zone B, µm.
    pub vbb_max_um: f64,
    /// Its standard uncertainty, µm.
    pub u_vbb_max_um: Option<f64>,
    /// Largest width in zone C, µm; null without the corner or the nose radius.
    pub vc_um: Option<f64>,
    /// Its standard uncertainty, µm.
    pub u_vc_um: Option<f64>,
    /// Largest width in zone N, µm; null without the corner.
    pub vn_um: Option<f64>,
    /// Its standard uncertainty, µm.
    pub u_vn_um: Option<f64>,
    /// Length over which the edge is worn, µm.
    pub worn_length_um: f64,
    /// How it is worn.
    pub class: WearClass,
    /// Whether it still cuts, by the decision rule.
    pub verdict: WearVerdict,
    /// What limits the use of the measurement.
    pub flags: Vec<&'static str>,
    /// Rows of u(VBB), µm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<FlankBudget>,
    /// The new edge: px into the flank by powers of the place along it over its length.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reference_curve: Vec<f64>,
}

/// Images of one call.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct FlankDocument {
    /// Every image that was measured.
    pub images: Vec<FlankImage>,
    /// When VBB and VBBmax reach their limits, where a history is kept.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub forecasts: Vec<Forecast>,
}

impl FlankImage {
    /// Of a measurement.
    pub(crate) fn new(image: String, m: &FlankMeasurement, limits: &WearLimits) -> Self {
        let land = Land { vbb_um: (m.vbb.um, m.vbb.u_um), vbb_max_um: (m.vbb_max.um, m.vbb_max.u_um) };
        let known = |u_um: f64| u_um.is_finite().then_some(u_um);
        Self {
            image,
            vbb_um: m.vbb.um,
            u_vbb_um: known(m.vbb.u_um),
            vbb_max_um: m.vbb_max.um,
            u_vbb_max_um: known(m.vbb_max.u_um),
            vc_um: m.vc.map(|w| w.um),
            u_vc_um: m.vc.and_then(|w| known(w.u_um)),
            vn_um: m.vn.map(|w| w.um),
            u_vn_um: m.vn.and_then(|w| known(w.u_um)),
            worn_length_um: m.worn_length_um,
            class: land.class(),
            verdict: land.verdict(limits),
            flags: m.flags.clone(),
            budget: Some(m.budget),
            reference_curve: m.curve.clone(),
        }
    }

    /// Of the paper's way, which states no uncertainty: nothing is proven by it.
    pub(crate) fn of_paper(image: String, p: &PaperFlank, limits: &WearLimits) -> Self {
        let land = Land { vbb_um: (p.vb_um, f64::NAN), vbb_max_um: (p.vb_max_um, f64::NAN) };
        Self {
            image,
            vbb_um: p.vb_um,
            u_vbb_um: None,
            vbb_max_um: p.vb_max_um,
            u_vbb_max_um: None,
            vc_um: None,
            u_vc_um: None,
            vn_um: None,
            u_vn_um: None,
            worn_length_um: p.worn_length_um,
            class: land.class(),
            verdict: land.verdict(limits),
            flags: vec!["no_uncertainty"],
            budget: None,
            reference_curve: Vec::new(),
        }
    }
}
