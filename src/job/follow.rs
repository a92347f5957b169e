//! Where the carriage stands and how the spindle is turned when the gauge follows the tool.

use std::f64::consts::PI;

use super::Job;
use super::error::from_render;
use super::scan::ScanWhen;
use crate::gauge::calibration::Conditions;
use crate::plan::{FollowFrame, FollowPlan, ScanPlan};
use crate::process::FeedDirection;
use crate::render::motion::Motion;
use crate::setting::SettingError as JobError;

/// Room between the tool and the field's edge, mm: chip and insert stand out from the tip.
const CLEAR_OF_TOOL_MM: f64 = 2.0;

/// Limits of a tabulated expansion, µm/(m·K): 11.5 ± 1 of steels in gauging practice (ISO 1).
const LIMIT_EXPANSION_UM_PER_M_K: f64 = 1.0;

impl Job {
    /// Speed of the spindle in pass `pass` (from 1), rev/min: the cutting speed at the pass's nominal diameter.
    pub fn spindle_rpm(&self, pass: u32) -> f64 {
        1e3 * self.cutting.speed_m_per_min / (PI * self.part.target_mm(pass))
    }

    /// Frames of pass `pass` while it is cut: at every field of the scan a burst over half a turn or, where the camera is slower,
    /// over as many whole turns more as it needs; fields that the tool's end keeps from the gauge are scanned after it.
    pub fn follow_plan(&self, pass: u32) -> FollowPlan {
        let towards_chuck = self.process.pass.feed_direction == FeedDirection::TowardsChuck;
        let (length, behind) = (self.part.length_mm, self.scan.behind_tool_mm);
        let way = if towards_chuck { -1.0 } else { 1.0 };
        let rpm = self.spindle_rpm(pass);
        let (angles, feed) = (self.scan.angles, self.cutting.feed_mm_per_rev);
        let apart = 1.0 / (2.0 * angles as f64);
        let period = self.camera.frame_period_ms * 1e-3 * rpm / 60.0;
        let step = (period - apart).max(0.0).ceil() + apart;
        let start_mm = if towards_chuck { length } else { 0.0 };
        let ScanPlan { mut field_z_mm, angle_deg } = self.scan_plan();
        if towards_chuck {
            field_z_mm.reverse();
        }
        let (mut frames, mut rest) = (Vec::new(), Vec::new());
        for field in field_z_mm {
            let first = (way * (field + way * behind - start_mm) / feed).ceil().max(0.0);
            let tool_at = |turns: f64| start_mm + way * feed * turns;
            let last = tool_at(first + step * (angles - 1) as f64);
            if !(0.0..=length).contains(&last) {
                rest.push(field);
                continue;
            }
            frames.extend(angle_deg.iter().enumerate().map(|(i, &angle_deg)| {
                let turns = first + step * i as f64;
                let tool_z_mm = tool_at(turns);
                FollowFrame { turns, tool_z_mm, field_z_mm: tool_z_mm - way * behind, angle_deg }
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

    /// What moves while a pass is cut: spindle and carriage by the cutting data, the rest as `[motion]` has it.
    pub fn cutting_motion(&self, follow: &FollowPlan) -> Motion {
        Motion { spindle_rpm: follow.spindle_rpm, carriage_mm_s: follow.carriage_mm_s, ..self.motion.clone() }
    }

    /// What is known of the part while it is scanned: its temperature, and its material's expansion where that counts.
    pub fn part_conditions(&self) -> Conditions {
        let (rise, limit) = (self.scan.part_rise_k, self.scan.limit_part_rise_k);
        let exact = Conditions::default();
        let Some(material) = self.process.material.resolve().ok().filter(|_| rise != 0.0 || limit != 0.0)
        else {
            return exact;
        };
        Conditions {
            temperature_c: exact.temperature_c + rise,
            limit_temperature_k: limit,
            expansion_um_per_m_k: material.expansion_um_per_m_k,
            limit_expansion_um_per_m_k: LIMIT_EXPANSION_UM_PER_M_K,
            ..exact
        }
    }

    /// Whether a gauge can follow the tool.
    pub(super) fn check_follow(&self) -> Result<(), JobError> {
        let (rise, limit) = (self.scan.part_rise_k, self.scan.limit_part_rise_k);
        if !(-70.0..=380.0).contains(&rise) {
            return Err(JobError::at("scan.part_rise_k", format!("{rise} K must lie between -70 and 380")));
        }
        if !(0.0..=100.0).contains(&limit) {
            return Err(JobError::at(
                "scan.limit_part_rise_k",
                format!("{limit} K must lie between 0 and 100"),
            ));
        }
        if self.scan.when != ScanWhen::DuringCut {
            let why =
                "nothing is read while the pass is cut: set scan.when = \"during_cut\", or leave it out";
            let idle = self.control.within_pass.is_some();
            return if idle { Err(JobError::at("control.within_pass", why)) } else { Ok(()) };
        }
        if self.probe.is_some() {
            return Err(JobError::at(
                "scan.when",
                "a touch probe reads a part that stands still: leave out [probe], or scan after_pass",
            ));
        }
        let least = 0.5 * f64::from(self.camera.columns) * self.nominal_mm_per_px() + CLEAR_OF_TOOL_MM;
        let behind = self.scan.behind_tool_mm;
        if !(behind >= least && behind < self.part.length_mm) {
            let why = format!(
                "{behind} mm: the field must lie behind the tool and on the part; at least {least:.1} mm (half the field and \
                 {CLEAR_OF_TOOL_MM} mm), below the length of {} mm",
                self.part.length_mm
            );
            return Err(JobError::at("scan.behind_tool_mm", why));
        }
        // The last pass turns fastest.
        let follow = self.follow_plan(self.part.passes() as u32);
        self.cutting_motion(&follow).check(self.camera.exposure_us).map_err(from_render)
    }
}
