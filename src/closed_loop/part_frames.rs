//! The frames of a pass themselves, for what is no diameter at a station: lengths, cones, radii.

use super::{ClosedLoop, LoopError};
use crate::frame::Frame;
use crate::gauge::FrameEdges;

impl ClosedLoop<'_> {
    /// Cuts the next pass and hands its frames to `each`, with their edges where the gauge finds
    /// any. No station is measured and nothing is decided: the pass stays the next one.
    ///
    /// # Errors
    /// Where the cut or the source fails.
    pub(crate) fn cut_and_look(
        &mut self,
        each: &mut dyn FnMut(&Frame, Option<&FrameEdges>),
    ) -> Result<(), LoopError> {
        let plan = self.plan();
        self.cell.cut(&plan)?;
        let mut stream = self.gauge.stream();
        let mut edges = FrameEdges::default();
        let mut source = self.cell.scan(&self.job.scan_plan())?;
        while let Some(frame) = source.next_frame()? {
            let measured = stream.measure(&frame.view(), &mut edges).is_ok();
            each(&frame, measured.then_some(&edges));
            source.recycle(frame);
        }
        Ok(())
    }
}
