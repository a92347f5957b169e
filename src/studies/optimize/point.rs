//! A choice of cutting data.

use serde::Serialize;

use crate::plan::CuttingData;

/// Cutting data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Point {
    /// Cutting speed, m/min.
    pub speed_m_per_min: f64,
    /// Feed, mm/r.
    pub feed_mm_per_rev: f64,
    /// Depth of cut, mm.
    pub depth_mm: f64,
}

impl Point {
    /// Feed and speed.
    pub(crate) fn cutting(&self) -> CuttingData {
        CuttingData { speed_m_per_min: self.speed_m_per_min, feed_mm_per_rev: self.feed_mm_per_rev }
    }
}
