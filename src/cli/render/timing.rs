//! `shadowgauge render --bench`: the time of a frame beside that of a kernel that only writes a
//! constant, and the growth of memory.

use std::time::Instant;

use crate::frame::{Frame, Roi};
use crate::job::Job;
use crate::render::{FrameRequest, Renderer, Scene, frame_job, geometric_edges};

use super::args::{RenderArgs, request, scene};
use super::folder_files::of_render;
use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::terminal::progress;

/// Frames drawn before the clock starts: pipelines are compiled and caches filled.
const WARM_UP: usize = 3;

/// Frames after which memory is measured a second time.
const RSS_AFTER: usize = 1000;

/// Times in ms, sorted, memory before the first frame, after [`RSS_AFTER`] of them and after the
/// last, and the size of a frame, pixels.
pub(crate) struct Timing {
    frames: Vec<f64>,
    floors: Vec<f64>,
    rss_mib: [Option<f64>; 3],
    columns_rows: (usize, usize),
}

impl Timing {
    /// Median time of a frame, ms.
    pub(crate) fn median(&self) -> f64 {
        self.frames[self.frames.len() / 2]
    }

    /// Median time of the write floor, ms.
    pub(crate) fn floor(&self) -> f64 {
        self.floors[self.floors.len() / 2]
    }
}

/// Draws `frames` frames without writing them and prints how long one takes.
///
/// # Errors
/// As `render`.
pub(super) fn benchmark(args: &RenderArgs, job: &Job, frames: usize) -> CommandResult {
    let scene = scene(job)?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let windows = match args.windows {
        Some(rows) => Some(edge_windows(&scene, &request(args, job, 0), rows)?),
        None => None,
    };
    let request = |index: usize| {
        let mut request = request(args, job, index);
        if let Some([upper, lower]) = windows {
            (request.roi, request.second_roi) = (Some(upper), Some(lower));
        }
        request
    };
    let bar = progress::bar(frames_of(frames) as u64, "drawing", "frames");
    let timing = timing(&renderer, &scene, (&request, frames), &|| bar.inc(1))?;
    bar.finish_and_clear();
    print(args, &timing, &renderer);
    Ok(Outcome::Done)
}

/// Frames that [`timing`] draws in all.
pub(crate) fn frames_of(frames: usize) -> usize {
    frames + WARM_UP
}

/// Times at least one frame, each beside the write floor of its buffers; `done` is called after
/// each, while no clock runs.
///
/// # Errors
/// As `render`.
pub(crate) fn timing(
    renderer: &Renderer,
    scene: &Scene,
    (request, frames): (&dyn Fn(usize) -> FrameRequest, usize),
    done: &dyn Fn(),
) -> Result<Timing, Failure> {
    // Allocated beforehand: the record of the times must not look like a leak.
    let unknown = || vec![f64::NAN; frames];
    let mut run = Timing { frames: unknown(), floors: unknown(), rss_mib: [None; 3], columns_rows: (0, 0) };
    let mut spare: Option<Frame> = None;
    for index in 0..frames_of(frames) {
        if index == WARM_UP {
            run.rss_mib[0] = resident_mib();
        }
        let (frame_ms, floor_ms, frame) = one(renderer, scene, &request(index), spare.take())?;
        if let Some(timed) = index.checked_sub(WARM_UP) {
            (run.frames[timed], run.floors[timed]) = (frame_ms, floor_ms);
        }
        if index == WARM_UP + RSS_AFTER {
            run.rss_mib[1] = resident_mib();
        }
        spare = Some(frame);
        done();
    }
    run.rss_mib[2] = resident_mib();
    run.frames.sort_by(f64::total_cmp);
    run.floors.sort_by(f64::total_cmp);
    run.columns_rows = spare.map_or((0, 0), |f| (f.view().columns(), f.view().rows()));
    Ok(run)
}

/// A frame, its time and that of the write floor in the same buffers, ms.
fn one(
    renderer: &Renderer,
    scene: &Scene,
    request: &FrameRequest,
    spare: Option<Frame>,
) -> Result<(f64, f64, Frame), Failure> {
    let ms = |start: Instant| start.elapsed().as_secs_f64() * 1e3;
    let start = Instant::now();
    let job = frame_job(scene, request, false).map_err(of_render)?;
    let buffer = renderer.draw(&job, spare.map(Frame::into_buffer)).map_err(of_render)?;
    let frame_ms = ms(start);
    let start = Instant::now();
    let buffer = renderer.draw_constant(&job, Some(buffer)).map_err(of_render)?;
    let floor_ms = ms(start);
    let (rows, columns) = (job.params.size.rows as usize, job.params.size.columns as usize);
    let frame =
        Frame::new(buffer, job.format, rows, columns, scene.setup().meta(request)).map_err(Failure::fail)?;
    scene.setup().give_back(job);
    Ok((frame_ms, floor_ms, frame))
}

fn print(args: &RenderArgs, run: &Timing, renderer: &Renderer) {
    let count = run.frames.len();
    let ((width, height), median, floor) = (run.columns_rows, run.median(), run.floor());
    if args.json {
        let report = serde_json::json!({
            "ms_per_frame_min": run.frames[0],
            "ms_per_frame_median": median,
            "floor_ms_median": floor,
            "ratio": median / floor,
            "backend": renderer.backend_name(),
            "adapter": renderer.adapter_name(),
            "width": width,
            "height": height,
            "frames": count,
            "threads": rayon::current_num_threads(),
            "rss_start_mib": run.rss_mib[0],
            "rss_after_1000_frames_mib": run.rss_mib[1],
            "rss_end_mib": run.rss_mib[2],
        });
        say_line!("{report}");
        return;
    }
    say_line!(
        "{width} x {height} by {} ({}): {median:.2} ms a frame (best {:.2}), write floor {floor:.2} ms, ratio {:.2}",
        renderer.backend_name(),
        renderer.adapter_name(),
        run.frames[0],
        median / floor
    );
    if let [Some(start), after, Some(end)] = run.rss_mib {
        let after = after.map_or(String::new(), |mib| format!(" {mib:.1} MiB after {RSS_AFTER},"));
        say_line!("resident memory {start:.1} MiB before,{after} {end:.1} MiB after {count} frames");
    }
}

/// Windows of `rows` rows about the middle of either edge.
pub(crate) fn edge_windows(scene: &Scene, request: &FrameRequest, rows: u32) -> Result<[Roi; 2], Failure> {
    let edges = geometric_edges(scene, request).map_err(of_render)?;
    let all = scene.setup().windows(request).map_err(of_render)?.first;
    let about = |row: fn(&crate::render::kernel::column_edges::ColumnEdges) -> f64| {
        let (low, high) =
            edges.iter().map(row).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r), h.max(r)));
        let first = (0.5 * (low + high) - 0.5 * f64::from(rows)).round().max(0.0) as u32;
        Roi { row: first.min(all.rows.saturating_sub(rows)), column: 0, rows, columns: all.columns }
    };
    Ok([about(|e| e.top_px), about(|e| e.bottom_px)])
}

/// Resident memory of this process, MiB, where the system reports it.
fn resident_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kib| kib / 1024.0)
}
