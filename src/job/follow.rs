//! Where the carriage stands and how the spindle is turned when the gauge follows the tool.

use std::f64::consts::PI;

use super::loop_job::LoopJob;
use super::scan::ScanWhen;
use crate::gauge::calibration::Conditions;
use crate::plan::{FeedDirection, FollowFrame, FollowPlan, ScanPlan};
use crate::setting::SettingError;

/// Clearance between the tool and the field's edge, mm: chip and insert extend beyond the tip.
const CLEAR_OF_TOOL_MM: f64 = 2.0;

/// Limits of a tabulated expansion, µm/(m·K): 11.5 ± 1 of steels in gauging practice (ISO 1).
const LIMIT_EXPANSION_UM_PER_M_K: f64 = 1.0;

/// Most angles of a burst that are reordered: the time of the search grows with the third power.
const MOST_ORDERED: usize = 64;

/// The angles of a burst over half a turn in the order they are taken, each with the turns since
/// the burst's integer turn; at least `period` turns lie between two frames.
fn burst_turns(angles: usize, period: f64) -> Vec<(usize, f64)> {
    let part = 1.0 / (2.0 * angles.max(1) as f64);
    let mut turned = 0.0;
    let mut before = 0.0;
    order_of_angles(angles)
        .into_iter()
        .enumerate()
        .map(|(k, i)| {
            let at = i as f64 * part;
            let apart = (at - before).rem_euclid(1.0);
            turned += if k == 0 { at } else { apart + (period - apart).max(0.0).ceil() };
            before = at;
            (i, turned)
        })
        .collect()
}

/// An order of angles in which the shaft's bending, which drifts as the tool advances, does not
/// resemble a bow that turns with the part: the place of an angle in the order has almost no first
/// harmonic over the angles. In ascending order, a drift over half a turn would look like cos φ.
/// Angles are swapped while a swap reduces the harmonic.
fn order_of_angles(angles: usize) -> Vec<usize> {
    // place[i]: when angle i is taken
    let mut place: Vec<f64> = (0..angles).map(|i| i as f64).collect();
    let phase = |i: usize| PI * i as f64 / angles as f64;
    let harmonic = |place: &[f64]| {
        let middle = 0.5 * (angles as f64 - 1.0);
        let sum = place.iter().enumerate().fold((0.0, 0.0), |sum, (i, p)| {
            (sum.0 + (p - middle) * phase(i).cos(), sum.1 + (p - middle) * phase(i).sin())
        });
        sum.0.hypot(sum.1)
    };
    let pairs = || (0..angles).flat_map(|i| (0..i).map(move |j| (i, j)));
    while (3..=MOST_ORDERED).contains(&angles) {
        let now = harmonic(&place);
        let after = |(i, j): (usize, usize)| {
            let mut swapped = place.clone();
            swapped.swap(i, j);
            harmonic(&swapped)
        };
        let best = pairs().map(|pair| (after(pair), pair)).min_by(|a, b| a.0.total_cmp(&b.0));
        match best.filter(|b| b.0 < now - 1e-9) {
            Some((_, (i, j))) => place.swap(i, j),
            None => break,
        }
    }
    let mut order: Vec<usize> = (0..angles).collect();
    order.sort_by(|a, b| place[*a].total_cmp(&place[*b]));
    order
}

impl LoopJob {
    /// Speed of the spindle in pass `pass` (from 1), rev/min: the cutting speed at the pass's
    /// nominal diameter.
    pub(crate) fn spindle_rpm(&self, pass: u32) -> f64 {
        1e3 * self.cutting.speed_m_per_min / (PI * self.part.target_mm(pass))
    }

    /// Frames of pass `pass` while it is cut: at every field of the scan a burst over the angles of
    /// half a turn, over as many whole turns as the camera needs; fields that the tool's end keeps
    /// from the gauge are scanned after it.
    pub(crate) fn follow_plan(&self, pass: u32) -> FollowPlan {
        let towards_chuck = self.feed_direction == FeedDirection::TowardsChuck;
        let (length, behind) = (self.part.length_mm, self.scan.behind_tool_mm);
        let way = if towards_chuck { -1.0 } else { 1.0 };
        let rpm = self.spindle_rpm(pass);
        let (angles, feed) = (self.scan.angles, self.cutting.feed_mm_per_rev);
        let period = self.field.frame_period_ms * 1e-3 * rpm / 60.0;
        let burst = burst_turns(angles, period);
        let start_mm = if towards_chuck { length } else { 0.0 };
        let ScanPlan { mut field_z_mm, angle_deg } = self.scan_plan();
        if towards_chuck {
            field_z_mm.reverse();
        }
        let (mut frames, mut rest) = (Vec::new(), Vec::new());
        for field in field_z_mm {
            let first = (way * (field + way * behind - start_mm) / feed).ceil().max(0.0);
            let tool_at = |turns: f64| start_mm + way * feed * turns;
            let last = tool_at(first + burst.last().map_or(0.0, |b| b.1));
            if !(0.0..=length).contains(&last) {
                rest.push(field);
                continue;
            }
            frames.extend(burst.iter().map(|&(i, turned)| {
                let turns = first + turned;
                let tool_z_mm = tool_at(turns);
                FollowFrame {
                    turns,
                    tool_z_mm,
                    field_z_mm: tool_z_mm - way * behind,
                    angle_deg: angle_deg[i],
                }
            }));
        }
        rest.sort_by(f64::total_cmp);
        FollowPlan {
            spindle_rpm: rpm,
            carriage_mm_s: way * feed * rpm / 60.0,
            frames,
            burst: angles,
            rest: ScanPlan { field_z_mm: rest, angle_deg },
        }
    }

