//! One frame to edges: where, in every column, the shadow begins and ends, with u of each.
//!
//! In: a [`FrameView`](crate::frame::FrameView) and [`GaugeSettings`](crate::gauge::GaugeSettings).
//! Out: [`FrameEdges`](crate::gauge::FrameEdges), two lines of edges in px with uncertainties,
//! states and reasons of gaps.
//!
//! The stages of a frame, each a function of the values before it: `locate` (where the part is) →
//! `frame_windows` (scan windows, `frame_survey` of levels and noise, blur) → `frame_lines` (the
//! edge lines of both sides; `side` holds the stages of one) → `acceptance`; `wire` instead of them
//! for a thin shadow. `stream` runs them over a frame and the frames that follow it.
//!
//! From below: `model` (the edge-spread function) → `image` (where in the frame it is) →
//! `estimation` (levels, noise, blur, the fit of every column) → `rejection` (edges that are not
//! those of the part), `refusals` (frames refused, in words) → `locate` → `wire`, `side` → `rings`,
//! `rounded_frame`, `frame_survey` → `frame_windows`, `frame_lines`, `acceptance` → `stream` →
//! `narrow` (line cameras) → `edge_stream` (either camera) → `parallel` (frames shared out);
//! `room`: what an edge needs, before a frame is taken.
//!
//! One more step of a frame is a file in the room to which it belongs and one call in the stage to
//! which it belongs; it is a function of values. Imports run in the order above.

pub(crate) mod acceptance;
pub(crate) mod both_sides;
pub(crate) mod edge_stream;
pub(crate) mod estimation;
pub(crate) mod frame_lines;
pub(crate) mod frame_survey;
pub(crate) mod frame_windows;
pub(crate) mod image;
pub(crate) mod locate;
pub(crate) mod model;
pub(crate) mod narrow;
pub(crate) mod parallel;
pub(crate) mod refusals;
pub(crate) mod rejection;
pub(crate) mod rings;
pub(crate) mod room;
pub(crate) mod rounded_frame;
pub(crate) mod settled;
pub(crate) mod side;
pub(crate) mod stream;
pub(crate) mod stream_settings;
pub(crate) mod wire;
