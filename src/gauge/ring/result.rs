//! Results of a ring measurement, in pixels and millimetres.

use super::outline::Outline;

/// One edge of a ring, in pixels unless named otherwise.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct EdgeCircle {
    /// Centre: x the column, y the row, px.
    pub centre_px: [f64; 2],
    /// Least-squares diameter of the 50 % edge, curvature bias corrected, px.
    pub diameter_px: f64,
    /// Its standard uncertainty from noise, levels, blur and the form that refused calipers hide,
    /// px.
    pub u_diameter_px: f64,
    /// Standard uncertainty of either coordinate of the centre, px.
    pub u_centre_px: f64,
    /// Roundness RONt about the least-squares circle after the Gaussian filter, px.
    pub roundness_px: f64,
    /// Diameter of the minimum circumscribed circle of the good calipers, px.
    pub circumscribed_px: f64,
    /// Diameter of the maximum inscribed circle of the good calipers, px.
    pub inscribed_px: f64,
    /// Least-squares diameter as traced by a ball of [`Self::stylus_radius_px`], burrs included,
    /// px.
    pub stylus_diameter_px: f64,
    /// Radius of that ball, px.
    pub stylus_radius_px: f64,
    /// Blur of the edge, px.
    pub sigma_px: f64,
    /// Shadow and light, counts; the light's level is extrapolated where it is clipped.
    pub levels: [f64; 2],
    /// Median χ² per degree of freedom of the good calipers.
    pub reduced_chi2: f64,
    /// Calipers.
    pub calipers: usize,
    /// Calipers unusable because of contamination, burrs or a poor fit; they are not in the circle.
    pub refused: usize,
    /// The edge caliper by caliper, in even steps of the angle.
    #[serde(skip)]
    pub outline: Outline,
    /// The same in millimetres, where a scale was given.
    pub mm: Option<EdgeMillimetres>,
}

/// Coaxiality of bore and outline.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Concentricity {
    /// Diameter of the zone around the outline's centre that holds the bore's centre (ISO 1101):
    /// twice their distance, px.
    pub px: f64,
    /// Its standard uncertainty, px.
    pub u_px: f64,
    /// The same in mm, where a scale was given.
    pub mm: Option<f64>,
}

/// A ring or disc seen end-on.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct RingMeasurement {
    /// Outline.
    pub outer: EdgeCircle,
    /// Bore; `None` for a disc.
    pub inner: Option<EdgeCircle>,
    /// Of bore and outline; `None` for a disc.
    pub concentricity: Option<Concentricity>,
}

/// An edge in millimetres, edge offset applied.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct EdgeMillimetres {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Its standard uncertainty: random part, scale and edge offset together, mm.
    pub u_diameter_mm: f64,
    /// The part of it that all parts measured at this scale share, mm.
    pub u_common_mm: f64,
    /// Diameter as traced by the stylus, mm.
    pub stylus_diameter_mm: f64,
    /// Roundness, mm.
    pub roundness_mm: f64,
}
