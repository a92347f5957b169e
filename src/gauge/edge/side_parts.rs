//! What a side of the silhouette carries beside its windows, levels and edge-spread function:
//! figures of the frame, the kind of its columns, and memory.

use super::estimation::side_survey::SideSurvey;
use super::rejection::neighbour_test::OutlierScratch;
use crate::gauge::edge::estimation::blur::BlurScratch;
use crate::gauge::edge::estimation::levels::LevelPool;
use crate::gauge::edge::estimation::scoring_table::Table;
use crate::gauge::edge::image::part_localisation::CoarseEdge;
use crate::gauge::limit::limits;

limits! {
    /// Memory of the scoring tables that a side keeps.
    TableLimits = "tables";
    /// Memory of the tables kept, bytes, at least. Within these bounds there is one for each pixel
    /// of the frame, since steep edges need many tables.
    least_bytes: usize = 1 << 20;
    /// Memory of the tables kept, bytes, at most: both sides' stay within the last cache of a small
    /// computer.
    most_bytes: usize = 4 << 20;
}

/// What the frame states of the side beside its edges.
#[derive(Clone, Debug)]
pub(crate) struct SideFigures {
    pub(crate) reduced_chi2: f64,
    pub(crate) survey: SideSurvey,
    /// Largest step between neighbouring edges, px; infinite with gaps.
    pub(crate) jump: f64,
    /// Rows of the edges, where there are no gaps.
    pub(crate) rows: Vec<CoarseEdge>,
    /// Standard uncertainty by a systematic residual of the edge model, px, one for every block of
    /// columns.
    pub(crate) model_uncertainty_px: Vec<f32>,
    /// Standard uncertainty of an edge by what is clipped of its shape, px.
    pub(crate) clipped_px: f64,
}

impl Default for SideFigures {
    fn default() -> Self {
        Self {
            reduced_chi2: 1.0,
            survey: SideSurvey::default(),
            jump: f64::INFINITY,
            rows: Vec::new(),
            model_uncertainty_px: Vec::new(),
            clipped_px: 0.0,
        }
    }
}

/// What neighbouring columns and their grey values are.
#[derive(Clone, Debug, Default)]
pub(crate) struct ColumnKind {
    /// Whether neighbouring columns are readings one after the other: where their edges lie states
    /// nothing of a slope.
    pub(crate) level_lines: bool,
    /// Whether columns are copies of one another: their grey values pile up wherever they lie, and
    /// are alike in every row as a stuck row's.
    pub(crate) copies: bool,
    /// Whether grey values have their signs turned: a lit part before a dark ground.
    pub(crate) turned: bool,
}

/// Memory that is kept from frame to frame.
#[derive(Clone, Debug)]
pub(super) struct Workspace {
    /// Blur for which the windows were laid out, px.
    pub(super) laid_out: f64,
    pub(super) tables: Vec<Table>,
    /// Memory that the tables may take, bytes.
    pub(super) most_table_bytes: usize,
    pub(super) normalised: Vec<f32>,
    pub(super) floats: Vec<f32>,
    pub(super) differences: Vec<f32>,
    pub(super) outliers: OutlierScratch,
    pub(super) pool: LevelPool,
    pub(super) blur_scratch: BlurScratch,
}

impl Default for Workspace {
    fn default() -> Self {
        Self {
            laid_out: 1.0,
            tables: Vec::new(),
            most_table_bytes: TableLimits::get().least_bytes,
            normalised: Vec::new(),
            floats: Vec::new(),
            differences: Vec::new(),
            outliers: OutlierScratch::default(),
            pool: LevelPool::default(),
            blur_scratch: BlurScratch::new(),
        }
    }
}
