//! The document of measured noses: what `tool nose` prints, and what a baseline and `tool
//! compensate` read of it.

use serde::{Deserialize, Serialize};

use crate::gauge::Calibration;
use crate::gauge::nose::{BaselineNose, NoseMeasurement, NoseSector, Reference, Wear};

/// Images, one after another.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct NoseDocument {
    /// Every image that was measured.
    pub images: Vec<NoseImage>,
}

/// A sector of 1° of the nose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SectorRow {
    /// Its middle, degrees: 0 to the right, counter-clockwise as seen.
    pub direction_deg: f64,
    /// Distance of the contour from the centre, px.
    pub radius_px: f64,
    /// Its standard uncertainty, px.
    pub u_px: f64,
}

/// Support of the nose's hull in a direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct SupportRow {
    /// Direction as seen, degrees.
    pub direction_deg: f64,
    /// Distance of the tangent from the centre, µm.
    pub h_um: f64,
    /// Its standard uncertainty, µm.
    pub u_um: f64,
}

/// What is missing against the same insert new.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct WearRows {
    /// Mean over the sectors, µm.
    pub mean_um: f64,
    /// Largest of a sector, µm.
    pub largest_um: f64,
    /// Where, degrees.
    pub largest_deg: f64,
    /// A sector each, in the order of `sectors`: µm.
    pub sectors_um: Vec<f64>,
    /// Their standard uncertainties, µm.
    pub u_sectors_um: Vec<f64>,
}

/// One image's nose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct NoseImage {
    /// The file's stem.
    pub image: String,
    /// Included angle of both edges, degrees.
    pub angle_deg: f64,
    /// Its standard uncertainty, degrees.
    pub u_angle_deg: f64,
    /// Column and row of the centre, which lies at the nominal radius from both edges.
    pub centre_px: [f64; 2],
    /// Its standard uncertainty along the axis in which it is known least, px.
    pub u_centre_px: f64,
    /// Mean of the sectors' radii, px.
    pub mean_radius_px: f64,
    /// Its standard uncertainty, px.
    pub u_mean_radius_px: f64,
    /// The same, mm.
    pub mean_radius_mm: f64,
    /// Its standard uncertainty with that of the scale, mm.
    pub u_mean_radius_mm: f64,
    /// Distance of the centre from both edges, px.
    pub nominal_radius_px: f64,
    /// Where that comes from.
    pub reference: Reference,
    /// Directions of the outward normals of both edges, counter-clockwise over the nose, degrees.
    pub edge_normals_deg: [f64; 2],
    /// Scale, µm per px.
    pub um_per_px: f64,
    /// Blur of the edges, px.
    pub sigma_px: f64,
    /// Sectors from edge to edge.
    pub sectors: Vec<SectorRow>,
    /// Against the baseline, where one is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wear: Option<WearRows>,
    /// Support of the hull about the centre.
    pub support: Vec<SupportRow>,
    /// Its covariance, µm².
    pub support_covariance_um2: Vec<Vec<f64>>,
    /// Standard uncertainty that all support values share: scale and edge offset, µm.
    pub u_common_um: f64,
    /// What limits the use.
    pub flags: Vec<&'static str>,
}

