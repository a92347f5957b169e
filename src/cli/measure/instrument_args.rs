//! Arguments of what frames are measured with: scale or calibration, conditions of the part.

use std::fs;
use std::path::{Path, PathBuf};

use super::frames::{FrameArgs, ScaleArgument, scale_argument, scale_of_files};
use crate::cli::failure::Failure;
use crate::cli::input_output::ConfigText;
use crate::frame::{BoundSource, CameraBinding};
use crate::gauge::Calibration;
use crate::gauge::calibration::{Conditions, Date, GivenConditions};
use crate::measurement::{conditions, known_conditions};

/// Scale or calibration, and the conditions of the part.
#[derive(Debug, clap::Args)]
pub(crate) struct InstrumentArgs {
    /// Scale, µm per pixel, when there is no calibration; `file` takes that of frames.csv or of the
    /// files' own tags.
    #[arg(long, value_name = "S|file", conflicts_with = "calibration", value_parser = scale_argument)]
    um_per_px: Option<ScaleArgument>,
    /// Calibration file (JSON) with scale, edge offset and their uncertainty.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Refuses a calibration of other optics than these.
    #[arg(long, value_name = "ID", requires = "calibration")]
    optics_id: Option<String>,
    /// Uses a calibration whose time is over, with a warning.
    #[arg(long, requires = "calibration")]
    accept_expired: bool,
    /// Judges the calibration's validity on this day instead of today, YYYY-MM-DD.
    #[arg(long, value_name = "DATE", requires = "calibration")]
    as_of: Option<Date>,
    /// Conditions of the part (TOML): temperature, expansion, place, with their limits; what it
    /// leaves out is the calibration's.
    #[arg(long, value_name = "FILE.toml")]
    conditions: Option<PathBuf>,
    /// Temperature of the part, °C, in place of the conditions' one.
    #[arg(long, value_name = "C", allow_negative_numbers = true)]
    part_temperature: Option<f64>,
}

impl InstrumentArgs {
    /// The scale of the command line.
    pub(crate) fn scale(&self) -> Option<ScaleArgument> {
        self.um_per_px
    }

    /// Whether a calibration is given.
    pub(crate) fn has_calibration(&self) -> bool {
        self.calibration.is_some()
    }

    /// The files named here.
    pub(crate) fn files(&self) -> impl Iterator<Item = PathBuf> {
        [&self.calibration, &self.conditions].into_iter().flatten().cloned()
    }

    /// Whether conditions of the part are stated.
    pub(crate) fn states_conditions(&self) -> bool {
        self.conditions.is_some() || self.part_temperature.is_some()
    }

    /// The calibration: that of the file, or of the scale; its validity and optics are checked.
    ///
    /// # Errors
    /// A file that is none; other optics; one whose time is over, without consent.
    pub(crate) fn calibration(
        &self,
        frames: &FrameArgs,
        paths: &[PathBuf],
    ) -> Result<Option<Calibration>, Failure> {
        let Some(path) = &self.calibration else {
            return Ok(match self.um_per_px {
                None => None,
                Some(ScaleArgument::Given(um_per_px)) => Some(Calibration::from_scale(um_per_px)),
                Some(ScaleArgument::File) => Some(Calibration::from_scale(scale_of_files(frames, paths)?)),
            });
        };
        let named = |e: &dyn std::fmt::Display| Failure::fail(format!("{}: {e}", path.display()));
        let file = fs::File::open(path).map_err(|e| named(&e))?;
        let calibration = Calibration::read(std::io::BufReader::new(file)).map_err(|e| named(&e))?;
        if let Some(id) = &self.optics_id {
            calibration.check_optics(id).map_err(|e| named(&e))?;
        }
        let today = self.as_of.unwrap_or_else(|| Date::of(std::time::SystemTime::now()));
        if let Some(Err(error)) = calibration.setup.as_ref().map(|b| b.check_date(today)) {
            if !self.accept_expired {
                return Err(named(&error));
            }
            tracing::warn!("{}: {error}; used with consent", path.display());
        }
        Ok(Some(calibration))
    }

    /// The calibration for the frames of an open camera or recording: that of a window inside the
    /// calibrated one where only the window differs. What does not state a camera is not compared.
    ///
    /// # Errors
    /// A calibration of another camera, or of one that was set otherwise: the setting with both
    /// values.
    pub(crate) fn bound(
        &self,
        calibration: Option<Calibration>,
        source: Option<(BoundSource, Option<&CameraBinding>)>,
    ) -> Result<Option<Calibration>, Failure> {
        let (Some(path), Some(calibration), Some((of, camera))) = (&self.calibration, &calibration, source)
        else {
            return Ok(calibration);
        };
        let shown = path.display();
        match (&calibration.camera, camera) {
            (None, Some(_)) => tracing::warn!(
                "{shown} states no camera: it is not compared with the camera of these frames (calibrate with \
                 source = \"gige:NAME\" binds a calibration)"
            ),
            (Some(_), None) => tracing::warn!(
                "the source states no camera: it is not compared with that of the calibration {shown}"
            ),
            _ => {}
        }
        let Some(camera) = camera else { return Ok(Some(calibration.clone())) };
        let of_camera = calibration.for_camera(camera, of);
        of_camera.map(Some).map_err(|why| Failure::fail(format!("{shown}: {why}")))
    }

    /// The part's conditions: the file's, otherwise the calibration's; `--part-temperature`
    /// overrides.
    ///
    /// # Errors
    /// Conditions out of range.
    pub(crate) fn conditions(&self, calibration: Option<&Calibration>) -> Result<Conditions, Failure> {
        let given = self.conditions.as_ref().map(|path| given_conditions(path, calibration)).transpose()?;
        conditions(calibration, given.as_ref(), self.part_temperature).map_err(Failure::refuse)
    }
}

/// The conditions in a file; logs what of the calibration's they leave.
fn given_conditions(path: &Path, calibration: Option<&Calibration>) -> Result<GivenConditions, Failure> {
    let text = ConfigText::read(path)?;
    let given: GivenConditions = text.parse()?;
    let named = text.tables()?;
    let all = toml::Table::try_from(known_conditions(calibration)).map_err(|e| text.refuse(e))?;
    let kept: Vec<String> = all
        .iter()
        .filter(|(key, _)| !named.contains_key(*key))
        .map(|(key, v)| format!("{key} = {v}"))
        .collect();
    tracing::info!("{}: kept of the calibration's conditions: {}", text.name, kept.join(", "));
    Ok(given)
}
