//! What separates the cut from the command: wear, drift, scatter, machine errors, heat, the blank's
//! own form.
//!
//! Every random quantity is drawn from (seed, purpose, pass) alone, so that controllers compared
//! with one seed are subject to the same disturbances.

use rand_distr::{Distribution, StandardNormal, Uniform};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Range;
use super::random::{Stream, generator, smoothing_kernel};
use crate::numerics::neighbours::{linear_between, neighbours};
use crate::setting::SettingError;
use crate::shaft::Lobe;

/// A point of the guideway's straightness error; linear between points, constant beyond.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GuidewayPoint {
    /// Machine z, mm.
    pub z_mm: f64,
    /// Displacement of the tool away from the workpiece, µm (radial).
    pub away_um: f64,
}

impl GuidewayPoint {
    /// Displacement at `z_mm` away from the workpiece, mm (radial); zero without points.
    pub(crate) fn away_mm(points: &[Self], z_mm: f64) -> f64 {
        let pair = neighbours(points, |p| p.z_mm < z_mm);
        linear_between(pair, z_mm, |p| (p.z_mm, p.away_um)).unwrap_or(0.0) * 1e-3
    }
}

/// `[process.disturbance]`; everything is zero by default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DisturbanceSettings {
    /// Recession of the edge over one pass, µm (radial); grows along the cut and stays for the next
    /// pass.
    pub wear_um_per_pass: f64,
    /// Growth of the diameter from pass to pass by thermal drift of the machine, µm of diameter.
    pub drift_um_per_pass: f64,
    /// Growth of the diameter while the machine warms up, µm of diameter, approached exponentially
    /// from a cold start.
    pub warm_up_um: f64,
    /// Passes after which 1 − 1/e of the warming is reached.
    pub warm_up_passes: f64,
    /// Standard deviation of the tool's position from pass to pass, µm of diameter.
    pub repeatability_um: f64,
    /// Standard deviation of the blank's diameter along z, µm.
    pub stock_form_um: f64,
    /// Correlation length of the blank's form, mm.
    pub stock_form_correlation_mm: f64,
    /// Half width of the uniform scatter of the force from blank to blank, relative.
    pub force_spread: f64,
    /// Guideway error.
    pub guideway: Vec<GuidewayPoint>,
    /// Lobes that the spindle's radial error motion leaves.
    pub spindle_lobes: Vec<Lobe>,
    /// Temperature of the workpiece above 20 °C where the cut starts, K.
    pub heat_start_k: f64,
    /// Temperature of the workpiece above 20 °C where the cut ends, K.
    pub heat_end_k: f64,
    /// Temperature of the workpiece above 20 °C while it is scanned after the pass, K: what the
    /// gauge sees has grown.
    pub heat_scan_k: f64,
}

impl Default for DisturbanceSettings {
    fn default() -> Self {
        Self {
            wear_um_per_pass: 0.0,
            drift_um_per_pass: 0.0,
            warm_up_um: 0.0,
            warm_up_passes: 8.0,
            repeatability_um: 0.0,
            stock_form_um: 0.0,
            stock_form_correlation_mm: 100.0,
            force_spread: 0.0,
            guideway: Vec::new(),
            spindle_lobes: Vec::new(),
            heat_start_k: 0.0,
            heat_end_k: 0.0,
            heat_scan_k: 0.0,
        }
    }
}

impl DisturbanceSettings {
    pub(super) fn validate(&self) -> Result<(), SettingError> {
        let key = |name: &str| format!("disturbance.{name}");
        Range::NOT_NEGATIVE.check(&key("wear_um_per_pass"), self.wear_um_per_pass)?;
        Range::between(-1e3, 1e3).check(&key("drift_um_per_pass"), self.drift_um_per_pass)?;
        Range::between(-1e3, 1e3).check(&key("warm_up_um"), self.warm_up_um)?;
        Range::POSITIVE.check(&key("warm_up_passes"), self.warm_up_passes)?;
        Range::NOT_NEGATIVE.check(&key("repeatability_um"), self.repeatability_um)?;
        Range::NOT_NEGATIVE.check(&key("stock_form_um"), self.stock_form_um)?;
        Range::between(1.0, 2000.0)
            .check(&key("stock_form_correlation_mm"), self.stock_form_correlation_mm)?;
        Range::between(0.0, 0.9).check(&key("force_spread"), self.force_spread)?;
        Range::between(-100.0, 500.0).check(&key("heat_start_k"), self.heat_start_k)?;
        Range::between(-100.0, 500.0).check(&key("heat_end_k"), self.heat_end_k)?;
        Range::between(-100.0, 500.0).check(&key("heat_scan_k"), self.heat_scan_k)?;
        for (index, pair) in self.guideway.windows(2).enumerate() {
            let name = format!("disturbance.guideway[{}].z_mm", index + 1);
            Range::between(pair[0].z_mm, f64::MAX).check(&name, pair[1].z_mm)?;
        }
        for (index, lobe) in self.spindle_lobes.iter().enumerate() {
            let name = format!("disturbance.spindle_lobes[{index}].order_upr");
            Range::between(2.0, 1e4).check(&name, f64::from(lobe.order_upr))?;
        }
        Ok(())
    }

    /// Displacement of the tool away from the workpiece by the guideway, mm (radial).
    pub(super) fn guideway_mm(&self, z_mm: f64) -> f64 {
        GuidewayPoint::away_mm(&self.guideway, z_mm)
    }

    /// Deviation of the blank's diameter at `nodes` nodes `step_mm` apart, mm.
    pub(super) fn stock_form_mm(&self, seed: u64, nodes: usize, step_mm: f64) -> Vec<f64> {
        if self.stock_form_um == 0.0 {
            return vec![0.0; nodes];
        }
        let kernel = smoothing_kernel(0.5 * self.stock_form_correlation_mm / step_mm);
        let mut random = generator(seed, Stream::StockForm, 0);
        let noise: Vec<f64> = (0..nodes + kernel.len()).map(|_| StandardNormal.sample(&mut random)).collect();
        let smooth = |window: &[f64]| -> f64 { window.iter().zip(&kernel).map(|(n, w)| n * w).sum() };
        noise.windows(kernel.len()).take(nodes).map(|w| self.stock_form_um * 1e-3 * smooth(w)).collect()
    }

    /// Factor on the force for this blank.
    pub(super) fn force_factor(&self, seed: u64) -> f64 {
        let half = self.force_spread;
        let mut random = generator(seed, Stream::Force, 0);
        Uniform::new_inclusive(1.0 - half, 1.0 + half).map_or(1.0, |range| range.sample(&mut random))
    }

    /// Displacement common to a whole pass, mm of diameter; `cuts` counts the passes since the
    /// machine was cold.
    pub(super) fn common_mm(&self, seed: u64, pass: u32, cuts: u32) -> f64 {
        let mut random = generator(seed, Stream::Repeatability, pass);
        let scatter: f64 = StandardNormal.sample(&mut random);
        let warmed = -(-f64::from(cuts) / self.warm_up_passes).exp_m1();
        let grown = self.drift_um_per_pass * f64::from(cuts) + self.warm_up_um * warmed;
        1e-3 * (grown + self.repeatability_um * scatter)
    }
}
