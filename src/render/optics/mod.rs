//! Optics: edge spread of a part, and imaging by the lens.
//!
//! In: the `[optics]` table ([`settings`]). Out: [`esf_table::EsfTable`], the edge-spread function
//! integrated over a pixel's area for the kernel, and the maps of [`lens`] (`lens_file`: as a
//! calibration found them). [`edge_spread`] holds the families of the edge-spread function in f64,
//! over the distance into the light in µm on the object; `laser_shoulder` the light of two edges
//! whose diffraction rings cross.
//!
//! A new family is a file in [`edge_spread`] that ends as an [`edge_spread::EdgeSpread`], and a
//! variant of [`settings::Esf`]; a new property of the lens is a file in [`lens`].

pub(crate) mod edge_spread;
pub(crate) mod esf_table;
pub(crate) mod laser_shoulder;
pub mod lens;
pub(crate) mod lens_file;
pub(crate) mod settings;
