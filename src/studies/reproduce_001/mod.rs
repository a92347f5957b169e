//! Reproduction of the paper on the lathe as its own measuring machine: its list of 21 errors, its
//! equations, its training samples, its nets and its experiments beside ours.
//!
//! In: [`Inputs`], what the paper prints. Out: rows with verdicts ([`super::reproduction`]).
//! `equations` has the list and eqs 1 to 6 against the first order of the exact chain, `samples`
//! the table of 2601, `experiments` straightness, cylindricity and flatness with what a probe on
//! the machine sees of its own part, `spiral` the 481 points, `models` nets and splines on an
//! assumed field, `spindle` what would separate the spindle's error motion. A further figure is a
//! row in the file of its subject.

mod equations;
mod experiments;
mod inputs;
mod models;
mod profile;
mod samples;
mod spindle;
mod spiral;

pub(crate) use inputs::Inputs;

use super::reproduction::Row;
use crate::gauge::form::FormError;

/// Computes every row.
///
/// # Errors
/// A form that its points do not determine.
pub(crate) fn run(inputs: &Inputs) -> Result<Vec<Row>, FormError> {
    let mut rows = equations::rows(inputs);
    rows.extend(samples::rows(inputs));
    rows.extend(experiments::rows(inputs));
    rows.extend(spiral::rows(inputs)?);
    rows.extend(models::rows(inputs));
    rows.extend(spindle::rows());
    Ok(rows)
}
