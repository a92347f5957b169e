//! The lathe as a measuring machine: what its 21 geometric errors do to a tool, a probe and a head.
//!
//! Axes after ISO 841 (Z along the spindle from the chuck, X radial, Y completes), names after ISO
//! 230-1: EXZ is the error along X of axis Z, EBZ its rotation about Y, B0C the orientation of C
//! about Y ([`ErrorName`]). Lengths in mm and angles in rad inside; µm and µrad in files and
//! results.
//!
//! In: [`MachineSettings`] (the `[machine]` of a config). Out: the 21 values at a position
//! ([`Motion`]: Fourier terms, polynomials and tables with reversal and drift), the exact pose of
//! whatever stands on a slide in the part's frame ([`Chain`], two topologies), its first order
//! ([`first_order`]) and what a cut part, a probe and a head make of a pose ([`response`]).
//! [`spindle`] separates error motion and form (ISO 230-7), pure functions of readings. Nothing
//! here reads a measurement: this is the simulated machine, its truth. One more topology is a
//! variant of `Topology` with its branch in `chain` and in `first_order`; one more kind of function
//! is a field of `error_settings` and a term of `ErrorFunction`.

pub(crate) mod chain;
pub(crate) mod conditions;
pub(crate) mod error_function;
pub(crate) mod error_name;
pub(crate) mod error_settings;
pub(crate) mod first_order;
pub(crate) mod motion;
pub(crate) mod response;
pub(crate) mod settings;
pub(crate) mod spindle;
pub(crate) mod stated_error;
pub(crate) mod station;
pub(crate) mod table;
pub(crate) mod table_file;
pub(crate) mod topology;

pub(crate) use chain::{Chain, Pose};
pub(crate) use conditions::Conditions;
pub(crate) use error_name::{Axis, ErrorName, ErrorValues};
pub(crate) use motion::Motion;
pub(crate) use settings::MachineSettings;
pub(crate) use station::Station;
