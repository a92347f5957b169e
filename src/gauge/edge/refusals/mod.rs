//! Frames refused, in words: what was seen instead of a part, and what would help.
//!
//! In: what a search or a test found wrong (a reason, rows, grey values). Out: a
//! [`FrameRefused`](crate::gauge::FrameRefused) whose text names the cause in the user's terms;
//! where no part is seen, `other_views` tries the frame upright, with light and shadow exchanged
//! and for smaller parts, so that the option that would show one can be named.
//!
//! One more refusal is one more function here, called where the fault is found; its text states
//! figures, units and a remedy.

pub(crate) mod explain;
pub(crate) mod other_views;
