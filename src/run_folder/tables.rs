//! The CSV tables of a run folder.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::folder::{RunFolder, RunFolderError};
use crate::job::{MachineRow, ProbeRow};
use crate::profile::{Diameter, DiameterProfile, Reading, Reason, Station};

/// A row of `passes.csv`: one finished pass. The `true_` columns are for comparison only; they and
/// those that follow from them are empty where no truth is given: of a recorded part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PassRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Target diameter of the pass, mm.
    pub nominal_mm: f64,
    /// Largest |measured - nominal| over stations, mm.
    pub max_abs_error_mm: f64,
    /// Root mean square of measured - nominal, mm.
    pub rms_error_mm: f64,
    /// Largest |true - nominal|, mm.
    pub true_max_abs_error_mm: Option<f64>,
    /// Largest |measured - true|, mm.
    pub worst_measured_minus_true_mm: Option<f64>,
    /// Rms over stations of (measured - true)/u.
    pub rms_error_over_u: Option<f64>,
    /// Stations with a reading.
    pub stations_measured: usize,
    /// Frames measured.
    pub frames: usize,
    /// Decision after the pass: `released`, `held` or `last`.
    pub decision: String,
    /// Largest radial force, N; this and the following columns come from the cell, are empty where
    /// it has none, and absent from older tables.
    #[serde(default)]
    pub radial_force_n: Option<f64>,
    /// Largest tangential force, N.
    #[serde(default)]
    pub tangential_force_n: Option<f64>,
    /// Largest feed force, N.
    #[serde(default)]
    pub feed_force_n: Option<f64>,
    /// Largest radial deflection at the tool, µm.
    #[serde(default)]
    pub deflection_um: Option<f64>,
    /// Upper bound of the diameter error of the tangential deflection, µm.
    #[serde(default)]
    pub tangential_error_um: Option<f64>,
    /// Height of the feed marks, µm.
    #[serde(default)]
    pub feed_mark_um: Option<f64>,
}

/// A row of `stations.csv`: one station as measured after a pass, and the truth beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StationRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Mean caliper diameter, mm; empty for a gap.
    pub d_mm: Option<f64>,
    /// Random standard uncertainty, mm.
    pub u_random_mm: Option<f64>,
    /// Common standard uncertainty, mm.
    pub u_common_mm: Option<f64>,
    /// Reason of a gap.
    pub flag: Option<Reason>,
    /// True mean caliper diameter, mm; empty where it is not given.
    pub true_d_mm: Option<f64>,
    /// Effective degrees of freedom of the uncertainty; empty where they are very many, absent from
    /// older tables.
    #[serde(default)]
    pub effective_freedom: Option<f64>,
}

impl StationRow {
    /// The row of a station.
    pub(crate) fn new(pass: u32, station: &Station, true_d_mm: Option<f64>) -> Self {
        let value = station.reading.value();
        Self {
            pass,
            z_mm: station.z_mm,
            d_mm: value.map(|d| d.d_mm),
            u_random_mm: value.map(|d| d.u_random_mm),
            u_common_mm: value.map(|d| d.u_common_mm),
            flag: match station.reading {
                Reading::Gap(reason) => Some(reason),
                Reading::Value(_) => None,
            },
            true_d_mm,
            effective_freedom: station.freedom,
        }
    }

    /// The measured station, without the truth.
    pub(crate) fn station(&self) -> Station {
        let reading = match (self.d_mm, self.u_random_mm, self.u_common_mm) {
            (Some(d_mm), Some(u_random_mm), Some(u_common_mm)) => {
                Reading::Value(Diameter { d_mm, u_random_mm, u_common_mm })
            }
            _ => Reading::Gap(self.flag.unwrap_or(Reason::NotScanned)),
        };
        Station { z_mm: self.z_mm, reading, freedom: self.effective_freedom }
    }
}

/// A row of `offsets.csv`: the offset in force at a station in a pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct OffsetRow {
    /// The pass the offset was cut with, from 1.
    pub pass: u32,
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Offset o, mm of diameter: b = r - o.
    pub offset_mm: f64,
    /// Offset as the controller decided it, before the machine's program rounded it, mm of
    /// diameter; absent from older tables.
    #[serde(default)]
    pub asked_mm: Option<f64>,
    /// Commanded diameter b, mm.
    pub commanded_mm: f64,
    /// `released`, or `held` where a guard kept the offsets of the pass before.
    pub status: String,
    /// Why it was held.
    pub reason: String,
}

