//! `shadowgauge render --bench`: how long a frame takes beside the floor of a kernel that only writes a constant, and
//! whether memory grows.

use std::time::Instant;

use crate::frame::{Frame, Roi};
use crate::job::Job;
use crate::render::{FrameRequest, Renderer, Scene};

use super::render::{RenderArgs, of_render, request, scene};
use super::{CommandResult, Failure, Outcome};

/// Frames drawn before the clock starts: pipelines are compiled and caches filled.
const WARM_UP: usize = 3;

/// Times in ms, sorted, and memory before and after.
struct Run {
    frames: Vec<f64>,
    floors: Vec<f64>,
    rss_mib: [Option<f64>; 2],
}

/// Draws `frames` frames without writing them and prints how long one takes.
///
/// # Errors
/// As `render`.
pub(super) fn bench(args: &RenderArgs, job: &Job, frames: usize) -> CommandResult {
    let scene = scene(job)?;
    let renderer = Renderer::new(args.backend).map_err(Failure::fail)?;
    let windows = match args.windows {
        Some(rows) => Some(edge_windows(&scene, &request(args, job, 0), rows)?),
        None => None,
    };
    let mut run = Run { frames: Vec::new(), floors: Vec::new(), rss_mib: [None; 2] };
    let mut spare: Option<Frame> = None;
    let mut floor_buffer = None;
    for index in 0..frames + WARM_UP {
        let mut request = request(args, job, index);
        if let Some([upper, lower]) = windows {
            (request.roi, request.second_roi) = (Some(upper), Some(lower));
        }
        if index == WARM_UP {
            run.rss_mib[0] = resident_mib();
        }
        let start = Instant::now();
        let frame = renderer.render(&scene, &request, spare.take()).map_err(of_render)?;
        let frame_ms = start.elapsed().as_secs_f64() * 1e3;
        let job = scene.job(&request).map_err(of_render)?;
        let start = Instant::now();
        floor_buffer = Some(renderer.draw_constant(&job, floor_buffer.take()).map_err(of_render)?);
        let floor_ms = start.elapsed().as_secs_f64() * 1e3;
        if index >= WARM_UP {
            run.frames.push(frame_ms);
            run.floors.push(floor_ms);
        }
        spare = Some(frame);
    }
    run.rss_mib[1] = resident_mib();
    run.frames.sort_by(f64::total_cmp);
    run.floors.sort_by(f64::total_cmp);
    let size = spare.map_or((0, 0), |f| (f.view().columns(), f.view().rows()));
    print(args, &run, &renderer, size);
    Ok(Outcome::Done)
}

fn print(args: &RenderArgs, run: &Run, renderer: &Renderer, (width, height): (usize, usize)) {
    let count = run.frames.len();
    let (median, floor) = (run.frames[count / 2], run.floors[count / 2]);
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
            "rss_end_mib": run.rss_mib[1],
        });
        println!("{report}");
        return;
    }
    println!(
        "{width} x {height} by {} ({}): {median:.2} ms a frame (best {:.2}), write floor {floor:.2} ms, ratio {:.2}",
        renderer.backend_name(),
        renderer.adapter_name(),
        run.frames[0],
        median / floor
    );
    if let [Some(start), Some(end)] = run.rss_mib {
        println!("resident memory {start:.1} MiB before, {end:.1} MiB after {count} frames");
    }
}

/// Windows of `rows` rows about the middle of either edge.
fn edge_windows(scene: &Scene, request: &FrameRequest, rows: u32) -> Result<[Roi; 2], Failure> {
    let edges = scene.geometric_edges(request).map_err(of_render)?;
    let all = scene.window(request).map_err(of_render)?;
    let about = |row: fn(&crate::render::columns::ColumnEdges) -> f64| {
        let (low, high) =
            edges.iter().map(row).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r), h.max(r)));
        let first = (0.5 * (low + high) - 0.5 * f64::from(rows)).round().max(0.0) as u32;
        Roi { row: first.min(all.rows.saturating_sub(rows)), column: 0, rows, columns: all.columns }
    };
    Ok([about(|e| e.top_px), about(|e| e.bottom_px)])
}

/// Memory of this process that stands in RAM, MiB, where the system tells.
fn resident_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kib| kib / 1024.0)
}
