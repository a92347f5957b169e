//! One frame to edges: where, in every column, the shadow begins and ends, with u of each.
//!
//! In: a [`FrameView`](crate::frame::FrameView) and [`GaugeSettings`](crate::gauge::GaugeSettings). Out:
//! [`FrameEdges`](crate::gauge::FrameEdges), two lines of edges in px with uncertainties, states and reasons of gaps.
//!
//! From below: `model` (what an edge looks like) and `image` (where in the frame it is) → `estimation` (levels, noise, blur, the fit of
//! every column) → `rejection` (what is no part of the shaft) → `side` (one side of the shadow), `wire` (both edges at once) → `stream`
//! (a frame, and the frames that follow it), `narrow` (line cameras), `parallel`. A further step of a frame is a file in the room whose
//! question it answers and one call in `stream` or `side`; it takes values and gives values.

pub(crate) mod acceptance;
pub(crate) mod both_sides;
pub(crate) mod edge_stream;
pub(crate) mod estimation;
pub(crate) mod image;
pub(crate) mod model;
pub(crate) mod narrow;
pub(crate) mod parallel;
mod refusals;
pub(crate) mod rejection;
pub(crate) mod rings;
pub(crate) mod rounded_frame;
pub(crate) mod scene;
pub(crate) mod side;
pub(crate) mod stream;
pub(crate) mod wire;
