//! Where the frames of a run come from: a renderer behind the simulated cell, a recording, or a
//! head on the wire.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::cell::{RecordedCell, SimulatedCell, TurningCell};
use crate::cli::failure::Failure;
use crate::closed_loop::Calibrated;
use crate::frame::BoundSource;
use crate::gauge::calibration::Date;
use crate::gauge::{Calibration, CalibrationError};
use crate::job::{Job, LoopJob};
use crate::measurement::edge_model;
use crate::render::{BackendChoice, Renderer};
use crate::setting::SettingError;
use crate::source::{Address, RecordedScan, Recording};

use super::wire_head::WireHead;

/// Where frames come from.
pub(crate) enum FramesFrom {
    /// Process and renderer.
    Simulation(Renderer),
    /// A folder of frames.
    Recording(Recording),
    /// A head whose process and renderer are another program.
    Wire(Box<WireHead>),
}

impl FramesFrom {
    /// A renderer.
    ///
    /// # Errors
    /// Exit 3 for a device that fails.
    pub(crate) fn simulation(backend: BackendChoice) -> Result<Self, Failure> {
        let renderer = Renderer::new(backend).map_err(Failure::fail)?;
        tracing::info!(backend = renderer.backend_name(), adapter = renderer.adapter_name(), "rendering");
        Ok(Self::Simulation(renderer))
    }

    /// The head on the wire, or the recording beside its config file, that a job names; `None`
    /// where it names neither.
    ///
    /// # Errors
    /// Exit 2 for a key of the job, by `refused`: a source of another kind, a folder that is not
    /// there, a head that contradicts the job. Exit 3 for a head that fails.
    pub(super) fn source(
        job: &Job,
        config: &Path,
        refused: &dyn Fn(SettingError) -> Failure,
    ) -> Result<Option<Self>, Failure> {
        let Some(source) = &job.source else { return Ok(None) };
        if source.starts_with("gige:") {
            let address = Address::of(Path::new(source));
            if let Address::Camera(name) = address.map_err(|why| refused(SettingError::at("source", why)))? {
                return Ok(Some(Self::Wire(Box::new(WireHead::open(job, &name, refused)?))));
            }
        }
        Self::recording(job, source, config).map(Some).map_err(refused)
    }

    fn recording(job: &Job, source: &str, config: &Path) -> Result<Self, SettingError> {
        let folder = config.parent().unwrap_or(Path::new(""));
        let refused = |what: String| SettingError::at("source", what);
        let recording = Recording::open(source, folder).map_err(refused)?;
        if job.probe.is_some() {
            return Err(refused(
                "a recorded run has frames; touches of [probe] are not recorded: leave it out".into(),
            ));
        }
        Ok(Self::Recording(recording))
    }

    /// Backend of the renderer, `recorded` or `head`.
    pub(super) fn backend(&self) -> &str {
        match self {
            Self::Simulation(renderer) => renderer.backend_name(),
            Self::Recording(_) => "recorded",
            Self::Wire(_) => "head",
        }
    }

    /// Adapter of the renderer, the folder, or the head.
    pub(super) fn adapter(&self) -> String {
        match self {
            Self::Simulation(renderer) => renderer.adapter_name().to_owned(),
            Self::Recording(recording) => recording.root().display().to_string(),
            Self::Wire(head) => head.shown().to_owned(),
        }
    }

    /// Whether the frames lie in a folder already.
    pub(super) fn is_recorded(&self) -> bool {
        matches!(self, Self::Recording(_))
    }

    /// Whether process and truth are simulated, so that the same job can run without control.
    pub(super) fn is_simulated(&self) -> bool {
        matches!(self, Self::Simulation(_))
    }

    /// The cell of a job.
    ///
    /// # Errors
    /// Exit 3 where a stage refuses its settings.
    pub(super) fn cell<'a>(&'a self, job: &Job) -> Result<Box<dyn TurningCell + 'a>, Failure> {
        Ok(match self {
            Self::Simulation(renderer) => Box::new(SimulatedCell::new(job, renderer).map_err(Failure::fail)?),
            Self::Recording(recording) => {
                let encoder = job.scan.encoder;
                Box::new(RecordedCell::new(recording.clone().by_encoder(encoder)))
            }
            Self::Wire(head) => head.cell(job)?,
        })
    }

    /// The calibration that lies in a recording.
    ///
    /// # Errors
    /// Exit 3 for a file that is none, or whose time is over.
    pub(super) fn calibration(&self) -> Result<Option<Calibrated>, Failure> {
        let Self::Recording(recording) = self else { return Ok(None) };
        recording.calibration().map(|path| read_calibration(&path)).transpose()
    }

    /// The calibration of a run, with the camera of a head on the wire.
    pub(super) fn bound(&self, calibration: &Calibrated) -> Calibrated {
        match (self, calibration) {
            (Self::Wire(head), Calibrated::Camera(own)) => {
                (**own).clone().with_camera(head.camera().cloned()).into()
            }
            _ => calibration.clone(),
        }
    }

    /// Refuses the calibration of an unfinished run where the head is another one, or is set
    /// otherwise.
    ///
    /// # Errors
    /// The setting that differs, with both values.
    pub(super) fn check_bound(&self, calibration: Option<&Calibrated>) -> Result<(), CalibrationError> {
        match (self, calibration) {
            (Self::Wire(head), Some(Calibrated::Camera(own))) => {
                head.camera().map_or(Ok(()), |found| own.for_camera(found, BoundSource::Camera).map(drop))
            }
            _ => Ok(()),
        }
    }

    /// The loop's job with the edge model of a recording's calibration: a gauge must expect the
    /// edges that the masters had.
    pub(super) fn with_edge_model(&self, mut job: LoopJob, calibration: Option<&Calibrated>) -> LoopJob {
        if let (Self::Recording(_), Some(Calibrated::Camera(camera))) = (self, calibration) {
            job.gauge.esf = edge_model(None, Some(camera));
        }
        job
    }

    /// Where the frames of a pass would lie, if they are not there.
    pub(super) fn missing(&self, pass: u32) -> Option<PathBuf> {
        let Self::Recording(recording) = self else { return None };
        let scan = RecordedScan::Pass(pass);
        (!recording.has(scan)).then(|| recording.place(scan))
    }
}

fn read_calibration(path: &Path) -> Result<Calibrated, Failure> {
    let named = |e: &dyn std::fmt::Display| Failure::fail(format!("{}: {e}", path.display()));
    let file = std::fs::File::open(path).map_err(|e| named(&e))?;
    let calibration = Calibration::read(std::io::BufReader::new(file)).map_err(|e| named(&e))?;
    let today = Date::of(SystemTime::now());
    calibration.setup.as_ref().map_or(Ok(()), |s| s.check_date(today)).map_err(|e| named(&e))?;
    Ok(calibration.into())
}
