//! One side of the shadow in one frame, stage by stage; both sides are worked on at the same time.
//!
//! `scan` (windows around the edges) → `survey` (levels, noise, ends of the grey scale) → `levels`
//! (pooled along the shaft) → `blur` (the width of the edge model) → `line` (edges, tested by
//! residual and neighbours). `model` and `tables` are what is fitted; `buffers` what all of it is
//! kept in. Each stage takes the values of those before it.

pub(crate) mod blur;
pub(crate) mod buffers;
pub(crate) mod levels;
pub(crate) mod line;
pub(crate) mod model;
pub(crate) mod scan;
pub(crate) mod survey;
pub(crate) mod tables;
