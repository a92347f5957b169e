//! Results of a nose measurement, px; places are (column, −row).

use glam::DVec2;
use nalgebra::DMatrix;

/// Where the nominal radius, and with it the centre, comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Reference {
    /// The settings: the tool's file.
    Nominal,
    /// The same insert new.
    Baseline,
    /// The circle that touches both edges and fits the nose, which is not worn.
    Fitted,
    /// The radius of ISO 1832 next to that of the worn nose's unworn ends.
    #[serde(rename = "iso_1832")]
    Iso1832,
}

/// A sector of 1° of the nose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NoseSector {
    /// Its middle, degrees.
    pub direction_deg: f64,
    /// Distance of the contour from the centre, px.
    pub radius_px: f64,
    /// Its standard uncertainty, px.
    pub u_px: f64,
    /// Whether an edge was fitted.
    pub fitted: bool,
}

/// Support of the hull in a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SupportValue {
    /// Direction, degrees.
    pub direction_deg: f64,
    /// Distance of the tangent from the centre, px.
    pub h_px: f64,
    /// Its standard uncertainty, px.
    pub u_px: f64,
}

/// A nose as measured.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NoseMeasurement {
    /// Included angle of the edges, degrees.
    pub angle_deg: f64,
    /// Its standard uncertainty, degrees.
    pub u_angle_deg: f64,
    /// Centre: (column, −row), px.
    pub centre: DVec2,
    /// Its standard uncertainty along the axis in which it is known least, px.
    pub u_centre_px: f64,
    /// Directions of the outward normals of both edges, counter-clockwise, degrees.
    pub normals_deg: [f64; 2],
    /// Their standard uncertainties, degrees.
    pub u_normals_deg: [f64; 2],
    /// Nominal radius, px: distance of the centre from both edges.
    pub nominal_radius_px: f64,
    /// Where it comes from.
    pub reference: Reference,
    /// Mean of the sectors' radii, px.
    pub mean_radius_px: f64,
    /// Its standard uncertainty, px.
    pub u_mean_radius_px: f64,
    /// Sectors from one edge's end of the nose to the other's, counter-clockwise.
    pub sectors: Vec<NoseSector>,
    /// Support about the centre.
    pub support: Vec<SupportValue>,
    /// Covariance of the support, px².
    pub support_covariance: DMatrix<f64>,
    /// Blur of the edges, px.
    pub sigma_px: f64,
    /// Shadow and light, counts.
    pub levels: [f64; 2],
    /// What limits the use of the measurement.
    pub flags: Vec<&'static str>,
}
