//! The largest value along a line of columns: over stretches (`largest_value`), and over crests
//! that face roots (`crests`).
//!
//! In: a value a column with its uncertainties, px. Out: the largest value with u and its position.
//! `fit` are the polynomials through a stretch, `running_sums` gives those of many stretches at the
//! same cost at any width. One more shape with a largest value of its own is one more file beside
//! `crests`.

pub(crate) mod crests;
pub(crate) mod fit;
pub(crate) mod largest_value;
mod running_sums;
