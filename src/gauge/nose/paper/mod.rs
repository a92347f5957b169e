//! The nose as the paper on tool wear measures it (Zhang, Lu, Xia, Zhang, Zhu 2025), for comparison
//! with the measurement beside this folder: Canny's edges, two lines by LSD's growing of regions on
//! them, their angle forced to the insert's, the centre at the nominal radius from both, the mean
//! distance of the edge's pixels from it.
//!
//! In: a frame, the nominal radius and the included angle. Out: [`PaperNose`] in px, without
//! uncertainties, since the paper states none. `edges` is Canny's detector, `segments` the growing
//! of regions with the threshold and the false alarms of `false_alarms`, `forced` turns a line,
//! `centres` is equation 10, `measurement` puts them together. What the paper leaves out (Canny's
//! thresholds, the limit of false alarms, the step by which a line turns) stands with its reason in
//! `limits`.

mod centres;
mod edges;
mod false_alarms;
mod forced;
mod gradients;
pub(crate) mod limits;
mod measurement;
mod rectangle;
mod region;
mod segment;
mod segments;

pub(crate) use centres::{Line, centres};
pub(crate) use false_alarms::{aligned_needed, binomial_tail, gradient_threshold, tests};
pub(crate) use measurement::{PaperNose, PaperSettings, measure_paper_nose};
