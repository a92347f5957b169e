//! `shadowgauge render`: frames of a config's shaft with their truth, or how long a frame takes.

mod calibration;
mod frame_files;
mod gallery;
mod gallery_cases;
mod label_font;
pub(super) mod timing;

use std::fmt::Write as _;
use std::io::Error as IoError;
use std::path::{Path, PathBuf};

use crate::config;
use crate::files::OutputFolder;
use crate::frame::Frame;
use crate::job::Job;
use crate::render::form::form_shaft;
use crate::render::{BackendChoice, FrameRequest, OpticalBench, RenderError, Renderer, Scene};
use crate::shaft::ProfileKnot;
use crate::truth;

use self::frame_files::{FileFormat, encode, encode_mask, preview};
use self::gallery::gallery;
use self::timing::bench;
use super::calibration_plan::is_plan;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::ConfigText;

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    /// The job whose shaft is drawn, or a calibration with [simulate], whose fields and pins are.
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
    /// Where frames are rendered; auto takes a hardware adapter, else the CPU path (a software adapter only by name).
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    pub(super) backend: BackendChoice,
    /// Draw N frames without writing them and print how long one takes.
    #[arg(long, value_name = "N")]
    pub(super) bench: Option<usize>,
    /// With --bench: read two windows of so many rows around the shaft's edges, not the whole sensor.
    #[arg(long, value_name = "ROWS", requires = "bench")]
    pub(super) windows: Option<u32>,
    /// Threads to use; all of the machine's by default.
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<usize>,
    /// Print the bench as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

/// Renders the frames of a config.
///
/// # Errors
/// Exit 2 for a config, a command line or an output folder that is refused; 3 for a device or a disk that fails.
pub fn run(args: &RenderArgs) -> CommandResult {
    if let Some(folder) = &args.gallery {
        return gallery(args, folder);
    }
    let Some(file) = &args.config else {
        return Err(Failure::refuse("a config or --gallery DIR is needed"));
    };
    if is_plan(&ConfigText::read(file)?.text) {
        return calibration::run(args, file);
    }
    let job = config::load(file).map_err(Failure::refused)?;
    if args.threads == Some(0) || args.bench == Some(0) || args.frames == Some(0) {
        return Err(Failure::refuse("--threads, --bench and --frames take numbers of at least 1"));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.unwrap_or(0))
        .build()
        .map_err(Failure::fail)?;
    pool.install(|| match (args.bench, &args.out) {
        (Some(frames), _) => bench(args, &job, frames),
        (None, Some(out)) => write_folder(args, &job, out),
        (None, None) => Err(Failure::refuse("--out DIR or --bench N is needed")),
    })
}

/// The scene of a config: its shaft at the last pass's nominal diameter with the form of `[shaft]`.
pub(super) fn scene(job: &Job) -> Result<Scene, Failure> {
    let bench = OpticalBench::resolve(&job.bench_settings(), job.seed).map_err(Failure::refuse)?;
    let diameter = job.part.nominal_diameter_mm.last().copied().unwrap_or(job.part.stock_diameter_mm);
    let profile = vec![ProfileKnot { z_mm: 0.0, radius_mm: diameter / 2.0 }];
    let shaft = form_shaft(profile, &job.shaft, job.part.length_mm, job.seed).map_err(Failure::refuse)?;
    Scene::new(&bench, shaft).map_err(Failure::refuse)
}

/// Request number `index` of the scan, going round again beyond its end.
pub(super) fn request(args: &RenderArgs, job: &Job, index: usize) -> FrameRequest {
    let plan = job.scan_plan();
    let angles = plan.angle_deg.len().max(1);
    let place = index % plan.frames().max(1);
    let windows = job.camera.windows.map(|w| w.rois(job.camera.columns));
    let (roi, second_roi) = (windows.map(|w| w[0]), windows.map(|w| w[1]));
    FrameRequest {
        frame_id: index as u64,
        t_ns: (index as f64 * job.camera.period_ms() * 1e6) as u64,
        z_mm: plan.field_z_mm.get(place / angles).copied().unwrap_or(0.0),
        angle_deg: plan.angle_deg.get(place % angles).copied().unwrap_or(0.0),
        noise: !args.no_noise,
        roi,
        second_roi,
        seed: job.seed,
        format: Some(args.format.pixel_format(job.sensor.format)),
    }
}

