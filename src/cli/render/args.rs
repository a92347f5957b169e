//! Arguments of `render`, and the scene and frame requests that follow from them.

use std::path::PathBuf;

use super::frame_files::FileFormat;
use crate::cell::{drawn_scene, scan_request};
use crate::cli::failure::Failure;
use crate::job::Job;
use crate::render::{BackendChoice, FrameRequest, Scene};

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
pub(crate) struct RenderArgs {
    /// The job whose shaft is drawn, or a calibration with [simulate], whose fields and pins are.
    /// Of a job only part, shaft, scan and optical setup are used: masters and falling diameters
    /// are needed by `run` alone.
    #[arg(required_unless_present = "gallery")]
    pub(super) config: Option<PathBuf>,
    /// Draw a frame of every kind and a contact sheet of all into a new folder; needs no config.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["config", "out", "bench"])]
    pub(super) gallery: Option<PathBuf>,
    /// Folder for the frames: absent or empty.
    #[arg(long, value_name = "DIR", required_unless_present_any = ["bench", "gallery"], conflicts_with = "bench")]
    pub(super) out: Option<PathBuf>,
    /// Frames to draw; all of the config's scan by default, going round again beyond it.
    #[arg(long, value_name = "N")]
    pub(super) frames: Option<usize>,
    /// File format of the frames.
    #[arg(long, value_enum, default_value_t = FileFormat::Png16)]
    pub(super) format: FileFormat,
    /// Leave the sensor's temporal noise out.
    #[arg(long)]
    pub(super) no_noise: bool,
    /// Where frames are rendered; auto takes a hardware adapter, else the CPU path (a software
    /// adapter only by name).
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    pub(super) backend: BackendChoice,
    /// Draw N frames without writing them and print how long one takes.
    #[arg(long, value_name = "N")]
    pub(super) bench: Option<usize>,
    /// With --bench: read two windows of so many rows around the shaft's edges, not the whole
    /// sensor.
    #[arg(long, value_name = "ROWS", requires = "bench")]
    pub(super) windows: Option<u32>,
    /// Threads to use; all of the machine's by default.
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<usize>,
    /// Print the bench as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

/// The scene of a config.
pub(crate) fn scene(job: &Job) -> Result<Scene, Failure> {
    drawn_scene(job).map_err(Failure::refuse)
}

/// Request number `index` of the scan, starting over at its end.
pub(super) fn request(args: &RenderArgs, job: &Job, index: usize) -> FrameRequest {
    FrameRequest {
        noise: !args.no_noise,
        format: Some(args.format.pixel_format(job.sensor.format)),
        ..scan_request(job, &job.loop_job().scan_plan(), index)
    }
}
