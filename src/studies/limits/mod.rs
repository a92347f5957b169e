//! What every threshold of the instrument does: each is halved and doubled, and the same scenes are
//! measured again.
//!
//! The scenes (`kinds`; drawn by `draw` and `look`, or by the studies of contamination and
//! coverage) are made once and handed as bytes to one process a variant, since a process has one
//! value of each threshold. A process measures them (`measure`) and gives counts and a digest of
//! every result by kind of scene: figures that stand beside the default's are paired, and equal
//! digests mean that not one bit differs. `values` holds which values a threshold is given,
//! `figures` what is compared.
//!
//! The scenes are few a kind: a change of one station is one station, not a rate. What the table
//! ranks is where to look with the larger studies; what it lists as without effect no scene here
//! reaches.

mod draw;
mod figures;
mod kinds;
mod look;
mod measure;
mod scene;
mod values;

pub(crate) use figures::{Change, Figures};
pub(crate) use measure::{Measured, measure};
pub(crate) use scene::{from_bytes, kind_names, make, to_bytes};
pub(crate) use values::{Variant, Way, is_share, variants};
