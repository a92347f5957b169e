//! `axis.csv` of a run folder: the axis of the part at every station, at rest and turning.

use serde::{Deserialize, Serialize};

use super::folder::{RunFolder, RunFolderError};
use crate::gauge::axis_line::{AxisLine, STILL_TOWARDS_CAMERA};

/// A row of `axis.csv`: the axis at a station after a pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct AxisRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Height above the optical axis of the axis at rest, mm.
    pub x_mm: f64,
    /// Its standard uncertainty, mm.
    pub u_x_mm: f64,
    /// Departure from the chord between the first and the last station, mm.
    pub bend_x_mm: f64,
    /// Its standard uncertainty, mm.
    pub u_bend_x_mm: f64,
    /// Turning component of the axis, upwards at spindle angle 0, mm; empty where the angles do not
    /// determine it.
    pub turning_x_mm: Option<f64>,
    /// Turning component of the axis, towards the camera at spindle angle 0, mm.
    pub turning_y_mm: Option<f64>,
    /// Standard uncertainty of either, mm.
    pub u_turning_mm: Option<f64>,
    /// Radial run-out of the axis, mm: twice the turning component.
    pub run_out_mm: Option<f64>,
    /// Component at rest towards the camera: not measured.
    pub still_y: String,
    /// Number of spindle angles measured.
    pub angles: usize,
}

impl AxisRow {
    /// The rows of a pass.
    pub(crate) fn of(pass: u32, axis: &AxisLine) -> Vec<Self> {
        let bend = axis.bend_mm();
        axis.stations
            .iter()
            .zip(bend)
            .map(|(s, (_, bend_x_mm, u_bend_x_mm))| Self {
                pass,
                z_mm: s.z_mm,
                x_mm: s.x_mm,
                u_x_mm: s.u_mm(),
                bend_x_mm,
                u_bend_x_mm,
                turning_x_mm: s.turning.map(|t| t.x_mm),
                turning_y_mm: s.turning.map(|t| t.y_mm),
                u_turning_mm: s.turning.map(|t| t.u_mm),
                run_out_mm: s.turning.map(|t| t.run_out_mm()),
                still_y: STILL_TOWARDS_CAMERA.to_owned(),
                angles: s.angles,
            })
            .collect()
    }
}

/// The axis after a pass, as in `run --json`.
pub(crate) fn axis_json(rows: &[AxisRow], pass: u32) -> serde_json::Value {
    let own: Vec<&AxisRow> = rows.iter().filter(|r| r.pass == pass).collect();
    let most = |f: &dyn Fn(&AxisRow) -> Option<f64>| {
        own.iter().filter(|r| f(r).is_some()).copied().max_by(|a, b| {
            let size = |r: &AxisRow| f(r).map_or(0.0, f64::abs);
            size(a).total_cmp(&size(b))
        })
    };
    let (Some(bend), turning) = (most(&|r| Some(r.bend_x_mm)), most(&|r| r.run_out_mm)) else {
        return serde_json::Value::Null;
    };
    serde_json::json!({
        "stations": own.len(),
        "max_bend_x_mm": bend.bend_x_mm,
        "max_bend_x_at_z_mm": bend.z_mm,
        "u_max_bend_x_mm": bend.u_bend_x_mm,
        "max_run_out_mm": turning.and_then(|r| r.run_out_mm),
        "max_run_out_at_z_mm": turning.map(|r| r.z_mm),
        "u_max_run_out_mm": turning.and_then(|r| r.u_turning_mm).map(|u| 2.0 * u),
        "still_towards_camera": STILL_TOWARDS_CAMERA,
    })
}

impl RunFolder {
    /// Writes `axis.csv`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_axis(&self, rows: &[AxisRow]) -> Result<(), RunFolderError> {
        self.write_csv("axis.csv", rows)
    }

    /// Reads `axis.csv`; empty where there is none.
    ///
    /// # Errors
    /// Where it cannot be read or parsed.
    pub(crate) fn axis(&self) -> Result<Vec<AxisRow>, RunFolderError> {
        self.read_csv("axis.csv")
    }
}