    /// Conditions of the part while it is scanned: its temperature, and its material's expansion
    /// where that matters.
    pub(crate) fn part_conditions(&self) -> Conditions {
        let (rise, limit) = (self.scan.part_rise_k, self.scan.limit_part_rise_k);
        let exact = Conditions { limb: self.scan.limb, ..Conditions::default() };
        if rise == 0.0 && limit == 0.0 {
            return exact;
        }
        Conditions {
            temperature_c: exact.temperature_c + rise,
            limit_temperature_k: limit,
            expansion_um_per_m_k: self.expansion_um_per_m_k,
            limit_expansion_um_per_m_k: LIMIT_EXPANSION_UM_PER_M_K,
            ..exact
        }
    }

    /// Whether a gauge can follow the tool.
    pub(super) fn check_follow(&self) -> Result<(), SettingError> {
        let (rise, limit) = (self.scan.part_rise_k, self.scan.limit_part_rise_k);
        if let Some(limb) = self.scan.limb {
            let of_scan = |key: &str| key.replacen("conditions.", "scan.", 1);
            limb.validate().map_err(|e| SettingError { key: of_scan(&e.key), ..e })?;
        }
        if !(-70.0..=380.0).contains(&rise) {
            return Err(SettingError::at(
                "scan.part_rise_k",
                format!("{rise} K must lie between -70 and 380"),
            ));
        }
        if !(0.0..=100.0).contains(&limit) {
            return Err(SettingError::at(
                "scan.limit_part_rise_k",
                format!("{limit} K must lie between 0 and 100"),
            ));
        }
        self.scan.encoder.map_or(Ok(()), |encoder| encoder.validate())?;
        if self.scan.when != ScanWhen::DuringCut {
            let why =
                "nothing is read while the pass is cut: set scan.when = \"during_cut\", or leave it out";
            let idle = self.control.within_pass.is_some();
            return if idle { Err(SettingError::at("control.within_pass", why)) } else { Ok(()) };
        }
        if self.probe.is_some() {
            return Err(SettingError::at(
                "scan.when",
                "a touch probe reads a part that stands still: leave out [probe], or scan after_pass",
            ));
        }
        let least = 0.5 * self.field.length_mm() + CLEAR_OF_TOOL_MM;
        let behind = self.scan.behind_tool_mm;
        // NaN is refused as well.
        if !(behind >= least) {
            let why = format!(
                "{behind} mm: the tool would stand in the field and hide the edge there; at least {least:.1} mm (half the field, and \
                 {CLEAR_OF_TOOL_MM} mm that insert and chip stand out from the tip)"
            );
            return Err(SettingError::at("scan.behind_tool_mm", why));
        }
        if !(behind < self.part.length_mm) {
            let why = format!(
                "{behind} mm: the field must lie on the part, below its length of {} mm",
                self.part.length_mm
            );
            return Err(SettingError::at("scan.behind_tool_mm", why));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drift_during_a_burst_looks_like_nothing_that_turns() {
        for (angles, most) in [(4, 0.4), (6, 0.15), (8, 0.08), (16, 0.01)] {
            let order = order_of_angles(angles);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..angles).collect::<Vec<_>>());
            let share = |order: &[usize]| {
                let sum = order.iter().enumerate().fold((0.0, 0.0), |sum, (k, i)| {
                    let phase = PI * *i as f64 / angles as f64;
                    let place = k as f64 - 0.5 * (angles as f64 - 1.0);
                    (sum.0 + place * phase.cos(), sum.1 + place * phase.sin())
                });
                f64::hypot(sum.0, sum.1)
            };
            let plain = share(&(0..angles).collect::<Vec<_>>());
            assert!(share(&order) < most * plain, "{angles}: {order:?} {} of {plain}", share(&order));
        }
        assert_eq!(order_of_angles(1), [0]);
        assert_eq!(order_of_angles(2), [0, 1]);
    }

    #[test]
    fn a_burst_leaves_the_camera_its_time_and_stands_at_its_angles() {
        for period in [0.0, 0.3, 1.54, 7.9] {
            let burst = burst_turns(8, period);
            assert!(burst.windows(2).all(|w| w[1].1 - w[0].1 >= period - 1e-12 && w[1].1 > w[0].1));
            for (i, turned) in burst {
                assert!((turned.rem_euclid(1.0) - i as f64 / 16.0).abs() < 1e-9);
            }
        }
    }
}
