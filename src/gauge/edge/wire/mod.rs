//! Shadows narrower than an edge's window: both edges are one fit.
//!
//! In: the plane of a frame, the part's contours from `image`, an edge-spread function. Out: the
//! same [`FrameEdges`](crate::gauge::FrameEdges) as of a wide part. `joint_fit` fits both edges,
//! levels and blur together; `rounding` states what whole counts repeat; `frame` runs them over one
//! frame and rejects as for other edges. One more cause of error of a thin shadow is one more file
//! with a function over the fitted wire.

pub(crate) mod clipped;
pub(crate) mod frame;
pub(crate) mod joint_fit;
pub(crate) mod rounding;
