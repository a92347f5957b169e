//! A nose by the paper's way, with the keys of the program's own mode where both have them.

use serde::Serialize;

use super::nose::NoseImage;
use crate::gauge::Calibration;
use crate::gauge::nose::paper::PaperNose;

/// A degree of the nose, without an uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct PaperSector {
    /// Its middle, degrees: 0 to the right, counter-clockwise as seen.
    pub direction_deg: f64,
    /// Mean distance of its edge pixels from the centre, px.
    pub radius_px: f64,
    /// None: the paper states none.
    pub u_px: Option<f64>,
}

/// One image's nose. Uncertainties are null, since the paper states none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct PaperNoseImage {
    /// The file's stem.
    pub image: String,
    /// `paper`.
    pub mode: &'static str,
    /// Included angle after one line was turned to the insert's, degrees.
    pub angle_deg: f64,
    /// As found, degrees.
    pub found_angle_deg: f64,
    /// None.
    pub u_angle_deg: Option<f64>,
    /// Column and row of the centre.
    pub centre_px: [f64; 2],
    /// None.
    pub u_centre_px: Option<f64>,
    /// Mean distance of the nose's edge pixels from the centre, px.
    pub mean_radius_px: f64,
    /// None.
    pub u_mean_radius_px: Option<f64>,
    /// The same, mm.
    pub mean_radius_mm: f64,
    /// None.
    pub u_mean_radius_mm: Option<f64>,
    /// Why there are none.
    pub u_reason: &'static str,
    /// Nominal radius R0, px.
    pub nominal_radius_px: f64,
    /// Directions of the outward normals of both edges, degrees.
    pub edge_normals_deg: [f64; 2],
    /// Scale, µm per px.
    pub um_per_px: f64,
    /// Degrees of the nose.
    pub sectors: Vec<PaperSector>,
    /// What limits the use.
    pub flags: Vec<&'static str>,
}

impl PaperNoseImage {
    /// A measurement in mm by a calibration's scale and edge offset.
    pub(crate) fn new(image: String, found: &PaperNose, by: &Calibration) -> Self {
        let sector =
            |&(direction_deg, radius_px): &(f64, f64)| PaperSector { direction_deg, radius_px, u_px: None };
        Self {
            image,
            mode: "paper",
            angle_deg: found.angle_deg,
            found_angle_deg: found.found_angle_deg,
            u_angle_deg: None,
            centre_px: [found.centre.x, -found.centre.y],
            u_centre_px: None,
            mean_radius_px: found.mean_radius_px,
            u_mean_radius_px: None,
            mean_radius_mm: by.scale_mm_per_px * found.mean_radius_px + 0.5 * by.offset_mm,
            u_mean_radius_mm: None,
            u_reason: "the paper's way states no uncertainty; --mode ml does",
            nominal_radius_px: found.nominal_radius_px,
            edge_normals_deg: found.normals_deg,
            um_per_px: 1e3 * by.scale_mm_per_px,
            sectors: found.sectors.iter().map(sector).collect(),
            flags: vec!["paper_mode"],
        }
    }
}

/// A nose by either mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum AnyNose {
    /// The program's own.
    Own(Box<NoseImage>),
    /// The paper's.
    Paper(Box<PaperNoseImage>),
}
