//! Mathematics without state, for every module: distributions, lines (also through points that are
//! uncertain both ways), neighbours in a list, normal
//! equations, splines (smoothing, penalised, through all samples), polynomials, a neural net,
//! robust statistics, a median network, a Gaussian over an image.
//!
//! In: numbers and slices of them. Out: numbers, or a fit that can be evaluated. No type here has a
//! unit, keeps state between calls or depends on another module, and the same arguments give the
//! same bits on every thread.
//!
//! A new method is a new file, with the source of its formula, its range and its error at the top,
//! and a test against an exact value. A computation that two modules share belongs here; one that
//! needs a module's own units stays there. The f64 reference of the renderer has its own functions,
//! so that a fault here cannot be in both.

pub(crate) mod both_uncertain;
pub(crate) mod chebyshev;
pub(crate) mod cubic_spline;
pub(crate) mod distributions;
pub(crate) mod gaussian;
pub(crate) mod line;
pub(crate) mod median_network;
pub(crate) mod neighbours;
pub(crate) mod neural_net;
pub(crate) mod normal_equations;
pub(crate) mod normal_table;
pub(crate) mod p_spline;
pub(crate) mod robust;
pub(crate) mod smoothing_spline;