impl NoseImage {
    /// A measurement in mm by a calibration's scale and edge offset.
    pub(crate) fn new(image: String, m: &NoseMeasurement, wear: Option<&Wear>, by: &Calibration) -> Self {
        let um = 1e3 * by.scale_mm_per_px;
        // an offset of both edges of a diameter is half of it at one edge
        let offset_um = 500.0 * by.offset_mm;
        let [vs, c, vo] = by.covariance;
        let d = 2.0 * m.mean_radius_px;
        let u_common_um = 500.0 * (d * d * vs + 2.0 * d * c + vo).max(0.0).sqrt();
        let n = m.support.len();
        let covariance = |i: usize, j: usize| um * um * m.support_covariance[(i, j)];
        Self {
            image,
            angle_deg: m.angle_deg,
            u_angle_deg: m.u_angle_deg,
            centre_px: [m.centre.x, -m.centre.y],
            u_centre_px: m.u_centre_px,
            mean_radius_px: m.mean_radius_px,
            u_mean_radius_px: m.u_mean_radius_px,
            mean_radius_mm: 1e-3 * (um * m.mean_radius_px + offset_um),
            u_mean_radius_mm: 1e-3 * (um * m.u_mean_radius_px).hypot(u_common_um),
            nominal_radius_px: m.nominal_radius_px,
            reference: m.reference,
            edge_normals_deg: m.normals_deg,
            um_per_px: um,
            sigma_px: m.sigma_px,
            sectors: m.sectors.iter().map(SectorRow::of).collect(),
            wear: wear.map(|w| WearRows::of(w, um)),
            support: m
                .support
                .iter()
                .map(|s| SupportRow {
                    direction_deg: s.direction_deg.rem_euclid(360.0),
                    h_um: um * s.h_px + offset_um,
                    u_um: um * s.u_px,
                })
                .collect(),
            support_covariance_um2: (0..n).map(|i| (0..n).map(|j| covariance(i, j)).collect()).collect(),
            u_common_um,
            flags: m.flags.clone(),
        }
    }
}

impl SectorRow {
    fn of(s: &NoseSector) -> Self {
        Self { direction_deg: s.direction_deg, radius_px: s.radius_px, u_px: s.u_px }
    }
}

impl WearRows {
    fn of(w: &Wear, um: f64) -> Self {
        Self {
            mean_um: um * w.mean_px,
            largest_um: um * w.largest_px,
            largest_deg: w.largest_deg,
            sectors_um: w.sectors.iter().map(|s| um * s.0).collect(),
            u_sectors_um: w.sectors.iter().map(|s| um * s.1).collect(),
        }
    }
}

/// Of a document, what a baseline needs.
#[derive(Debug, Deserialize)]
struct BaselineDocument {
    images: Vec<BaselineImage>,
}

#[derive(Debug, Deserialize)]
struct BaselineImage {
    angle_deg: f64,
    u_angle_deg: f64,
    nominal_radius_px: f64,
    edge_normals_deg: [f64; 2],
    um_per_px: f64,
    sectors: Vec<SectorRow>,
}

/// Reads the one nose of a document as a baseline for images of a scale, µm per px.
///
/// # Errors
/// No such document, none or several images, another scale; as text.
pub(crate) fn read_baseline(text: &str, um_per_px: f64) -> Result<BaselineNose, String> {
    let document: BaselineDocument = serde_json::from_str(text).map_err(|e| {
        format!("is no nose of the insert when new, as `tool nose --out FILE.json` writes it: {e}")
    })?;
    let [image] = &document.images[..] else {
        return Err(format!("has {} images, a baseline is one: the same insert new", document.images.len()));
    };
    let numbers = [image.angle_deg, image.u_angle_deg, image.nominal_radius_px, image.um_per_px];
    let normals = image.edge_normals_deg;
    let rows = image.sectors.iter().flat_map(|s| [s.direction_deg, s.radius_px, s.u_px]);
    if image.sectors.len() < 3 || !numbers.into_iter().chain(normals).chain(rows).all(f64::is_finite) {
        return Err("has too few sectors, or values that are no numbers".to_owned());
    }
    if (image.um_per_px / um_per_px - 1.0).abs() > 1e-6 {
        return Err(format!(
            "was measured at {} µm per px, these images are at {um_per_px}: a baseline is taken by the same camera and \
             calibration",
            image.um_per_px
        ));
    }
    let sector = |s: &SectorRow| NoseSector {
        direction_deg: s.direction_deg,
        radius_px: s.radius_px,
        u_px: s.u_px,
        fitted: true,
    };
    Ok(BaselineNose {
        angle_deg: image.angle_deg,
        u_angle_deg: image.u_angle_deg,
        normals_deg: normals,
        nominal_radius_px: image.nominal_radius_px,
        sectors: image.sectors.iter().map(sector).collect(),
    })
}
