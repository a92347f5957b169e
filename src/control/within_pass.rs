//! Control within a pass: the deviation that the gauge measures behind the tool is corrected at the
//! stations ahead of it.
//!
//! A station k behind the tool was cut with offset o_k and reads e_k = D_k - r. With the plan's
//! offset p_k it would have read δ_k = e_k + g·(o_k - p_k), g the plant gain: the deviation of this
//! pass from its plan, without the corrections already made. The distance of the gauge behind the
//! tool is thus no delay in a loop: the correction of the stations ahead, o = p + γ·δ/g, does not
//! act back on δ and is stable for any 0 < γ ≤ 1. It assumes that δ continues as over the newest
//! field (drift, wear, force; not the shape of the sag, which the plan already includes from the
//! pass before).

use super::settings::WithinPassSettings;
use crate::numerics::robust::central_median;
use crate::profile::DiameterProfile;

/// A pass in progress.
#[derive(Clone, Debug)]
pub(crate) struct WithinPass {
    settings: WithinPassSettings,
    plant_gain: f64,
    stations: Vec<StationOffset>,
}

/// The offset of a station in a pass.
#[derive(Clone, Copy, Debug)]
struct StationOffset {
    planned_mm: f64,
    /// In force when the station was or will be cut.
    applied_mm: f64,
    /// Whether the station was read.
    read: bool,
}

impl WithinPass {
    /// Begins a pass with the planned offsets.
    pub(crate) fn begin(settings: WithinPassSettings, plant_gain: f64, planned_mm: &[f64]) -> Self {
        let planned = |o: &f64| StationOffset { planned_mm: *o, applied_mm: *o, read: false };
        Self { settings, plant_gain, stations: planned_mm.iter().map(planned).collect() }
    }

    /// Offsets as they were applied, mm of diameter.
    pub(crate) fn applied_mm(&self) -> Vec<f64> {
        self.stations.iter().map(|s| s.applied_mm).collect()
    }

    /// Puts the offsets in force as the machine rounds them: stations that may still be changed are
    /// cut with these.
    pub(crate) fn put_in_force(
        &mut self,
        in_force_mm: &[f64],
        stations_z_mm: &[f64],
        ahead: impl Fn(f64) -> bool,
    ) {
        for (station, (in_force, z_mm)) in self.stations.iter_mut().zip(in_force_mm.iter().zip(stations_z_mm))
        {
            if !station.read && ahead(*z_mm) {
                station.applied_mm = *in_force;
            }
        }
    }

    /// Takes the stations read so far; `ahead` states which may still be changed. Returns new
    /// offsets where stations were newly read.
    pub(crate) fn decide(
        &mut self,
        nominal_mm: f64,
        measured: &DiameterProfile,
        ahead: impl Fn(f64) -> bool,
    ) -> Option<Vec<f64>> {
        let mut deviations = Vec::new();
        for (station, seen) in self.stations.iter_mut().zip(&measured.stations) {
            let Some(d) = seen.reading.value().filter(|_| !station.read) else { continue };
            station.read = true;
            let changed = station.applied_mm - station.planned_mm;
            deviations.push(d.d_mm - nominal_mm + self.plant_gain * changed);
        }
        let middle = central_median(&mut deviations)?;
        let limit = self.settings.limit_mm;
        let shift = (self.settings.gain * middle / self.plant_gain).clamp(-limit, limit);
        for (station, seen) in self.stations.iter_mut().zip(&measured.stations) {
            if !station.read && ahead(seen.z_mm) {
                station.applied_mm = station.planned_mm + shift;
            }
        }
        Some(self.applied_mm())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Diameter, Reading, Reason, Station};

    /// Ten stations cut from the far end, each of which comes out `bias(k)` too large, read two
    /// stations late: the correction removes a constant deviation at once and does not overshoot
    /// while its own effect is on the way.
    fn cut(gain: f64, bias: impl Fn(usize) -> f64) -> Vec<f64> {
        let planned = vec![0.003; 10];
        let mut within = WithinPass::begin(WithinPassSettings { gain, limit_mm: 0.1 }, 1.0, &planned);
        let mut errors = vec![f64::NAN; 10];
        for tool in (0..10).rev() {
            errors[tool] = bias(tool) + planned[tool] - within.applied_mm()[tool];
            let stations = (0..10)
                .map(|k| Station {
                    z_mm: k as f64,
                    reading: if k >= tool + 2 {
                        Reading::Value(Diameter {
                            d_mm: 25.0 + errors[k],
                            u_random_mm: 1e-4,
                            u_common_mm: 0.0,
                        })
                    } else {
                        Reading::Gap(Reason::NotScanned)
                    },
                    freedom: None,
                })
                .collect();
            within.decide(25.0, &DiameterProfile { pass: 1, stations }, |z| z < tool as f64);
        }
        errors
    }

    #[test]
    fn a_constant_deviation_is_taken_off_after_the_delay_and_stays_off() {
        let errors = cut(1.0, |_| 0.02);
        assert!(errors[7..].iter().all(|e| (e - 0.02).abs() < 1e-12), "{errors:?}");
        assert!(errors[..7].iter().all(|e| e.abs() < 1e-12), "{errors:?}");
        let half = cut(0.5, |_| 0.02);
        assert!(half[..7].iter().all(|e| (e - 0.01).abs() < 1e-12), "{half:?}");
    }

    #[test]
    fn a_drift_is_followed_by_the_delay() {
        let errors = cut(1.0, |k| 0.001 * (9 - k) as f64);
        // Three stations late (two of distance, and the one being cut): three steps of the drift
        // are left.
        assert!(errors[..7].iter().all(|e| (e - 0.003).abs() < 1e-12), "{errors:?}");
    }
}
