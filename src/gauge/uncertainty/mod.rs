//! The uncertainty of a diameter (GUM): one row a source, random and common apart.
//!
//! In: a width or diameter, its calibration and conditions. Out: a [`Budget`](budget::Budget) with
//! k and U (`coverage`), the same by Monte Carlo (`monte_carlo`, JCGM 101), values as people read
//! them (`stated`).
//!
//! One more source is one more row: a `Contribution` with its sensitivity, distribution and degrees
//! of freedom, made in `budget` (of a width) or in `budget_conditions` (of the conditions of use).
//! `form_scatter` is the scatter of columns, `largest_reading` the budget of a largest diameter.

pub(crate) mod budget;
pub(crate) mod budget_conditions;
pub(crate) mod coverage;
pub(crate) mod form_scatter;
pub(crate) mod largest_reading;
pub(crate) mod monte_carlo;
pub mod stated;
pub(crate) mod texts;
