//! Identification of a machine's errors from readings, and their compensation.
//!
//! In: the geometry of a machine, the errors that are sought, sets of readings
//! ([`IdentificationConfig`]) and the texts of their files ([`checked_set`]). Out: [`identify`], an
//! [`IdentifiedMachine`] (`machine.json`) with tables, uncertainties and covariance, and what
//! cannot be separated in words; [`export`] makes tables of a control from it, [`head_geometry`]
//! what readings of a head are corrected by. The truth of a simulated machine is not read here.
//!
//! Bottom to top: `instrument`, `reading`, `reading_set`, `settings`; `reading_file` with
//! `reading_order` and `turn_mean` (text to readings); `observation` (what a reading holds of each
//! error, by the first order of the chain), `sag`; `spline_basis`, `unknowns`, `equations`;
//! `rank`, `normal_equations`, `smoothing` (how smooth each error is), `least_squares`,
//! `inseparable` (in words), `midline_file` (frames to text), `iso230_2`, `spindle_readings` (turns
//! of an artefact); `solution` (a model, fitted), `identified` (the file), `assemble`, `export`.
//! One more instrument is a variant of [`instrument::Instrument`] and its terms in `observation`.

pub(crate) mod assemble;
mod checked_sets;
mod equations;
pub(crate) mod export;
pub(crate) mod head_geometry;
pub(crate) mod identified;
mod inseparable;
pub(crate) mod instrument;
pub(crate) mod iso230_2;
mod least_squares;
pub(crate) mod midline_file;
mod normal_equations;
mod observation;
mod rank;
pub(crate) mod reading;
mod reading_file;
mod reading_order;
pub(crate) mod reading_set;
mod sag;
pub(crate) mod settings;
mod smoothing;
mod solution;
pub(crate) mod spindle_readings;
mod spline_basis;
mod turn_mean;
mod unknowns;

pub(crate) use assemble::{Identification, identify};
pub(crate) use checked_sets::checked_set;
pub(crate) use equations::CheckedSet;
pub(crate) use identified::{IdentifiedMachine, MachineIdentity};
pub(crate) use settings::IdentificationConfig;
pub(crate) use spindle_readings::spindle;
