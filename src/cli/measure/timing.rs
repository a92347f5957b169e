//! `measure --bench`: the time to find the edges of a frame from memory, and what all results of a
//! series take beside it; with several threads also their speed-up, beside that of independent
//! streams on the same machine.

use std::num::NonZeroUsize;
use std::time::Instant;

use serde_json::{Value, json};

use crate::frame::{FrameMeta, FrameView};
use crate::gauge::{EdgeStream, FrameEdges, FrameRefused, Gauge, Lanes};
use crate::measurement::Stream;
use crate::numerics::robust::median_of;

/// Number of rounds, in which the ways of using the threads alternate.
const ROUNDS: usize = 15;
const FRAMES: usize = 256;

/// Times `count` frames in one new stream of edges, on the threads of the calling pool; `whole` is
/// a stream of the same gauge that gives all results of the command.
pub(super) fn benchmark(gauge: &Gauge, whole: Stream, frames: &[FrameView<'_>], count: u32) -> Value {
    let mut stream = gauge.stream();
    let mut edges = FrameEdges::default();
    let (mut times, mut found) = (Vec::with_capacity(count as usize), 0);
    for frame in frames.iter().cycle().take(count as usize) {
        let start = Instant::now();
        let measured = stream.measure(frame, &mut edges);
        times.push(start.elapsed().as_secs_f64() * 1e3);
        if measured.is_ok() {
            found = edges.top.iter().chain(&edges.bottom).filter(|e| e.is_usable()).count();
        }
    }
    let first = times.first().copied();
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times.get((times.len() as f64 * share) as usize).copied();
    let threads = rayon::current_num_threads();
    let mut out = json!({
        "ms_per_frame_min": times.first(),
        "ms_per_frame_median": at(0.5),
        "ms_per_frame_p99": at(0.99),
        "first_frame_ms": first,
        "edges": found,
        "threads": threads,
        "results_over_edges": results_over_edges(gauge, whole, frames),
    });
    if threads > 1
        && !frames.is_empty()
        && let Some(out) = out.as_object_mut()
    {
        let gains = compare(gauge, frames, threads);
        out.insert("speedup".to_owned(), json!(gains.of_lanes));
        out.insert("speedup_within_a_frame".to_owned(), json!(gains.within_a_frame));
        out.insert("speedup_of_independent_streams".to_owned(), json!(gains.of_independent_streams));
    }
    out
}

/// Time of a frame with all its results over that of its edges alone: the median of rounds in which
/// the two alternate. `None` without a frame.
fn results_over_edges(gauge: &Gauge, mut whole: Stream, frames: &[FrameView<'_>]) -> Option<f64> {
    let (mut worker, meta) = (Worker::new(gauge), FrameMeta::default());
    let mut ratios = Vec::with_capacity(ROUNDS);
    // Upright parts are views laid level already, as the stream of edges is given them.
    for _ in 0..if frames.is_empty() { 0 } else { ROUNDS } {
        let start = Instant::now();
        worker.run(frames);
        let edges_s = start.elapsed().as_secs_f64();
        let start = Instant::now();
        for frame in frames.iter().cycle().take(FRAMES) {
            let _ = whole.push_prepared("", &meta, frame);
        }
        ratios.push(start.elapsed().as_secs_f64() / edges_s);
    }
    (!ratios.is_empty()).then(|| median_of(ratios))
}

/// Speed-up of several threads over one, medians over rounds.
struct Gains {
    /// Lanes that take the frames in turn: time with one thread over time with all.
    of_lanes: f64,
    /// One stream each of whose frames is shared between the threads.
    within_a_frame: f64,
    /// As many independent streams as threads: the limit of this machine's cores, caches and
    /// memory.
    of_independent_streams: f64,
}

/// A stream with its output buffer.
struct Worker {
    stream: EdgeStream,
    edges: FrameEdges,
}

impl Worker {
    fn new(gauge: &Gauge) -> Self {
        Self { stream: gauge.stream(), edges: FrameEdges::default() }
    }

    fn run(&mut self, frames: &[FrameView<'_>]) {
        for frame in frames.iter().cycle().take(FRAMES) {
            // A refused frame takes its time as well.
            let _ = self.stream.measure(frame, &mut self.edges);
        }
    }
}

fn compare(gauge: &Gauge, frames: &[FrameView<'_>], threads: usize) -> Gains {
    let mut shared = Worker::new(gauge);
    let mut lanes = Lanes::new(gauge, NonZeroUsize::new(threads).unwrap_or(NonZeroUsize::MIN));
    let queue: Vec<FrameView<'_>> = frames.iter().cycle().take(FRAMES).copied().collect();
    let looked_at = |_, _: Result<&FrameEdges, FrameRefused>| {};
    lanes.measure(&queue, looked_at);
    let mut alone: Vec<Worker> = (0..threads).map(|_| Worker::new(gauge)).collect();
    shared.run(frames);
    alone.iter_mut().for_each(|worker| worker.run(frames));
    let (mut in_turn, mut within, mut independent) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let single = seconds(|| at_once(&mut alone[..1], frames));
        let turns = seconds(|| lanes.measure(&queue, looked_at));
        let together = seconds(|| shared.run(frames));
        let apart = seconds(|| at_once(&mut alone, frames));
        in_turn.push(single / turns);
        within.push(single / together);
        independent.push(threads as f64 * single / apart);
    }
    Gains {
        of_lanes: median_of(in_turn),
        within_a_frame: median_of(within),
        of_independent_streams: median_of(independent),
    }
}

/// Runs each worker on its own thread, outside the pool.
fn at_once(workers: &mut [Worker], frames: &[FrameView<'_>]) {
    std::thread::scope(|scope| {
        for worker in workers {
            scope.spawn(|| worker.run(frames));
        }
    });
}

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}
