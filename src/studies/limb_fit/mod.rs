//! The lens and light of a head from frames of its round masters: numerical aperture, ratio of
//! coherence, further blur and the distance of the masters' axes from the plane of focus.
//!
//! In: a calibration's plan, its recordings, optics as their data sheets state them. Out: a
//! [`LimbFit`], whose optics `calibrate --fit-esf` writes and fits edges by. `profile` is what a
//! frame shows of an edge, `least_squares` the fit of any family's edges to profiles.
//!
//! The place of an edge is free in every profile: nothing here is learnt of diameters, and no
//! diameter is needed better than for the shape of its limb (0.1 mm moves it by 1e-5 of the light).

mod least_squares;
mod profile;

use serde::Serialize;

use crate::gauge::{EsfModel, Gauge, GaugeSettings};
use crate::render::RenderError;
use crate::render::optics::edge_spread::{CylinderEdge, EdgeSpread};
use crate::setting::SettingError;
use crate::studies::calibration::{CalibrateError, CalibrationPlan, Recordings};

use self::least_squares::{Family, Fitted, PARAMETERS, Prior, fit};
use self::profile::{MasterProfile, profiles};

/// What a data sheet leaves open of numerical aperture (share) and ratio of coherence: lenses are
/// specified by an f-number that holds to a tenth and an iris that is not measured.
const SD_NA: f64 = 0.1;
const SD_RATIO: f64 = 0.15;

/// What is known of the further blur, µm (with its half), and of the masters' distance from the
/// plane of focus, mm: lenses are focused by eye to about half of a depth of field.
const SD_BLUR_UM: f64 = 2.0;
const SD_FOCUS_MM: f64 = 0.5;

/// Optics that were found, with standard uncertainties.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LimbFit {
    /// Lens, light and the masters' surface.
    pub(crate) optics: CylinderEdge,
    /// Standard uncertainty of the numerical aperture.
    pub(crate) u_na: f64,
    /// Standard uncertainty of the ratio of coherence.
    pub(crate) u_coherence_ratio: f64,
    /// Standard uncertainty of the further blur, µm.
    pub(crate) u_extra_sigma_um: f64,
    /// Standard uncertainty of the distance from the plane of focus, mm.
    pub(crate) u_defocus_mm: f64,
    /// χ² over its degrees of freedom.
    pub(crate) reduced_chi2: f64,
    /// Edges that were fitted.
    pub(crate) profiles: usize,
}

/// Fits optics to the masters of a plan, from the figures of `stated`.
///
/// # Errors
/// Frames that are unavailable, masters of which no edge is found, limbs that cannot be computed.
pub(crate) fn fit_limbs(
    plan: &CalibrationPlan,
    recordings: &mut dyn Recordings,
    stated: &CylinderEdge,
    um_per_px: f64,
) -> Result<LimbFit, CalibrateError> {
    let gauge = Gauge::new(GaugeSettings { esf: EsfModel::Gaussian {}, ..plan.gauge.clone() })?;
    let mut seen = Vec::new();
    for (index, pin) in plan.masters.iter().enumerate() {
        for position in &pin.positions {
            for frame in recordings.pin(index, pin, position)? {
                let Ok(edges) = gauge.edges(&frame.view()) else { continue };
                seen.extend(profiles(&frame.view(), &edges, (pin.diameter_mm, position.y_mm)));
            }
        }
    }
    if seen.is_empty() {
        let why = "show no edge that optics could be fitted to: frames of round pins in focus are needed";
        return Err(SettingError::at("masters", why).into());
    }
    let family = Limbs { stated: stated.clone(), um_per_px };
    let found = fit(&family, &seen, &prior(stated))?;
    Ok(of_fit(stated, &found, seen.len()))
}

fn prior(stated: &CylinderEdge) -> Prior {
    let CylinderEdge { na, coherence_ratio, extra_sigma_um, defocus_mm, .. } = *stated;
    Prior {
        mean: [na, coherence_ratio, extra_sigma_um, defocus_mm],
        sd: [SD_NA * na, SD_RATIO, SD_BLUR_UM + 0.5 * extra_sigma_um, SD_FOCUS_MM],
        least: [0.3 * na, 0.0, 0.0, f64::NEG_INFINITY],
        most: [2.0 * na, 3.0, f64::INFINITY, f64::INFINITY],
    }
}

fn of_fit(stated: &CylinderEdge, found: &Fitted, profiles: usize) -> LimbFit {
    let [u_na, u_coherence_ratio, u_extra_sigma_um, u_defocus_mm] = found.u;
    LimbFit {
        optics: with(stated, &found.parameters),
        u_na,
        u_coherence_ratio,
        u_extra_sigma_um,
        u_defocus_mm,
        reduced_chi2: found.reduced_chi2,
        profiles,
    }
}

/// Stated optics with other parameters.
fn with(stated: &CylinderEdge, [na, coherence_ratio, extra_sigma_um, defocus_mm]: &[f64; 4]) -> CylinderEdge {
    CylinderEdge {
        na: *na,
        coherence_ratio: *coherence_ratio,
        extra_sigma_um: *extra_sigma_um,
        defocus_mm: *defocus_mm,
        ..stated.clone()
    }
}

/// Limbs of masters in optics of any parameters.
struct Limbs {
    stated: CylinderEdge,
    um_per_px: f64,
}

impl Family for Limbs {
    fn edge(&self, parameters: &[f64; PARAMETERS], of: &MasterProfile) -> Result<EdgeSpread, RenderError> {
        with(&self.stated, parameters).edge_spread(0.5 * of.diameter_mm, of.y_mm)
    }

    fn um_per_px(&self) -> f64 {
        self.um_per_px
    }
}
