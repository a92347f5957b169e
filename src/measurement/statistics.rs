//! Statistics of the frames' mean diameters.

use serde::{Serialize, Serializer};

use super::by_key::by_key;
use crate::gauge::diameter::reading_scatter::ScatterTest;
use crate::gauge::diameter::reading_series::Capability;
use crate::gauge::diameter::running_series::RunningSeries;
use crate::gauge::stated::stated;
use crate::profile::Diameter;

/// Probability that the scatter of identical parts is taken for scatter of the process.
const SCATTER_RISK: f64 = 0.05;
/// Confidence of the intervals of Cp and Cpk.
const CONFIDENCE: f64 = 0.95;

/// Statistics of the frames' mean diameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Frames with a diameter.
    pub count: usize,
    /// Their mean with its uncertainty, mm.
    pub mean: Diameter,
    /// Their standard deviation, mm; `None` for a single frame.
    pub sd_mm: Option<f64>,
    /// Number of independent frames whose mean scatters as that of these.
    pub effective_count: f64,
    /// χ² of the means against their own random uncertainties.
    pub scatter: Option<ScatterTest>,
    /// Least mean diameter, mm.
    pub min_mm: f64,
    /// Greatest mean diameter, mm.
    pub max_mm: f64,
    /// Cp and Cpk, or why there are none; where there is a tolerance.
    pub capability: Option<Result<(Capability, Capability), String>>,
}

#[derive(Serialize)]
struct Keys<'a> {
    count: usize,
    mean_mm: f64,
    sd_mm: Option<f64>,
    u_mean_mm: f64,
    u_mean_random_mm: f64,
    u_mean_common_mm: f64,
    effective_count: f64,
    scatter: Option<ScatterTest>,
    min_mm: f64,
    max_mm: f64,
    range_mm: f64,
    #[serde(flatten)]
    capability: Option<CapabilityKeys<'a>>,
}

#[derive(Serialize)]
struct CapabilityKeys<'a> {
    cp: Option<Capability>,
    cpk: Option<Capability>,
    capability_none: Option<&'a str>,
}

impl Serialize for Statistics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let capability = self.capability.as_ref().map(|capability| match capability {
            Ok((cp, cpk)) => CapabilityKeys { cp: Some(*cp), cpk: Some(*cpk), capability_none: None },
            Err(why) => CapabilityKeys { cp: None, cpk: None, capability_none: Some(why) },
        });
        let keys = Keys {
            count: self.count,
            mean_mm: self.mean.d_mm,
            sd_mm: self.sd_mm,
            u_mean_mm: self.mean.u_mm(),
            u_mean_random_mm: self.mean.u_random_mm,
            u_mean_common_mm: self.mean.u_common_mm,
            effective_count: self.effective_count,
            scatter: self.scatter,
            min_mm: self.min_mm,
            max_mm: self.max_mm,
            range_mm: self.max_mm - self.min_mm,
            capability,
        };
        by_key(&keys, serializer)
    }
}

/// Mean diameters of the frames in their order.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameMeans {
    series: RunningSeries,
}

impl FrameMeans {
    pub(super) fn push(&mut self, mean: Diameter) {
        self.series.push(mean);
    }

    /// The statistics; `None` without a frame. `limits_mm` are those of a tolerance, `parts`
    /// whether every frame is another part.
    pub(super) fn statistics(&self, limits_mm: Option<(f64, f64)>, parts: bool) -> Option<Statistics> {
        let of = self.series.mean()?;
        let (min_mm, max_mm) = self.series.values().extremes()?;
        let count = self.series.values().count() as usize;
        Some(Statistics {
            count,
            mean: of.mean,
            // A single value has no scatter.
            sd_mm: (count > 1).then_some(of.sd_mm),
            effective_count: of.effective_number,
            scatter: self.series.scatter(),
            min_mm,
            max_mm,
            capability: limits_mm.map(|limits| self.capability(limits, parts)),
        })
    }

    /// Cp and Cpk of the batch with intervals of 95 %.
    ///
    /// # Errors
    /// Why there are none: a single part has no capability, nor has scatter of the gauge alone.
    fn capability(
        &self,
        (lower, upper): (f64, f64),
        parts: bool,
    ) -> Result<(Capability, Capability), String> {
        if !parts {
            return Err("one part has none; --parts takes every frame as another part".to_owned());
        }
        let s = self.series.values();
        s.exceeds_noise(self.series.noise_mm2(), SCATTER_RISK).map_err(|e| e.to_string())?;
        let both = s.cp(lower, upper, CONFIDENCE).and_then(|cp| Ok((cp, s.cpk(lower, upper, CONFIDENCE)?)));
        both.map_err(|e| e.to_string())
    }

    /// A warning where the frames scatter beyond their u.
    pub(super) fn word(&self) -> Option<String> {
        let test = self.series.scatter().filter(|test| test.beyond_u)?;
        let sd_um = 1e3 * self.series.mean()?.sd_mm;
        Some(format!(
            "the mean diameters of {} frames scatter by {} um (standard deviation), {:.1} times what their u explains (chi2 {:.4} at {} degrees of \
             freedom, limit {:.4} at a false alarm of {} %): form, motion, drift or dirt between the frames; u of their mean \
             is taken from the scatter",
            self.series.values().count(),
            stated(sd_um, sd_um)[0],
            test.ratio(),
            test.chi2,
            test.freedom,
            test.chi2_limit,
            100.0 * test.false_alarm_probability
        ))
    }
}
