//! A line segment.

use glam::DVec2;

/// A segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// Its ends, (column, −row) of the image.
    pub(super) ends: [DVec2; 2],
}

impl Segment {
    pub(super) fn middle(&self) -> DVec2 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    pub(super) fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }
}
