//! The conditions under which a part is measured, as far as its diameter at 20 °C depends on them.
//!
//! D₂₀ = D_T/(1 + α(T − 20 °C)) (ISO 1). What a condition is not known to comes in as a rectangular
//! distribution of the half width given, u = half/√3 (GUM 4.3.7). What is not stated is not exact:
//! it has the limits of [`Unstated`].

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::finish::Finish;
use super::head_geometry::HeadPlace;
use super::limb_difference::{LimbDifference, LimbRow};
use super::unstated::{Unstated, UnstatedLimits};
use crate::setting::{SettingError, within};

/// Reference temperature of ISO 1, °C.
const REFERENCE_C: f64 = 20.0;

/// Temperature, position and finish of the part while it is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "GivenConditions")]
pub struct Conditions {
    /// Temperature of the part, °C. -50 ..= 400.
    pub temperature_c: f64,
    /// Limits of its error, ± K. 0 ..= 100.
    pub limit_temperature_k: f64,
    /// Coefficient of expansion of the part, µm/(m·K). 0 ..= 100.
    pub expansion_um_per_m_k: f64,
    /// Limits of its error, ± µm/(m·K). 0 ..= 50.
    pub limit_expansion_um_per_m_k: f64,
    /// Distance of the axis from the plane of the masters, towards the camera, mm. -1000 ..= 1000.
    pub axis_y_mm: f64,
    /// Limits of its error, ± mm. 0 ..= 100.
    pub limit_axis_y_mm: f64,
    /// Limits within which an edge of the part differs from one of the masters (finish, edge
    /// shape), ± µm an edge. 0 ..= 100.
    pub limit_edge_um: f64,
    /// Limits of the scale's drift since the calibration, ± ppm. 0 ..= 1e5.
    pub limit_drift_ppm: f64,
    /// Finish of the masters; with the part's it sets `limit_edge_um` where that is not stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finish_of_masters: Option<Finish>,
    /// Finish of the part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finish_of_part: Option<Finish>,
    /// How far the part's limbs stand from the masters' line, in place of `limit_edge_um`, which is
    /// then 0 unless it is stated beside it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limb: Option<LimbDifference>,
    /// What of these nobody stated.
    #[serde(skip_serializing_if = "Unstated::is_empty")]
    pub unstated: Unstated,
    /// Where a machine carries the head in this frame; it is of the frame, not of the part, and in
    /// no file.
    #[serde(skip)]
    pub machine: Option<HeadPlace>,
}

impl Default for Conditions {
    /// Known exactly: 20 °C, in the masters' plane, edges like the masters'.
    fn default() -> Self {
        Self {
            temperature_c: REFERENCE_C,
            limit_temperature_k: 0.0,
            expansion_um_per_m_k: 11.5,
            limit_expansion_um_per_m_k: 0.0,
            axis_y_mm: 0.0,
            limit_axis_y_mm: 0.0,
            limit_edge_um: 0.0,
            limit_drift_ppm: 0.0,
            finish_of_masters: None,
            finish_of_part: None,
            limb: None,
            unstated: Unstated::default(),
            machine: None,
        }
    }
}

/// Conditions as a file gives them: keys left out stay as they were, or unstated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct GivenConditions {
    /// Temperature of the part, °C.
    pub temperature_c: Option<f64>,
    /// Limits of its error, ± K.
    pub limit_temperature_k: Option<f64>,
    /// Coefficient of expansion of the part, µm/(m·K).
    pub expansion_um_per_m_k: Option<f64>,
    /// Limits of its error, ± µm/(m·K).
    pub limit_expansion_um_per_m_k: Option<f64>,
    /// Distance of the axis from the plane of the masters, mm.
    pub axis_y_mm: Option<f64>,
    /// Limits of its error, ± mm.
    pub limit_axis_y_mm: Option<f64>,
    /// Limits within which an edge of the part differs from one of the masters, ± µm an edge.
    pub limit_edge_um: Option<f64>,
    /// Limits of the scale's drift since the calibration, ± ppm.
    pub limit_drift_ppm: Option<f64>,
    /// Finish of the masters.
    pub finish_of_masters: Option<Finish>,
    /// Finish of the part.
    pub finish_of_part: Option<Finish>,
    /// How far the part's limbs stand from the masters' line, as `optics limb` prints it.
    pub limb: Option<LimbDifference>,
    /// What a file written by `calibrate` says that nobody stated.
    pub unstated: Unstated,
}

impl From<GivenConditions> for Conditions {
    fn from(given: GivenConditions) -> Self {
        let written = given.unstated;
        let mut conditions = given.over(&Self::unstated());
        conditions.unstated = conditions.unstated.or(written);
        conditions
    }
}

