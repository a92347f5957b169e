//! What a head's config states of its optics, in figures a data sheet has.

use serde::Serialize;

use super::setup::{HeadSetup, clips};
use crate::render::settings::Esf;

/// Optics, light and field of a head.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct OpticsFigures {
    /// Family of the edge-spread function, as in `[optics.esf]`.
    pub edge: &'static str,
    /// Image size over object size.
    pub magnification: f64,
    /// A pixel on the part, µm.
    pub um_per_px: f64,
    /// Numerical aperture on the side of the part; none for light without a lens or a measured
    /// edge.
    pub numerical_aperture: Option<f64>,
    /// Wavelength, nm.
    pub wavelength_nm: Option<f64>,
    /// Aperture of the light over that of the lens.
    pub coherence_ratio: Option<f64>,
    /// Blur of the edge, σ of a Gaussian as steep, px.
    pub blur_px: f64,
    /// The same on the part, µm.
    pub blur_um: f64,
    /// Field across and along the part, mm.
    pub field_mm: [f64; 2],
    /// Radial distortion at the corner, per cent.
    pub distortion_percent: f64,
    /// Grey levels of shadow and light, counts.
    pub grey_counts: [f64; 2],
    /// Contrast over noise at mid-edge.
    pub snr: f64,
    /// Whether the bright field fills the well or the scale.
    pub clipped: bool,
    /// Exposure, µs.
    pub exposure_us: f64,
}

impl OpticsFigures {
    /// Of a head.
    pub(super) fn of(head: &HeadSetup) -> Self {
        let (job, um_per_px) = (&head.job, head.um_per_px());
        let optics = &job.optics;
        let (edge, numerical_aperture, wavelength_nm, coherence_ratio) = match &optics.esf {
            Esf::PartiallyCoherent(p) => {
                ("partially_coherent", Some(p.na), Some(p.wavelength_nm), Some(p.coherence_ratio))
            }
            Esf::Cylinder(c) => ("cylinder", Some(c.na), Some(c.wavelength_nm), Some(c.coherence_ratio)),
            Esf::Fresnel(f) => ("fresnel", None, Some(f.wavelength_nm), None),
            Esf::Gaussian(_) => ("gaussian", positive(optics.defocus_na), None, None),
            Esf::Measured(_) => ("measured", positive(optics.defocus_na), None, None),
        };
        let (rows, columns) = (job.camera.rows as usize, head.config.job.camera.columns as usize);
        let mm = |px: usize| px as f64 * head.optics.pixel_mm;
        let corner = optics.distortion.distort_px(0.0, 0.0, rows, columns);
        let (middle_row, middle_column) = (0.5 * (rows as f64 - 1.0), 0.5 * (columns as f64 - 1.0));
        let half = middle_row.hypot(middle_column);
        let imaged = (middle_row - corner.0).hypot(middle_column - corner.1);
        Self {
            edge,
            magnification: optics.magnification,
            um_per_px,
            numerical_aperture,
            wavelength_nm,
            coherence_ratio,
            blur_px: head.room.blur_px,
            blur_um: head.room.blur_px * um_per_px,
            field_mm: [mm(rows), mm(columns)],
            distortion_percent: 1e2 * (imaged / half - 1.0),
            grey_counts: [head.levels.dark, head.levels.light],
            snr: head.levels.snr(),
            clipped: clips(&job.sensor, &head.levels),
            exposure_us: head.turning.exposure_us,
        }
    }
}

fn positive(value: f64) -> Option<f64> {
    (value > 0.0).then_some(value)
}
