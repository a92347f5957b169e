//! `shadowgauge render`: frames of a config's shaft with their truth, or how long a frame takes.
//!
//! In: a job, or a calibration with `[simulate]` (`calibration`), or `--gallery` (`gallery`,
//! `gallery_cases`, `label_font`). Out: a folder of frames in one of the formats of `frame_files`,
//! with `frames.csv` and the truth (`folder_files`); with `--bench` times alone (`timing`). `args`
//! holds the arguments, the scene and the frame requests. A new kind of output is a file beside
//! these with an entry in [`run`]; no file imports this one.

mod args;
mod calibration;
mod folder_files;
pub(crate) mod frame_files;
mod gallery;
mod gallery_cases;
mod label_font;
pub(super) mod timing;

pub(crate) use args::RenderArgs;
pub(super) use args::scene;

use std::fmt::Write as _;
use std::path::Path;

use crate::config;
use crate::files::OutputFolder;
use crate::job::Job;
use crate::render::{Renderer, Scene, geometric_edges};
use crate::truth;

use self::args::request;
use self::folder_files::of_render;
use self::folder_files::{FRAMES_HEADER, describe, put};
use self::frame_files::{encode, encode_mask, preview};
use self::gallery::gallery;
use self::timing::benchmark;
use super::calibration_plan::is_plan;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::input_output::ConfigText;
use crate::cli::terminal::progress;

/// Renders the frames of a config.
///
/// # Errors
/// Exit 2 for a config, a command line or an output folder that is refused; 3 for a device or a
/// disk that fails.
pub(crate) fn run(args: &RenderArgs) -> CommandResult {
    if let Some(folder) = &args.gallery {
        return gallery(args, folder);
    }
    let Some(file) = &args.config else {
        return Err(Failure::refuse("a config or --gallery DIR is needed"));
    };
    if is_plan(&ConfigText::read(file)?.text) {
        return calibration::run(args, file);
    }
    let job = config::load_scene(file).map_err(Failure::refused)?;
    if args.threads == Some(0) || args.bench == Some(0) || args.frames == Some(0) {
        return Err(Failure::refuse("--threads, --bench and --frames take numbers of at least 1"));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.unwrap_or(0))
        .build()
        .map_err(Failure::fail)?;
    pool.install(|| match (args.bench, &args.out) {
        (Some(frames), _) => benchmark(args, &job, frames),
        (None, Some(out)) => write_folder(args, &job, out),
        (None, None) => Err(Failure::refuse("--out DIR or --bench N is needed")),
    })
}

// ---- frames to a folder

fn write_folder(args: &RenderArgs, job: &Job, out: &Path) -> CommandResult {
    let scene = scene(job)?;
    let count = args.frames.unwrap_or_else(|| job.loop_job().scan_plan().frames());
    for index in 0..count.min(job.loop_job().scan_plan().frames()) {
        geometric_edges(&scene, &request(args, job, index)).map_err(Failure::refuse)?;
    }
    let folder = OutputFolder::claim(out)?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    Series { args, job, scene: &scene, count }.write(&renderer, &folder)?;
    folder.finish()?;
    say_line!(
        "{count} frames by {} ({}) in {}",
        renderer.backend_name(),
        renderer.adapter_name(),
        out.display()
    );
    Ok(Outcome::Done)
}

/// Frames that are drawn into a folder.
struct Series<'a> {
    args: &'a RenderArgs,
    job: &'a Job,
    scene: &'a Scene,
    count: usize,
}

impl Series<'_> {
    fn write(&self, renderer: &Renderer, folder: &OutputFolder) -> Result<(), Failure> {
        let Self { args, job, scene, count } = *self;
        let um_per_px = job.setup_settings().nominal_pixel_mm() * 1e3;
        let mut frames_csv = String::from(FRAMES_HEADER);
        let mut truth_csv = String::from("frame,column,top_px,bottom_px\n");
        let mut spare = None;
        let bar = progress::bar(count as u64, "drawing", "frames");
        for index in 0..count {
            let request = request(args, job, index);
            let (frame, mask) = renderer.render_masked(scene, &request, spare.take()).map_err(of_render)?;
            let stem = format!("{index:06}");
            let name = format!("frames/{stem}.{}", args.format.extension());
            put(folder, &name, encode(&frame, args.format, um_per_px))?;
            put(folder, &format!("previews/{stem}.png"), preview(&frame, um_per_px))?;
            if let Some(mask) = mask {
                // The mask of the contamination as an 8-bit PNG: the sum of the bits of
                // `contamination::mask`.
                put(folder, &format!("masks/{stem}.png"), encode_mask(&frame.view(), &mask, um_per_px))?;
            }
            describe(&mut frames_csv, &stem, &frame, um_per_px);
            let edges = truth::true_edges(scene, &request).map_err(of_render)?;
            for (column, e) in edges.iter().enumerate() {
                let _ = writeln!(truth_csv, "{stem},{column},{:.6},{:.6}", e.top_px, e.bottom_px);
            }
            spare = Some(frame);
            bar.inc(1);
        }
        bar.finish_and_clear();
        put(folder, "frames.csv", Ok(frames_csv.into_bytes()))?;
        put(folder, "truth.csv", Ok(truth_csv.into_bytes()))?;
        put(folder, "truth.json", Ok(true_setup(scene).into_bytes()))
    }
}

/// The true optical setup, which only the truth may contain.
fn true_setup(scene: &Scene) -> String {
    let setup = scene.setup();
    let json = serde_json::json!({
        "um_per_px": setup.pixel_mm * 1e3,
        "esf": setup.esf,
        "electrons_per_count": setup.electrons_per_count,
    });
    format!("{json:#}\n")
}