/// A row of `truth_axis.csv`: the axis at a station in the frames of a pass (tool clear, or under
/// the force of the cut); for comparison only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct TrueAxisRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Component at rest along x (up in the image), mm.
    pub still_x_mm: f64,
    /// Component at rest along y (towards the camera), mm.
    pub still_y_mm: f64,
    /// Turning component along the body's 0°, mm.
    pub turning_x_mm: f64,
    /// Turning component along the body's 90°, mm.
    pub turning_y_mm: f64,
}

impl RunFolder {
    /// Writes `truth_axis.csv`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_true_axis(&self, rows: &[TrueAxisRow]) -> Result<(), RunFolderError> {
        self.write_csv("truth_axis.csv", rows)
    }

    /// Reads `truth_axis.csv`; empty where there is none.
    ///
    /// # Errors
    /// Where it cannot be read or parsed.
    pub(crate) fn true_axis(&self) -> Result<Vec<TrueAxisRow>, RunFolderError> {
        self.read_csv("truth_axis.csv")
    }

    /// Writes `truth_machine.csv`: what the errors of the lathe amount to, for comparison only.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_machine(&self, rows: &[MachineRow]) -> Result<(), RunFolderError> {
        self.write_csv("truth_machine.csv", rows)
    }

    /// Writes `machine_probe.csv`: what a displacement probe on the lathe indicates.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_machine_probe(&self, rows: &[ProbeRow]) -> Result<(), RunFolderError> {
        self.write_csv("machine_probe.csv", rows)
    }

    /// Writes `passes.csv`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_passes(&self, rows: &[PassRow]) -> Result<(), RunFolderError> {
        self.write_csv("passes.csv", rows)
    }

    /// Reads `passes.csv`; empty where no pass is finished.
    ///
    /// # Errors
    /// Where it cannot be read or parsed.
    pub(crate) fn passes(&self) -> Result<Vec<PassRow>, RunFolderError> {
        self.read_csv("passes.csv")
    }

    /// Writes `stations.csv`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_stations(&self, rows: &[StationRow]) -> Result<(), RunFolderError> {
        self.write_csv("stations.csv", rows)
    }

    /// Reads `stations.csv`.
    ///
    /// # Errors
    /// Where it cannot be read or parsed.
    pub(crate) fn stations(&self) -> Result<Vec<StationRow>, RunFolderError> {
        self.read_csv("stations.csv")
    }

    /// Writes `offsets.csv`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_offsets(&self, rows: &[OffsetRow]) -> Result<(), RunFolderError> {
        self.write_csv("offsets.csv", rows)
    }

    /// Reads `offsets.csv`.
    ///
    /// # Errors
    /// Where it cannot be read or parsed.
    pub(crate) fn offsets(&self) -> Result<Vec<OffsetRow>, RunFolderError> {
        self.read_csv("offsets.csv")
    }

    pub(super) fn write_csv<T: Serialize>(&self, name: &str, rows: &[T]) -> Result<(), RunFolderError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let failed = |e: String| RunFolderError::Write {
            path: self.path().join(name),
            cause: std::io::Error::other(e),
        };
        rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|e| failed(e.to_string()))?;
        let bytes = writer.into_inner().map_err(|e| failed(e.to_string()))?;
        self.write(name, &bytes)
    }

    pub(super) fn read_csv<T: DeserializeOwned>(&self, name: &str) -> Result<Vec<T>, RunFolderError> {
        if !self.path().join(name).exists() {
            return Ok(Vec::new());
        }
        let text = self.read_text(name)?;
        csv::Reader::from_reader(text.as_bytes())
            .deserialize()
            .collect::<Result<_, _>>()
            .map_err(|e| RunFolderError::Read { path: self.path().join(name), cause: e.to_string() })
    }
}

/// The measured profile of a pass from its rows.
pub(crate) fn profile_of(pass: u32, rows: &[StationRow]) -> DiameterProfile {
    DiameterProfile {
        pass,
        stations: rows.iter().filter(|r| r.pass == pass).map(StationRow::station).collect(),
    }
}
