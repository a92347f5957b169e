//! The sensor by itself (EMVA 1288): what its counts mean before any edge is looked for.
//!
//! In: frames of even light, dark frames, settings. Out: photon transfer (gain, read noise), the
//! inverse of a response that bends ([`Response`]), dark and flat field with a list of defective
//! pixels ([`FlatField`], of a part of the frames by `flat_window`), all of them values that a
//! calibration file keeps. Grey values are in counts, places in pixels.
//!
//! One more property of sensors is one more file here: a function from frames to a value, and,
//! where frames are corrected by it, a method that corrects one frame. Nothing in this room imports
//! another room of the gauge.

mod defect_correction;
pub(crate) mod flat_field;
mod flat_window;
pub(crate) mod photon_transfer;
pub(crate) mod response;

pub use self::{flat_field::FlatField, response::Response};
pub(crate) use defect_correction::ShaftRuns;
pub(crate) use flat_field::FlatFieldError;
pub(crate) use response::{NoResponse, response};
