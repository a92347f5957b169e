//! Diameters of a part that turns off its axis, before a lens that is not quite telecentric.
//!
//! ```text
//! D = s·w·(1 + t·y) + o        t  telecentricity error, 1/mm;  y  distance from the masters'
//! plane, towards the camera, mm
//! ```
//!
//! What turns with the part (eccentricity, bow) carries a section towards the camera and away from
//! it, y = a·sin φ + b·cos φ, with (a, b) measured in the image plane from spindle angles 90° apart
//! ([`AxisLine`]). Over a whole turn it averages out of the mean diameter; over half a turn 2/π of
//! it stays, D·t·e·2/π: 40 nm at Ø 25, t = 2.7e-5/mm (.03° at the corner of a field of 38 mm) and
//! an eccentricity e of .1 mm. Either way it looks like a lobe. Where the calibration determines t,
//! it is taken off; a t of which only limits are known is in the uncertainty. What stands still
//! towards the camera is not seen: it belongs to the conditions' `axis_y_mm` and its limits.

use super::axis_line::{AxisLine, AxisStation, TurningOffset};
use super::column_diameters::ColumnDiameters;
use crate::frame::FrameMeta;
use crate::gauge::calibration::gauge_calibration::Calibration;
use crate::profile::{Diameter, DiameterProfile, Reading};

/// The telecentricity error of a lens, 1/mm: positive where what comes closer looks smaller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Telecentricity {
    /// Its estimate.
    pub per_mm: f64,
    /// Its standard uncertainty.
    pub u_per_mm: f64,
}

impl Telecentricity {
    /// As an optical setup was calibrated; `None` of a calibration by masters in one plane, which
    /// does not show it.
    pub(crate) fn of(calibration: &Calibration) -> Option<Self> {
        let setup = calibration.setup.as_ref()?;
        Some(Self { per_mm: setup.lens.telecentricity_per_mm, u_per_mm: setup.u_telecentricity_per_mm() })
    }

    /// Known by its limits alone: a rectangular distribution about zero.
    pub(crate) fn within(limit_per_mm: f64) -> Self {
        Self { per_mm: 0.0, u_per_mm: limit_per_mm.abs() / 3.0_f64.sqrt() }
    }

    /// A diameter with y taken off, where the mean over the angles is at `mean_mm` and y is known
    /// to `u_mm`. The error of t is the same at every angle.
    fn applied(&self, d: &Diameter, y_mm: f64, mean_mm: f64, u_mm: f64) -> Diameter {
        let common = d.d_mm * (self.u_per_mm * mean_mm).hypot(self.per_mm * u_mm);
        Diameter { d_mm: d.d_mm * (1.0 + self.per_mm * y_mm), u_common_mm: d.u_common_mm.hypot(common), ..*d }
    }
}

/// What turns towards the camera, to be taken out of the diameters of a scan.
#[derive(Clone, Debug)]
pub(crate) struct DepthCorrection {
    axis: AxisLine,
    /// By station, the mean of y over the angles of the scan, mm.
    mean_mm: Vec<f64>,
    telecentricity: Telecentricity,
}

impl DepthCorrection {
    /// By the axis of a scan with frames at these spindle angles.
    pub(crate) fn new(axis: AxisLine, angle_deg: &[f64], telecentricity: Telecentricity) -> Self {
        let mean = |s: &AxisStation| s.turning.map_or(0.0, |turning| mean_depth_mm(&turning, angle_deg));
        Self { mean_mm: axis.stations.iter().map(mean).collect(), axis, telecentricity }
    }

    /// Takes y out of the diameters of a frame.
    pub(crate) fn apply(&self, meta: &FrameMeta, diameters: &mut ColumnDiameters) {
        for column in 0..diameters.columns.len() {
            let Some(station) = nearest(&self.axis, diameters.z_mm(meta, column)) else { continue };
            let Some(turning) = self.axis.stations[station].turning else { continue };
            let Reading::Value(d) = &mut diameters.columns[column].reading else { continue };
            let (_, y_mm) = turning.at(meta.angle_deg);
            *d = self.telecentricity.applied(d, y_mm, self.mean_mm[station], turning.u_mm);
        }
    }
}

/// Takes y out of the diameters of every frame of a scan.
#[cfg(test)]
pub(crate) fn correct_frames(
    frames: &mut [(FrameMeta, ColumnDiameters)],
    axis: &AxisLine,
    telecentricity: Telecentricity,
) {
    let angles: Vec<f64> = frames.iter().map(|(meta, _)| meta.angle_deg).collect();
    let correction = DepthCorrection::new(axis.clone(), &angles, telecentricity);
    frames.iter_mut().for_each(|(meta, diameters)| correction.apply(meta, diameters));
}

/// Takes the mean of y over the angles of a scan out of its stations.
pub(crate) fn correct_profile(
    profile: &mut DiameterProfile,
    axis: &AxisLine,
    angle_deg: &[f64],
    telecentricity: Telecentricity,
) {
    for station in &mut profile.stations {
        let near = nearest(axis, station.z_mm);
        let Some(turning) = near.and_then(|near| axis.stations[near].turning) else { continue };
        let Reading::Value(d) = &mut station.reading else { continue };
        let mean_mm = mean_depth_mm(&turning, angle_deg);
        *d = telecentricity.applied(d, mean_mm, mean_mm, turning.u_mm);
    }
}

/// Mean of y over spindle angles, mm.
fn mean_depth_mm(turning: &TurningOffset, angle_deg: &[f64]) -> f64 {
    angle_deg.iter().map(|angle| turning.at(*angle).1).sum::<f64>() / angle_deg.len().max(1) as f64
}

/// The station nearest to z, by its place in the list.
fn nearest(axis: &AxisLine, z_mm: f64) -> Option<usize> {
    let after = axis.stations.partition_point(|s| s.z_mm < z_mm);
    let near = after.checked_sub(1).into_iter().chain((after < axis.stations.len()).then_some(after));
    let off = |index: &usize| (axis.stations[*index].z_mm - z_mm).abs();
    near.min_by(|a, b| off(a).total_cmp(&off(b)))
}