impl GivenConditions {
    /// These conditions, with `known` where they give nothing. A temperature that is stated without
    /// limits is a reading of an unstated thermometer, unless `known` states its limits.
    #[must_use]
    pub(crate) fn over(&self, known: &Conditions) -> Conditions {
        let mut c = Conditions {
            temperature_c: self.temperature_c.unwrap_or(known.temperature_c),
            limit_temperature_k: self.limit_temperature_k.unwrap_or(known.limit_temperature_k),
            expansion_um_per_m_k: self.expansion_um_per_m_k.unwrap_or(known.expansion_um_per_m_k),
            limit_expansion_um_per_m_k: self
                .limit_expansion_um_per_m_k
                .unwrap_or(known.limit_expansion_um_per_m_k),
            axis_y_mm: self.axis_y_mm.unwrap_or(known.axis_y_mm),
            limit_axis_y_mm: self.limit_axis_y_mm.unwrap_or(known.limit_axis_y_mm),
            limit_edge_um: self.limit_edge_um.unwrap_or(known.limit_edge_um),
            limit_drift_ppm: self.limit_drift_ppm.unwrap_or(known.limit_drift_ppm),
            finish_of_masters: self.finish_of_masters.or(known.finish_of_masters),
            finish_of_part: self.finish_of_part.or(known.finish_of_part),
            limb: self.limb.or(known.limb),
            unstated: known.unstated,
            machine: known.machine,
        };
        if self.temperature_c.is_some() && known.unstated.temperature {
            c.limit_temperature_k = UnstatedLimits::get().reading_k;
        }
        if let Some(limit) = self.limit_temperature_k {
            c.limit_temperature_k = limit;
            c.unstated.temperature = false;
        }
        c.unstated.expansion &= self.limit_expansion_um_per_m_k.is_none();
        c.unstated.edge &= self.limit_edge_um.is_none();
        let names_finish = self.finish_of_masters.is_some() || self.finish_of_part.is_some();
        if let (None, true, Some(masters), Some(part)) =
            (self.limit_edge_um, names_finish || c.unstated.edge, c.finish_of_masters, c.finish_of_part)
        {
            c.limit_edge_um = masters.limit_um(part);
            c.unstated.edge = false;
        }
        if self.limb.is_some() {
            // Its rows take the place of one limit for all.
            c.limit_edge_um = self.limit_edge_um.unwrap_or(0.0);
            c.unstated.edge = false;
        }
        c
    }
}

impl Conditions {
    /// Nothing stated: wide limits of temperature, expansion and edges.
    pub fn unstated() -> Self {
        let unstated_limits = UnstatedLimits::get();
        Self {
            limit_temperature_k: unstated_limits.temperature_k,
            limit_expansion_um_per_m_k: unstated_limits.expansion_um_per_m_k,
            limit_edge_um: unstated_limits.edge_um,
            unstated: Unstated { temperature: true, expansion: true, edge: true },
            ..Self::default()
        }
    }

    /// Unstated conditions taken as exact: for frames that were rendered, whose temperature and
    /// finish are known.
    #[must_use]
    pub(crate) fn known(&self) -> Self {
        let keep = |limit: f64, unstated: bool| if unstated { 0.0 } else { limit };
        let Unstated { temperature, expansion, edge } = self.unstated;
        Self {
            limit_temperature_k: keep(self.limit_temperature_k, temperature),
            limit_expansion_um_per_m_k: keep(self.limit_expansion_um_per_m_k, expansion),
            limit_edge_um: keep(self.limit_edge_um, edge),
            unstated: Unstated::default(),
            ..*self
        }
    }

    /// At another temperature, as it is read.
    #[must_use]
    pub fn at(&self, temperature_c: f64) -> Self {
        GivenConditions { temperature_c: Some(temperature_c), ..GivenConditions::default() }.over(self)
    }
}

impl Conditions {
    /// Checks every range.
    ///
    /// # Errors
    /// Names the key.
    pub fn validate(&self) -> Result<(), SettingError> {
        let at = |key: &str, value, low, high, right| {
            within(&format!("conditions.{key}"), value, low, high, right)
        };
        at("temperature_c", self.temperature_c, -50.0, 400.0, "-50 to 400 °C")?;
        at("limit_temperature_k", self.limit_temperature_k, 0.0, 100.0, "0 to 100 K")?;
        at("expansion_um_per_m_k", self.expansion_um_per_m_k, 0.0, 100.0, "0 to 100 µm/(m K); steel 11.5")?;
        at("limit_expansion_um_per_m_k", self.limit_expansion_um_per_m_k, 0.0, 50.0, "0 to 50 µm/(m K)")?;
        at("axis_y_mm", self.axis_y_mm, -1e3, 1e3, "a distance in mm")?;
        at("limit_axis_y_mm", self.limit_axis_y_mm, 0.0, 100.0, "0 to 100 mm")?;
        at("limit_edge_um", self.limit_edge_um, 0.0, 100.0, "0 to 100 µm")?;
        at("limit_drift_ppm", self.limit_drift_ppm, 0.0, 1e5, "0 to 100 000 ppm")?;
        self.limb.map_or(Ok(()), |limb| limb.validate())
    }

