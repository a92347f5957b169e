//! Parts seen end-on: rings and discs by radial calipers.
//!
//! A coarse search finds the part and its centre (`coarse`); then every pixel of a band along each
//! edge takes part in a maximum-likelihood fit of the pixel-integrated Gaussian edge (`model`,
//! along lines `straight_edge`; `fit`, its result in `edge_fit`, in uneven or clipped light
//! `levelled`): levels, blur and noise pooled over the whole edge, the radius free in each of many
//! sectors. Clipped pixels only bound the light. No pixel is resampled. The sectors' radii, without
//! those that contamination covers, give the least-squares circle (LSCI), the roundness and the
//! concentricity (`measurement`).
//!
//! Positions are in pixels, x the column and y the row. A curved edge is located towards the centre
//! of its disc by (σ² + 1/12)/2R; that is corrected. Valid for blur below 3 px, radii above 8 px,
//! walls above 6 px.
//!
//! In: a frame and [`RingSettings`]. Out: [`RingMeasurement`] (`result`) in px, and in mm where a
//! scale or a calibration is given (`millimetres`). One more figure of a ring is one more field of
//! `result`, computed in `measurement`.

pub(crate) mod coarse;
pub(crate) mod edge_fit;
pub(crate) mod edge_pixels;
mod error;
pub(crate) mod fit;
pub(crate) mod levelled;
pub(crate) mod measurement;
pub(crate) mod millimetres;
mod model;
mod outline;
mod pixel_model;
mod result;
mod settings;
pub(crate) mod straight_edge;

pub use self::{
    error::RingError,
    outline::{Outline, OutlinePoint, PointOrigin},
    result::{Concentricity, EdgeCircle, EdgeMillimetres, RingMeasurement},
    settings::{RingScale, RingSettings},
};
pub(crate) use measurement::measure_ring;
