//! What stands between two parts: the state file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::labels::Labels;
use crate::job::LoopJob;
use crate::plan::{DiameterOffset, PassPlan};
use crate::profile::{Diameter, DiameterProfile, Reading, Reason, Station};

/// Version of the file's form.
const VERSION: u32 = 1;
/// What a trial cut leaves on the diameter, mm. Ten times the expanded uncertainty of a usual
/// optical setup (5 µm), so that a factor of 2 or a sign stands out of it; half the largest step
/// that the guards let pass (`control.guards.step_limit_mm`, 0.1 mm); and larger, never smaller, so
/// that the part can still be cut to size.
pub(crate) const TRIAL_MM: f64 = 0.05;
/// Parts kept for the controller. Of an average with the default weight of the run-to-run
/// controllers (0.3) what lies further back has a share of 0.7³² = 1e-5; the sum of a PID forgets
/// what lies further back.
const MOST_PARTS: usize = 32;

/// Where a tool stands between its first part and regular use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Stage {
    /// The next images show a part that was cut without offsets.
    #[default]
    First,
    /// The next images show the trial cut.
    Trial,
    /// Sign and unit are proven; every part moves the offsets.
    Released,
}

/// A station of the next part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StationInForce {
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// Offset that the machine's program makes of it, mm of diameter; it is subtracted from the
    /// nominal.
    pub offset_mm: f64,
    /// Offset before it was rounded for the machine, mm of diameter.
    pub asked_mm: f64,
}

/// A station of a part that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StationRead {
    /// Offset that it was cut with, mm of diameter.
    pub offset_mm: f64,
    /// Mean caliper diameter, mm; absent where there is no reading.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub d_mm: Option<f64>,
    /// Random standard uncertainty, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_random_mm: Option<f64>,
    /// Common standard uncertainty, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_common_mm: Option<f64>,
}

/// A part that was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PartRead {
    /// Running number of the measurement, from 1.
    pub measurement: u32,
    /// Identity of the part; empty where none was given.
    #[serde(default)]
    pub part: String,
    /// Whether it was the trial cut.
    #[serde(default)]
    pub trial: bool,
    /// Digests of its images.
    pub images: Vec<String>,
    /// Its stations, in the order of `stations`.
    pub readings: Vec<StationRead>,
}

/// The state of offsets between two parts, as `measure --offsets JOB --state FILE` leaves it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OffsetState {
    /// Version of this form: 1.
    pub version: u32,
    /// Name of the job.
    pub job: String,
    /// Pass that the offsets are for: the one whose result is measured.
    pub pass: u32,
    /// Target diameter of that pass, mm.
    pub nominal_mm: f64,
    /// Where the tool stands.
    pub stage: Stage,
    /// Measurements so far: the number of the last one.
    pub measurements: u32,
    /// Part measured last, and tool and insert for the next one.
    pub labels: Labels,
    /// Observed over commanded change of the diameter, where the last command was large enough to
    /// judge by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observed_over_commanded: Option<f64>,
    /// Why the offsets in force were held or the trial cut was refused, where they were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<String>,
    /// Digest of the images of every measurement: the same ones never move an offset twice.
    pub used: Vec<String>,
    /// Offsets that were first released with an insert that was new, mm of diameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub new_insert_mm: Option<Vec<f64>>,
    /// Stations with the offsets of the next part.
    pub stations: Vec<StationInForce>,
    /// The part without offsets, that the trial cut is compared with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first: Option<PartRead>,
    /// Parts that the controller is given, the last ones of this insert.
    #[serde(default)]
    pub history: Vec<PartRead>,
}

/// A state that does not belong to the job.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the state is of {found}, the job is {wanted}; give the state of this job, or another file to begin anew"
)]
pub(crate) struct OtherJob {
    found: String,
    wanted: String,
}

impl OffsetState {
    /// The state before the first part of pass `pass` of a job.
    pub(crate) fn new(job: &LoopJob, pass: u32, labels: Labels) -> Self {
        let station = |z_mm: f64| StationInForce { z_mm, offset_mm: 0.0, asked_mm: 0.0 };
        Self {
            version: VERSION,
            job: job.name.clone(),
            pass,
            nominal_mm: job.part.target_mm(pass),
            stage: Stage::First,
            measurements: 0,
            labels,
            observed_over_commanded: None,
            held: None,
            used: Vec::new(),
            new_insert_mm: None,
            stations: station_z_mm(job).into_iter().map(station).collect(),
            first: None,
            history: Vec::new(),
        }
    }

