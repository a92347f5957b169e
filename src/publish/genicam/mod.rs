//! The head as GenICam describes it: what every register is, and the XML that names it.
//!
//! In: the [`DataSheet`] of a head. Out: its [`Feature`]s, from which both follow: the XML that
//! clients read (`xml`, with `chunk_nodes`; GenICam schema 1.1, names of the SFNC 2.7) and the
//! registers that a write is checked by (`registers`). `address` is the map of the memory. A new
//! feature is an address and a line of the file of its category in `features`; nothing else has to
//! agree with it.

pub(crate) mod address;
mod chunk_nodes;
mod data_sheet;
mod feature;
mod features;
mod registers;
mod xml;

pub(crate) use address::MOST_STATIONS;
pub(crate) use data_sheet::DataSheet;
pub(crate) use features::features;
pub(crate) use registers::RegisterMap;
pub(crate) use xml::xml;
