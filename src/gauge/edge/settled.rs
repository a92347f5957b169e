//! A stream whose first readings of a line camera wait until there are enough to measure them by.
//!
//! A line camera's first reading shows levels, noise and width of the edge by its own pixels alone;
//! a picture of thirty-two readings shows all of these to a fifth of that. Where no one needs a
//! reading at once (a scan, a master pin), the first ones wait until the picture is full, are
//! measured anew in it, and count like those that follow. An area camera's frames wait for nothing.

use super::edge_stream::EdgeStream;
use super::estimation::model_bias::ResidualAccumulator;
use crate::frame::FrameView;
use crate::gauge::edges::{FrameEdges, FrameRefused};
use crate::gauge::settings::GaugeSettings;

/// A reading that waits: what belongs to it, and its edges as the first look gave them.
#[derive(Clone, Debug)]
struct Waiting<T> {
    tag: T,
    edges: FrameEdges,
}

/// A stream of frames that gives every frame's edges once they are settled, together with what
/// belongs to the frame.
#[derive(Clone, Debug)]
pub(crate) struct SettledStream<T> {
    stream: EdgeStream,
    waiting: Vec<Waiting<T>>,
    /// Whether readings wait at all, or any more.
    waits: bool,
}

impl<T> SettledStream<T> {
    /// A stream whose first readings wait.
    pub(crate) fn new(stream: EdgeStream) -> Self {
        Self { stream, waiting: Vec::new(), waits: true }
    }

    /// A stream that gives every frame at once, for those who act on it.
    pub(crate) fn at_once(stream: EdgeStream) -> Self {
        Self { waits: false, ..Self::new(stream) }
    }

    /// Measures a frame into `edges`, as a stream does, and gives what is settled: this frame, or,
    /// of a line camera, all that waited once the picture of them is full.
    ///
    /// # Errors
    /// As [`EdgeStream::measure`]; nothing is given then.
    pub(crate) fn measure(
        &mut self,
        view: &FrameView<'_>,
        edges: &mut FrameEdges,
        tag: T,
        mut give: impl FnMut(T, &FrameEdges),
    ) -> Result<(), FrameRefused> {
        if !self.waiting.is_empty() && !self.stream.narrow.as_ref().is_some_and(|n| n.fits(view)) {
            self.settle(&mut give);
        }
        self.stream.measure(view, edges)?;
        let full = match &self.stream.narrow {
            Some(narrow) if self.waits && narrow.fits(view) => narrow.is_full_for(view.columns()),
            _ => {
                give(tag, edges);
                return Ok(());
            }
        };
        self.waiting.push(Waiting { tag, edges: edges.clone() });
        if full {
            self.settle(&mut give);
            self.waits = false;
        }
        Ok(())
    }

    /// Gives what still waits: fewer readings than a picture has.
    pub(crate) fn finish(&mut self, mut give: impl FnMut(T, &FrameEdges)) {
        self.settle(&mut give);
    }

    /// Measures the readings that wait in the picture of all of them, and gives them in their
    /// order.
    fn settle(&mut self, give: &mut impl FnMut(T, &FrameEdges)) {
        let waiting = std::mem::take(&mut self.waiting);
        let columns = waiting.iter().map(|w| w.edges.columns()).sum::<usize>();
        let settled = self.stream.narrow.as_mut().is_some_and(|narrow| narrow.settle(columns));
        let mut first = 0;
        for Waiting { tag, mut edges } in waiting {
            let columns = edges.columns();
            if let Some(narrow) = self.stream.narrow.as_ref().filter(|_| settled) {
                narrow.give(first..first + columns, &mut edges);
            }
            first += columns;
            give(tag, &edges);
        }
    }

    /// The settings it measures by.
    pub(crate) fn settings(&self) -> &GaugeSettings {
        self.stream.settings()
    }

    /// As [`EdgeStream::accumulate`], for the frame measured last; of a line camera once for every
    /// picture of readings, so that no reading counts twice.
    pub(crate) fn accumulate(&mut self, residuals: &mut ResidualAccumulator, measured: &FrameEdges) {
        self.stream.accumulate(residuals, measured);
    }
}
