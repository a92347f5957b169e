//! What `measure` gives its store: a run a call, a pass a frame.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::args::failure;
use crate::cli::failure::Failure;
use crate::gauge::Calibration;
use crate::measurement::{Measurement, StationResult};
use crate::profile::Reading;
use crate::source::sha256_hex;
use crate::store::{Entry, EntryKind, PassToStore, RunToStore, StationToStore, Store, Utc};

/// Frames a transaction at most: a commit waits for the disk.
const FRAMES: usize = 256;
/// How long a frame waits for its commit at most.
const WAITS: Duration = Duration::from_millis(500);

/// A store that a call of `measure` writes.
#[derive(Debug)]
pub(in crate::cli) struct MeasuredStore {
    store: Store,
    run: RunToStore,
    waiting: Vec<PassToStore>,
    frames: u32,
    committed: Instant,
}

impl MeasuredStore {
    /// Stores the calibration; `named` are the inputs.
    ///
    /// # Errors
    /// Exit 2 or 3 as the store refuses.
    pub(in crate::cli) fn begin(
        mut store: Store,
        named: &[PathBuf],
        calibration: &Calibration,
    ) -> Result<Self, Failure> {
        let document = serde_json::to_string(calibration).map_err(Failure::fail)?;
        let calibration = Entry { kind: EntryKind::Calibration, key: sha256_hex(&document), document };
        store.put(&calibration).map_err(failure)?;
        let named: Vec<String> = named.iter().map(|path| path.display().to_string()).collect();
        let config = serde_json::json!({ "inputs": named }).to_string();
        // a call is a run of its own, whatever it measures
        let call = format!("{config}{}{}", Utc::now(), std::process::id());
        let run = RunToStore {
            key: sha256_hex(&call),
            origin: "measure".to_owned(),
            name: named.first().cloned().unwrap_or_default(),
            part: None,
            tool: None,
            calibration: Some(calibration.key),
            config,
        };
        Ok(Self { store, run, waiting: Vec::new(), frames: 0, committed: Instant::now() })
    }

    /// Adds a frame; it is acknowledged with those before it, half a second later at most while
    /// frames come.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub(in crate::cli) fn add(&mut self, measured: &Measurement) -> Result<(), Failure> {
        self.frames += 1;
        self.waiting.push(pass(self.frames, measured));
        if self.waiting.len() >= FRAMES || self.committed.elapsed() >= WAITS {
            self.finish()?;
        }
        Ok(())
    }

    /// Acknowledges the frames that wait.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub(in crate::cli) fn finish(&mut self) -> Result<(), Failure> {
        if !self.waiting.is_empty() {
            self.store.acknowledge(&self.run, &self.waiting).map_err(failure)?;
            self.waiting.clear();
        }
        self.committed = Instant::now();
        Ok(())
    }
}

fn pass(number: u32, m: &Measurement) -> PassToStore {
    let stations = match m.stations.as_deref() {
        Some(stations) if !stations.is_empty() => stations.iter().map(station).collect(),
        _ => vec![largest(m)],
    };
    PassToStore { pass: number, name: Some(m.frame.clone()), stations, ..PassToStore::default() }
}

fn station(s: &StationResult) -> StationToStore {
    let value = s.reading.value();
    StationToStore {
        z_mm: Some(s.z_mm),
        nominal_mm: None,
        d_mm: value.map(|d| d.d_mm),
        u_mm: value.map(|d| d.u_mm()),
        flag: match s.reading {
            Reading::Gap(reason) => Some(reason.as_str().to_owned()),
            Reading::Value(_) => None,
        },
    }
}

/// The largest diameter of a frame, where stations were not asked for.
fn largest(m: &Measurement) -> StationToStore {
    let diameter = m.diameter.as_ref();
    StationToStore {
        z_mm: m.place.filter(|_| diameter.is_some()).map(|place| place.z_mm),
        nominal_mm: None,
        d_mm: diameter.map(|d| d.diameter.d_mm),
        u_mm: diameter.map(|d| d.expanded_u_mm / d.coverage_factor),
        flag: m.refusal.as_ref().map(|refusal| refusal.reason.as_str().to_owned()),
    }
}
