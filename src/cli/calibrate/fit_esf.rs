//! `calibrate --fit-esf`: lens and light of the masters' frames, from the figures of the optics
//! that `--esf` names.

use std::fmt::Write as _;
use std::path::Path;

use crate::cli::failure::Failure;
use crate::cli::optics::NominalOptics;
use crate::gauge::EsfModel;
use crate::job::NominalEdge;
use crate::render::optics::edge_spread::CylinderEdge;
use crate::render::settings::{Esf, Optics};
use crate::studies::calibration::{CalibrateError, CalibrationPlan, Recordings};
use crate::studies::limb_fit::{LimbFit, fit_limbs};

/// Optics that were found, and the edge that a gauge fits by them.
pub(super) struct FittedEdge {
    /// What was found.
    pub(super) fit: LimbFit,
    /// The edge of the masters in their plane, at the scale it was fitted at.
    pub(super) model: EsfModel,
}

/// The lens that `--esf` names: what a fit begins from.
///
/// # Errors
/// Exit 2 without a config there, and for families that state no lens and light.
pub(super) fn stated(esf: Option<&str>) -> Result<(NominalOptics, CylinderEdge), Failure> {
    let config = esf.map(Path::new).filter(|path| path.extension().is_some_and(|e| e == "toml"));
    let Some(path) = config else {
        let why = "fits the optics of a config to the masters: name it by --esf CONFIG.toml";
        return Err(Failure::refuse(format!("--fit-esf: {why}")));
    };
    let nominal = NominalOptics::load(path)?;
    let lens = match &nominal.optics.esf {
        Esf::Cylinder(limb) => limb.clone(),
        Esf::PartiallyCoherent(p) => CylinderEdge::of_lens(p),
        _ => {
            let why = "states no aperture of lens and light to begin from: [optics.esf.cylinder] or \
                       [optics.esf.partially_coherent] is needed";
            return Err(Failure::refuse(format!("--fit-esf: {}: {why}", path.display())));
        }
    };
    Ok((nominal, lens))
}

/// Fits lens and light to the masters of a plan.
///
/// # Errors
/// Frames that are unavailable or show no edge, limbs that cannot be computed.
pub(super) fn fitted(
    plan: &CalibrationPlan,
    recordings: &mut dyn Recordings,
    (nominal, stated): &(NominalOptics, CylinderEdge),
    um_per_px: f64,
) -> Result<FittedEdge, CalibrateError> {
    let fit = fit_limbs(plan, recordings, stated, um_per_px)?;
    let optics =
        Optics { esf: Esf::Cylinder(fit.optics.clone()), reflection: None, ..nominal.optics.clone() };
    let masters = plan.masters.iter().map(|pin| 0.5 * pin.diameter_mm);
    let radius_mm = masters.sum::<f64>() / plan.masters.len().max(1) as f64;
    let model = NominalEdge::new(&optics, 1e-3 * um_per_px, radius_mm, 0.0)?.model(um_per_px);
    Ok(FittedEdge { fit, model })
}

/// The table of a config, with what is known of its values.
///
/// # Errors
/// Never for optics that were fitted.
pub(super) fn in_toml(fit: &LimbFit) -> Result<String, Failure> {
    #[derive(serde::Serialize)]
    struct Tables<'a> {
        optics: OfOptics<'a>,
    }
    #[derive(serde::Serialize)]
    struct OfOptics<'a> {
        esf: OfEsf<'a>,
    }
    #[derive(serde::Serialize)]
    struct OfEsf<'a> {
        cylinder: &'a CylinderEdge,
    }
    let mut text = format!("# fitted to {} edges of masters, chi^2 {:.3}\n", fit.profiles, fit.reduced_chi2);
    let rows = [
        ("numerical_aperture", fit.u_na),
        ("coherence_ratio", fit.u_coherence_ratio),
        ("extra_sigma_um", fit.u_extra_sigma_um),
        ("defocus_mm", fit.u_defocus_mm),
    ];
    for (key, u) in rows {
        let _ = writeln!(text, "# u({key}) = {u:.5}");
    }
    let tables = Tables { optics: OfOptics { esf: OfEsf { cylinder: &fit.optics } } };
    Ok(text + &toml::to_string(&tables).map_err(Failure::fail)?)
}
