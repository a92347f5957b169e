//! Plots and HTML from what a run folder holds.

pub mod html;
pub mod plot;
