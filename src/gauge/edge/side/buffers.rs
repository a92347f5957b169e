//! The buffers of one side: each holds what its stage gave for the frame at hand, and the next
//! frame takes over the memory alone.

use super::levels::SideLevels;
use super::scan::ScanWindows;
use super::survey::SurveyBuffers;
use crate::gauge::edge::estimation::blur::BlurScratch;
use crate::gauge::edge::estimation::levels::LevelPool;
use crate::gauge::edge::image::part_localisation::CoarseEdge;
use crate::gauge::edge::image::scan_windows::Side;
use crate::gauge::edge::rejection::neighbour_test::OutlierScratch;

/// Buffers of one side, in the order of the stages.
#[derive(Clone, Debug)]
pub(crate) struct SideBuffers {
    pub(crate) scan: ScanWindows,
    pub(crate) survey: SurveyBuffers,
    pub(crate) pool: LevelPool,
    pub(crate) levels: SideLevels,
    pub(crate) blur: BlurScratch,
    pub(crate) fit: FitBuffers,
    /// Rows of the edges, where there are no gaps.
    pub(crate) rows: Vec<CoarseEdge>,
}

/// Buffers of the fit of a side's edges.
#[derive(Clone, Debug, Default)]
pub(crate) struct FitBuffers {
    pub(crate) normalised: Vec<f32>,
    pub(crate) floats: Vec<f32>,
    pub(crate) outliers: OutlierScratch,
}

impl SideBuffers {
    pub(crate) fn new(side: Side) -> Self {
        Self {
            scan: ScanWindows::new(side),
            survey: SurveyBuffers::default(),
            pool: LevelPool::default(),
            levels: SideLevels::default(),
            blur: BlurScratch::new(),
            fit: FitBuffers::default(),
            rows: Vec::new(),
        }
    }
}
