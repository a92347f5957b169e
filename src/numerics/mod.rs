//! Mathematics without state, for every room: distributions, lines, normal equations, a smoothing
//! spline, robust statistics, a median network.
//!
//! In: numbers and slices of them. Out: numbers, or a fit that is asked for values. No type here
//! has a unit, keeps anything between calls or refers to another room, and the same arguments give
//! the same bits on every thread.
//!
//! One more method is one more file, with the source of its formula, its range and its error in its
//! head, and a test against an exact value. What two rooms compute alike belongs here; what one
//! room needs with its own units stays with it. The f64 reference of the renderer keeps functions
//! of its own, so that a fault here cannot hide in both.

pub(crate) mod distributions;
pub(crate) mod line;
pub(crate) mod median_network;
pub(crate) mod normal_equations;
pub(crate) mod normal_table;
pub(crate) mod robust;
pub(crate) mod smoothing_spline;
