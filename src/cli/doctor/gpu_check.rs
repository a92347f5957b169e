//! `shadowgauge doctor --gpu-check`: a graphics adapter compared with the CPU twin, golden case by
//! golden case, and the time of a frame on both, beside that of a kernel that only writes a
//! constant.

use crate::config;
use crate::render::{BackendChoice, FrameRequest, RenderError, Renderer};
use crate::studies::golden_cases::{CASES, FrameDifference, GoldenCase, compare};

use crate::cli::failure::{CommandResult, Failure, Outcome};
use crate::cli::render::timing::{Timing, edge_windows, frames_of, timing};
use crate::cli::terminal::progress;

/// The timed cases: name, config and number of rows of two windows that are read out, if not the
/// whole sensor.
const TIMED: [(&str, &str, Option<u32>); 3] = [
    ("2048 x 2048, 12 bit, noise", include_str!("../../../configs/bench_2048.toml"), None),
    ("the same, two windows of 32 rows", include_str!("../../../configs/bench_2048.toml"), Some(32)),
    (
        "2048 x 2048, contamination and coherence",
        include_str!("../../../configs/bench_everything.toml"),
        None,
    ),
];

#[derive(Debug, serde::Serialize)]
struct Check {
    adapter: String,
    backend: String,
    cases: Vec<CaseCheck>,
    times: Vec<TimeCheck>,
}

#[derive(Debug, serde::Serialize)]
struct CaseCheck {
    case: &'static str,
    agrees: bool,
    #[serde(flatten)]
    difference: FrameDifference,
}

#[derive(Debug, serde::Serialize)]
struct TimeCheck {
    frame: &'static str,
    adapter_ms: f64,
    adapter_floor_ms: f64,
    twin_ms: f64,
    twin_floor_ms: f64,
}

/// Checks the adapter of `backend` over the golden cases and times `frames` frames of each kind.
///
/// # Errors
/// Exit 3 where there is no adapter (`auto`: no hardware adapter) or it fails during the check;
/// exit 1 where one of its frames differs from the twin's by more than a thousandth of a pixel.
pub(super) fn run(backend: BackendChoice, frames: usize, json: bool) -> CommandResult {
    let (device, twin) = (open(backend)?, Renderer::new(BackendChoice::Cpu).map_err(Failure::fail)?);
    let steps = CASES.len() + 2 * TIMED.len() * frames_of(frames);
    let bar = progress::bar(steps as u64, "comparing and timing", "frames");
    let done = || bar.inc(1);
    let cases = CASES.iter().map(|case| check_case(case, &device, &twin).inspect(|_| done()));
    let cases = cases.collect::<Result<_, _>>()?;
    let times = TIMED.iter().map(|timed| time(timed, frames, [&device, &twin], &done));
    let check = Check {
        adapter: device.adapter_name().into(),
        backend: device.backend_name().into(),
        cases,
        times: times.collect::<Result<_, _>>()?,
    };
    bar.finish_and_clear();
    if json {
        say_line!("{}", serde_json::to_string_pretty(&check).map_err(Failure::fail)?);
    } else {
        print(&check);
    }
    let agree = check.cases.iter().all(|case| case.agrees);
    Ok(if agree { Outcome::Done } else { Outcome::OutOfTolerance })
}

/// The adapter; a device that fails is an error here.
fn open(backend: BackendChoice) -> Result<Renderer, Failure> {
    let renderer = Renderer::new(backend).map_err(Failure::fail)?;
    if renderer.backend_name() == "cpu" {
        return Err(Failure::fail(
            "no hardware graphics adapter is here to be checked (`shadowgauge doctor` lists what is; \
             --backend vulkan|gl takes a software adapter, too)",
        ));
    }
    Ok(renderer.strict())
}

fn check_case(
    (name, text): &(&'static str, &'static str),
    device: &Renderer,
    twin: &Renderer,
) -> Result<CaseCheck, Failure> {
    let case: GoldenCase = config::parse_loose(text, name).map_err(Failure::fail)?;
    let difference = compare(&case, device, twin).map_err(|e| failed(name, &e))?;
    let agrees = difference.counts_agree() && difference.edges_agree();
    Ok(CaseCheck { case: name, agrees, difference })
}

fn time(
    (name, text, rows): &(&'static str, &'static str, Option<u32>),
    frames: usize,
    [device, twin]: [&Renderer; 2],
    done: &dyn Fn(),
) -> Result<TimeCheck, Failure> {
    let job = config::parse(text, name).map_err(Failure::fail)?;
    let scene = crate::cli::render::scene(&job)?;
    let whole = |index: usize| FrameRequest {
        frame_id: index as u64,
        z_mm: 0.5 * job.part.length_mm,
        noise: true,
        ..FrameRequest::default()
    };
    let windows = rows.map(|rows| edge_windows(&scene, &whole(0), rows)).transpose()?;
    let request = |index: usize| {
        let mut request = whole(index);
        if let Some([upper, lower]) = windows {
            (request.roi, request.second_roi) = (Some(upper), Some(lower));
        }
        request
    };
    let [adapter, cpu]: [Timing; 2] =
        [timing(device, &scene, (&request, frames), done)?, timing(twin, &scene, (&request, frames), done)?];
    Ok(TimeCheck {
        frame: name,
        adapter_ms: adapter.median(),
        adapter_floor_ms: adapter.floor(),
        twin_ms: cpu.median(),
        twin_floor_ms: cpu.floor(),
    })
}

fn failed(case: &str, error: &RenderError) -> Failure {
    Failure::fail(format!("golden case {case}: {error}"))
}

fn print(check: &Check) {
    say_line!("{} ({}) beside the CPU twin", check.adapter, check.backend);
    say_line!(
        "{:<24} {:>12} {:>8} {:>12} {:>12}",
        "golden case",
        "counts",
        "limit",
        "shift / px",
        "mean / px"
    );
    for CaseCheck { case, agrees, difference: d } in &check.cases {
        let word = if *agrees { "" } else { "  DIFFERS" };
        say_line!(
            "{case:<24} {:>12.1} {:>8.1} {:>12.1e} {:>12.1e}{word}",
            d.worst_counts,
            d.limit_counts,
            d.worst_shift_px,
            d.mean_shift_px
        );
    }
    say_line!("");
    say_line!("{:<42} {:>8} {:>8} {:>8} {:>8}", "ms a frame (median)", "adapter", "floor", "twin", "floor");
    for t in &check.times {
        say_line!(
            "{:<42} {:>8.2} {:>8.2} {:>8.2} {:>8.2}",
            t.frame,
            t.adapter_ms,
            t.adapter_floor_ms,
            t.twin_ms,
            t.twin_floor_ms
        );
    }
}
