//! One frame to edges: where, in every column, the shadow begins and ends, with u of each.
//!
//! In: a [`FrameView`](crate::frame::FrameView) and [`GaugeSettings`](crate::gauge::GaugeSettings).
//! Out: [`FrameEdges`](crate::gauge::FrameEdges), two lines of edges in px with uncertainties,
//! states and reasons of gaps.
//!
//! From below: `model` (the edge-spread function) → `image` (where in the frame it is) →
//! `estimation` (levels, noise, blur, the fit of every column) → `rejection` (edges that are not
//! those of the part), `refusals` (frames refused, in words) → `wire` (both edges of a thin
//! shadow), `side` (one side of a wide one) → `rounded_frame`, `rings`, `frame_survey` (both sides)
//! → `acceptance`, `stream` (a frame, and the frames that follow it) → `narrow` (line cameras) →
//! `edge_stream` (either camera) → `parallel` (frames shared out).
//!
//! One more step of a frame is a file in the room to which it belongs and one call in `stream` or
//! `side`; it is a function of values. Imports run in the order above.

pub(crate) mod acceptance;
pub(crate) mod both_sides;
pub(crate) mod edge_stream;
pub(crate) mod estimation;
pub(crate) mod frame_survey;
pub(crate) mod image;
pub(crate) mod model;
pub(crate) mod narrow;
pub(crate) mod parallel;
pub(crate) mod refusals;
pub(crate) mod rejection;
pub(crate) mod rings;
pub(crate) mod rounded_frame;
pub(crate) mod settled;
pub(crate) mod side;
pub(crate) mod side_parts;
pub(crate) mod stream;
pub(crate) mod wire;
