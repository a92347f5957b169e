//! Several streams that take the frames of one camera in turn.
//!
//! A frame takes a fifth of a millisecond: to split it between threads costs as much in waking them
//! as it gains. Frames that lie in memory already are shared out whole instead. Which stream a
//! frame goes to depends on its number alone, so that the results do not depend on the number of
//! threads; a stream follows the part from each of its own frames to the next.

use std::num::NonZeroUsize;

use rayon::prelude::*;

use super::edge_stream::EdgeStream;
use crate::frame::FrameView;
use crate::gauge::edges::{FrameEdges, FrameRefused};

/// Streams that take frames in turn.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    lanes: Vec<Lane>,
    /// Frames taken so far.
    taken: usize,
}

/// One stream and the memory of its results.
#[derive(Clone, Debug)]
struct Lane {
    stream: EdgeStream,
    edges: FrameEdges,
}

impl Lanes {
    /// So many copies of a stream.
    pub(crate) fn of(stream: &EdgeStream, lanes: NonZeroUsize) -> Self {
        let lane = || Lane { stream: stream.clone().unsplit(), edges: FrameEdges::default() };
        Self { lanes: (0..lanes.get()).map(|_| lane()).collect(), taken: 0 }
    }

    /// Measures frames that follow those of the last call, on the threads of the pool that this is
    /// called in. Each result is lent to `take` by the thread that measured it, with the frame's
    /// index in `frames`; within a lane in the frames' order.
    pub(crate) fn measure(
        &mut self,
        frames: &[FrameView<'_>],
        take: impl Fn(usize, Result<&FrameEdges, FrameRefused>) + Sync,
    ) {
        let (count, taken) = (self.lanes.len(), self.taken);
        self.lanes.par_iter_mut().enumerate().with_max_len(1).for_each(|(number, Lane { stream, edges })| {
            let first = (number + count - taken % count) % count;
            for (index, frame) in frames.iter().enumerate().skip(first).step_by(count) {
                match stream.measure(frame, edges) {
                    Ok(()) => take(index, Ok(edges)),
                    Err(refused) => take(index, Err(refused)),
                }
            }
        });
        self.taken += frames.len();
    }
}