    /// Refuses a state of another version, job, pass or of other stations.
    ///
    /// # Errors
    /// Both by name.
    pub(crate) fn check(&self, job: &LoopJob, pass: u32) -> Result<(), OtherJob> {
        let other = |found: String, wanted: String| Err(OtherJob { found, wanted });
        if self.version != VERSION {
            return other(format!("version {}", self.version), format!("read with version {VERSION}"));
        }
        if self.job != job.name {
            return other(format!("job {:?}", self.job), format!("{:?}", job.name));
        }
        let nominal_mm = job.part.target_mm(pass);
        if self.pass != pass || (self.nominal_mm - nominal_mm).abs() > SAME_MM {
            return other(
                format!("pass {} with {} mm", self.pass, self.nominal_mm),
                format!("at pass {pass} with {nominal_mm} mm"),
            );
        }
        let z_mm = station_z_mm(job);
        let same = |(s, z): (&StationInForce, &f64)| (s.z_mm - z).abs() <= SAME_MM;
        if self.stations.len() != z_mm.len() || !self.stations.iter().zip(&z_mm).all(same) {
            return other(
                format!("{} stations at other places", self.stations.len()),
                format!("one with {} stations", z_mm.len()),
            );
        }
        let parts = self.history.iter().chain(&self.first);
        let short = parts.map(|p| p.readings.len()).find(|n| *n != z_mm.len());
        match short {
            Some(n) => {
                other(format!("a part with {n} readings"), format!("one with {} stations", z_mm.len()))
            }
            None => Ok(()),
        }
    }

    /// Offsets in force, mm of diameter.
    pub(crate) fn offsets_mm(&self) -> Vec<f64> {
        self.stations.iter().map(|s| s.offset_mm).collect()
    }

    /// The pass that the state commands, with the offsets before rounding.
    pub(crate) fn plan(&self, job: &LoopJob) -> PassPlan {
        let o_mm = self.stations.iter().map(|s| s.asked_mm).collect();
        job.pass_plan(self.pass, DiameterOffset { o_mm })
    }

    /// Keeps a part for the controller.
    pub(super) fn remember(&mut self, part: PartRead) {
        self.history.push(part);
        let over = self.history.len().saturating_sub(MOST_PARTS);
        self.history.drain(..over);
    }

    /// The measurement that used one of these images, where one did: by all of them, or, of the
    /// parts still kept, by any.
    pub(super) fn used_in(&self, images: &[String], all: &str) -> Option<u32> {
        let kept = self.history.iter().chain(&self.first);
        let any = |part: &&PartRead| part.images.iter().any(|image| images.contains(image));
        kept.filter(any).map(|part| part.measurement).max().or_else(|| {
            let index = self.used.iter().position(|used| used == all)?;
            u32::try_from(index + 1).ok()
        })
    }
}

/// Middles of the stations that a pass of the job has, mm.
pub(super) fn station_z_mm(job: &LoopJob) -> Vec<f64> {
    job.pass_plan(1, DiameterOffset::zero(0)).station_z_mm
}

/// Difference below which places and diameters are the same, mm: tables hold all digits.
const SAME_MM: f64 = 1e-6;

impl PartRead {
    /// A part as it was measured, with the offsets that it was cut with.
    pub(super) fn new(profile: &DiameterProfile, offsets_mm: &[f64], images: Vec<String>) -> Self {
        let read = |(station, offset_mm): (&Station, &f64)| {
            let value = station.reading.value();
            StationRead {
                offset_mm: *offset_mm,
                d_mm: value.map(|d| d.d_mm),
                u_random_mm: value.map(|d| d.u_random_mm),
                u_common_mm: value.map(|d| d.u_common_mm),
            }
        };
        let readings = profile.stations.iter().zip(offsets_mm).map(read).collect();
        Self { measurement: 0, part: String::new(), trial: false, images, readings }
    }

    /// Its profile as pass `pass` of the controller.
    pub(super) fn profile(&self, pass: u32, z_mm: &[f64]) -> DiameterProfile {
        let station = |(read, z_mm): (&StationRead, &f64)| Station {
            z_mm: *z_mm,
            reading: read.value().map_or(Reading::Gap(Reason::NotScanned), Reading::Value),
            freedom: None,
        };
        DiameterProfile { pass, stations: self.readings.iter().zip(z_mm).map(station).collect() }
    }
}

impl StationRead {
    /// Diameter and uncertainty, where there is a reading.
    pub(super) fn value(&self) -> Option<Diameter> {
        let (d_mm, u_random_mm, u_common_mm) = (self.d_mm?, self.u_random_mm?, self.u_common_mm?);
        Some(Diameter { d_mm, u_random_mm, u_common_mm })
    }
}
