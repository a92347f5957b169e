//! What a run gives its store: the job, then every pass as soon as its tables are written.

use super::args::failure;
use crate::cli::failure::Failure;
use crate::job::Job;
use crate::run_folder::{ControlRecord, OffsetRow, PassRow, StationRow};
use crate::source::sha256_hex;
use crate::store::{Acknowledged, Entry, EntryKind, PassToStore, RunToStore, StationToStore, Store};

/// A store that a run writes.
#[derive(Debug)]
pub(in crate::cli) struct RunStore {
    store: Store,
    run: RunToStore,
}

/// The tables of the finished passes.
#[derive(Clone, Copy, Debug)]
pub(in crate::cli) struct PassTables<'a> {
    pub(in crate::cli) passes: &'a [PassRow],
    pub(in crate::cli) stations: &'a [StationRow],
    pub(in crate::cli) offsets: &'a [OffsetRow],
    pub(in crate::cli) control: &'a ControlRecord,
}

impl RunStore {
    /// Stores part, tool and calibration of a job.
    ///
    /// # Errors
    /// Exit 2 or 3 as the store refuses.
    pub(in crate::cli) fn begin(mut store: Store, job: &Job, calibration: &str) -> Result<Self, Failure> {
        let json = |value: Result<String, serde_json::Error>| value.map_err(Failure::fail);
        let part = Entry {
            kind: EntryKind::Part,
            key: job.name.clone(),
            document: json(serde_json::to_string(&job.part))?,
        };
        let calibration = Entry {
            kind: EntryKind::Calibration,
            key: sha256_hex(calibration),
            document: calibration.to_owned(),
        };
        let tool = job.tool.as_ref().map(|tool| {
            let document = json(serde_json::to_string(tool))?;
            let key = format!("tool of {}", job.name);
            Ok::<_, Failure>(Entry { kind: EntryKind::Tool, key, document })
        });
        let tool = tool.transpose()?;
        for entry in [Some(&part), Some(&calibration), tool.as_ref()].into_iter().flatten() {
            store.put(entry).map_err(failure)?;
        }
        let run = RunToStore {
            key: crate::config::hash(job).map_err(Failure::fail)?,
            origin: "run".to_owned(),
            name: job.name.clone(),
            part: Some(part.key),
            tool: tool.map(|tool| tool.key),
            calibration: Some(calibration.key),
            config: crate::config::resolved(job).map_err(Failure::fail)?,
        };
        Ok(Self { store, run })
    }

    /// Stores the passes of these tables; those that are there already stay.
    ///
    /// # Errors
    /// Exit 2 for a pass that is there with other values, 3 where the disk fails.
    pub(in crate::cli) fn acknowledge(&mut self, tables: &PassTables<'_>) -> Result<usize, Failure> {
        let passes: Vec<PassToStore> = tables.passes.iter().map(|row| pass(row, tables)).collect();
        let stored = self.store.acknowledge(&self.run, &passes).map_err(failure)?;
        Ok(stored.iter().filter(|&&outcome| outcome == Acknowledged::Stored).count())
    }
}

fn pass(row: &PassRow, tables: &PassTables<'_>) -> PassToStore {
    let stations = tables.stations.iter().filter(|s| s.pass == row.pass).map(|s| station(row, s)).collect();
    let record = tables.control.passes.iter().find(|p| p.pass == row.pass);
    let offsets = tables.offsets.iter().filter(|o| o.pass == row.pass).map(|o| o.offset_mm);
    let offsets: Vec<f64> = offsets.collect();
    let reason = record.and_then(|r| r.reason.clone()).unwrap_or_default();
    PassToStore {
        pass: row.pass,
        name: None,
        stations,
        max_abs_error_mm: Some(row.max_abs_error_mm),
        decision: Some([row.decision.clone(), reason, serde_json::json!(offsets).to_string()]),
        alarm: record.and_then(|r| r.alarm.clone()),
    }
}

fn station(row: &PassRow, s: &StationRow) -> StationToStore {
    let u = s.u_random_mm.zip(s.u_common_mm).map(|(random, common)| random.hypot(common));
    StationToStore {
        z_mm: Some(s.z_mm),
        nominal_mm: Some(row.nominal_mm),
        d_mm: s.d_mm,
        u_mm: u,
        flag: s.flag.map(|reason| reason.as_str().to_owned()),
    }
}
