//! Several streams that take the frames of one camera in turn.
//!
//! A frame takes a fifth of a millisecond: to split it between threads costs as much in waking them as it gains. Frames that lie in memory
//! already are shared out whole instead. Which stream a frame goes to depends on its number alone, so that the results do not depend on the
//! number of threads; a stream follows the part from each of its own frames to the next.

use std::num::NonZeroUsize;

use rayon::prelude::*;

use super::Gauge;
use super::edges::{FrameEdges, FrameRefused};
use super::finder::EdgeStream;
use crate::frame::FrameView;

/// What came of one frame: its edges, or why there are none.
pub type MeasuredFrame = Result<FrameEdges, FrameRefused>;

/// Streams that take frames in turn.
#[derive(Clone, Debug)]
pub struct Lanes {
    streams: Vec<EdgeStream>,
    /// Frames taken so far.
    taken: usize,
}

impl Lanes {
    /// As many streams as said, usually one a core. The number belongs to the measurement, not to the machine: another number gives results
    /// that differ as those of two streams do, by thousandths of the noise.
    pub fn new(gauge: &Gauge, lanes: NonZeroUsize) -> Self {
        Self { streams: (0..lanes.get()).map(|_| gauge.stream()).collect(), taken: 0 }
    }

    /// Measures frames that follow those of the last call into `out`, in their order, on the threads of the pool that this is called in.
    /// `out` keeps its memory from call to call.
    pub fn measure(&mut self, frames: &[FrameView<'_>], out: &mut Vec<MeasuredFrame>) {
        let lanes = self.streams.len();
        out.resize_with(frames.len(), || Ok(FrameEdges::default()));
        let mut shares: Vec<(&mut EdgeStream, Vec<_>)> =
            self.streams.iter_mut().map(|stream| (stream, Vec::new())).collect();
        for (index, job) in frames.iter().zip(out.iter_mut()).enumerate() {
            shares[(self.taken + index) % lanes].1.push(job);
        }
        shares.into_par_iter().for_each(|(stream, jobs)| {
            for (frame, out) in jobs {
                measure_into(stream, frame, out);
            }
        });
        self.taken += frames.len();
    }
}

fn measure_into(stream: &mut EdgeStream, frame: &FrameView<'_>, out: &mut MeasuredFrame) {
    let mut edges = std::mem::replace(out, Ok(FrameEdges::default())).unwrap_or_default();
    *out = stream.measure(frame, &mut edges).map(|()| edges);
}
