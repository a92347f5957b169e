//! Pixels: from two lines of edges to widths, corrected for the pose of the axis, curvature and
//! blur.
//!
//! In: [`FrameEdges`](crate::gauge::FrameEdges). Out: widths and middles in px: per column, as
//! means over columns (`column_means`), or the largest caliper diameter of the frame
//! (`largest_caliper`, over the stretches of `stretch`). Factors for slope (`axis_pose`,
//! `axis_slope`), the bias of a curved flank (`curvature_bias`) and the share of the blur's
//! uncertainty (`blur_sensitivity`); `reused` is the memory of their lists.
//!
//! One more width is one more file: a function of `FrameEdges` that gives px with u. Nothing here
//! has millimetres.

pub(crate) mod axis_pose;
pub(crate) mod axis_slope;
pub(crate) mod blur_sensitivity;
pub(crate) mod column_means;
pub(crate) mod curvature_bias;
pub(crate) mod largest_caliper;
pub(crate) mod reused;
pub(crate) mod stretch;