// ---- frames to a folder

fn write_folder(args: &RenderArgs, job: &Job, out: &Path) -> CommandResult {
    let scene = scene(job)?;
    let count = args.frames.unwrap_or_else(|| job.scan_plan().frames());
    for index in 0..count.min(job.scan_plan().frames()) {
        scene.geometric_edges(&request(args, job, index)).map_err(Failure::refuse)?;
    }
    let folder = OutputFolder::claim(out)?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    write_frames(args, job, &scene, &renderer, &folder, count)?;
    folder.finish()?;
    say_line!(
        "{count} frames by {} ({}) in {}",
        renderer.backend_name(),
        renderer.adapter_name(),
        out.display()
    );
    Ok(Outcome::Done)
}

/// Columns of `frames.csv`.
pub(super) const FRAMES_HEADER: &str = "frame,t_ns,z_mm,angle_deg,exposure_us,bit_depth,um_per_px\n";

fn write_frames(
    args: &RenderArgs,
    job: &Job,
    scene: &Scene,
    renderer: &Renderer,
    folder: &OutputFolder,
    count: usize,
) -> Result<(), Failure> {
    let um_per_px = job.bench_settings().nominal_pixel_mm() * 1e3;
    let mut frames_csv = String::from(FRAMES_HEADER);
    let mut truth_csv = String::from("frame,column,top_px,bottom_px\n");
    let mut spare = None;
    for index in 0..count {
        let request = request(args, job, index);
        let (frame, mask) = renderer.render_masked(scene, &request, spare.take()).map_err(of_render)?;
        let stem = format!("{index:06}");
        let name = format!("frames/{stem}.{}", args.format.extension());
        put(folder, &name, encode(&frame, args.format, um_per_px))?;
        put(folder, &format!("previews/{stem}.png"), preview(&frame, um_per_px))?;
        if let Some(mask) = mask {
            // What contamination touches, as an 8-bit PNG: the sum of the bits of `contamination::mask`.
            put(folder, &format!("masks/{stem}.png"), encode_mask(&frame.view(), &mask, um_per_px))?;
        }
        describe(&mut frames_csv, &stem, &frame, um_per_px);
        let edges = truth::true_edges(scene, &request).map_err(of_render)?;
        for (column, e) in edges.iter().enumerate() {
            let _ = writeln!(truth_csv, "{stem},{column},{:.6},{:.6}", e.top_px, e.bottom_px);
        }
        spare = Some(frame);
    }
    put(folder, "frames.csv", Ok(frames_csv.into_bytes()))?;
    put(folder, "truth.csv", Ok(truth_csv.into_bytes()))?;
    put(folder, "truth.json", Ok(true_bench(scene).into_bytes()))
}

pub(super) fn describe(csv: &mut String, stem: &str, frame: &Frame, um_per_px: f64) {
    let meta = &frame.meta;
    let _ = writeln!(
        csv,
        "{stem},{},{:.6},{:.6},{},{},{um_per_px:.6}",
        meta.t_ns,
        meta.z_mm,
        meta.angle_deg,
        meta.exposure_us,
        frame.view().format().bit_depth()
    );
}

/// The true bench: what only truth may know.
fn true_bench(scene: &Scene) -> String {
    let bench = scene.bench();
    let json = serde_json::json!({
        "um_per_px": bench.pixel_mm * 1e3,
        "esf": bench.esf,
        "electrons_per_count": bench.electrons_per_count,
    });
    format!("{json:#}\n")
}

/// Writes a file of a folder, its name with the folders in it.
pub(super) fn put(folder: &OutputFolder, name: &str, bytes: Result<Vec<u8>, IoError>) -> Result<(), Failure> {
    let bytes = bytes.map_err(|e| Failure::fail(format!("{name}: cannot be written: {e}")))?;
    Ok(folder.write(name, &bytes)?)
}

pub(super) fn of_render(error: RenderError) -> Failure {
    match error {
        RenderError::Device { .. } | RenderError::NoAdapter { .. } => Failure::fail(error),
        _ => Failure::refuse(error),
    }
}