    /// Distance of the axis from the plane of the masters in this frame, towards the camera, mm: as
    /// stated, and by what a machine does to the head.
    pub(crate) fn axis_in_frame_mm(&self) -> f64 {
        self.axis_y_mm + self.machine.map_or(0.0, |place| place.axis_y_mm)
    }

    /// D₂₀/D_T.
    pub fn to_reference(&self) -> f64 {
        1.0 / (1.0 + 1e-6 * self.expansion_um_per_m_k * (self.temperature_c - REFERENCE_C))
    }

    /// The part's diameter at its temperature, mm, from what the masters' calibration gives for its
    /// shadow: without the shifts of its limbs.
    pub(crate) fn part_mm(&self, calibrated_mm: f64) -> f64 {
        // Telecentricity moves limits only.
        let shift_um: f64 = self.limb_rows(calibrated_mm, 0.0).iter().flatten().map(|row| row.shift_um).sum();
        calibrated_mm - 2e-3 * shift_um
    }

    /// Rows of the part's limbs before a lens of the telecentricity `t_per_mm`, where they are
    /// stated.
    pub(crate) fn limb_rows(&self, diameter_mm: f64, t_per_mm: f64) -> Option<[LimbRow; 6]> {
        let place_mm = (self.axis_in_frame_mm(), self.limit_axis_y_mm);
        self.limb.map(|limb| limb.rows(diameter_mm, place_mm, t_per_mm))
    }

    /// Standard uncertainty by what is not known of the part's limbs, mm.
    pub(crate) fn u_limb_mm(&self, diameter_mm: f64, t_per_mm: f64) -> f64 {
        let rows = self.limb_rows(diameter_mm, t_per_mm);
        rows.iter().flatten().map(|row| row.u_mm().powi(2)).sum::<f64>().sqrt()
    }

    /// Standard uncertainty of D₂₀ by the part's temperature, mm. Both factors of α(T − 20) are
    /// uncertain: near 20 °C the product of their errors counts too (GUM 5.1.2, note).
    pub(crate) fn u_temperature_mm(&self, diameter_mm: f64) -> f64 {
        let u = self.limit_temperature_k / 3.0_f64.sqrt();
        let product = 1e-6 * self.limit_expansion_um_per_m_k / 3.0_f64.sqrt() * u;
        diameter_mm * (1e-6 * self.expansion_um_per_m_k * u).hypot(product)
    }

    /// Standard uncertainty of D₂₀ by the part's coefficient of expansion, mm.
    pub(crate) fn u_expansion_mm(&self, diameter_mm: f64) -> f64 {
        diameter_mm * 1e-6 * self.limit_expansion_um_per_m_k / 3.0_f64.sqrt()
            * (self.temperature_c - REFERENCE_C).abs()
    }

    /// Standard uncertainty by the axis' place before the camera, mm: t·y with t known to `u_t`,
    /// 1/mm. Where limbs are stated, t itself is part of their row of the depth, which the same y
    /// enters, and what is not known of t remains.
    pub(crate) fn u_focus_mm(&self, diameter_mm: f64, t_per_mm: f64, u_t_per_mm: f64) -> f64 {
        let t_per_mm = if self.limb.is_some() { 0.0 } else { t_per_mm };
        diameter_mm * t_per_mm.hypot(u_t_per_mm) * self.limit_axis_y_mm / 3.0_f64.sqrt()
    }

    /// Standard uncertainty by where a machine carries the head, mm: t·û_y with t known to `u_t`,
    /// 1/mm. The square of the sum of all errors of the product (GUM 5.1.2, note).
    pub(crate) fn u_machine_mm(&self, diameter_mm: f64, t_per_mm: f64, u_t_per_mm: f64) -> f64 {
        self.machine.map_or(0.0, |place| diameter_mm * t_per_mm.hypot(u_t_per_mm) * place.u_axis_y_mm)
    }

    /// Standard uncertainty by edges unlike the masters', mm of diameter: both edges are of one
    /// finish.
    pub(crate) fn u_edges_mm(&self) -> f64 {
        2e-3 * self.limit_edge_um / 3.0_f64.sqrt()
    }

    /// Standard uncertainty by the scale's drift, mm.
    pub(crate) fn u_drift_mm(&self, diameter_mm: f64) -> f64 {
        diameter_mm * 1e-6 * self.limit_drift_ppm / 3.0_f64.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warm_part_is_smaller_at_20_degrees() {
        let warm = Conditions { temperature_c: 30.0, ..Conditions::default() };
        let at_20 = 25.002_875 * warm.to_reference();
        assert!((at_20 - 25.0).abs() < 1e-9, "{at_20}");
        let uncertain = Conditions { limit_temperature_k: 3.0_f64.sqrt(), ..warm };
        // 1 K of standard uncertainty: 25 mm x 11.5 ppm.
        assert!((uncertain.u_temperature_mm(25.0) - 25.0 * 11.5e-6).abs() < 1e-12);
        let expansion = Conditions { limit_expansion_um_per_m_k: 3.0_f64.sqrt(), ..warm };
        assert!((expansion.u_expansion_mm(25.0) - 25.0 * 1e-5).abs() < 1e-12);
    }

    /// Nothing stated is ± 1.5 µm an edge and 20 ± 5 °C; what is stated takes its place, key by
    /// key.
    #[test]
    fn what_is_not_stated_has_wide_limits() {
        let read = |text: &str| toml::from_str::<Conditions>(text).unwrap();
        let none = read("");
        assert_eq!(none, Conditions::unstated());
        assert!((1e3 * none.u_edges_mm() - 3.0 / 3.0_f64.sqrt()).abs() < 1e-12);
        // 25 mm: hypot(11.5 · 5/√3, 1/√3 · 5/√3) ppm.
        let ppm = (11.5 * 5.0 / 3.0_f64.sqrt()).hypot(5.0 / 3.0);
        assert!((none.u_temperature_mm(25.0) - 25e-6 * ppm).abs() < 1e-12);
        let stated = read("limit_temperature_k = 0.5\nlimit_edge_um = 0.0\nlimit_expansion_um_per_m_k = 0.0");
        assert!(stated.unstated.is_empty() && stated.u_edges_mm() == 0.0);
        let reading = read("temperature_c = 24.0");
        assert!(reading.unstated.temperature && reading.limit_temperature_k == 1.0);
        assert_eq!(stated.at(24.0).limit_temperature_k, 0.5);
        let rendered = none.known();
        assert_eq!(rendered, Conditions::default());
        assert_eq!(stated.known(), stated);
    }

    #[test]
    fn a_pair_of_finishes_sets_the_edges_limit() {
        let unstated_limits = UnstatedLimits::get();
        let read = |text: &str| toml::from_str::<Conditions>(text).unwrap();
        let pair = |m: &str, p: &str| read(&format!("finish_of_masters = \"{m}\"\nfinish_of_part = \"{p}\""));
        let lapped = pair("lapped", "lapped");
        assert!(!lapped.unstated.edge && lapped.limit_edge_um < 0.01);
        let ground = pair("lapped", "ground");
        assert!((0.3..0.45).contains(&ground.limit_edge_um), "{}", ground.limit_edge_um);
        assert_eq!(read("finish_of_part = \"ground\"").limit_edge_um, unstated_limits.edge_um);
        assert_eq!(
            read("limit_edge_um = 0.2\nfinish_of_masters = \"lapped\"\nfinish_of_part = \"turned\"")
                .limit_edge_um,
            0.2
        );
        // The second of the pair may come later, from the command line's file.
        let part = GivenConditions { finish_of_part: Some(Finish::Ground), ..GivenConditions::default() };
        let masters = read("finish_of_masters = \"lapped\"");
        assert_eq!(part.over(&masters).limit_edge_um, ground.limit_edge_um);
        assert!(toml::from_str::<Conditions>("finish_of_part = \"shiny\"").is_err());
    }

    /// What `calibrate` writes reads back as it was, stated or not; files from before state all.
    #[test]
    fn a_file_keeps_what_was_stated() {
        for text in ["", "temperature_c = 22.0", "limit_edge_um = 0.1", "limit_temperature_k = 0.5"] {
            let conditions: Conditions = toml::from_str(text).unwrap();
            let json = serde_json::to_string(&conditions).unwrap();
            assert_eq!(serde_json::from_str::<Conditions>(&json).unwrap(), conditions, "{json}");
        }
        let before = r#"{"temperature_c":20.0,"limit_temperature_k":0.0,"expansion_um_per_m_k":11.5,
            "limit_expansion_um_per_m_k":0.0,"axis_y_mm":0.0,"limit_axis_y_mm":0.0,"limit_edge_um":0.0,"limit_drift_ppm":0.0}"#;
        assert_eq!(serde_json::from_str::<Conditions>(before).unwrap(), Conditions::default());
    }

    #[test]
    fn a_wrong_condition_is_named() {
        let wrong = Conditions { temperature_c: f64::NAN, ..Conditions::default() };
        assert_eq!(wrong.validate().unwrap_err().key, "conditions.temperature_c");
        assert!(toml::from_str::<Conditions>("temperature = 20.0").is_err());
    }
}
